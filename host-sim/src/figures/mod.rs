//! What the commands draw.

pub mod replay;
pub mod residuals;

use twinrotor::axes::PerMotor;
use twinrotor_plot::flight::{dashed, line};
use twinrotor_plot::{Band, Figure, Line, Panel, SERIES, Stroke, series};
use twinrotor_sim::flight::{Flight, Reading, Row};
use twinrotor_tune::contest::Peer;
use twinrotor_tune::optimise::Compromise;
use twinrotor_tune::robust::{Score, quantile};

/// Two flights of the same scenario, the first dashed, until both have long settled.
pub fn comparison(title: &str, flights: [(&str, &Flight); 2], limit: PerMotor<f64>) -> Figure {
    let [before, after] = flights;
    let shown = |flight: &Flight| shown(flight).max(1);
    let end = shown(before.1).max(shown(after.1));
    let [before, after] = [before, after].map(|(name, f)| (name, &f.rows[..end.min(f.rows.len())]));
    let both = |name: &str, colour: usize, value: fn(&Row) -> f64| {
        [
            dashed(line(&format!("{name}, {}", before.0), colour, before.1, value)),
            line(&format!("{name}, {}", after.0), colour, after.1, value),
        ]
    };
    let reference = |name: &str, value: fn(&Row) -> f64| dashed(line(name, 6, after.1, value));
    Figure {
        title: title.to_owned(),
        x_label: String::new(),
        panels: vec![
            Panel {
                y_label: "pitch θ [°]".to_owned(),
                lines: [reference("reference", |r| r.reference.pitch.to_degrees())]
                    .into_iter()
                    .chain(both("pitch", 0, |r| r.state.angle.pitch.to_degrees()))
                    .collect(),
                ..Panel::default()
            },
            Panel {
                y_label: "yaw ψ [°]".to_owned(),
                lines: [reference("reference", |r| r.reference.yaw.to_degrees())]
                    .into_iter()
                    .chain(both("yaw", 1, |r| r.state.angle.yaw.to_degrees()))
                    .collect(),
                ..Panel::default()
            },
            Panel {
                y_label: "motor volts [V]".to_owned(),
                lines: both("main", 0, |r| r.volts.main)
                    .into_iter()
                    .chain(both("tail", 1, |r| r.volts.tail))
                    .collect(),
                limits: vec![limit.main, -limit.main, limit.tail, -limit.tail],
                ..Panel::default()
            },
        ],
    }
}

/// How many rows show all that happens: twice the slower settling time where both axes settle and nothing is
/// asked for afterwards, else all.
fn shown(flight: &Flight) -> usize {
    let (pitch, yaw) = (&flight.report.pitch, &flight.report.yaw);
    let all = flight.rows.len();
    let asked = flight.rows.windows(2).rfind(|pair| pair[0].reference != pair[1].reference);
    let asked = asked.map_or(0.0, |pair| pair[1].time);
    match (pitch.settling_time_2, yaw.settling_time_2) {
        (Some(p), Some(y)) if asked <= p.max(y) => {
            flight.rows.iter().position(|r| r.time > 2.0 * p.max(y)).unwrap_or(all)
        }
        _ => all,
    }
}

/// How fast each method nears the best cost known: the median over seeds, with the band between the quarter
/// points.
pub fn convergence(title: &str, peers: &[Peer], best_known: f64, budget: usize) -> Figure {
    const POINTS: usize = 80;
    /// \[%\] What is nearer than this is drawn here: the costs' own last digits.
    const NEAREST: f64 = 1e-4;
    let counts: Vec<usize> = (1..=POINTS).map(|k| (k * budget).div_ceil(POINTS)).collect();
    let excess = |peer: &Peer, part: f64| -> Vec<(f64, f64)> {
        let at = |n: usize| {
            let costs: Vec<f64> = peer.runs.iter().map(|r| r.cost_after(n)).collect();
            // Before every seed has a cost there is nothing to draw.
            let there = costs.iter().all(|c| c.is_finite());
            let excess = 100.0 * (quantile(&costs, part) / best_known - 1.0);
            (n as f64, if there { excess.max(NEAREST) } else { f64::NAN })
        };
        counts.iter().map(|n| at(*n)).collect()
    };
    let mut panel =
        Panel { y_label: "above the best known [%]".to_owned(), logarithmic: true, ..Panel::default() };
    for (k, peer) in peers.iter().enumerate() {
        let [low, middle, high] = [0.25, 0.5, 0.75].map(|part| excess(peer, part));
        let points = low.into_iter().zip(high).map(|((x, low), (_, high))| (x, low, high)).collect();
        // With many methods the bands would hide each other.
        let (colour, stroke) = series(k);
        if peers.len() <= SERIES {
            panel.bands.push(Band { points, colour });
        }
        panel.lines.push(Line { name: peer.name.clone(), points: middle, colour, stroke });
    }
    Figure { title: title.to_owned(), x_label: "evaluations".to_owned(), panels: vec![panel] }
}

