//! The least squares behind a fit: which constants make simulated windows look like the logs?
//!
//! Unknown are the free constants, a pitch offset of each run (its zero lies anywhere within the friction
//! band) and, for every window, its initial angles and rates. The latter are many and each matters to its own
//! window alone, so they are solved for inside and projected out of residuals and Jacobian (variable
//! projection: Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973, with Kaufman's simplification). What remains
//! has as many unknowns as there are constants and runs.
//!
//! Residuals are in parts of each angle's standard deviation over its log, so the sum of squares is what the
//! fit in percent is made of; one beyond a threshold counts by its size rather than its square.

use super::constants::{CONSTANTS, COUNT, from_array, to_array};
use super::windows::{Run, Window};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::plant::{PlantParameters, State};
use twinrotor_tune::parallel::{self, NEVER, Stop};

/// What is fitted to what.
#[derive(Debug, Clone)]
pub struct Problem<'a> {
    runs: &'a [Run],
    windows: Vec<Window>,
    /// From which constants what is not fitted is taken.
    base: [f64; COUNT],
    free: Vec<usize>,
    bounds: Vec<[f64; 2]>,
    /// Residual, in parts of the angle's standard deviation, from which on it counts by its size; infinite
    /// for squares alone.
    threshold: f64,
}

/// A guess at everything but the windows' initial states.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Guess {
    /// Of the free constants, in their order.
    pub values: Vec<f64>,
    /// \[rad\] What each run's pitch reads too little.
    pub offsets: Vec<f64>,
}

/// One window at the best initial state.
#[derive(Debug, Clone)]
pub struct Block {
    /// Which.
    pub window: Window,
    /// Weighted, with outliers held down.
    pub residuals: DVector<f64>,
    /// The same by each free constant and then each run's offset, with what initial states can explain taken
    /// out; empty unless asked for.
    pub jacobian: DMatrix<f64>,
    /// The initial state that fits best.
    pub start: State<f64>,
}

/// \[s\] About how far apart the compared rows are: angles do not change faster.
const COMPARE_EVERY: f64 = 0.02;
/// Most steps to a window's initial state.
const START_STEPS: usize = 8;
/// What a better initial state could still take of the squares when it is good enough.
const SETTLED: f64 = 1e-6;
/// Steps for derivatives by differences: \[rad\] and \[rad/s\].
const STATE_STEP: f64 = 1e-6;
/// The same for constants, of their size: wide enough to look past the small kinks that friction makes in the
/// cost.
const VALUE_STEP: f64 = 1e-3;
/// Directions of the initial state that matter less than this part of the one that matters most are left
/// alone: a body held by friction forgets its initial rate.
const NEGLIGIBLE: f64 = 1e-5;

impl<'a> Problem<'a> {
    /// Fits the `free` constants to the windows, the others as `base` has them.
    pub fn new(
        runs: &'a [Run],
        windows: Vec<Window>,
        base: &PlantParameters<f64>,
        free: &[usize],
        threshold: f64,
    ) -> Self {
        let bounds = free.iter().map(|k| CONSTANTS[*k].bounds(base)).collect();
        Self { runs, windows, base: to_array(base), free: free.to_vec(), bounds, threshold }
    }

    /// The same question with other windows.
    pub fn with_windows(&self, windows: Vec<Window>) -> Self {
        Self { windows, ..self.clone() }
    }

    /// Least and most of each free constant.
    pub fn bounds(&self) -> &[[f64; 2]] {
        &self.bounds
    }

    /// Which constants are free.
    pub fn free(&self) -> &[usize] {
        &self.free
    }

    /// A constant, by its place in [`CONSTANTS`], as it was before the fit.
    pub fn base(&self, constant: usize) -> f64 {
        self.base[constant]
    }

