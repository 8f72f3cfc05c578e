//! What the paper claims in words, and where it contradicts itself.

use super::measure::{effort, errors, fly};
use super::search::{Searches, objective};
use super::{Entry, Picture, Section, Verdict, entry};
use crate::error::Outcome;
use rayon::prelude::*;
use twinrotor::gains::{self, AxisGains, Gains};
use twinrotor::plant::presets::PAPER;
use twinrotor_plot::{Figure, Line, Panel, Stroke};
use twinrotor_sim::flight::{Flight, Row};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::metrics::Criterion;

/// Every claim in words.
pub(super) fn claims(searches: &Searches, seed: u64) -> Outcome<Section> {
    let (trade_off, picture) = trade_off(searches)?;
    Ok(Section {
        title: "Claims in words".to_owned(),
        text: String::new(),
        entries: vec![criteria(searches)?, lyapunov(searches)?, trade_off, rejection(seed)?],
        measured: None,
        pictures: vec![picture],
    })
}

/// "ISE provides a more effective penalization ... appropriate for transient performance".
fn criteria(searches: &Searches) -> Outcome<Entry> {
    let ise = objective(Criterion::Ise)?;
    let mut rows = Vec::new();
    for (name, gains) in ["ISE", "IAE", "ITAE"].iter().zip(&searches.tuned) {
        let report = fly(&PAPER, gains, "step", 1)?.report;
        let settled =
            report.pitch.settling_time_2.unwrap_or(5.0).max(report.yaw.settling_time_2.unwrap_or(5.0));
        rows.push((name, ise.cost(gains), settled, report.pitch.overshoot_percent.unwrap_or(0.0)));
    }
    let told: Vec<String> = rows
        .iter()
        .map(|(name, cost, settled, over)| {
            format!("{name}: settles in {settled:.3} s, overshoots {over:.1} %, ISE {cost:.5}")
        })
        .collect();
    let best = rows[1..].iter().all(|r| rows[0].2 <= r.2 && rows[0].3 <= r.3);
    Ok(entry(
        "ISE suits transients better than IAE and ITAE",
        "better",
        told.join("; "),
        Verdict::of(best),
        "gains tuned on the other two give up half a percent of ISE, settle sooner and hardly overshoot",
    ))
}

/// Half the sum of the squared errors of eq. (18), both axes.
fn lyapunov_function(flown: &Flight, gains: &Gains<f64>) -> Vec<f64> {
    let part = |error: f64, rate: f64, g: &AxisGains<f64>| {
        // The reference is constant: its rate is zero. Eqs (12), (20).
        let second = g.position * error - rate;
        0.5 * (error * error + second * second)
    };
    let of = |r: &Row| {
        let error = errors(r);
        part(error.pitch, r.state.rate.pitch, &gains.pitch) + part(error.yaw, r.state.rate.yaw, &gains.yaw)
    };
    flown.rows.iter().map(of).collect()
}

/// Of the ticks with a motor at its limit: how many there are, in how many the function rises, and in how
/// many it falls slower than eq. (24) with the control law says, Ṁ = -μ1 ξ1² - μ2 ξ2² ≤ -2 min(μ) M on each
/// axis.
fn clamped(file: &GainsFile) -> Outcome<[usize; 3]> {
    let flown = fly(&PAPER, file, "step", 1)?;
    let gains = file.gains().unwrap_or(gains::PAPER);
    let m = lyapunov_function(&flown, &gains);
    let at_limit = |r: &Row| {
        let limit = PAPER.volts_limit;
        r.volts.main.abs() >= 0.999 * limit.main || r.volts.tail.abs() >= 0.999 * limit.tail
    };
    let slowest = gains.to_paper_order().into_iter().fold(f64::INFINITY, f64::min);
    let promised = libm::exp(-2.0 * slowest * twinrotor_sim::scenario::SAMPLE_TIME);
    let ticks: Vec<usize> = (0..m.len() - 1).filter(|k| at_limit(&flown.rows[*k])).collect();
    let count = |of: &dyn Fn(usize) -> bool| ticks.iter().filter(|k| of(**k)).count();
    let rises = count(&|k| m[k + 1] > m[k] * (1.0 + 1e-6));
    let slower = count(&|k| m[k + 1] > m[k] * promised * (1.0 + 1e-4));
    Ok([ticks.len(), rises, slower])
}

/// "maintains stability due to the Lyapunov-based design" under saturation.
fn lyapunov(searches: &Searches) -> Outcome<Entry> {
    let [paper, tuned] = [clamped(&GainsFile::paper())?, clamped(&searches.tuned[0])?];
    let told = |name: &str, [ticks, rises, slower]: [usize; 3]| {
        format!(
            "{name}: in {ticks} ticks with a motor at its limit the function of eq. (18) rises in {rises} \
             and falls slower than the theorem says in {slower}"
        )
    };
    let holds = |[_, rises, slower]: [usize; 3]| rises == 0 && slower == 0;
    let verdict = match (holds(paper), holds(tuned)) {
        (true, true) => Verdict::Reproduced,
        (true, false) => Verdict::WithinAmbiguity,
        (false, _) => Verdict::NotReproduced,
    };
    Ok(entry(
        "stable under saturation by Lyapunov's theorem",
        "by the design",
        format!("{}; {}", told("Table 4", paper), told("tuned on ISE", tuned)),
        verdict,
        "every step here is stable, but not by this theorem: eqs (24)-(27) take the law's torque for the \
         motors', and clamped motors do not give it",
    ))
}

