//! What all methods share that move a whole generation at once: the budget, the bounds, the best so far.
//!
//! Methods work in the unit cube, so that a coordinate's scale means nothing to them. They were written for
//! this trait because none of the crates that have them (argmin, cmaes, metaheuristics-nature) can be asked
//! and told, saved between two generations, and resumed to the same bytes.

use super::{
    AdaptiveFlowers, Best, Bounds, Candidate, CovarianceAdaptation, DifferentialEvolution, Draws, Genetic,
    NelderMead, Optimiser, Samples, Swarm, Wolves,
};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

/// What a method is told of where the search stands.
#[derive(Debug)]
pub(super) struct Turn<'a> {
    /// Random numbers.
    pub draws: Draws,
    /// Evaluations used so far.
    pub done: usize,
    /// Evaluations there are in all.
    pub budget: usize,
    /// The box that the unit cube stands for.
    pub bounds: &'a Bounds,
}

impl Turn<'_> {
    /// How many coordinates.
    pub(super) fn dimension(&self) -> usize {
        self.bounds.dimension()
    }

    /// The random numbers of the `k`th candidate of this turn.
    pub(super) fn rng(&self, k: usize) -> impl Rng + use<> {
        self.draws.of_move(self.done + k)
    }

    /// `count` points, uniform in the cube.
    pub(super) fn uniform(&self, count: usize) -> Vec<Candidate> {
        (0..count)
            .map(|k| {
                let mut rng = self.rng(k);
                free((0..self.dimension()).map(|_| rng.random()).collect())
            })
            .collect()
    }

    /// Which part of the budget is used, 0..1.
    pub(super) fn part(&self) -> f64 {
        self.done as f64 / self.budget as f64
    }
}

/// A candidate whose exact cost matters, however high.
pub(super) fn free(position: Vec<f64>) -> Candidate {
    Candidate { position, bound: f64::INFINITY }
}

/// The indices of `costs` from the lowest cost to the highest.
pub(super) fn ranking(costs: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..costs.len()).collect();
    order.sort_by(|a, b| costs[*a].total_cmp(&costs[*b]));
    order
}

/// A method of search in the unit cube, a generation at a time.
pub(super) trait Method {
    /// The next generation. Coordinates outside the cube are moved to its face before they are evaluated.
    fn propose(&mut self, turn: &Turn<'_>) -> Vec<Candidate>;

    /// The generation as it was evaluated, and its costs; none is NaN.
    fn learn(&mut self, points: Vec<Candidate>, costs: &[f64]);
}

/// The methods there are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) enum AnyMethod {
    Adaptive(AdaptiveFlowers),
    Genetic(Genetic),
    Swarm(Swarm),
    Wolves(Wolves),
    Evolution(DifferentialEvolution),
    Covariance(CovarianceAdaptation),
    Simplex(NelderMead),
    Samples(Samples),
}

impl AnyMethod {
    /// Could `begun`, which has only begun, have come to this in so many dimensions?
    fn continues(&self, begun: &Self, dimension: usize) -> bool {
        match (self, begun) {
            (Self::Adaptive(then), Self::Adaptive(begun)) => then.continues(begun, dimension),
            (Self::Genetic(then), Self::Genetic(begun)) => then.continues(begun, dimension),
            (Self::Swarm(then), Self::Swarm(begun)) => then.continues(begun, dimension),
            (Self::Wolves(then), Self::Wolves(begun)) => then.continues(begun, dimension),
            (Self::Evolution(then), Self::Evolution(begun)) => then.continues(begun, dimension),
            (Self::Covariance(then), Self::Covariance(begun)) => then.continues(begun, dimension),
            (Self::Simplex(then), Self::Simplex(_)) => then.is_sound(dimension),
            (Self::Samples(then), Self::Samples(begun)) => then == begun,
            _ => false,
        }
    }

    fn as_method(&mut self) -> &mut dyn Method {
        match self {
            Self::Adaptive(m) => m,
            Self::Genetic(m) => m,
            Self::Swarm(m) => m,
            Self::Wolves(m) => m,
            Self::Evolution(m) => m,
            Self::Covariance(m) => m,
            Self::Simplex(m) => m,
            Self::Samples(m) => m,
        }
    }
}

/// A search by one of these methods.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Generations {
    method: AnyMethod,
    bounds: Bounds,
    draws: Draws,
    budget: usize,
    done: usize,
    best: Option<Best>,
    /// What was asked for and is not told yet, in the unit cube.
    asked: Vec<Candidate>,
}

impl Generations {
    pub(super) fn new(method: AnyMethod, bounds: Bounds, draws: Draws, budget: usize) -> Self {
        Self { method, bounds, draws, budget, done: 0, best: None, asked: Vec::new() }
    }

    /// Could `begun`, which has only begun, have come to this?
    pub(super) fn continues(&self, begun: &Self) -> bool {
        let same = (&self.bounds, self.draws, self.budget) == (&begun.bounds, begun.draws, begun.budget);
        let untouched = self.method == begun.method && self.best.is_none();
        same && self.done <= self.budget
            && (self.done > 0 || untouched)
            && self.best.as_ref().is_none_or(|best| self.bounds.has(&best.position))
            && self.asked.is_empty()
            && self.method.continues(&begun.method, self.bounds.dimension())
    }

    pub(super) fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn position(&self, unit: &[f64]) -> Vec<f64> {
        let mut position = self.bounds.at(|k| unit[k]);
        // Rounding could carry the far face of the cube beyond the bound.
        self.bounds.clip(&mut position);
        position
    }
}

impl Optimiser for Generations {
    fn ask(&mut self) -> Vec<Candidate> {
        let left = self.budget - self.done;
        if left == 0 {
            return Vec::new();
        }
        let turn = Turn { draws: self.draws, done: self.done, budget: self.budget, bounds: &self.bounds };
        self.asked = self.method.as_method().propose(&turn);
        self.asked.truncate(left);
        for candidate in &mut self.asked {
            for x in &mut candidate.position {
                *x = x.clamp(0.0, 1.0);
            }
        }
        self.asked
            .iter()
            .map(|c| Candidate { position: self.position(&c.position), bound: c.bound })
            .collect()
    }

    fn tell(&mut self, costs: &[f64]) {
        let asked = std::mem::take(&mut self.asked);
        let costs: Vec<f64> = costs.iter().map(|c| if c.is_nan() { f64::INFINITY } else { *c }).collect();
        self.done += asked.len();
        for (candidate, cost) in asked.iter().zip(&costs) {
            if self.best.as_ref().is_none_or(|b| *cost < b.cost) {
                self.best = Some(Best { position: self.position(&candidate.position), cost: *cost });
            }
        }
        if self.done < self.budget {
            self.method.as_method().learn(asked, &costs);
        }
    }

    fn best(&self) -> Option<&Best> {
        self.best.as_ref()
    }

    fn evaluations(&self) -> usize {
        self.done
    }

    fn budget(&self) -> usize {
        self.budget
    }
}