    /// The runs themselves.
    pub fn logs(&self) -> &'a [Run] {
        self.runs
    }

    /// How many runs, and offsets.
    pub fn runs(&self) -> usize {
        self.runs.len()
    }

    /// The plant of a guess.
    pub fn plant(&self, values: &[f64]) -> PlantParameters<f64> {
        let mut all = self.base;
        for (k, value) in self.free.iter().zip(values) {
            all[*k] = *value;
        }
        from_array(&all)
    }

    /// Half the sum of squares, or nothing if `stop` says so before it is known.
    pub fn cost_until(&self, guess: &Guess, stop: Stop<'_>) -> Option<f64> {
        let blocks = self.blocks_until(guess, false, stop)?;
        Some(0.5 * blocks.iter().map(|b| b.residuals.norm_squared()).sum::<f64>())
    }

    /// Every window at its best initial state, with derivatives if they are wanted.
    pub fn blocks(&self, guess: &Guess, derivatives: bool) -> Vec<Block> {
        self.blocks_until(guess, derivatives, NEVER).expect("nothing stops it")
    }

    /// The same, or nothing if `stop` says so before all are known.
    pub fn blocks_until(&self, guess: &Guess, derivatives: bool, stop: Stop<'_>) -> Option<Vec<Block>> {
        let plant = self.plant(&guess.values);
        let rotors = self.rotor_volts(&plant);
        let moved: Vec<Moved> = if derivatives { self.moved(guess, &rotors) } else { Vec::new() };
        let block = |k: usize| {
            let window = &self.windows[k];
            let at = At { plant: &plant, offset: guess.offsets[window.run], rotor_volts: rotors[k] };
            let (start, residuals, basis) = self.settle(window, &at, derivatives);
            let jacobian = if derivatives {
                self.jacobian(k, &at, start, &residuals, &basis, &moved)
            } else {
                DMatrix::zeros(0, 0)
            };
            Block { window: *window, residuals, jacobian, start }
        };
        let places: Vec<usize> = (0..self.windows.len()).collect();
        parallel::try_map(&places, |k| if stop() { None } else { Some(block(*k)) })
    }

    fn rotor_volts(&self, plant: &PlantParameters<f64>) -> Vec<PerMotor<f64>> {
        let of_run = |run: usize| {
            let own: Vec<Window> = self.windows.iter().filter(|w| w.run == run).copied().collect();
            self.runs[run].rotor_volts(&own, plant.rotor_time_constant)
        };
        let by_run: Vec<_> = parallel::by_index(self.runs.len(), of_run);
        let mut next = vec![0; self.runs.len()];
        let take = |w: &Window| {
            next[w.run] += 1;
            by_run[w.run][next[w.run] - 1]
        };
        self.windows.iter().map(take).collect()
    }

    /// The plants with each free constant moved on a little.
    fn moved(&self, guess: &Guess, rotors: &[PerMotor<f64>]) -> Vec<Moved> {
        let moved = |k: usize| {
            let [least, most] = self.bounds[k];
            let step = VALUE_STEP * guess.values[k].abs().max(1e-4 * (most - least));
            let mut values = guess.values.clone();
            values[k] += step;
            let plant = self.plant(&values);
            let lag = CONSTANTS[self.free[k]].name.starts_with("rotor_time_constant");
            let rotor_volts = if lag { self.rotor_volts(&plant) } else { rotors.to_vec() };
            Moved { plant, step, rotor_volts }
        };
        (0..self.free.len()).map(moved).collect()
    }

    /// Weighted differences between simulation and log, in the order of the compared rows.
    fn residuals(&self, window: &Window, at: &At<'_>, start: State<f64>) -> DVector<f64> {
        let run = &self.runs[window.run];
        let stride = stride(run);
        let rows = run.log.angle.len().div_ceil(stride) as f64;
        let weight = 1.0 / rows.sqrt();
        let mut residuals = Vec::with_capacity(2 * window.rows.div_ceil(stride));
        run.simulate(window, at.plant, start, at.rotor_volts, stride, |row, angle| {
            let measured = run.log.angle[row];
            let error = PerAxis {
                pitch: (angle.pitch - at.offset - measured.pitch) / run.scale.pitch,
                yaw: (angle.yaw - measured.yaw) / run.scale.yaw,
            };
            if run.moves.pitch {
                residuals.push(weight * held_down(error.pitch, self.threshold));
            }
            if run.moves.yaw {
                residuals.push(weight * held_down(error.yaw, self.threshold));
            }
        });
        DVector::from_vec(residuals)
    }

    /// The initial state that fits a window best (Gauss and Newton, halved steps), with residuals and a basis
    /// of what other initial states would change. The slopes are taken anew only where the old ones no longer
    /// lead on, since a window is nearly linear in them, and where they end up in derivatives.
    fn settle(
        &self,
        window: &Window,
        at: &At<'_>,
        for_derivatives: bool,
    ) -> (State<f64>, DVector<f64>, DMatrix<f64>) {
        let run = &self.runs[window.run];
        let mut start = run.guess(window.first);
        start.angle.pitch += at.offset;
        let mut residuals = self.residuals(window, at, start);
        let mut slopes = Slopes::new(self.by_start(window, at, start, &residuals));
        let mut fresh = true;
        for _ in 0..START_STEPS {
            let (step, gain) = slopes.step(&residuals);
            if gain <= SETTLED * residuals.norm_squared() {
                if fresh || !for_derivatives {
                    break;
                }
                slopes = Slopes::new(self.by_start(window, at, start, &residuals));
                fresh = true;
                continue;
            }
            let gained = [1.0, 0.3].into_iter().find_map(|part| {
                let next = moved_start(run, start, &(&step * part));
                let found = self.residuals(window, at, next);
                (found.norm_squared() < residuals.norm_squared() - 0.1 * part * gain).then_some((next, found))
            });
            match gained {
                Some((next, found)) => (start, residuals, fresh) = (next, found, false),
                None if fresh => break,
                None => {
                    slopes = Slopes::new(self.by_start(window, at, start, &residuals));
                    fresh = true;
                }
            }
        }
        (start, residuals, slopes.basis)
    }

    /// Derivatives of the residuals by what of the initial state is unknown.
    fn by_start(
        &self,
        window: &Window,
        at: &At<'_>,
        start: State<f64>,
        residuals: &DVector<f64>,
    ) -> DMatrix<f64> {
        let run = &self.runs[window.run];
        let unknown = unknown(run);
        let columns: Vec<DVector<f64>> = (0..unknown)
            .map(|k| {
                let mut step = DVector::zeros(unknown);
                step[k] = STATE_STEP;
                (self.residuals(window, at, moved_start(run, start, &step)) - residuals) / STATE_STEP
            })
            .collect();
        DMatrix::from_columns(&columns)
    }

    fn jacobian(
        &self,
        index: usize,
        at: &At<'_>,
        start: State<f64>,
        residuals: &DVector<f64>,
        basis: &DMatrix<f64>,
        moved: &[Moved],
    ) -> DMatrix<f64> {
        let window = &self.windows[index];
        let mut jacobian = DMatrix::zeros(residuals.len(), moved.len() + self.runs.len());
        for (k, m) in moved.iter().enumerate() {
            let at = At { plant: &m.plant, rotor_volts: m.rotor_volts[index], ..*at };
            jacobian.set_column(k, &((self.residuals(window, &at, start) - residuals) / m.step));
        }
        if self.runs[window.run].moves.pitch {
            let at = At { offset: at.offset + STATE_STEP, ..*at };
            let mut start = start;
            start.angle.pitch += STATE_STEP;
            let column = (self.residuals(window, &at, start) - residuals) / STATE_STEP;
            jacobian.set_column(moved.len() + window.run, &column);
        }
        let explained = basis * (basis.transpose() * &jacobian);
        jacobian - explained
    }
}

