//! A log through the firmware's own estimator and law: what would they have made of it?
//!
//! Every row is a tick of the core's pipeline in `f32`, with the row's counts as measurement and the logged volts as what is applied
//! until the next. The estimator's rates are compared with those of a smoother that sees the future as well; the law is asked what it
//! wants at each estimate, but has no say: its integrator runs on errors that it does not control.

use crate::identify::smooth::smooth;
use crate::log::Log;
use crate::plot::{Figure, Line, Panel, Stroke};
use crate::scenario::{SAMPLE_TIME, Scenario};
use serde::Serialize;
use std::ops::Range;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::controller::ControllerSettings;
use twinrotor::encoder::angle_per_count;
use twinrotor::pipeline::{Pipeline, Settings};
use twinrotor::plant::presets::Rig;
use twinrotor::real::Real;
use twinrotor::reference::Reference;

/// \[s\] Reach, to either side, of the cubics that the true rates are taken from.
pub const SMOOTHER_REACH: f64 = 0.12;
/// Part of an axis' fastest rate below which it is no longer on its way.
const SLOW: f64 = 0.05;

/// What happened at one row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// \[s\]
    pub time: f64,
    /// \[rad/s\] As the estimator had it, from what came before.
    pub estimated: PerAxis<f64>,
    /// \[rad/s\] As the smoother has it, from what came before and after.
    pub smoothed: PerAxis<f64>,
    /// \[V\] In the log.
    pub volts: PerMotor<f64>,
    /// \[V\] What our law would have sent, where it was told what is wanted.
    pub ours: Option<PerMotor<f64>>,
}

/// Differences, as root mean squares.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Report {
    /// \[s\] The rows that were replayed.
    pub from_s: f64,
    /// \[s\] To when.
    pub to_s: f64,
    /// \[s\] From row to row.
    pub sample_time_s: f64,
    /// \[s\] Reach of the smoother, which looks ahead (acausal).
    pub smoother_reach_s: f64,
    /// \[rad/s\] Estimated minus smoothed rate, all rows.
    pub rate_error: PerAxisReport,
    /// \[rad/s\] The same while either axis is on its way.
    pub rate_error_transient: PerAxisReport,
    /// \[s\] How long that is.
    pub transient_s: f64,
    /// \[V\] Our law's volts minus the logged ones, if it was asked.
    pub volts_difference: Option<PerMotorReport>,
}

/// A number for each axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the axes")]
pub struct PerAxisReport {
    pub pitch: f64,
    pub yaw: f64,
}

/// A number for each motor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the motors")]
pub struct PerMotorReport {
    pub main: f64,
    pub tail: f64,
}

/// What was wanted at each row, in the log's order: as it was recorded, or as a scenario has it; none if neither is there.
pub fn references(log: &Log, scenario: Option<&Scenario>) -> Option<Vec<Reference<f32>>> {
    if let Some(scenario) = scenario {
        let trajectory = scenario.trajectory::<f32>();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "seconds of a log, counted in ms"
        )]
        let at = |time: &f64| trajectory.at((time / SAMPLE_TIME).round() as u32);
        return Some(log.time.iter().map(at).collect());
    }
    let recorded = log.reference.as_ref()?;
    Some(recorded.iter().map(|angle| Reference::at_rest(angle.cast())).collect())
}

/// The longest stretch of a log without gaps through `controller` on `rig`.
pub fn replay(
    log: &Log,
    rig: &Rig,
    controller: &ControllerSettings<f64>,
    wanted: Option<&[Reference<f32>]>,
) -> (Vec<Row>, Report) {
    let rows = longest(log);
    let settings: Settings<f32> = Settings::new(rig, *controller, log.sample_time).map(f32::from_f64);
    let per_count: PerAxis<f32> = rig.encoder_counts.map(angle_per_count);
    let measured = |angle: PerAxis<f64>| angle.zip(per_count, as_counted);
    let start = measured(log.angle[rows.start]);
    let mut pipeline = Pipeline::new(&settings, start);
    let smoothed = |of: fn(&PerAxis<f64>) -> f64| {
        let samples: Vec<f64> = log.angle[rows.clone()].iter().map(of).collect();
        smooth(&samples, log.sample_time, SMOOTHER_REACH)
    };
    let smoothed = PerAxis { pitch: smoothed(|a| a.pitch), yaw: smoothed(|a| a.yaw) };
    let row = |(k, index): (usize, usize)| {
        let belief = pipeline.believe(measured(log.angle[index]), log.volts[index].cast());
        let estimate = belief.estimate;
        let ours =
            wanted.map(|wanted| pipeline.decide(belief, &wanted[index]).allocation.volts.map(f64::from));
        Row {
            time: log.time[index],
            estimated: estimate.state.rate.map(f64::from),
            smoothed: PerAxis { pitch: smoothed.pitch[k].rate, yaw: smoothed.yaw[k].rate },
            volts: log.volts[index],
            ours,
        }
    };
    let replayed: Vec<Row> = rows.enumerate().map(row).collect();
    let report = report(&replayed, log.sample_time);
    (replayed, report)
}

