//! The Flower Pollination Algorithm (X.-S. Yang, "Flower pollination algorithm for global optimization", UCNC
//! 2012), in the three forms that are called by this name:
//!
//! | | [`Variant::Paper`] | [`Variant::Yang`] | [`Variant::Demo`] |
//! |---|---|---|---|
//! | source | Fig. 4 and Table 2 of the paper on the 2-DOF helicopter | Yang 2012, Fig. 1 | the demo code that most copies descend from |
//! | global move, with probability | p = .03 | p = .8 | **1 - p** = .2: the switch is inverted |
//! | global move | x_g + c L (x_i - x_g) | x_i + γ L (g* - x_i) | x_i + .01 L (x_i - g*) |
//! | local move | x_g + c (x_j - x_k) | x_i + ε (x_j - x_k), ε ~ U(0, 1) | the same |
//! | a flower is replaced | always | by a better one | by one that is not worse |
//! | the best flower g* changes | at once | after a whole generation | at once |
//!
//! So the paper's "local pollination" searches around the *best* flower (differential evolution's best/1
//! without crossover), not around the flower itself, and its p makes the global move a rarity. Where the
//! paper is silent we take: Lévy exponent 1.5 by Mantegna's method, one draw a dimension, coordinates outside
//! the bounds moved to the bound, j and k two different flowers drawn from the whole population, uniform
//! start.
//!
//! Moves that change the best flower at once make the search sequential. To use many lanes and threads all
//! the same, moves are planned ahead as if none of them improved anything; when one does, those behind it are
//! thrown away and planned anew from the first that had looked at what changed. The outcome is exactly the
//! sequential one.

use super::{Best, Bounds, Candidate, Draws, Optimiser, are_points, levy_step};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

/// Which algorithm of that name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Variant {
    /// As the paper's Fig. 4 has it.
    Paper,
    /// As Yang published it.
    Yang,
    /// As the widespread demo code has it.
    Demo,
}

/// The numbers of Table 2, and those that the paper leaves out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FpaSettings {
    /// Which algorithm.
    pub variant: Variant,
    /// N, at least 2.
    pub population_size: usize,
    /// Evaluations in all: N (T + 1) of Table 2.
    pub evaluations: usize,
    /// p, 0..=1.
    pub switching_probability: f64,
    /// c or γ, above 0.
    pub scaling_factor: f64,
    /// λ, 1..2.
    pub levy_exponent: f64,
}

impl FpaSettings {
    /// What each variant is published with; N = 50 and T = 30 of Table 2, 1,550 evaluations, for all of them.
    pub fn published(variant: Variant) -> Self {
        let (switching_probability, scaling_factor) = match variant {
            Variant::Paper => (0.03, 0.5),
            Variant::Yang => (0.8, 0.1),
            Variant::Demo => (0.8, 0.01),
        };
        Self {
            variant,
            population_size: 50,
            evaluations: 1550,
            switching_probability,
            scaling_factor,
            levy_exponent: 1.5,
        }
    }
}

/// The search in progress.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FlowerPollination {
    settings: FpaSettings,
    bounds: Bounds,
    draws: Draws,
    flowers: Vec<Vec<f64>>,
    costs: Vec<f64>,
    best: Option<Best>,
    /// Evaluations used; the first N are the initial flowers, then one a move.
    done: usize,
    /// What was asked for and is not told yet.
    planned: Vec<Move>,
    /// How many moves are planned ahead.
    width: usize,
}

/// A planned move, and what it was made from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Move {
    candidate: Candidate,
    /// The flowers that it looked at.
    flowers: [usize; 3],
    /// Did it look at the best flower?
    best: bool,
}

/// What the moves told so far have changed, against what the plan took for granted.
#[derive(Debug, Default)]
struct Changed {
    flowers: Vec<usize>,
    best: bool,
}

impl Changed {
    fn makes_stale(&self, planned: &Move) -> bool {
        (self.best && planned.best) || planned.flowers.iter().any(|f| self.flowers.contains(f))
    }
}

/// Least and most moves planned ahead: four groups of eight lanes, and what amortises handing them out.
/// Doubled when a whole plan passed without an improvement, halved when one was cut short. Chosen by
/// measurement; the outcome does not depend on it.
const WIDTH: [usize; 2] = [32, 256];

impl FlowerPollination {
    /// A new search. `settings` must be valid.
    pub fn new(settings: FpaSettings, bounds: Bounds, draws: Draws) -> Self {
        let (size, dimension) = (settings.population_size, bounds.dimension());
        Self {
            settings,
            bounds,
            draws,
            flowers: vec![vec![0.0; dimension]; size],
            costs: vec![f64::INFINITY; size],
            best: None,
            done: 0,
            planned: Vec::new(),
            width: WIDTH[0],
        }
    }

    /// Could `begun`, which has only begun, have come to this?
    pub fn continues(&self, begun: &Self) -> bool {
        let (size, dimension) = (begun.population(), begun.bounds.dimension());
        let same =
            (&self.settings, &self.bounds, self.draws) == (&begun.settings, &begun.bounds, begun.draws);
        same && self.done <= begun.budget()
            && are_points(&self.flowers, size, dimension)
            && self.costs.len() == size
            && self.best.as_ref().is_none_or(|best| self.bounds.has(&best.position))
            && self.planned.is_empty()
            && (WIDTH[0]..=WIDTH[1]).contains(&self.width)
    }

    pub(super) fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn population(&self) -> usize {
        self.settings.population_size
    }

    /// Does a plan reach beyond the present generation? In Yang's form a generation is built from the last
    /// one alone.
    fn plan_length(&self) -> usize {
        let size = self.population();
        let left = self.budget() - self.done;
        let generation = size - self.done % size;
        if self.done < size || self.settings.variant == Variant::Yang {
            left.min(generation)
        } else {
            left.min(self.width)
        }
    }

