//! Which experiment would tell most about the constant that is known worst.
//!
//! Candidates are flights of the identified rig: steps of one axis or of both, at several sizes and paces,
//! within its envelope. Each is simulated with the identified constants, and what it would add to the
//! information is counted as if the new log were explained as well as the old ones (in percent of its
//! spread). The one that narrows the worst constant's interval most is suggested.

use super::interval::Precision;
use super::problem::{Guess, Problem};
use super::windows::Run;
use super::{Parameter, THRESHOLD, training_windows};
use crate::log::Log;
use nalgebra::DMatrix;
use twinrotor::axes::PerAxis;
use twinrotor::plant::presets::Rig;
use twinrotor_sim::flight::{Fidelity, Plan, Scalar, fly};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::scenario::{SAMPLE_TIME, Scenario};
use twinrotor_sim::{Error, Outcome};
use twinrotor_tune::parallel;

/// An experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Suggestion {
    /// In words.
    pub what: String,
    /// The constant it is for.
    pub constant: &'static str,
    /// Of the constant's interval as it is now, what is left after the experiment.
    pub remaining: f64,
    /// The scenario file.
    pub toml: String,
}

/// \[s\] How long an experiment lasts.
const DURATION: f64 = 30.0;
/// Parts of the pitch envelope to step to.
const PITCH_PARTS: [f64; 3] = [0.0, 0.35, 0.75];
/// \[deg\] Yaw steps.
const YAW_STEPS_DEG: [f64; 3] = [0.0, 30.0, 90.0];
/// \[s\] From step to step.
const PACES: [f64; 3] = [1.5, 3.0, 6.0];
/// Every how many ticks a row is taken.
const DECIMATION: usize = 2;

