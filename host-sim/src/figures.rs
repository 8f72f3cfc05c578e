//! What the commands draw.

use crate::flight::{Flight, Row};
use crate::plot::{Figure, Line, Panel};
use twinrotor::axes::PerMotor;

fn line(name: &str, colour: usize, rows: &[Row], value: impl Fn(&Row) -> f64) -> Line {
    Line {
        name: name.to_owned(),
        points: rows.iter().map(|r| (r.time, value(r))).collect(),
        colour,
        dashed: false,
    }
}

fn dashed(line: Line) -> Line {
    Line { dashed: true, ..line }
}

/// A flight: angles with references, volts with limits, squared errors (the paper's Fig. 5).
pub fn flight(title: &str, flight: &Flight, limit: PerMotor<f64>) -> Figure {
    let rows = &flight.rows;
    let squared = |e: f64| e * e;
    Figure {
        title: title.to_owned(),
        panels: vec![
            Panel {
                y_label: "angle [°]".to_owned(),
                lines: vec![
                    dashed(line("pitch reference θd", 6, rows, |r| r.reference.pitch.to_degrees())),
                    dashed(line("yaw reference ψd", 6, rows, |r| r.reference.yaw.to_degrees())),
                    line("pitch θ", 0, rows, |r| r.state.angle.pitch.to_degrees()),
                    line("yaw ψ", 1, rows, |r| r.state.angle.yaw.to_degrees()),
                ],
                limits: vec![],
            },
            Panel {
                y_label: "motor volts [V]".to_owned(),
                lines: vec![
                    line("main Vp", 0, rows, |r| r.volts.main),
                    line("tail Vy", 1, rows, |r| r.volts.tail),
                ],
                limits: vec![limit.main, -limit.main, limit.tail, -limit.tail],
            },
            Panel {
                y_label: "squared error [rad²]".to_owned(),
                lines: vec![
                    line("pitch ξp²", 0, rows, |r| squared(r.reference.pitch - r.state.angle.pitch)),
                    line("yaw ξy²", 1, rows, |r| squared(r.reference.yaw - r.state.angle.yaw)),
                ],
                limits: vec![],
            },
        ],
    }
}

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
        panels: vec![
            Panel {
                y_label: "pitch θ [°]".to_owned(),
                lines: [reference("reference", |r| r.reference.pitch.to_degrees())]
                    .into_iter()
                    .chain(both("pitch", 0, |r| r.state.angle.pitch.to_degrees()))
                    .collect(),
                limits: vec![],
            },
            Panel {
                y_label: "yaw ψ [°]".to_owned(),
                lines: [reference("reference", |r| r.reference.yaw.to_degrees())]
                    .into_iter()
                    .chain(both("yaw", 1, |r| r.state.angle.yaw.to_degrees()))
                    .collect(),
                limits: vec![],
            },
            Panel {
                y_label: "motor volts [V]".to_owned(),
                lines: both("main", 0, |r| r.volts.main)
                    .into_iter()
                    .chain(both("tail", 1, |r| r.volts.tail))
                    .collect(),
                limits: vec![limit.main, -limit.main, limit.tail, -limit.tail],
            },
        ],
    }
}

/// How many rows show all that happens: twice the slower settling time where both axes settle, else all.
fn shown(flight: &Flight) -> usize {
    let (pitch, yaw) = (&flight.report.pitch, &flight.report.yaw);
    let all = flight.rows.len();
    match (pitch.settling_time_2, yaw.settling_time_2) {
        (Some(p), Some(y)) => flight.rows.iter().position(|r| r.time > 2.0 * p.max(y)).unwrap_or(all),
        _ => all,
    }
}
