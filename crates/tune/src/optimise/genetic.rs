//! A genetic algorithm on real numbers: binary tournaments, simulated binary crossover, polynomial mutation,
//! elitist selection.

use super::generations::{Method, Turn, free, ranking};
use super::{Candidate, are_points};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

/// The population: the better half of parents and children together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Genetic {
    size: usize,
    people: Vec<Vec<f64>>,
    costs: Vec<f64>,
}

impl Genetic {
    pub(super) fn new(size: usize) -> Self {
        Self { size, people: Vec::new(), costs: Vec::new() }
    }

    /// Could `begun` have come to this?
    pub(super) fn continues(&self, begun: &Self, dimension: usize) -> bool {
        let count = if self.people.is_empty() { 0 } else { begun.size };
        self.size == begun.size && are_points(&self.people, count, dimension) && self.costs.len() == count
    }

    /// The better of two drawn at random.
    fn parent(&self, rng: &mut impl Rng) -> &[f64] {
        let [a, b] = [rng.random_range(0..self.size), rng.random_range(0..self.size)];
        &self.people[if self.costs[a] <= self.costs[b] { a } else { b }]
    }
}

impl Method for Genetic {
    fn propose(&mut self, turn: &Turn<'_>) -> Vec<Candidate> {
        if self.people.is_empty() {
            return turn.uniform(self.size);
        }
        let child = |k| {
            let mut rng = turn.rng(k);
            let (mother, father) = (self.parent(&mut rng), self.parent(&mut rng));
            let mut child = crossover(mother, father, &mut rng);
            mutate(&mut child, &mut rng);
            free(child)
        };
        (0..self.size).map(child).collect()
    }

    fn learn(&mut self, points: Vec<Candidate>, costs: &[f64]) {
        self.people.extend(points.into_iter().map(|c| c.position));
        self.costs.extend(costs);
        let fittest = &ranking(&self.costs)[..self.size];
        self.people = fittest.iter().map(|k| self.people[*k].clone()).collect();
        self.costs = fittest.iter().map(|k| self.costs[*k]).collect();
    }
}

/// With this probability a child mixes its parents at all.
const CROSSOVER: f64 = 0.9;
/// Distribution indices that Deb's NSGA-II uses.
const CROSSOVER_INDEX: f64 = 15.0;
const MUTATION_INDEX: f64 = 20.0;

/// One child by simulated binary crossover within the unit cube (K. Deb, R. B. Agrawal, Complex Systems 9,
/// 1995; the bounded form of Deb's NSGA-II code).
pub(super) fn crossover(mother: &[f64], father: &[f64], rng: &mut impl Rng) -> Vec<f64> {
    let mixes = rng.random::<f64>() < CROSSOVER;
    let power = CROSSOVER_INDEX + 1.0;
    let mut coordinate = |(a, b): (&f64, &f64)| {
        let [mixed, u, upper] = [rng.random::<f64>(), rng.random(), rng.random()];
        let (low, high) = (a.min(*b), a.max(*b));
        if !mixes || mixed < 0.5 || high - low < 1e-14 {
            return *a;
        }
        let room = if upper < 0.5 { 1.0 - high } else { low };
        let alpha = 2.0 - libm::pow(1.0 + 2.0 * room / (high - low), -power);
        let spread = if u <= 1.0 / alpha { u * alpha } else { 1.0 / (2.0 - u * alpha) };
        let half = 0.5 * libm::pow(spread, 1.0 / power) * (high - low);
        let middle = 0.5 * (low + high);
        (if upper < 0.5 { middle + half } else { middle - half }).clamp(0.0, 1.0)
    };
    mother.iter().zip(father).map(&mut coordinate).collect()
}

/// Polynomial mutation within the unit cube, of one coordinate on average (the same sources).
pub(super) fn mutate(child: &mut [f64], rng: &mut impl Rng) {
    let rate = 1.0 / child.len() as f64;
    let power = MUTATION_INDEX + 1.0;
    for x in child {
        let [chance, u] = [rng.random::<f64>(), rng.random::<f64>()];
        if chance >= rate {
            continue;
        }
        let change = if u < 0.5 {
            libm::pow(2.0 * u + (1.0 - 2.0 * u) * libm::pow(1.0 - *x, power), 1.0 / power) - 1.0
        } else {
            1.0 - libm::pow(2.0 * (1.0 - u) + (2.0 * u - 1.0) * libm::pow(*x, power), 1.0 / power)
        };
        *x = (*x + change).clamp(0.0, 1.0);
    }
}