/// The best of the candidates for the worst of `parameters`, flown with `gains`.
///
/// # Errors
///
/// If none stays within the envelope.
pub fn suggest(
    rig: &Rig,
    gains: &GainsFile,
    free: &[usize],
    found: &Guess,
    (parameters, known): (&[Parameter], &Precision),
    window: f64,
) -> Outcome<Suggestion> {
    let worst = worst(parameters);
    let now = variance(&known.information, worst);
    let candidates: Vec<(String, String)> = candidates(rig);
    let judged = parallel::map(&candidates, |(_, toml): &(String, String)| {
        let run = flown(rig, gains, toml)?;
        let runs = [run];
        let windows = training_windows(&runs, window).ok()?;
        let own = Problem::new(&runs, windows, &rig.plant, free, THRESHOLD);
        let guess = Guess { values: found.values.clone(), offsets: vec![0.0] };
        let blocks = own.blocks(&guess, true);
        let gained = blocks.iter().fold(DMatrix::zeros(free.len() + 1, free.len() + 1), |sum, b| {
            sum + b.jacobian.transpose() * &b.jacobian
        });
        Some(variance(&joined(&known.information, &(gained / known.mean_square), free.len()), worst))
    });
    let best = judged
        .iter()
        .enumerate()
        .filter_map(|(k, v)| v.filter(|v| v.is_finite()).map(|v| (k, v)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((k, then)) = best else {
        return Err(Error::Failed(
            "no candidate stays within the envelope with these gains; allowed: gains of this rig".to_owned(),
        ));
    };
    let remaining = if now.is_finite() { (then / now).sqrt() } else { 0.0 };
    let (what, toml) = candidates[k].clone();
    Ok(Suggestion { what, constant: parameters[worst].name, remaining, toml })
}

/// The constant whose interval is widest against its value; one without an interval first of all, one at a
/// bound last.
fn worst(parameters: &[Parameter]) -> usize {
    let doubt = |p: &Parameter| match p.ci95 {
        _ if p.at_bound => 0.0,
        None => f64::INFINITY,
        Some([least, most]) => (most - least) / p.value.abs().max(f64::MIN_POSITIVE),
    };
    (0..parameters.len())
        .max_by(|a, b| doubt(&parameters[*a]).total_cmp(&doubt(&parameters[*b])))
        .unwrap_or(0)
}

/// The variance of one unknown, in units of residuals as large as they were.
fn variance(information: &DMatrix<f64>, index: usize) -> f64 {
    let n = information.nrows();
    let root = |x: f64| if x > 0.0 { x.sqrt() } else { 1.0 };
    let scale: Vec<f64> = (0..n).map(|k| root(information[(k, k)])).collect();
    let mut scaled = DMatrix::from_fn(n, n, |i, j| information[(i, j)] / (scale[i] * scale[j]));
    for k in 0..n {
        // What nothing is known of stays unknown, but does not spoil the rest.
        scaled[(k, k)] += 1e-12;
    }
    if information[(index, index)] <= 0.0 {
        return f64::INFINITY;
    }
    scaled.cholesky().map_or(f64::INFINITY, |c| c.inverse()[(index, index)] / (scale[index] * scale[index]))
}

/// The information of old and new logs: the new one has an offset of its own.
fn joined(old: &DMatrix<f64>, gained: &DMatrix<f64>, free: usize) -> DMatrix<f64> {
    let n = old.nrows();
    let mut all = DMatrix::zeros(n + 1, n + 1);
    all.view_mut((0, 0), (n, n)).copy_from(old);
    let at = |k: usize| if k < free { k } else { n };
    for i in 0..=free {
        for j in 0..=free {
            all[(at(i), at(j))] += gained[(i, j)];
        }
    }
    all
}

/// Step experiments: what they are called and their scenario files.
fn candidates(rig: &Rig) -> Vec<(String, String)> {
    let mut all = Vec::new();
    for pitch_part in PITCH_PARTS {
        for yaw_deg in YAW_STEPS_DEG {
            if pitch_part == 0.0 && yaw_deg == 0.0 {
                continue;
            }
            for pace in PACES {
                let rest_deg = rig.rest_angle.pitch.to_degrees();
                let reach_deg = (rig.envelope.pitch.to_degrees() * pitch_part).round();
                let what = format!("pitch ±{reach_deg}°, yaw ±{yaw_deg}°, a step every {pace} s");
                let levels = [1.0, -1.0, 0.5, -0.5, 0.0];
                let course = |axis: &str, rest: f64, size: f64, from: f64| {
                    let jump = |(k, level): (usize, &f64)| {
                        format!("[{}, {}]", from + k as f64 * pace, rest + size * level)
                    };
                    let jumps: Vec<String> = levels.iter().enumerate().map(jump).collect();
                    let period = pace * levels.len() as f64;
                    format!(
                        "[{axis}.steps]\ninitial_deg = {rest:?}\njumps = [{}]\nperiod = {period:?}\n",
                        jumps.join(", ")
                    )
                };
                // The axes step in turn, so that each one's effect on the other shows.
                let toml = format!(
                    "# {what}\nduration = {DURATION:?}\n\n{}\n{}",
                    course("pitch", rest_deg.clamp(-reach_deg.max(0.0), 0.0), reach_deg, 0.0),
                    course("yaw", 0.0, yaw_deg, pace / 2.0)
                );
                all.push((what, toml));
            }
        }
    }
    all
}

/// The log that an experiment would give; none if it leaves the envelope or diverges.
fn flown(rig: &Rig, gains: &GainsFile, toml: &str) -> Option<Run> {
    let scenario = Scenario::parse("suggestion", toml).ok()?;
    let settings = gains.settings(rig);
    let initial = rig.rest_angle;
    let plan = Plan {
        rig,
        truth: rig,
        settings: &settings,
        scenario: &scenario,
        initial,
        fidelity: Fidelity::Rig,
        seed: 1,
    };
    let rows = fly(&plan, Scalar::F64).ok()?.rows;
    if rows
        .iter()
        .any(|r| r.state.angle.pitch.abs() > rig.envelope.pitch.max(rig.rest_angle.pitch.abs() + 1e-9))
    {
        return None;
    }
    let rows: Vec<_> = rows
        .chunks(DECIMATION)
        .map(|r| (PerAxis::new(r[0].state.angle.pitch, r[0].state.angle.yaw), r[0].volts))
        .collect();
    Some(Run::new(Log::from_rows("suggestion", SAMPLE_TIME * DECIMATION as f64, &rows)))
}
