//! Where a fit begins, without a guess from outside: accelerations by linear regression.
//!
//! With angles smoothed and rotors given a lag, M q̈ = torque is linear in every other constant.
//! Differentiated encoder counts bias such a fit, so it is only a start; but the signs it finds are those of
//! the rig, and show columns that are swapped.

use super::constants::{CONSTANTS, from_array, to_array};
use super::smooth::smooth;
use super::windows::Run;
use nalgebra::{DMatrix, DVector};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::plant::{FRICTION_WIDTH, PlantParameters, decay};

/// \[s\] Reach of the polynomials that rates and accelerations come from.
const REACH: f64 = 0.12;
/// Part of the largest direction below which the regression knows nothing.
const UNKNOWN: f64 = 1e-3;
/// \[s\] Lags that are tried.
const LAGS: [f64; 6] = [0.03, 0.06, 0.1, 0.15, 0.22, 0.3];

/// The constants that regression gives, at the lag that explains most, with `base`'s inertias and lag-free
/// terms.
pub fn first_guess(runs: &[Run], base: &PlantParameters<f64>) -> PlantParameters<f64> {
    let guesses = LAGS.map(|lag| regress(runs, base, lag));
    let best = guesses.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    best.map_or(*base, |(plant, _)| plant)
}

/// One regression for each axis: (regressors, acceleration times inertia), weighted alike.
fn regress(runs: &[Run], base: &PlantParameters<f64>, lag: f64) -> (PlantParameters<f64>, f64) {
    let mut values = to_array(base);
    let mut set = |name: &str, value: f64| {
        if let Some(k) = CONSTANTS.iter().position(|c| c.name == name) {
            values[k] = value;
        }
    };
    let (pitch, missed_pitch) =
        solve(runs.iter().filter(|r| r.moves.pitch).map(|run| rows(run, base, lag, true)));
    let (yaw, missed_yaw) = solve(runs.iter().filter(|r| r.moves.yaw).map(|run| rows(run, base, lag, false)));
    let names = [
        ["effectiveness.main_on_pitch", "effectiveness.main_on_yaw"],
        ["effectiveness.tail_on_pitch", "effectiveness.tail_on_yaw"],
        ["quadratic_effectiveness.main_on_pitch", "quadratic_effectiveness.main_on_yaw"],
        ["quadratic_effectiveness.tail_on_pitch", "quadratic_effectiveness.tail_on_yaw"],
        ["damping.pitch", "damping.yaw"],
        ["coulomb_friction.pitch", "coulomb_friction.yaw"],
        ["rotor_reaction.tail", "rotor_reaction.main"],
    ];
    for (k, [of_pitch, of_yaw]) in names.iter().enumerate() {
        set(of_pitch, pitch[k]);
        set(of_yaw, yaw[k]);
    }
    set("stiffness", pitch[7]);
    set("rotor_time_constant.main", lag);
    set("rotor_time_constant.tail", lag);
    (from_array(&values), missed_pitch + missed_yaw)
}

/// How many terms a regression has.
const TERMS: usize = 9;

/// The least squares solution over all runs, and the part of the accelerations that it misses.
fn solve(parts: impl Iterator<Item = Vec<([f64; TERMS], f64)>>) -> ([f64; TERMS], f64) {
    let rows: Vec<([f64; TERMS], f64)> = parts.flatten().collect();
    if rows.len() <= TERMS {
        return ([0.0; TERMS], 1.0);
    }
    let scale: Vec<f64> = (0..TERMS)
        .map(|k| rows.iter().map(|(x, _)| x[k] * x[k]).sum::<f64>().sqrt())
        .map(|s| if s > 0.0 { s } else { 1.0 })
        .collect();
    let a = DMatrix::from_fn(rows.len(), TERMS, |i, k| rows[i].0[k] / scale[k]);
    let b = DVector::from_iterator(rows.len(), rows.iter().map(|(_, y)| *y));
    let normal = (a.transpose() * &a).svd(true, true);
    let most = normal.singular_values.max();
    let x = normal
        .solve(&(a.transpose() * &b), UNKNOWN * UNKNOWN * most)
        .unwrap_or_else(|_| DVector::zeros(TERMS));
    let missed = (&a * &x - &b).norm_squared() / b.norm_squared().max(f64::MIN_POSITIVE);
    (std::array::from_fn(|k| x[k] / scale[k]), missed)
}

