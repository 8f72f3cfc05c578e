//! What the paper claims in words, and where it contradicts itself.

use super::measure::{effort, errors, fly};
use super::search::{Searches, objective};
use super::{Entry, Picture, Section, Verdict, entry};
use crate::error::Outcome;
use rayon::prelude::*;
use twinrotor::gains::{self, AxisGains, Gains};
use twinrotor::plant::RigidBody;
use twinrotor::plant::presets::PAPER;
use twinrotor_plot::{Figure, Line, Panel, Stroke};
use twinrotor_sim::flight::Row;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::metrics::Criterion;

/// Every claim in words.
pub(super) fn claims(searches: &Searches, seed: u64) -> Outcome<Section> {
    let (trade_off, picture) = trade_off(searches)?;
    Ok(Section {
        title: "Claims in words".to_owned(),
        text: String::new(),
        entries: vec![criteria(searches)?, lyapunov(searches)?, trade_off, rejection(seed)?],
        measured: vec![],
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

/// The function of eq. (18), half the sum of the squared errors of both axes; its slope \[1/s\] with the
/// volts applied, Σ ξ ξ̇; and what eq. (24) says that the slope is, -Σ μ ξ².
fn lyapunov_function(row: &Row, gains: &Gains<f64>) -> [f64; 3] {
    let torque = PAPER.plant.effectiveness.torque(row.volts);
    let accel = RigidBody::new(&PAPER.plant).at(&row.state).accel(torque);
    let part = |error: f64, rate: f64, accel: f64, g: &AxisGains<f64>| {
        // The reference is constant: its rate is zero. Eqs (12), (20).
        let second = g.position * error - rate;
        let slope = -error * rate - second * (g.position * rate + accel);
        let promised = -g.position * error * error - g.rate * second * second;
        [0.5 * (error * error + second * second), slope, promised]
    };
    let (error, rate) = (errors(row), row.state.rate);
    let pitch = part(error.pitch, rate.pitch, accel.pitch, &gains.pitch);
    let yaw = part(error.yaw, rate.yaw, accel.yaw, &gains.yaw);
    [pitch[0] + yaw[0], pitch[1] + yaw[1], pitch[2] + yaw[2]]
}

/// \[-\] By which part the slope may miss eq. (24): f32, and volts in steps.
const ROUNDING: f64 = 1e-3;

/// What became of the function of eq. (18) in the ticks with a motor at its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Clamped {
    ticks: usize,
    /// In so many it rises.
    rises: usize,
    /// In so many it falls by less than eq. (24) says, or rises.
    slower: usize,
    /// The same of the other ticks.
    slower_without: usize,
}

impl Clamped {
    fn of(file: &GainsFile) -> Outcome<Self> {
        let flown = fly(&PAPER, file, "step", 1)?;
        let gains = file.gains().unwrap_or(gains::PAPER);
        let limit = PAPER.volts_limit;
        let mut found = Self { ticks: 0, rises: 0, slower: 0, slower_without: 0 };
        for pair in flown.rows.windows(2) {
            let [before, slope, promised] = lyapunov_function(&pair[0], &gains);
            let [after, ..] = lyapunov_function(&pair[1], &gains);
            // Where nothing is left to fall, rounding decides.
            let slower = slope > (1.0 - ROUNDING) * promised && before > 1e-6;
            let volts = pair[0].volts;
            if volts.main.abs() >= 0.999 * limit.main || volts.tail.abs() >= 0.999 * limit.tail {
                found.ticks += 1;
                found.rises += usize::from(after > before * (1.0 + 1e-6));
                found.slower += usize::from(slower);
            } else {
                found.slower_without += usize::from(slower);
            }
        }
        Ok(found)
    }

    /// What the theorem says, as an equality.
    fn holds(&self) -> bool {
        self.slower == 0
    }
}

/// "maintains stability due to the Lyapunov-based design" under saturation.
fn lyapunov(searches: &Searches) -> Outcome<Entry> {
    let [paper, tuned] = [Clamped::of(&GainsFile::paper())?, Clamped::of(&searches.tuned[0])?];
    let told = |name: &str, Clamped { ticks, rises, slower, slower_without }: Clamped| {
        format!(
            "{name}: of {ticks} ticks with a motor at its limit the function of eq. (18) falls slower than \
             eq. (24) says in {slower} and rises in {rises}; of the others it falls slower in \
             {slower_without}"
        )
    };
    let verdict = match (paper.holds(), tuned.holds()) {
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
                entry(what, &paper, done, Verdict::Contradictory, "")
            })
            .into(),
        ..Section::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eq. (24) is an equality wherever the motors give what the law asks for, and fails at every clamped
    /// tick.
    #[test]
    fn the_theorem_holds_but_for_the_ticks_with_a_motor_at_its_limit() {
        let found = Clamped::of(&GainsFile::paper()).unwrap();
        assert_eq!(found, Clamped { ticks: 39, rises: 0, slower: 39, slower_without: 0 });
    }
}
