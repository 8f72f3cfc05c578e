//! A log through the firmware's own estimator and law: what would they have made of it?
//!
//! The log becomes a board's ticks: volts are held from row to row, and between rows an encoder counts
//! evenly. Each tick goes through the core's [`Replay`], here or on a board; the estimator's rates are
//! compared with those of a smoother that sees the future as well; the law is asked what it wants at each
//! estimate, but has no say: its integrator runs on errors that it does not control.

use crate::log::Log;
use crate::smooth::smooth;
use serde::Serialize;
use std::ops::Range;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::encoder::angle_per_count;
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets::Rig;
use twinrotor::reference::Reference;
use twinrotor::replay::{Replay, Replayed, Sample};
use twinrotor_sim::scenario::{SAMPLE_TIME, Scenario};

/// \[s\] Reach, to either side, of the cubics that the true rates are taken from: with which they are nearest
/// to rates that are known, on simulated runs of an Aero (a test). Pitch has half as many counts a turn as
/// yaw, and so takes a longer one.
pub const SMOOTHER_REACH: PerAxis<f64> = PerAxis { pitch: 0.15, yaw: 0.12 };
/// Part of an axis' fastest rate below which it is no longer on its way.
const SLOW: f64 = 0.05;

/// What happened at one tick.
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
    /// \[s\] What was replayed, a tick every ms.
    pub from_s: f64,
    /// \[s\] To when.
    pub to_s: f64,
    /// \[s\] From row to row of the log.
    pub sample_time_s: f64,
    /// \[s\] Reach of the smoother, which looks ahead (acausal).
    pub smoother_reach_s: PerAxisReport,
    /// \[rad/s\] Estimated minus smoothed rate, all ticks.
    pub rate_error: PerAxisReport,
    /// \[rad/s\] The same while that axis is on its way: faster than a twentieth of its fastest.
    pub rate_error_transient: PerAxisReport,
    /// \[s\] How long that is.
    pub transient_s: PerAxisReport,
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

/// The longest stretch of a log without gaps as the ticks of a board at `rig`. What was wanted is as it was
/// recorded, or as a scenario has it.
pub fn samples(log: &Log, rig: &Rig, scenario: Option<&Scenario>) -> Vec<Sample> {
    let rows = longest(log);
    let per_count: PerAxis<f64> = rig.encoder_counts.map(angle_per_count);
    let trajectory = scenario.map(Scenario::trajectory::<f32>);
    let recorded = |row: usize| log.reference.as_ref().map(|angles| Reference::at_rest(angles[row].cast()));
    let sample = |number: u32| {
        let (row, part) = place(log, &rows, number);
        let [before, after] = [row, row + 1].map(|row| log.angle[row.min(rows.end - 1)]);
        let angle = before.zip(after, |before, after| before + part * (after - before));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "counts of a few turns; seconds of a log, counted in ms"
        )]
        Sample {
            number,
            counts: angle.zip(per_count, |angle, per_count| (angle / per_count).round() as i32),
            volts: log.volts[row].cast(),
            wanted: match &trajectory {
                Some(trajectory) => {
                    Some(trajectory.at((log.time[rows.start] / SAMPLE_TIME).round() as u32 + number))
                }
                None => recorded(row),
            },
        }
    };
    (0..ticks(log, &rows)).map(sample).collect()
}

/// Ticks from the first row to the last.
fn ticks(log: &Log, rows: &Range<usize>) -> u32 {
    let spans = rows.len().saturating_sub(1) as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "seconds of a log, counted in ms"
    )]
    let last = (spans * log.sample_time / SAMPLE_TIME + A_LITTLE) as u32;
    if rows.is_empty() { 0 } else { last + 1 }
}

/// The row in force at a tick, and which part of the way to the next one has passed.
fn place(log: &Log, rows: &Range<usize>, tick: u32) -> (usize, f64) {
    let at = f64::from(tick) * SAMPLE_TIME / log.sample_time;
    let whole = (at + A_LITTLE).floor();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a row of the log")]
    let row = rows.start + whole as usize;
    (row.min(rows.end - 1), (at - whole).max(0.0))
}

