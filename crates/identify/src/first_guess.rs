//! Where a fit begins, without a guess from outside: accelerations by linear regression.
//!
//! With angles smoothed and rotors given a lag, M q̈ = torque is linear in every other constant.
//! Differentiated encoder counts bias such a fit, so it is only a start; [`doubts`](crate::doubts) asks it
//! for more.

use super::constants::{CONSTANTS, from_array, to_array};
use super::smooth::smooth;
use super::windows::Run;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use twinrotor::axes::PerMotor;
use twinrotor::plant::{FRICTION_WIDTH, PlantParameters, decay};

/// \[s\] Reach of the polynomials that rates and accelerations come from.
const REACH: f64 = 0.12;
/// Part of the largest direction below which the regression knows nothing.
const UNKNOWN: f64 = 1e-3;
/// Rows of the shortest stretch of which accelerations can be had.
const FEWEST_ROWS: usize = 20;
/// \[s\] Lags that are tried.
pub(super) const LAGS: [f64; 6] = [0.03, 0.06, 0.1, 0.15, 0.22, 0.3];

/// The constants that regression gives, at the lag that explains most, with `base`'s inertias and lag-free
/// terms.
pub fn first_guess(runs: &[Run], base: &PlantParameters<f64>) -> PlantParameters<f64> {
    let pitch: Vec<_> = runs.iter().filter(|r| r.moves.pitch).map(|run| (run, motion(run, true))).collect();
    let yaw: Vec<_> = runs.iter().filter(|r| r.moves.yaw).map(|run| (run, motion(run, false))).collect();
    let guesses = LAGS.map(|lag| regress(&pitch, &yaw, base, lag));
    let best = guesses.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    best.map_or(*base, |(plant, _)| plant)
}

/// One regression for each axis: (regressors, acceleration times inertia), weighted alike.
fn regress(
    pitch: &[(&Run, Vec<Motion>)],
    yaw: &[(&Run, Vec<Motion>)],
    base: &PlantParameters<f64>,
    lag: f64,
) -> (PlantParameters<f64>, f64) {
    let mut values = to_array(base);
    let mut set = |name: &str, value: f64| {
        if let Some(k) = CONSTANTS.iter().position(|c| c.name == name) {
            values[k] = value;
        }
    };
    let of = |moved: &[(&Run, Vec<Motion>)], is_pitch: bool| {
        solve(moved.iter().map(|(run, motion)| rows(run, motion, base, lag, is_pitch)))
    };
    let ((pitch, missed_pitch), (yaw, missed_yaw)) = (of(pitch, true), of(yaw, false));
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
pub(super) const TERMS: usize = 9;

/// One row of a regression.
#[derive(Debug, Clone, Copy)]
pub(super) struct Term {
    /// What acts for each unit of its constant: both motors' volts, these times their size, minus rate and
    /// its sign, the other rotor's change, minus the sine of pitch, and 1.
    pub(super) terms: [f64; TERMS],
    /// \[N m\] Inertia times acceleration.
    pub(super) torque: f64,
    /// \[N m\] Of the centre of mass, known beforehand.
    pub(super) weight: f64,
}

/// The least squares solution over all runs, and the part of the accelerations that it misses.
fn solve(parts: impl Iterator<Item = Vec<Term>>) -> ([f64; TERMS], f64) {
    let rows: Vec<([f64; TERMS], f64)> = parts.flatten().map(|t| (t.terms, t.torque + t.weight)).collect();
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

/// How one axis moves in a stretch of a run, as polynomials have it.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    stretch: Range<usize>,
    rate: Vec<f64>,
    accel: Vec<f64>,
}

/// The motion of one axis in every stretch that is long enough.
pub(super) fn motion(run: &Run, is_pitch: bool) -> Vec<Motion> {
    let log = &run.log;
    let of = |stretch: &Range<usize>| {
        let angle: Vec<f64> =
            log.angle[stretch.clone()].iter().map(|a| if is_pitch { a.pitch } else { a.yaw }).collect();
        let rate: Vec<f64> = smooth(&angle, log.sample_time, REACH).iter().map(|s| s.rate).collect();
        let accel = smooth(&rate, log.sample_time, REACH).iter().map(|s| s.rate).collect();
        Motion { stretch: stretch.clone(), rate, accel }
    };
    log.stretches.iter().filter(|stretch| stretch.len() >= FEWEST_ROWS).map(of).collect()
}

/// The rows of one axis of a run in which it moves.
pub(super) fn rows(
    run: &Run,
    motion: &[Motion],
    base: &PlantParameters<f64>,
    lag: f64,
    is_pitch: bool,
) -> Vec<Term> {
    let log = &run.log;
    let keep = decay(log.sample_time, lag);
    let coupling = base.mass * base.center_of_mass * base.center_of_mass;
    let mut found = Vec::new();
    for Motion { stretch, rate, accel } in motion {
        let mut acting: PerMotor<f64> = log.volts[stretch.start];
        for (k, volts) in log.volts[stretch.clone()].iter().enumerate() {
            let missing = volts.minus(acting);
            if k % super::problem::stride(run) == 0 && rate[k].abs() > 5.0 * FRICTION_WIDTH {
                let squared = acting.map(|v| v * v.abs());
                let (sine, cosine) = log.angle[stretch.start + k].pitch.sin_cos();
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
                found.push(Term { terms, torque: inertia * accel[k], weight });
            }
            acting = volts.minus(missing.scaled(keep));
        }
    }
    found
}