    /// A flower as it will be when the planned moves before `ahead` are made, if none of them improves
    /// anything.
    fn flower<'a>(&'a self, index: usize, planned: &'a [Move]) -> &'a [f64] {
        if self.settings.variant == Variant::Paper {
            let latest = planned
                .iter()
                .enumerate()
                .rev()
                .find(|(ahead, _)| (self.done + ahead) % self.population() == index);
            if let Some((_, latest)) = latest {
                return &latest.candidate.position;
            }
        }
        &self.flowers[index]
    }

    fn initial(&self, number: usize) -> Move {
        let mut rng = self.draws.of_move(number);
        let parts: Vec<f64> = (0..self.bounds.dimension()).map(|_| rng.random()).collect();
        let candidate = Candidate { position: self.bounds.at(|k| parts[k]), bound: f64::INFINITY };
        Move { candidate, flowers: [number; 3], best: false }
    }

    /// Move `number`, given those planned before it. Every move makes the same draws, whichever of them it
    /// uses.
    fn pollinated(&self, number: usize, planned: &[Move]) -> Move {
        let settings = &self.settings;
        let mut rng = self.draws.of_move(number);
        let switch: f64 = rng.random();
        let epsilon: f64 = rng.random();
        let [j, k] = two_of(&mut rng, self.population());
        let levy: Vec<f64> =
            (0..self.bounds.dimension()).map(|_| levy_step(&mut rng, settings.levy_exponent)).collect();

        let index = number % self.population();
        let own = self.flower(index, planned);
        let (first, second) = (self.flower(j, planned), self.flower(k, planned));
        let best = self.best.as_ref().map_or(own, |b| &b.position);
        let (p, c) = (settings.switching_probability, settings.scaling_factor);
        let global = match settings.variant {
            Variant::Paper | Variant::Yang => switch < p,
            Variant::Demo => switch > p,
        };
        let coordinate = |d: usize| {
            let difference = first[d] - second[d];
            match (settings.variant, global) {
                (Variant::Paper, true) => best[d] + c * levy[d] * (own[d] - best[d]),
                (Variant::Paper, false) => best[d] + c * difference,
                (Variant::Yang, true) => own[d] + c * levy[d] * (best[d] - own[d]),
                (Variant::Demo, true) => own[d] + c * levy[d] * (own[d] - best[d]),
                (Variant::Yang | Variant::Demo, false) => own[d] + epsilon * difference,
            }
        };
        let mut position: Vec<f64> = (0..self.bounds.dimension()).map(coordinate).collect();
        self.bounds.clip(&mut position);
        let bound = match settings.variant {
            Variant::Paper => self.best.as_ref().map_or(f64::INFINITY, |b| b.cost),
            Variant::Yang | Variant::Demo => self.costs[index],
        };
        let reads_best = global || settings.variant == Variant::Paper;
        Move { candidate: Candidate { position, bound }, flowers: [index, j, k], best: reads_best }
    }

    /// Takes a move's outcome and notes what it changed that the plan did not foresee. In Yang's form a
    /// generation looks at the one before it, so nothing within one goes stale.
    fn commit(&mut self, candidate: Candidate, cost: f64, changed: &mut Changed) {
        let (size, variant) = (self.population(), self.settings.variant);
        let initial = self.done < size;
        let index = self.done % size;
        self.done += 1;
        let better = cost < self.best.as_ref().map_or(f64::INFINITY, |b| b.cost);
        let replaced = initial
            || match variant {
                Variant::Paper => true,
                Variant::Yang => cost < self.costs[index],
                Variant::Demo => cost <= self.costs[index],
            };
        if better {
            self.best = Some(Best { position: candidate.position.clone(), cost });
        }
        if replaced {
            self.flowers[index] = candidate.position;
            self.costs[index] = cost;
        }
        if !initial && variant != Variant::Yang {
            changed.best |= better;
            if replaced && variant == Variant::Demo {
                changed.flowers.push(index);
            }
        }
    }
}

/// Two different indices below `size`.
fn two_of(rng: &mut impl Rng, size: usize) -> [usize; 2] {
    let first = rng.random_range(0..size);
    let second = rng.random_range(0..size - 1);
    [first, if second < first { second } else { second + 1 }]
}

impl Optimiser for FlowerPollination {
    fn ask(&mut self) -> Vec<Candidate> {
        let mut planned: Vec<Move> = Vec::new();
        for ahead in 0..self.plan_length() {
            let number = self.done + ahead;
            let next = if number < self.population() {
                self.initial(number)
            } else {
                self.pollinated(number, &planned)
            };
            planned.push(next);
        }
        let asked = planned.iter().map(|m| m.candidate.clone()).collect();
        self.planned = planned;
        asked
    }

    fn tell(&mut self, costs: &[f64]) {
        let planned = std::mem::take(&mut self.planned);
        let asked = planned.len();
        let mut used = 0;
        let mut changed = Changed::default();
        for (planned, cost) in planned.into_iter().zip(costs) {
            if changed.makes_stale(&planned) {
                break;
            }
            used += 1;
            let cost = if cost.is_nan() { f64::INFINITY } else { *cost };
            self.commit(planned.candidate, cost, &mut changed);
        }
        let [least, most] = WIDTH;
        self.width = if used == asked { (2 * self.width).min(most) } else { (self.width / 2).max(least) };
    }

    fn best(&self) -> Option<&Best> {
        self.best.as_ref()
    }

    fn evaluations(&self) -> usize {
        self.done
    }

    fn budget(&self) -> usize {
        self.settings.evaluations
    }
}
