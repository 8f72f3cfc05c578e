//! Differential evolution (R. Storn, K. Price, J. Global Optim. 11, 1997) with SciPy's defaults: best/1/bin,
//! CR = .7, F in .5..1, drawn anew for each child.

use super::generations::{Method, Turn};
use super::{Candidate, are_points};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// Range of F.
const SCALE: [f64; 2] = [0.5, 1.0];
/// CR: how often a coordinate comes from the mutant.
const CROSSOVER: f64 = 0.7;

/// The population.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct DifferentialEvolution {
    size: usize,
    people: Vec<Vec<f64>>,
    costs: Vec<f64>,
}

impl DifferentialEvolution {
    pub(super) fn new(size: usize) -> Self {
        Self { size, people: Vec::new(), costs: Vec::new() }
    }

    /// Could `begun` have come to this?
    pub(super) fn continues(&self, begun: &Self, dimension: usize) -> bool {
        let count = if self.people.is_empty() { 0 } else { begun.size };
        self.size == begun.size && are_points(&self.people, count, dimension) && self.costs.len() == count
    }
}

/// Two different indices below `size`, neither of them `not`; `size` is at least 3.
pub(super) fn two_others(rng: &mut impl rand::Rng, size: usize, not: usize) -> [usize; 2] {
    let first = (not + rng.random_range(1..size)) % size;
    loop {
        let second = rng.random_range(0..size);
        if second != not && second != first {
            return [first, second];
        }
    }
}

impl Method for DifferentialEvolution {
    fn propose(&mut self, turn: &Turn<'_>) -> Vec<Candidate> {
        let Some(best) = (0..self.people.len()).min_by(|a, b| self.costs[*a].total_cmp(&self.costs[*b]))
        else {
            return turn.uniform(self.size);
        };
        let best = &self.people[best];
        let child = |k: usize| {
            let mut rng = turn.rng(k);
            let [first, second] = two_others(&mut rng, self.size, k);
            let scale = rng.random_range(SCALE[0]..SCALE[1]);
            let sure = rng.random_range(0..turn.dimension());
            let mut coordinate = |d: usize| {
                let [mixed, anew] = [rng.random::<f64>(), rng.random::<f64>()];
                if mixed >= CROSSOVER && d != sure {
                    return self.people[k][d];
                }
                let mutant = best[d] + scale * (self.people[first][d] - self.people[second][d]);
                if (0.0..=1.0).contains(&mutant) { mutant } else { anew }
            };
            let position = (0..turn.dimension()).map(&mut coordinate).collect();
            Candidate { position, bound: self.costs[k] }
        };
        (0..self.size).map(child).collect()
    }

    fn learn(&mut self, points: Vec<Candidate>, costs: &[f64]) {
        if self.people.is_empty() {
            self.people = points.into_iter().map(|c| c.position).collect();
            self.costs = costs.to_vec();
            return;
        }
        for (k, (point, cost)) in points.into_iter().zip(costs).enumerate() {
            if *cost <= self.costs[k] {
                self.people[k] = point.position;
                self.costs[k] = *cost;
            }
        }
    }
}