/// What initial states change, by singular values.
struct Slopes {
    basis: DMatrix<f64>,
    /// From a coordinate along the basis to the initial state.
    inverse: DMatrix<f64>,
}

impl Slopes {
    fn new(slopes: DMatrix<f64>) -> Self {
        let unknowns = slopes.ncols();
        let svd = slopes.svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
            return Self { basis: DMatrix::zeros(0, 0), inverse: DMatrix::zeros(unknowns, 0) };
        };
        let most = svd.singular_values.max();
        let kept: Vec<usize> =
            (0..svd.singular_values.len()).filter(|k| svd.singular_values[*k] > NEGLIGIBLE * most).collect();
        let inverse =
            DMatrix::from_fn(unknowns, kept.len(), |i, j| v_t[(kept[j], i)] / svd.singular_values[kept[j]]);
        Self { basis: u.select_columns(&kept), inverse }
    }

    /// The step that takes out of the residuals what an initial state can, and how much of their square that
    /// is.
    fn step(&self, residuals: &DVector<f64>) -> (DVector<f64>, f64) {
        let along = self.basis.transpose() * residuals;
        (-(&self.inverse * &along), along.norm_squared())
    }
}

/// The circumstances of a simulation.
#[derive(Clone, Copy)]
struct At<'b> {
    plant: &'b PlantParameters<f64>,
    offset: f64,
    rotor_volts: PerMotor<f64>,
}

struct Moved {
    plant: PlantParameters<f64>,
    step: f64,
    rotor_volts: Vec<PerMotor<f64>>,
}

/// Every how many rows simulation and log are compared.
pub(super) fn stride(run: &Run) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive number")]
    let stride = (COMPARE_EVERY / run.log.sample_time).round() as usize;
    stride.max(1)
}

/// How many numbers of a window's initial state are unknown.
fn unknown(run: &Run) -> usize {
    2 * (usize::from(run.moves.pitch) + usize::from(run.moves.yaw))
}

/// A start moved on by what is unknown of it: angle and rate of each axis that moves.
fn moved_start(run: &Run, start: State<f64>, step: &DVector<f64>) -> State<f64> {
    let mut parts = step.iter().copied();
    let mut next = || parts.next().unwrap_or(0.0);
    let mut start = start;
    if run.moves.pitch {
        start.angle.pitch += next();
        start.rate.pitch += next();
    }
    if run.moves.yaw {
        start.angle.yaw += next();
        start.rate.yaw += next();
    }
    start
}

/// Pseudo-Huber: half its square is the loss δ²(√(1 + (r/δ)²) - 1), smooth, and linear far beyond δ.
fn held_down(residual: f64, threshold: f64) -> f64 {
    let part = residual / threshold;
    residual * (2.0 / (1.0 + (1.0 + part * part).sqrt())).sqrt()
}
