//! The constants of a real rig from its own logs.
//!
//! Output error: the core's plant is fed the volts of a log and its constants are moved until its angles look
//! like the logged ones. In the order of a run: [`mod@log`] reads and mends, [`windows`] cuts, [`doubts`]
//! asks whether the columns are what they are said to be, [`tachometer`] reads lags, [`first_guess`] finds
//! where to begin, [`problem`] is the least squares, [`search`] and [`descent`] solve it, [`interval`] says
//! how well each constant is known, [`mod@fit`] how well the logs are explained, and [`suggest`] which
//! experiment would tell more. [`identification`] is the run itself, from the question to the report, and
//! [`coverage`] a study of whether intervals hold what they claim.

#![cfg_attr(
    test,
    allow(
        clippy::float_cmp,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "tests compare bits and make samples"
    )
)]

pub mod constants;
pub mod coverage;
pub mod descent;
pub mod doubts;
pub mod first_guess;
pub mod fit;
pub mod identification;
pub mod interval;
pub mod log;
pub mod problem;
pub mod replay;
pub mod search;
pub mod smooth;
pub mod suggest;
pub mod tachometer;
pub mod windows;

use constants::{CONSTANTS, from_array, to_array};
use fit::{Fit, LENGTHS, fit};
use interval::{Precision, precision};
use problem::{Guess, Problem};
use serde::Serialize;
use twinrotor::plant::PlantParameters;
use twinrotor::plant::presets::Rig;
use twinrotor_sim::{Error, Outcome};
use twinrotor_tune::parallel::NEVER;
use windows::{Run, Window};

/// \[s\] Length of the windows that constants are fitted to, when nothing else is said: long enough to tell
/// friction from damping, and short enough that a real rig's whims do not add up. Logs that were kept out
/// decided (docs/identify.md).
pub const WINDOW: f64 = 3.5;
/// Part of an angle's standard deviation from which on a residual is an outlier, when nothing else is said.
pub const THRESHOLD: f64 = 0.3;

/// A constant as it was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// As a preset file spells it.
    pub name: &'static str,
    /// What fits best.
    pub value: f64,
    /// What was believed before: the preset's.
    pub preset: f64,
    /// SI.
    pub unit: &'static str,
    /// Least and most of the 95 % interval; none at a bound, or where the logs say nothing.
    pub ci95: Option<[f64; 2]>,
    /// Do the logs determine it?
    pub identifiable: bool,
    /// Does it lie at the bound that physics sets?
    pub at_bound: bool,
}

/// Of a bound's range: an interval narrower than this is knowledge even around zero.
const NARROW: f64 = 1e-3;

/// Takes the lags that tachometers show into `plant`, and out of what is `free` unless it was `freed` by
/// name; gives them as found.
pub fn hold_measured_lags(
    runs: &[Run],
    plant: &mut PlantParameters<f64>,
    free: &mut Vec<usize>,
    freed: &[String],
) -> Vec<Parameter> {
    let mut values = to_array(plant);
    let lags = tachometer::lags(runs);
    let mut found = Vec::new();
    for (name, lag) in [("rotor_time_constant.main", lags.main), ("rotor_time_constant.tail", lags.tail)] {
        let place = free.iter().position(|k| CONSTANTS[*k].name == name);
        let (Some(lag), Some(place), false) = (lag, place, freed.iter().any(|f| f == name)) else { continue };
        let index = free.remove(place);
        found.push(Parameter {
            name,
            value: lag.value,
            preset: std::mem::replace(&mut values[index], lag.value),
            unit: CONSTANTS[index].unit,
            ci95: Some([lag.value - lag.half_width, lag.value + lag.half_width]),
            identifiable: lag.half_width < lag.value,
            at_bound: false,
        });
    }
    *plant = from_array(&values);
    found
}

/// Part of a log's moving pieces that another log may share by chance.
const CHANCE: f64 = 0.02;

