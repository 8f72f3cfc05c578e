//! CMA-ES (N. Hansen, "The CMA Evolution Strategy: A Tutorial", arXiv:1604.00772, the numbers of its Table 1
//! without negative weights), with restarts of doubled population (A. Auger, N. Hansen, CEC 2005).
//!
//! Bounds by reflection: the search runs in unbounded space, and a face of the cube mirrors it.

use super::Candidate;
use super::generations::{Method, Turn, free, ranking};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

/// First step size, as a part of the cube.
const STEP: f64 = 0.3;
/// A distribution narrower than this in every direction has converged.
const NARROW: f64 = 1e-10;
/// A covariance whose axes differ by more than this (squared) is spent.
const ELONGATED: f64 = 1e14;
/// More candidates than a budget lets a generation grow to.
const MOST_CANDIDATES: usize = 1 << 31;

/// The distribution and its paths.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct CovarianceAdaptation {
    /// λ; 0 for 4 + 3 ln n.
    population: usize,
    /// Restart before the next generation?
    spent: bool,
    generation: u32,
    mean: Vec<f64>,
    step: f64,
    covariance: Vec<f64>,
    covariance_path: Vec<f64>,
    step_path: Vec<f64>,
    /// B D of the covariance B D² Bᵀ.
    root: Vec<f64>,
    /// B D⁻¹ Bᵀ.
    inverse_root: Vec<f64>,
    /// What was asked for, before the mirrors.
    asked: Vec<Vec<f64>>,
    /// The best cost of the last generations.
    recent: Vec<f64>,
}

/// Hansen's Table 1 for λ candidates in n dimensions.
struct Rates {
    weights: Vec<f64>,
    effective: f64,
    step: f64,
    damping: f64,
    path: f64,
    rank_one: f64,
    rank_mu: f64,
    expected_norm: f64,
}

