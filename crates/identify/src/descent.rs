//! Levenberg and Marquardt's descent, within bounds.

use super::problem::{Block, Guess, Problem};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use twinrotor_tune::parallel::Stop;

/// Descends from a guess to the nearest minimum. Constants stay within their bounds by p = least + (most -
/// least)(1 + sin x)/2, as MINUIT does it (F. James, CERN D506). Nothing comes of it if `stop` says so first.
pub fn descend(problem: &Problem<'_>, from: &Guess, stop: Stop<'_>) -> Option<(Guess, f64)> {
    let mut start = from.clone();
    for (value, [least, most]) in start.values.iter_mut().zip(problem.bounds()) {
        // At a bound the sine is flat and the descent would not move.
        let margin = EDGE * (most - least);
        *value = value.clamp(least + margin, most - margin);
    }
    let at = position(problem, &start);
    let blocks = problem.blocks_until(&start, false, stop)?;
    let target = Descent { problem, at, blocks: Some(blocks), stop };
    let method =
        LevenbergMarquardt::new().with_ftol(1e-6).with_xtol(1e-6).with_gtol(1e-9).with_patience(PATIENCE);
    let (ended, report) = method.minimize(target);
    let whole = ended.blocks.is_some() && !stop();
    whole.then(|| (guess(problem, &ended.at), report.objective_function))
}

/// Costs that a descent may take, for each unknown.
const PATIENCE: usize = 3;
/// Part of a range that a start keeps from its bounds.
const EDGE: f64 = 1e-6;
/// \[rad\] One unit of an offset's coordinate.
const OFFSET_UNIT: f64 = 0.01;

struct Descent<'a> {
    problem: &'a Problem<'a>,
    at: DVector<f64>,
    /// Nothing from when it was stopped on, which ends the descent.
    blocks: Option<Vec<Block>>,
    stop: Stop<'a>,
}

fn position(problem: &Problem<'_>, guess: &Guess) -> DVector<f64> {
    let inside =
        guess.values.iter().zip(problem.bounds()).map(|(value, [least, most])| {
            (2.0 * (value - least) / (most - least) - 1.0).clamp(-1.0, 1.0).asin()
        });
    let all: Vec<f64> = inside.chain(guess.offsets.iter().map(|o| o / OFFSET_UNIT)).collect();
    DVector::from_vec(all)
}

fn guess(problem: &Problem<'_>, at: &DVector<f64>) -> Guess {
    let bounds = problem.bounds();
    let values =
        at.iter().zip(bounds).map(|(x, [least, most])| least + (most - least) * 0.5 * (1.0 + x.sin()));
    let values = values.collect();
    Guess { values, offsets: at.iter().skip(bounds.len()).map(|x| x * OFFSET_UNIT).collect() }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Descent<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.at.copy_from(x);
        self.blocks = self.problem.blocks_until(&guess(self.problem, x), false, self.stop);
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let all: Vec<f64> = self.blocks.as_ref()?.iter().flat_map(|b| b.residuals.iter().copied()).collect();
        all.iter().all(|r| r.is_finite()).then(|| DVector::from_vec(all))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let blocks = self.problem.blocks_until(&guess(self.problem, &self.at), true, self.stop)?;
        let rows = blocks.iter().map(|b| b.residuals.len()).sum();
        let mut all = DMatrix::zeros(rows, self.at.len());
        let mut row = 0;
        for block in &blocks {
            all.rows_mut(row, block.jacobian.nrows()).copy_from(&block.jacobian);
            row += block.jacobian.nrows();
        }
        let bounds = self.problem.bounds();
        for (k, x) in self.at.iter().enumerate() {
            let slope = bounds.get(k).map_or(OFFSET_UNIT, |[least, most]| (most - least) * 0.5 * x.cos());
            all.column_mut(k).scale_mut(slope);
        }
        all.iter().all(|x| x.is_finite()).then_some(all)
    }
}
