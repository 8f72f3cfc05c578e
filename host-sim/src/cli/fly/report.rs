//! What `fly` has to say of a flight.

use super::desk::Step;
use crate::cli::tables::{self, percent, seconds};
use serde::Serialize;
use std::fmt::Write;
use twinrotor_sim::flight::Flight;
use twinrotor_sim::metrics::Report;
use twinrotor_station::recording::Gaps;

/// What was flown less what was expected, on one axis.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Difference {
    /// \[deg\] Root mean square.
    rms_deg: f64,
    /// \[deg\] At most.
    worst_deg: f64,
}

/// The same on both.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Differences {
    pitch: Difference,
    yaw: Difference,
}

impl Differences {
    /// Tick for tick, as far as both go.
    pub(super) fn new(flown: &Flight, simulated: &Flight) -> Self {
        let axis = |of: fn(&twinrotor_sim::flight::Row) -> f64| {
            let pairs = flown.rows.iter().zip(&simulated.rows);
            let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
            for difference in pairs.map(|(a, b)| (of(a) - of(b)).to_degrees()) {
                sum += difference * difference;
                worst = worst.max(difference.abs());
                count += 1.0;
            }
            Difference { rms_deg: f64::sqrt(sum / f64::max(count, 1.0)), worst_deg: worst }
        };
        Self { pitch: axis(|row| row.state.angle.pitch), yaw: axis(|row| row.state.angle.yaw) }
    }
}

/// One document.
#[derive(Debug, Serialize)]
pub(super) struct Document<'a> {
    pub(super) preset: &'a str,
    pub(super) scenario: &'a str,
    pub(super) gains: &'a str,
    pub(super) port: &'a str,
    pub(super) duration_s: f64,
    pub(super) ended: &'static str,
    pub(super) motors: &'static str,
    pub(super) why: Option<String>,
    pub(super) steps: &'a [Step],
    pub(super) differs: Vec<String>,
    pub(super) frames: usize,
    #[serde(flatten)]
    pub(super) gaps: Gaps,
    pub(super) frames_dropped: Option<u32>,
    pub(super) flown: Option<Report>,
    pub(super) simulated: Option<Report>,
    pub(super) accepted: Option<Report>,
    pub(super) tried: Option<Report>,
    pub(super) difference: Option<Differences>,
    pub(super) verified_ticks: Option<usize>,
    pub(super) record: Option<String>,
    pub(super) notes: Vec<String>,
}

impl Document<'_> {
    /// For a terminal; the steps were told as they happened.
    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        if let (Some(flown), Some(simulated), Some(difference)) =
            (&self.flown, &self.simulated, &self.difference)
        {
            let _ = write!(text, "\nflown\n{flown}\nsimulated\n{simulated}\n");
            let Differences { pitch, yaw } = difference;
            let _ = writeln!(
                text,
                "flown less simulated: pitch {:.3}° rms, {:.3}° at most; yaw {:.3}° rms, {:.3}° at most",
                pitch.rms_deg, pitch.worst_deg, yaw.rms_deg, yaw.worst_deg
            );
        }
        if let (Some(accepted), Some(tried)) = (&self.accepted, &self.tried) {
            let _ =
                writeln!(text, "\nwith motors that one flight has warmed\n{}", side_by_side(accepted, tried));
        }
        if let Some(ticks) = self.verified_ticks {
            let _ = writeln!(
                text,
                "bit for bit equal to the host over {ticks} ticks: the board's own flight, computed once \
                 more with\nwhat it was told and when; the simulation above is a flight of its own, which \
                 begins at level"
            );
        }
        let dropped = self.frames_dropped.map_or_else(String::new, |n| format!(", {n} dropped by the board"));
        let Gaps { gaps, lost_ticks } = self.gaps;
        let _ =
            writeln!(text, "{} frames of telemetry, {lost_ticks} lost in {gaps} gaps{dropped}", self.frames);
        if let Some(record) = &self.record {
            let _ = writeln!(text, "{record}");
        }
        for note in &self.notes {
            let _ = writeln!(text, "note: {note}");
        }
        text
    }
}

/// The controller that was in force beside the one that was tried.
fn side_by_side(accepted: &Report, tried: &Report) -> impl std::fmt::Display {
    let mut table = tables::table(&["", "accepted", "tried"]);
    let mut row = |name: &str, of: &dyn Fn(&Report) -> String| {
        tables::add(&mut table, [name.to_owned(), of(accepted), of(tried)]);
    };
    row("settling 2 %, pitch [s]", &|r| seconds(r.pitch.settling_time_2));
    row("settling 2 %, yaw [s]", &|r| seconds(r.yaw.settling_time_2));
    row("overshoot, pitch [%]", &|r| percent(r.pitch.overshoot_percent));
    row("overshoot, yaw [%]", &|r| percent(r.yaw.overshoot_percent));
    row("ISE, pitch [rad² s]", &|r| format!("{:.6}", r.pitch.ise));
    row("ISE, yaw [rad² s]", &|r| format!("{:.6}", r.yaw.ise));
    row("peak volts, main [V]", &|r| format!("{:.2}", r.main.peak_volts));
    row("peak volts, tail [V]", &|r| format!("{:.2}", r.tail.peak_volts));
    table
}

/// A step as a line.
pub(super) fn line(step: &Step) -> String {
    format!("{:9.3} s  {:10} {}\n", step.time, step.step, step.told)
}