impl Rates {
    fn new(lambda: usize, dimension: usize) -> Self {
        let n = dimension as f64;
        let raw: Vec<f64> = (0..lambda / 2)
            .map(|k| libm::log(0.5 * (lambda as f64 + 1.0)) - libm::log(k as f64 + 1.0))
            .collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / sum).collect();
        let effective = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let step = (effective + 2.0) / (n + effective + 5.0);
        let rank_one = 2.0 / ((n + 1.3) * (n + 1.3) + effective);
        let rank_mu = (2.0 * (effective - 2.0 + 1.0 / effective) / ((n + 2.0) * (n + 2.0) + effective))
            .min(1.0 - rank_one);
        Self {
            weights,
            effective,
            step,
            damping: 1.0 + 2.0 * (((effective - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + step,
            path: (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n),
            rank_one,
            rank_mu,
            expected_norm: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}

/// Where a coordinate is seen between mirrors at 0 and 1.
fn mirrored(x: f64) -> f64 {
    let turn = x.rem_euclid(2.0);
    if turn > 1.0 { 2.0 - turn } else { turn }
}

impl CovarianceAdaptation {
    pub(super) fn new(population: usize) -> Self {
        Self { population, ..Self::default() }
    }

    /// Could `begun` have come to this?
    pub(super) fn continues(&self, begun: &Self, dimension: usize) -> bool {
        let size = if self.mean.is_empty() { 0 } else { dimension };
        let has =
            |numbers: &[f64], count: usize| numbers.len() == count && numbers.iter().all(|x| x.is_finite());
        (self.mean.is_empty() == (*self == *begun))
            && (begun.population..=MOST_CANDIDATES).contains(&self.population)
            && [&self.mean, &self.covariance_path, &self.step_path].iter().all(|path| has(path, size))
            && [&self.covariance, &self.root, &self.inverse_root].iter().all(|all| has(all, size * size))
            && self.step.is_finite()
            && self.generation < u32::MAX
    }

    /// A wide distribution around a random point.
    fn restart(&mut self, turn: &Turn<'_>) {
        let n = turn.dimension();
        if self.population == 0 {
            let customary = 4.0 + 3.0 * libm::log(n as f64);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a small number above 4"
            )]
            let customary = customary as usize;
            self.population = customary;
        } else if self.spent {
            self.population *= 2;
        }
        let mut rng = turn.draws.of_move(usize::MAX - turn.done);
        let identity = DMatrix::<f64>::identity(n, n).as_slice().to_vec();
        *self = Self {
            population: self.population,
            mean: (0..n).map(|_| rng.random()).collect(),
            step: STEP,
            covariance: identity.clone(),
            covariance_path: vec![0.0; n],
            step_path: vec![0.0; n],
            root: identity.clone(),
            inverse_root: identity,
            ..Self::default()
        };
    }

    fn decompose(&mut self, covariance: DMatrix<f64>) {
        let n = covariance.nrows();
        // The search for its axes would not end.
        if covariance.iter().any(|x| !x.is_finite()) {
            self.spent = true;
            return;
        }
        let eigen = SymmetricEigen::new(covariance.clone());
        let (most, least) = (eigen.eigenvalues.max(), eigen.eigenvalues.min());
        let converged = self.step * most.max(0.0).sqrt() < NARROW;
        if !(least > 0.0 && most / least < ELONGATED && self.step.is_finite()) || converged {
            self.spent = true;
            return;
        }
        let scale = eigen.eigenvalues.map(f64::sqrt);
        let root = &eigen.eigenvectors * DMatrix::from_diagonal(&scale);
        let inverse = &eigen.eigenvectors
            * DMatrix::from_diagonal(&scale.map(|d| 1.0 / d))
            * eigen.eigenvectors.transpose();
        debug_assert_eq!(root.nrows(), n);
        self.covariance = covariance.as_slice().to_vec();
        self.root = root.as_slice().to_vec();
        self.inverse_root = inverse.as_slice().to_vec();
    }
}

impl Method for CovarianceAdaptation {
    fn propose(&mut self, turn: &Turn<'_>) -> Vec<Candidate> {
        if self.mean.is_empty() || self.spent {
            self.restart(turn);
        }
        let n = turn.dimension();
        let root = DMatrix::from_column_slice(n, n, &self.root);
        let mean = DVector::from_column_slice(&self.mean);
        let sample = |k| {
            let mut rng = turn.rng(k);
            let normal = DVector::from_fn(n, |_, _| StandardNormal.sample(&mut rng));
            (&mean + self.step * (&root * normal)).as_slice().to_vec()
        };
        self.asked = (0..self.population.min(turn.budget - turn.done)).map(sample).collect();
        self.asked.iter().map(|x| free(x.iter().copied().map(mirrored).collect())).collect()
    }

    fn learn(&mut self, _points: Vec<Candidate>, costs: &[f64]) {
        let n = self.mean.len();
        let rates = Rates::new(self.population, n);
        let order = ranking(costs);
        let old = DVector::from_column_slice(&self.mean);
        let steps: Vec<DVector<f64>> = order
            .iter()
            .take(rates.weights.len())
            .map(|k| (DVector::from_column_slice(&self.asked[*k]) - &old) / self.step)
            .collect();
        let mut mean_step = DVector::zeros(n);
        for (w, y) in rates.weights.iter().zip(&steps) {
            mean_step += *w * y;
        }
        self.generation += 1;
        self.mean = (&old + self.step * &mean_step).as_slice().to_vec();

        let inverse = DMatrix::from_column_slice(n, n, &self.inverse_root);
        let c = rates.step;
        let step_path = (1.0 - c) * DVector::from_column_slice(&self.step_path)
            + (c * (2.0 - c) * rates.effective).sqrt() * (inverse * &mean_step);
        let norm = step_path.norm();
        let settled = 1.0 - libm::pow(1.0 - c, 2.0 * f64::from(self.generation));
        let moving = norm / settled.sqrt() < (1.4 + 2.0 / (n as f64 + 1.0)) * rates.expected_norm;
        let c = rates.path;
        let push = if moving { (c * (2.0 - c) * rates.effective).sqrt() } else { 0.0 };
        let path = (1.0 - c) * DVector::from_column_slice(&self.covariance_path) + push * &mean_step;
        let lost = if moving { 0.0 } else { c * (2.0 - c) };
        let kept = 1.0 - rates.rank_one - rates.rank_mu + rates.rank_one * lost;
        let mut covariance = kept * DMatrix::from_column_slice(n, n, &self.covariance);
        covariance += rates.rank_one * (&path * path.transpose());
        for (w, y) in rates.weights.iter().zip(&steps) {
            covariance += rates.rank_mu * *w * (y * y.transpose());
        }
        self.step *= libm::exp((rates.step / rates.damping) * (norm / rates.expected_norm - 1.0));
        self.step_path = step_path.as_slice().to_vec();
        self.covariance_path = path.as_slice().to_vec();
        self.decompose(covariance);

        // No better than ten generations and more ago: as flat as it gets.
        self.recent.push(costs[order[0]]);
        let window = 10 + 30 * n / self.population;
        if self.recent.len() > window {
            let recent = &self.recent[self.recent.len() - window..];
            let (low, high) = recent.iter().fold((f64::MAX, f64::MIN), |(l, h), c| (l.min(*c), h.max(*c)));
            self.spent |= high - low <= 1e-12 * high.abs();
        }
    }
}