fn rows(run: &Run, base: &PlantParameters<f64>, lag: f64, is_pitch: bool) -> Vec<([f64; TERMS], f64)> {
    let log = &run.log;
    let keep = decay(log.sample_time, lag);
    let coupling = base.mass * base.center_of_mass * base.center_of_mass;
    let mut found = Vec::new();
    for stretch in &log.stretches {
        let part = &log.angle[stretch.clone()];
        if part.len() < 20 {
            continue;
        }
        let pitch: Vec<f64> = part.iter().map(|a| a.pitch).collect();
        let angle = if is_pitch { pitch.clone() } else { part.iter().map(|a| a.yaw).collect() };
        let rate: Vec<f64> = smooth(&angle, log.sample_time, REACH).iter().map(|s| s.rate).collect();
        let accel = smooth(&rate, log.sample_time, REACH);
        let mut acting: PerMotor<f64> = log.volts[stretch.start];
        for (k, volts) in log.volts[stretch.clone()].iter().enumerate() {
            let missing = volts.minus(acting);
            if k % super::problem::stride(run) == 0 && rate[k].abs() > 5.0 * FRICTION_WIDTH {
                let squared = acting.map(|v| v * v.abs());
                let (sine, cosine) = pitch[k].sin_cos();
                let (inertia, reaction) = if is_pitch {
                    (base.inertia.pitch + coupling, missing.tail / lag)
                } else {
                    (base.inertia.yaw + coupling * cosine * cosine, missing.main / lag)
                };
                let weight =
                    if is_pitch { base.mass * base.center_of_mass * base.gravity * cosine } else { 0.0 };
                let (pull, constant) = if is_pitch { (-sine, 1.0) } else { (0.0, 0.0) };
                let terms = [
                    acting.main,
                    acting.tail,
                    squared.main,
                    squared.tail,
                    -rate[k],
                    -rate[k].signum(),
                    reaction,
                    pull,
                    constant,
                ];
                found.push((terms, inertia * accel[k].rate + weight));
            }
            acting = volts.minus(missing.scaled(keep));
        }
    }
    found
}

/// What the signs of a first guess say of the columns: a line for each that looks swapped.
pub fn swapped(
    guess: &PlantParameters<f64>,
    expected: &PlantParameters<f64>,
    runs: &[Run],
    volts: f64,
) -> Vec<String> {
    let found = guess.effectiveness_at(volts);
    let meant = expected.effectiveness_at(volts);
    let ran = |of: fn(&PerMotor<f64>) -> f64| runs.iter().any(|r| r.log.volts.iter().any(|v| of(v) != 0.0));
    let moved = PerAxis { pitch: runs.iter().any(|r| r.moves.pitch), yaw: runs.iter().any(|r| r.moves.yaw) };
    let mut lines = Vec::new();
    let mut say = |motor: &str, axis: &str, column: &str| {
        lines.push(format!(
            "positive volts on {motor} turn {axis} the wrong way: {column} looks swapped; say so: columns \
             {column}=-NAME"
        ));
    };
    let against = |found: f64, meant: f64| found * meant < 0.0;
    if ran(|v| v.main) && moved.pitch && found.main_on_pitch < 0.0 {
        // The other motor tells which of the two it is, where it moves pitch too.
        let pitch = against(found.tail_on_pitch, meant.tail_on_pitch);
        say("v0", "pitch", if pitch { "pitch" } else { "v0" });
    }
    if ran(|v| v.tail) && moved.yaw && found.tail_on_yaw < 0.0 {
        let yaw = against(found.main_on_yaw, meant.main_on_yaw);
        say("v1", "yaw", if yaw { "yaw" } else { "v1" });
    }
    lines
}