/// "a better trade-off between transient response and control effort" than fixed gains.
fn trade_off(searches: &Searches) -> Outcome<(Entry, Picture)> {
    let point = |gains: &GainsFile| -> Outcome<(f64, f64)> {
        let flown = fly(&PAPER, gains, "step", 1)?;
        Ok((effort(&flown), flown.report.ise()))
    };
    // One number for all four gains: as plain as fixed gains can be.
    let fixed = (4..=50)
        .into_par_iter()
        .map(|k| point(&GainsFile::backstepping(Gains::from_paper_order([0.5 * f64::from(k); 4]))))
        .collect::<Outcome<Vec<_>>>()?;
    let (paper, tuned) = (point(&GainsFile::paper())?, point(&searches.tuned[0])?);
    let beaten = fixed.iter().filter(|p| p.0 <= paper.0 && p.1 <= paper.1).count();
    let line = |name: &str, points: Vec<(f64, f64)>, colour, stroke| Line {
        name: name.to_owned(),
        points,
        colour,
        stroke,
    };
    let figure = Figure {
        title: "Error against effort, the step".to_owned(),
        x_label: "effort ∫ Vp² + Vy² dt [V² s]".to_owned(),
        panels: vec![Panel {
            y_label: "ISE [rad² s]".to_owned(),
            lines: vec![
                line("all gains alike, 2..25", fixed, 6, Stroke::Dots),
                line("Table 4", vec![paper], 1, Stroke::Rings),
                line("tuned on ISE", vec![tuned], 0, Stroke::Rings),
            ],
            ..Panel::default()
        }],
    };
    let told = entry(
        "a better trade-off between transient and effort than fixed gains",
        "better",
        format!(
            "Table 4 is beaten in both error and effort by {beaten} of 47 controllers whose four gains are \
             simply alike"
        ),
        Verdict::of(beaten == 0),
        "Table 4 is a set of fixed gains like any other",
    );
    let caption =
        "Each dot is a controller whose four gains are one number. Lower and further left is better.";
    Ok((told, Picture { name: "trade-off".to_owned(), caption: caption.to_owned(), figure }))
}

/// "integrating disturbance rejection mechanisms".
fn rejection(seed: u64) -> Outcome<Entry> {
    let flown = fly(&PAPER, &GainsFile::paper(), "3", seed)?;
    let most = super::measure::peak_deg(&flown, [3.0, 20.0], super::measure::yaw);
    Ok(entry(
        "disturbance rejection mechanisms are integrated",
        "abstract",
        format!("eqs (26)-(29) have none; yaw is pushed up to {most:.2}° away in scenario 3"),
        Verdict::NotReproduced,
        "no integral, no observer: a constant disturbance leaves a constant error",
    ))
}

/// Where the paper contradicts itself or its source.
pub(super) fn contradictions() -> Section {
    let list = [
        (
            "scenario 2, instants",
            "text: 8, 16, 23, 30 s",
            "eq. (35): 8, 16, 24, 32 s",
            "the equation is flown",
        ),
        (
            "scenario 3, disturbance",
            "text: applied after 20 s",
            "eqs (38)-(39): 0 to 20 s",
            "the equations are flown",
        ),
        ("Fig. 9, pitch reference", "text: a variable square", "eq. (36): 20° constant", "both are flown"),
        ("selection", "text: greedy", "Fig. 4: a flower is always replaced", "Fig. 4 is run (fpa-paper)"),
        (
            "comparison",
            "abstract and conclusion: significant improvements over other approaches",
            "section 5: not directly compared",
            "Table 6 is measured here",
        ),
        ("letter T", "iterations (Table 2)", "horizon of the integral (eq. (30))", "30, and 5 s"),
        ("figure numbers", "two figures are 2, two are 4", "", "4a and 4b here"),
        ("Table 1", "captioned as obtained controller gains", "lists methods", "taken as methods"),
        (
            "steady error",
            "≈ .02° and .007° (Table 5)",
            "asymptotic convergence to 0 (section 3)",
            "the errors go to zero",
        ),
        (
            "machine",
            "inertias, mass and k_yy are an Aero's, whose centre of mass lies below the pivot (gravity as \
             sin θ)",
            "gravity as m g L cos θ is the older 2-DOF Helicopter's",
            "as printed; presets 'aero' and 'heli' are the machines",
        ),
    ];
    Section {
        title: "Contradictions in the text".to_owned(),
        text: "What the paper says in two ways, and what is done here.".to_owned(),
        entries: list
            .map(|(what, one, other, done)| {
                let paper = if other.is_empty() { one.to_owned() } else { format!("{one} / {other}") };
                entry(what, &paper, done, Verdict::WithinAmbiguity, "")
            })
            .into(),
        ..Section::default()
    }
}