/// The `runs` without those whose rows another one holds already, and what is said of rows that they and the
/// logs that were kept out, `others`, have in common.
pub fn distinct(runs: Vec<Run>, others: &[Run]) -> (Vec<Run>, Vec<String>) {
    let mut kept: Vec<Run> = Vec::new();
    let mut notes = Vec::new();
    for run in runs {
        let shared = kept.iter().map(|other| (other, run.log.shared_with(&other.log)));
        let most = shared.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, part)| *part > CHANCE);
        let (name, drop) = (&run.log.name, most.is_some_and(|(_, part)| part > 0.98));
        if let Some((other, part)) = most {
            let (other, percent) = (&other.log.name, 100.0 * part);
            notes.push(if drop {
                format!("{name}: its rows are in {other} already: left out, since they prove nothing twice")
            } else {
                format!("{name}: {percent:.0} % of it is in {other} too: intervals come out too narrow")
            });
        }
        if !drop {
            kept.push(run);
        }
    }
    for run in others {
        let shared = kept.iter().map(|other| (other, run.log.shared_with(&other.log)));
        let most = shared.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, part)| *part > CHANCE);
        if let Some((other, part)) = most {
            notes.push(format!(
                "{}: {:.0} % of it is in {}, which the constants were fitted to: its fit proves nothing",
                run.log.name,
                100.0 * part,
                other.log.name
            ));
        }
    }
    (kept, notes)
}

/// The windows of every run in which anything happens.
///
/// # Errors
///
/// If there is none.
pub fn training_windows(runs: &[Run], length: f64) -> Outcome<Vec<Window>> {
    let windows: Vec<Window> = runs
        .iter()
        .enumerate()
        .flat_map(|(k, run)| run.calm_windows(k, length).into_iter().filter(|w| run.is_alive(w)))
        .collect();
    if windows.is_empty() {
        return Err(Error::invalid(
            "window",
            format_args!("{length} s, and no log has a window of that length in which anything happens"),
            "less",
        ));
    }
    Ok(windows)
}

/// Intervals of what was found.
pub fn parameters(problem: &Problem<'_>, found: &Guess) -> (Vec<Parameter>, Precision) {
    let blocks = problem.blocks(found, true);
    let known = precision(problem, &found.values, &blocks);
    let parameter = |(k, index): (usize, &usize)| {
        let (value, half, [least, most]) = (found.values[k], known.half_width[k], problem.bounds()[k]);
        let interval = half.is_finite() && !known.at_bound[k];
        Parameter {
            name: CONSTANTS[*index].name,
            value,
            preset: problem.base(*index),
            unit: CONSTANTS[*index].unit,
            ci95: interval.then_some([value - half, value + half]),
            identifiable: interval && half < value.abs().max(NARROW * (most - least)),
            at_bound: known.at_bound[k],
        }
    };
    (problem.free().iter().enumerate().map(parameter).collect(), known)
}

/// The pitch offset \[rad\] of a log that the constants were not fitted to.
pub fn offset_of(run: &Run, plant: &PlantParameters<f64>, window: f64) -> f64 {
    if !run.moves.pitch {
        return 0.0;
    }
    let runs = std::slice::from_ref(run);
    let problem = Problem::new(runs, run.calm_windows(0, window), plant, &[], THRESHOLD);
    let nothing = Guess { values: Vec::new(), offsets: vec![0.0] };
    descent::descend(&problem, &nothing, NEVER).map_or(0.0, |(found, _)| found.offsets[0])
}

/// The fit of one log with every window length that it is long enough for.
pub fn fits(run: &Run, plant: &PlantParameters<f64>, offset: f64) -> Vec<Fit> {
    let long_enough = |length: &f64| run.log.duration() >= *length;
    LENGTHS.into_iter().filter(long_enough).map(|length| fit(run, plant, offset, length)).collect()
}

/// The rig with what was found. A law that thinks the thrust curve straight takes its slope at the volts that
/// were usual in the logs, where the preset named none.
///
/// # Errors
///
/// If such a rig could not be.
pub fn identified(rig: &Rig, plant: PlantParameters<f64>, runs: &[Run]) -> Outcome<Rig> {
    let mut rig = Rig { plant, ..*rig };
    if rig.nominal_volts == 0.0 {
        let volts = runs.iter().flat_map(|r| &r.log.volts).flat_map(|v| [v.main.abs(), v.tail.abs()]);
        let (sum, count) = volts.filter(|v| *v > 0.0).fold((0.0, 0.0), |(sum, n), v| (sum + v, n + 1.0));
        rig.nominal_volts = (10.0 * sum / f64::max(count, 1.0)).round() / 10.0;
    }
    rig.validate().map_err(|e| Error::Failed(format!("the logs lead to a rig that cannot be: {e}")))?;
    Ok(rig)
}

#[cfg(test)]
mod tests;
