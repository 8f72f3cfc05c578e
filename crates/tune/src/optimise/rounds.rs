//! One search after the other, each around the best point so far and within less.
//!
//! A search that contracts fast (the paper's FPA does, its population by .7 an iteration) gains more in a
//! dozen dimensions from starting anew around what it found than from more iterations.

use super::{Best, Bounds, Candidate, Draws, Optimiser, Searcher, Setup};
use serde::{Deserialize, Serialize};

/// From round to round the reach shrinks to this part.
const SHRINK: f64 = 0.6;

/// The rounds in progress. The first evaluation is of the start itself, the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rounds {
    setup: Setup,
    rounds: u64,
    seed: u64,
    dimension: usize,
    reach: f64,
    /// Rounds begun.
    round: u64,
    search: Option<Searcher>,
    /// Evaluations before the search in progress.
    before: usize,
    best: Option<Best>,
}

impl Rounds {
    /// `rounds` searches of `setup` each in `dimension` coordinates, the first within ±`reach`.
    pub fn new(setup: Setup, rounds: usize, dimension: usize, reach: f64, seed: u64) -> Self {
        let rounds = rounds as u64;
        Self { setup, rounds, seed, dimension, reach, round: 0, search: None, before: 0, best: None }
    }

    /// One round more than there were.
    pub(super) fn add(&mut self) {
        self.rounds += 1;
    }

    /// The box of the round in progress, or of the last one.
    pub(super) fn bounds(&self) -> Option<&Bounds> {
        self.search.as_ref().and_then(Searcher::bounds)
    }

    /// Could `begun`, which has only begun, have come to this?
    pub(super) fn continues(&self, begun: &Self) -> bool {
        let same = (self.setup, self.rounds, self.seed, self.dimension)
            == (begun.setup, begun.rounds, begun.seed, begun.dimension);
        let near = |x: &f64| x.abs() <= begun.reach / (1.0 - SHRINK);
        let best = self.best.as_ref().map(|best| &best.position);
        let within = best.is_none_or(|p| p.len() == self.dimension && p.iter().all(near));
        let untouched = *self == *begun;
        same && within
            && (best.is_some() || untouched)
            && self.round <= self.rounds
            && self.reach > 0.0
            && self.reach <= begun.reach
            && self.before <= self.most_before()
            && self.search.as_ref().is_none_or(|search| self.has_begun(search))
    }

    /// What the rounds that have come to an end may have used, and the start.
    fn most_before(&self) -> usize {
        let ended = self.round.saturating_sub(u64::from(self.search.is_some()));
        let ended = usize::try_from(ended).unwrap_or(usize::MAX);
        ended.saturating_mul(self.setup.evaluations).saturating_add(1)
    }

    /// Is this a search of the round that has been begun last?
    fn has_begun(&self, search: &Searcher) -> bool {
        let Some(bounds) = search.bounds() else { return false };
        let usable = bounds.dimension() == self.dimension && Bounds::new(bounds.as_slice().to_vec()).is_ok();
        let round = self.round.wrapping_sub(1);
        usable && search.continues(&self.setup.start(bounds.clone(), self.draws(round)))
    }

    fn draws(&self, round: u64) -> Draws {
        Draws::new(self.seed.wrapping_mul(1000).wrapping_add(round))
    }

    /// Nothing where the reach is lost beside the last digit of the centre: there is nothing left to search.
    fn begin(&self, center: &[f64]) -> Option<Searcher> {
        let bounds = Bounds::new(center.iter().map(|c| [c - self.reach, c + self.reach]).collect());
        Some(self.setup.start(bounds.ok()?, self.draws(self.round)))
    }
}

impl Optimiser for Rounds {
    fn ask(&mut self) -> Vec<Candidate> {
        let Some(best) = &self.best else {
            return vec![Candidate { position: vec![0.0; self.dimension], bound: f64::INFINITY }];
        };
        let center = best.position.clone();
        if let Some(search) = &mut self.search {
            let asked = search.ask();
            if !asked.is_empty() {
                return asked;
            }
            // The last one stays: its box says where the search has ended.
            if self.round == self.rounds {
                return Vec::new();
            }
            self.before += search.evaluations();
            self.search = None;
            self.reach *= SHRINK;
        }
        if self.round == self.rounds {
            return Vec::new();
        }
        let Some(mut search) = self.begin(&center) else { return Vec::new() };
        let asked = search.ask();
        self.search = Some(search);
        self.round += 1;
        asked
    }

    fn tell(&mut self, costs: &[f64]) {
        let Some(search) = &mut self.search else {
            self.best = Some(Best {
                position: vec![0.0; self.dimension],
                cost: if costs[0].is_nan() { f64::INFINITY } else { costs[0] },
            });
            self.before = 1;
            return;
        };
        search.tell(costs);
        let found = search.best().filter(|b| self.best.as_ref().is_none_or(|best| b.cost < best.cost));
        if let Some(found) = found {
            self.best = Some(found.clone());
        }
    }

    fn best(&self) -> Option<&Best> {
        self.best.as_ref()
    }

    fn evaluations(&self) -> usize {
        self.before + self.search.as_ref().map_or(0, Optimiser::evaluations)
    }

    fn budget(&self) -> usize {
        usize::try_from(self.rounds)
            .map_or(usize::MAX, |rounds| rounds.saturating_mul(self.setup.evaluations).saturating_add(1))
    }
}
