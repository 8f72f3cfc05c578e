//! Particle swarm optimisation (J. Kennedy, R. Eberhart, 1995) with the constriction coefficients of M. Clerc
//! and J. Kennedy, IEEE Trans. Evol. Comput. 6(1), 2002, every particle informed by the best of all.

use super::generations::{Method, Turn};
use super::{Candidate, are_points};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// χ of Clerc and Kennedy.
const INERTIA: f64 = 0.729_844;
/// χ φ/2 for φ = 4.1.
const ATTRACTION: f64 = 1.496_18;

/// The particles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Swarm {
    size: usize,
    positions: Vec<Vec<f64>>,
    velocities: Vec<Vec<f64>>,
    /// Each particle's best point and its cost.
    memories: Vec<(Vec<f64>, f64)>,
}

impl Swarm {
    pub(super) fn new(size: usize) -> Self {
        Self { size, positions: Vec::new(), velocities: Vec::new(), memories: Vec::new() }
    }

    /// Could `begun` have come to this?
    pub(super) fn continues(&self, begun: &Self, dimension: usize) -> bool {
        let count = if self.memories.is_empty() { 0 } else { begun.size };
        let remembered: Vec<Vec<f64>> = self.memories.iter().map(|(position, _)| position.clone()).collect();
        let lists = [&self.positions, &self.velocities, &remembered];
        self.size == begun.size && lists.iter().all(|points| are_points(points, count, dimension))
    }
}

impl Method for Swarm {
    fn propose(&mut self, turn: &Turn<'_>) -> Vec<Candidate> {
        let Some((best, _)) = self.memories.iter().min_by(|a, b| a.1.total_cmp(&b.1)) else {
            self.velocities = vec![vec![0.0; turn.dimension()]; self.size];
            return turn.uniform(self.size);
        };
        let mut generation = Vec::with_capacity(self.size);
        for (k, ((x, v), (own, cost))) in
            self.positions.iter().zip(&mut self.velocities).zip(&self.memories).enumerate()
        {
            let mut rng = turn.rng(k);
            let mut next = x.clone();
            for d in 0..x.len() {
                let [to_own, to_best] = [rng.random::<f64>(), rng.random::<f64>()];
                v[d] = INERTIA * v[d] + ATTRACTION * (to_own * (own[d] - x[d]) + to_best * (best[d] - x[d]));
                next[d] = x[d] + v[d];
                // A wall takes the speed of what hits it.
                if !(0.0..=1.0).contains(&next[d]) {
                    v[d] = 0.0;
                }
            }
            generation.push(Candidate { position: next, bound: *cost });
        }
        generation
    }

    fn learn(&mut self, points: Vec<Candidate>, costs: &[f64]) {
        self.positions = points.into_iter().map(|c| c.position).collect();
        let now = self.positions.iter().cloned().zip(costs.iter().copied());
        if self.memories.is_empty() {
            self.memories = now.collect();
            return;
        }
        for (memory, now) in self.memories.iter_mut().zip(now) {
            if now.1 < memory.1 {
                *memory = now;
            }
        }
    }
}