/// More than rounding, and less than any part of a row or tick.
const A_LITTLE: f64 = 1e-6;

/// What the core makes of each tick.
pub fn replay(parameters: &Parameters, samples: &[Sample]) -> Vec<Replayed> {
    let Some(first) = samples.first() else { return Vec::new() };
    let mut replay = Replay::new(parameters, first);
    samples.iter().map(|sample| replay.step(sample)).collect()
}

/// The ticks of [`samples`] and what was made of them beside the log.
pub fn compare(log: &Log, samples: &[Sample], replayed: &[Replayed]) -> (Vec<Row>, Report) {
    let rows = longest(log);
    let smoothed = |of: fn(&PerAxis<f64>) -> f64, reach: f64| {
        let angles: Vec<f64> = log.angle[rows.clone()].iter().map(of).collect();
        smooth(&angles, log.sample_time, reach)
    };
    let reach = SMOOTHER_REACH;
    let smoothed = PerAxis { pitch: smoothed(|a| a.pitch, reach.pitch), yaw: smoothed(|a| a.yaw, reach.yaw) };
    let row = |(sample, replayed): (&Sample, &Replayed)| {
        let (row, part) = place(log, &rows, sample.number);
        let rate = |row: usize| {
            let k = row.min(rows.end - 1) - rows.start;
            PerAxis { pitch: smoothed.pitch[k].rate, yaw: smoothed.yaw[k].rate }
        };
        let [before, after] = [row, row + 1].map(rate);
        Row {
            time: log.time[rows.start] + f64::from(sample.number) * SAMPLE_TIME,
            estimated: replayed.rate.map(f64::from),
            smoothed: before.zip(after, |before, after| before + part * (after - before)),
            volts: log.volts[row],
            ours: replayed.volts.map(|volts| volts.map(f64::from)),
        }
    };
    let replayed: Vec<Row> = samples.iter().zip(replayed).map(row).collect();
    let report = report(&replayed, log.sample_time);
    (replayed, report)
}

fn longest(log: &Log) -> Range<usize> {
    log.stretches.iter().max_by_key(|s| s.len()).cloned().unwrap_or(0..0)
}

fn report(rows: &[Row], sample_time: f64) -> Report {
    let error = |r: &Row| r.estimated.minus(r.smoothed);
    let peak =
        rows.iter().fold(PerAxis::zero(), |m: PerAxis<f64>, r| m.zip(r.smoothed, |m, s| m.max(s.abs())));
    let axis = |of: fn(PerAxis<f64>) -> f64| {
        let on_its_way: Vec<&Row> = rows.iter().filter(|r| of(r.smoothed).abs() > SLOW * of(peak)).collect();
        let all = rms(rows.iter().map(|r| of(error(r))));
        let transient = rms(on_its_way.iter().map(|r| of(error(r))));
        (all, transient, on_its_way.len() as f64 * SAMPLE_TIME)
    };
    let (pitch, yaw) = (axis(|v| v.pitch), axis(|v| v.yaw));
    let asked = rows.iter().all(|r| r.ours.is_some());
    let difference = |of: fn(PerMotor<f64>) -> f64| {
        rms(rows.iter().filter_map(|r| r.ours.map(|ours| of(ours.minus(r.volts)))))
    };
    Report {
        from_s: rows.first().map_or(0.0, |r| r.time),
        to_s: rows.last().map_or(0.0, |r| r.time),
        sample_time_s: sample_time,
        smoother_reach_s: PerAxisReport { pitch: SMOOTHER_REACH.pitch, yaw: SMOOTHER_REACH.yaw },
        rate_error: PerAxisReport { pitch: pitch.0, yaw: yaw.0 },
        rate_error_transient: PerAxisReport { pitch: pitch.1, yaw: yaw.1 },
        transient_s: PerAxisReport { pitch: pitch.2, yaw: yaw.2 },
        volts_difference: asked
            .then(|| PerMotorReport { main: difference(|v| v.main), tail: difference(|v| v.tail) }),
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, n), v| (sum + v * v, n + 1.0));
    if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
}

#[cfg(test)]
mod tests;