/// On how many plants each controller's flights cost no more than so much; those that fail count on none.
pub fn costs(title: &str, controllers: &[(String, &[Score])]) -> Figure {
    let curve = |(k, (name, scores)): (usize, &(String, &[Score]))| {
        let mut costs: Vec<f64> = scores.iter().filter(|s| !s.failed).map(Score::cost).collect();
        costs.sort_by(f64::total_cmp);
        let share = |k: usize| 100.0 * k as f64 / scores.len() as f64;
        // A step at each plant.
        let steps = costs.iter().enumerate().flat_map(|(k, &cost)| [(cost, share(k)), (cost, share(k + 1))]);
        let (colour, stroke) = series(k);
        Line { name: name.clone(), points: steps.collect(), colour, stroke }
    };
    let lines = controllers.iter().enumerate().map(curve).collect();
    let panel = Panel { y_label: "plants that cost no more [%]".to_owned(), lines, ..Panel::default() };
    Figure { title: title.to_owned(), x_label: "cost of a plant's flights".to_owned(), panels: vec![panel] }
}

/// Some numbers of a flight over time.
pub fn over_time(title: &str, y_label: &str, rows: &[Row], curves: &[(&str, Reading)]) -> Figure {
    let lines = curves.iter().enumerate().map(|(k, (name, value))| line(name, k, rows, value)).collect();
    let panel = Panel { y_label: y_label.to_owned(), lines, ..Panel::default() };
    Figure { title: title.to_owned(), x_label: String::new(), panels: vec![panel] }
}

/// Pitch and yaw of many flights of one scenario: the median, and the band that holds nine tenths of them.
pub fn fan(title: &str, flights: &[&Flight]) -> Figure {
    /// Of every so many ticks one is drawn.
    const THIN: usize = 10;
    let ticks = flights.iter().map(|f| f.rows.len()).min().unwrap_or(0);
    let panel = |y_label: &str, colour: usize, angle: fn(&Row) -> f64, reference: fn(&Row) -> f64| {
        let (mut middle, mut points) = (Vec::new(), Vec::new());
        for tick in (0..ticks).step_by(THIN) {
            let there: Vec<f64> = flights.iter().map(|f| angle(&f.rows[tick])).collect();
            let [low, median, high] = [0.05, 0.5, 0.95].map(|part| quantile(&there, part));
            let time = flights[0].rows[tick].time;
            middle.push((time, median));
            points.push((time, low, high));
        }
        let median = Line { name: "median".to_owned(), points: middle, colour, stroke: Stroke::Solid };
        let mut lines = vec![median];
        lines.extend(flights.first().map(|f| dashed(line("reference", 6, &f.rows, reference))));
        let bands = vec![Band { points, colour }];
        Panel { y_label: y_label.to_owned(), lines, bands, ..Panel::default() }
    };
    Figure {
        title: title.to_owned(),
        x_label: String::new(),
        panels: vec![
            panel("pitch θ [°]", 0, |r| r.state.angle.pitch.to_degrees(), |r| r.reference.pitch.to_degrees()),
            panel("yaw ψ [°]", 1, |r| r.state.angle.yaw.to_degrees(), |r| r.reference.yaw.to_degrees()),
        ],
    }
}

/// A Pareto front of settling \[s\], disturbance error \[deg\] and voltage variation \[V/s\], the last one
/// against each of the others.
pub fn front(title: &str, front: &[Compromise], chosen: usize) -> Figure {
    let panel = |y_label: &str, objective: usize| {
        let point = |p: &Compromise| (p.costs[2], p.costs[objective]);
        let labels = (1..).zip(front).map(|(k, p)| (point(p).0, point(p).1, format!("{k:02}"))).collect();
        let line =
            |name: &str, points, colour, stroke| Line { name: name.to_owned(), points, colour, stroke };
        let lines = vec![
            line("one controller each", front.iter().map(point).collect(), 0, Stroke::Dots),
            line("chosen", front.get(chosen).map(point).into_iter().collect(), 1, Stroke::Rings),
        ];
        Panel { y_label: y_label.to_owned(), lines, labels, ..Panel::default() }
    };
    Figure {
        title: title.to_owned(),
        x_label: "voltage variation while holding [V/s]".to_owned(),
        panels: vec![panel("settling, both axes [s]", 0), panel("disturbed RMS error, both axes [°]", 1)],
    }
}