/// \[rad\] What the board makes of the counts that a logged angle stands for.
fn as_counted(angle: f64, per_count: f32) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "counts of a few turns")]
    let counts = (angle / f64::from(per_count)).round() as i32;
    f32::from_i32(counts) * per_count
}

fn longest(log: &Log) -> Range<usize> {
    log.stretches.iter().max_by_key(|s| s.len()).cloned().unwrap_or(0..0)
}

fn report(rows: &[Row], sample_time: f64) -> Report {
    let error = |r: &Row| r.estimated.minus(r.smoothed);
    let peak =
        rows.iter().fold(PerAxis::zero(), |m: PerAxis<f64>, r| m.zip(r.smoothed, |m, s| m.max(s.abs())));
    let on_its_way =
        |r: &&Row| r.smoothed.pitch.abs() > SLOW * peak.pitch || r.smoothed.yaw.abs() > SLOW * peak.yaw;
    let moving: Vec<&Row> = rows.iter().filter(on_its_way).collect();
    let axes = |rows: &[&Row]| PerAxisReport {
        pitch: rms(rows.iter().map(|r| error(r).pitch)),
        yaw: rms(rows.iter().map(|r| error(r).yaw)),
    };
    let all: Vec<&Row> = rows.iter().collect();
    let asked = rows.iter().all(|r| r.ours.is_some());
    let difference = |of: fn(PerMotor<f64>) -> f64| {
        rms(rows.iter().filter_map(|r| r.ours.map(|ours| of(ours.minus(r.volts)))))
    };
    Report {
        from_s: rows.first().map_or(0.0, |r| r.time),
        to_s: rows.last().map_or(0.0, |r| r.time),
        sample_time_s: sample_time,
        smoother_reach_s: SMOOTHER_REACH,
        rate_error: axes(&all),
        rate_error_transient: axes(&moving),
        transient_s: moving.len() as f64 * sample_time,
        volts_difference: asked
            .then(|| PerMotorReport { main: difference(|v| v.main), tail: difference(|v| v.tail) }),
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, n), v| (sum + v * v, n + 1.0));
    if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
}

/// Rates estimated and smoothed, their differences, and volts logged and ours.
pub fn figure(title: &str, rows: &[Row], limit: PerMotor<f64>) -> Figure {
    let line = |name: &str, colour: usize, dashed: bool, of: &dyn Fn(&Row) -> f64| Line {
        name: name.to_owned(),
        points: rows.iter().map(|r| (r.time, of(r))).collect(),
        colour,
        stroke: if dashed { Stroke::Dashed } else { Stroke::Solid },
    };
    let panel = |y_label: &str, lines: Vec<Line>, limits: Vec<f64>| Panel {
        y_label: y_label.to_owned(),
        lines,
        limits,
        ..Panel::default()
    };
    let mut panels = vec![
        panel(
            "pitch rate [°/s]",
            vec![
                line("smoothed", 6, false, &|r| r.smoothed.pitch.to_degrees()),
                line("estimated", 0, true, &|r| r.estimated.pitch.to_degrees()),
            ],
            vec![],
        ),
        panel(
            "yaw rate [°/s]",
            vec![
                line("smoothed", 6, false, &|r| r.smoothed.yaw.to_degrees()),
                line("estimated", 1, true, &|r| r.estimated.yaw.to_degrees()),
            ],
            vec![],
        ),
        panel(
            "rate error [°/s]",
            vec![
                line("pitch", 0, false, &|r| (r.estimated.pitch - r.smoothed.pitch).to_degrees()),
                line("yaw", 1, false, &|r| (r.estimated.yaw - r.smoothed.yaw).to_degrees()),
            ],
            vec![],
        ),
    ];
    let ours = |r: &Row, of: fn(PerMotor<f64>) -> f64| r.ours.map_or(f64::NAN, of);
    for (name, colour, limit, of) in [
        ("main", 0, limit.main, (|v| v.main) as fn(PerMotor<f64>) -> f64),
        ("tail", 1, limit.tail, |v| v.tail),
    ] {
        let mut lines = vec![line("in the log", 6, false, &|r| of(r.volts))];
        if rows.iter().any(|r| r.ours.is_some()) {
            lines.push(line("our law", colour, true, &|r| ours(r, of)));
        }
        panels.push(panel(&format!("{name} motor [V]"), lines, vec![limit, -limit]));
    }
    Figure { title: title.to_owned(), panels, ..Figure::default() }
}

#[cfg(test)]
mod tests;
