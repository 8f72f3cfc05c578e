//! Grey Wolf Optimizer (S. Mirjalili, S. M. Mirjalili, A. Lewis, Adv. Eng. Softw. 69, 2014), as published.
//!
//! Its distance |C X - x|, with C uniform in 0..2, is taken from the origin of the coordinates: the method is
//! drawn to zero. It is kept so, in the box's own coordinates; the tests move the optimum away.

use super::generations::{Method, Turn, free, ranking};
use super::{Candidate, are_points};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// The pack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Wolves {
    size: usize,
    positions: Vec<Vec<f64>>,
    /// The three best points ever seen, with their costs.
    leaders: Vec<(Vec<f64>, f64)>,
}

impl Wolves {
    pub(super) fn new(size: usize) -> Self {
        Self { size, positions: Vec::new(), leaders: Vec::new() }
    }

    /// Could `begun` have come to this?
    pub(super) fn continues(&self, begun: &Self, dimension: usize) -> bool {
        let count = if self.positions.is_empty() { 0 } else { begun.size };
        let leaders: Vec<Vec<f64>> = self.leaders.iter().map(|(position, _)| position.clone()).collect();
        self.size == begun.size
            && are_points(&self.positions, count, dimension)
            && are_points(&leaders, count.min(3), dimension)
    }
}

impl Method for Wolves {
    fn propose(&mut self, turn: &Turn<'_>) -> Vec<Candidate> {
        if self.positions.is_empty() {
            return turn.uniform(self.size);
        }
        let reach = 2.0 * (1.0 - turn.part());
        // Where the cube has the box's zero.
        let origin: Vec<f64> = turn.bounds.as_slice().iter().map(|[low, high]| -low / (high - low)).collect();
        let hunt = |(k, x): (usize, &Vec<f64>)| {
            let mut rng = turn.rng(k);
            let mut coordinate = |d: usize| {
                let mut towards = |leader: &[f64]| {
                    let [a, c] = [rng.random::<f64>(), rng.random::<f64>()];
                    let distance = (2.0 * c * (leader[d] - origin[d]) - (x[d] - origin[d])).abs();
                    leader[d] - reach * (2.0 * a - 1.0) * distance
                };
                self.leaders.iter().map(|(leader, _)| towards(leader)).sum::<f64>()
                    / self.leaders.len() as f64
            };
            free((0..x.len()).map(&mut coordinate).collect())
        };
        self.positions.iter().enumerate().map(hunt).collect()
    }

    fn learn(&mut self, points: Vec<Candidate>, costs: &[f64]) {
        self.positions = points.into_iter().map(|c| c.position).collect();
        for k in ranking(costs).into_iter().take(3) {
            self.leaders.push((self.positions[k].clone(), costs[k]));
        }
        self.leaders.sort_by(|a, b| a.1.total_cmp(&b.1));
        self.leaders.truncate(3);
    }
}
