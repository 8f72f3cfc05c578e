//! Minimising a cost over a box, by asking for costs and being told them. Nothing in here knows of
//! helicopters.
//!
//! An [`Optimiser`] is a state machine: [`ask`](Optimiser::ask) gives candidates whose costs it wants,
//! [`tell`](Optimiser::tell) takes them. Whoever drives it may compute the costs on as many threads and lanes
//! as there are: the answers, and so the outcome, do not depend on that. Its whole state can be saved between
//! two calls and read back.

mod adaptive;
mod algorithm;
mod covariance;
mod draws;
mod evolution;
mod fpa;
mod generations;
mod genetic;
mod levy;
mod pareto;
mod rounds;
mod samples;
mod simplex;
mod swarm;
mod wolves;

use adaptive::AdaptiveFlowers;
pub use algorithm::{ALGORITHMS, Algorithm, MOST_EVALUATIONS, Searcher, Setup};
use covariance::CovarianceAdaptation;
pub use draws::Draws;
use evolution::DifferentialEvolution;
pub use fpa::{FlowerPollination, FpaSettings, Variant};
pub use generations::Generations;
use genetic::Genetic;
pub use levy::levy_step;
pub use pareto::{Compromise, dominates, knee, pareto_front};
pub use rounds::Rounds;
use samples::Samples;
use simplex::NelderMead;
use swarm::Swarm;
use twinrotor_sim::{Error, Outcome};
use wolves::Wolves;

use serde::{Deserialize, Serialize};

/// A point whose cost is wanted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Its coordinates, within the bounds.
    pub position: Vec<f64>,
    /// A cost that is provably not below this may be told as infinity: the candidate loses either way.
    pub bound: f64,
}

/// The best point so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Best {
    /// Its coordinates.
    pub position: Vec<f64>,
    /// Its cost.
    pub cost: f64,
}

/// \[-\] A coordinate this near to a bound, in parts of the way to the other, is probably held there by it.
pub const NEAR_A_BOUND: f64 = 0.02;

/// An end of a coordinate's range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// The lower.
    Least,
    /// The upper.
    Most,
}

/// A coordinate at a bound of the box that was searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reached {
    /// Which, from 0.
    pub coordinate: usize,
    /// At which end.
    pub side: Side,
    /// What that is.
    pub bound: f64,
}

/// Least and most of each coordinate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bounds(Vec<[f64; 2]>);

impl Bounds {
    /// One `[least, most]` for each coordinate, finite, least below most.
    ///
    /// # Errors
    ///
    /// If they are not: which is wrong.
    pub fn new(bounds: Vec<[f64; 2]>) -> Outcome<Self> {
        if bounds.is_empty() {
            return Err(Error::invalid("bounds", "empty", "one pair for each coordinate"));
        }
        for (k, [low, high]) in bounds.iter().enumerate() {
            if !(low.is_finite() && high.is_finite() && low < high) {
                return Err(Error::invalid(
                    format_args!("bounds of coordinate {}", k + 1),
                    format_args!("{low},{high}"),
                    "two finite numbers, the lower one first",
                ));
            }
        }
        Ok(Self(bounds))
    }

    /// How many coordinates.
    pub fn dimension(&self) -> usize {
        self.0.len()
    }

    /// Each coordinate's least and most.
    pub fn as_slice(&self) -> &[[f64; 2]] {
        &self.0
    }

    /// The point at `part` (0..1) of the way along each coordinate.
    pub fn at(&self, part: impl Fn(usize) -> f64) -> Vec<f64> {
        self.0.iter().enumerate().map(|(k, [low, high])| low + (high - low) * part(k)).collect()
    }

    /// Is it a point of the box?
    fn has(&self, position: &[f64]) -> bool {
        position.len() == self.dimension()
            && position.iter().zip(&self.0).all(|(x, [low, high])| (*low..=*high).contains(x))
    }

    /// The coordinates of `position` that the box holds back, or probably does: each with the bound that is
    /// nearer than [`NEAR_A_BOUND`] of the way to the other.
    pub fn reached(&self, position: &[f64]) -> Vec<Reached> {
        let reached = |(coordinate, (x, [low, high])): (usize, (&f64, &[f64; 2]))| {
            let near = NEAR_A_BOUND * (high - low);
            let side = match (x - low < near, high - x < near) {
                (true, _) => Side::Least,
                (_, true) => Side::Most,
                _ => return None,
            };
            let bound = if side == Side::Least { *low } else { *high };
            Some(Reached { coordinate, side, bound })
        };
        position.iter().zip(&self.0).enumerate().filter_map(reached).collect()
    }

    /// Moves each coordinate that is outside to the bound it passed.
    pub fn clip(&self, position: &mut [f64]) {
        for (x, [low, high]) in position.iter_mut().zip(&self.0) {
            *x = x.clamp(*low, *high);
        }
    }
}

/// Are these `count` points of `dimension` finite coordinates each? Asked of what was read from a file.
fn are_points(points: &[Vec<f64>], count: usize, dimension: usize) -> bool {
    points.len() == count && points.iter().all(|p| p.len() == dimension && p.iter().all(|x| x.is_finite()))
}

/// A method of search.
pub trait Optimiser {
    /// Candidates whose costs are wanted now, in order; none when it is done.
    fn ask(&mut self) -> Vec<Candidate>;

    /// Their costs in the same order; NaN counts as infinity.
    fn tell(&mut self, costs: &[f64]);

    /// The best so far, once anything has been told.
    fn best(&self) -> Option<&Best>;

    /// How many costs it has used. What was computed ahead and thrown away does not count.
    fn evaluations(&self) -> usize;

    /// How many it will use in all.
    fn budget(&self) -> usize;
}

/// Drives an optimiser to its end: `costs` gives the costs of candidates in their order, `seen` is shown
/// every new best with the number of evaluations it took, and stops the search by returning false after any
/// exchange.
pub fn run(
    optimiser: &mut dyn Optimiser,
    mut costs: impl FnMut(&[Candidate]) -> Vec<f64>,
    mut seen: impl FnMut(&dyn Optimiser) -> bool,
) {
    loop {
        let candidates = optimiser.ask();
        if candidates.is_empty() {
            return;
        }
        optimiser.tell(&costs(&candidates));
        if !seen(optimiser) {
            return;
        }
    }
}

#[cfg(test)]
mod peer_tests;
#[cfg(test)]
mod tests;
