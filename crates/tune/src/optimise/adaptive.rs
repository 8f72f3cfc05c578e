//! `fpa-adaptive`: flower pollination with what comparing it with its peers teaches. Against the form of the
//! paper's Fig. 4:
//!
//! | | paper | here |
//! |---|---|---|
//! | a flower is replaced | always | by a better one |
//! | local move | x_g + c (x_j - x_k) | x_i + F (x_b - x_i) + F (x_j - x_k), b one of the best flowers |
//! | coordinates that move | all | each with probability R: flower constancy, taken at its word |
//! | F, R | c = .5, 1 | drawn around what made flowers better before (R. Tanabe, A. Fukunaga, "Success-history based parameter adaptation", CEC 2013) |
//! | global move, with probability | p = .03 | what its share of the improvements was, .02 to .3 |
//! | global move | x_g + c L (x_i - x_g) | x_i + F L (x_b - x_i), Yang's, towards one of the best |
//! | population | 50 | falls over the budget from 25 to 5 (L-SHADE, CEC 2014) |
//! | beyond a bound | on the bound | halfway from the flower to the bound |

use super::evolution::two_others;
use super::generations::{Method, Turn, ranking};
use super::levy_step;
use super::{Candidate, are_points};
use rand::{Rng, RngExt};
use rand_distr::{Cauchy, Distribution, Normal};
use serde::{Deserialize, Serialize};

/// How many successes are remembered.
const MEMORY: usize = 5;
/// The best flowers that attract: this part of all, at least two.
const BEST: f64 = 0.15;
/// Flowers at the end.
const LAST: usize = 5;
/// Range of the share of global moves.
const GLOBAL: [f64; 2] = [0.02, 0.3];

/// How a flower was moved.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Manner {
    global: bool,
    /// F.
    scale: f64,
    /// R.
    rate: f64,
}

/// The flowers, and what has worked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct AdaptiveFlowers {
    size: usize,
    flowers: Vec<Vec<f64>>,
    costs: Vec<f64>,
    manners: Vec<Manner>,
    /// F and R that worked, oldest overwritten first.
    memory: Vec<[f64; 2]>,
    next: usize,
    /// Share of global moves.
    global: f64,
}

impl AdaptiveFlowers {
    pub(super) fn new(size: usize) -> Self {
        Self {
            size,
            flowers: Vec::new(),
            costs: Vec::new(),
            manners: Vec::new(),
            memory: vec![[0.5, 0.8]; MEMORY],
            next: 0,
            global: 0.1,
        }
    }

    /// Could `begun` have come to this?
    pub(super) fn continues(&self, begun: &Self, dimension: usize) -> bool {
        let count = self.flowers.len();
        let finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
        self.size == begun.size
            && (count == 0 || (self.size.min(LAST)..=self.size).contains(&count))
            && are_points(&self.flowers, count, dimension)
            && self.costs.len() == count
            && self.memory.len() == MEMORY
            && self.memory.iter().all(|pair| finite(pair))
            && self.next < MEMORY
            && (0.0..=1.0).contains(&self.global)
    }

    fn manner(&self, rng: &mut impl Rng) -> Manner {
        let global = rng.random::<f64>() < self.global;
        let [scale, rate] = self.memory[rng.random_range(0..MEMORY)];
        let normal = Normal::new(rate, 0.1).expect("a finite mean");
        let cauchy = Cauchy::new(scale, 0.1).expect("a finite median");
        let rate = normal.sample(rng).clamp(0.0, 1.0);
        let scale = cauchy.sample(rng).clamp(0.1, 1.0);
        Manner { global, scale, rate }
    }

    fn moved(&self, k: usize, order: &[usize], manner: Manner, rng: &mut impl Rng) -> Vec<f64> {
        let count = self.flowers.len();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a part of a small number"
        )]
        let attractive = ((BEST * count as f64).round() as usize).clamp(2, count);
        let best = &self.flowers[order[rng.random_range(0..attractive)]];
        let [first, second] = two_others(rng, count, k);
        let (own, first, second) = (&self.flowers[k], &self.flowers[first], &self.flowers[second]);
        let sure = rng.random_range(0..own.len());
        (0..own.len())
            .map(|d| {
                let mixed = rng.random::<f64>();
                let levy = levy_step(rng, 1.5);
                if mixed >= manner.rate && d != sure {
                    return own[d];
                }
                let moved = if manner.global {
                    own[d] + manner.scale * levy * (best[d] - own[d])
                } else {
                    own[d] + manner.scale * (best[d] - own[d] + first[d] - second[d])
                };
                if moved < 0.0 {
                    0.5 * own[d]
                } else if moved > 1.0 {
                    0.5 * (own[d] + 1.0)
                } else {
                    moved
                }
            })
            .collect()
    }

    /// Means of what worked, weighted by how much it gained; Lehmer's for F, which keeps it from sinking.
    fn remember(&mut self, worked: &[(Manner, f64)]) {
        let total: f64 = worked.iter().map(|(_, gain)| gain).sum();
        if total <= 0.0 || !total.is_finite() {
            return;
        }
        let sum = |of: fn(&Manner) -> f64| worked.iter().map(|(m, gain)| gain / total * of(m)).sum::<f64>();
        let scale = sum(|m| m.scale * m.scale) / sum(|m| m.scale);
        self.memory[self.next] = [scale, sum(|m| m.rate)];
        self.next = (self.next + 1) % MEMORY;
        let share = sum(|m| f64::from(u8::from(m.global)));
        self.global = (0.8 * self.global + 0.2 * share).clamp(GLOBAL[0], GLOBAL[1]);
    }
}

impl Method for AdaptiveFlowers {
    fn propose(&mut self, turn: &Turn<'_>) -> Vec<Candidate> {
        if self.flowers.is_empty() {
            return turn.uniform(self.size);
        }
        let spread = self.size.saturating_sub(LAST) as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 5 and the first size"
        )]
        let wanted = self.size - (spread * turn.part()).round() as usize;
        let order = ranking(&self.costs);
        if wanted < self.flowers.len() {
            self.flowers = order[..wanted].iter().map(|k| self.flowers[*k].clone()).collect();
            self.costs = order[..wanted].iter().map(|k| self.costs[*k]).collect();
        }
        let order = ranking(&self.costs);
        let mut generation = Vec::new();
        self.manners.clear();
        for k in 0..self.flowers.len() {
            let mut rng = turn.rng(k);
            let manner = self.manner(&mut rng);
            let position = self.moved(k, &order, manner, &mut rng);
            self.manners.push(manner);
            generation.push(Candidate { position, bound: self.costs[k] });
        }
        generation
    }

    fn learn(&mut self, points: Vec<Candidate>, costs: &[f64]) {
        if self.flowers.is_empty() {
            self.flowers = points.into_iter().map(|c| c.position).collect();
            self.costs = costs.to_vec();
            return;
        }
        let mut worked = Vec::new();
        for (k, (point, cost)) in points.into_iter().zip(costs).enumerate() {
            if *cost <= self.costs[k] {
                if *cost < self.costs[k] {
                    worked.push((self.manners[k], self.costs[k] - cost));
                }
                self.flowers[k] = point.position;
                self.costs[k] = *cost;
            }
        }
        self.remember(&worked);
    }
}
