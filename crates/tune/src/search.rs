//! A search: an optimiser and a problem, driven to the end or for as long as whoever watches lets it, and
//! resumed where it was broken off.

use crate::checkpoint::{self, Identity};
use crate::optimise::{Best, Candidate, Optimiser, Reached, Searcher};
use crate::parallel::{NEVER, Stop};
use crate::tunable::{AtBound, Tunable};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use twinrotor_sim::Outcome;

/// Something to minimise.
pub trait Problem: Sync {
    /// The cost of each candidate, in order, or nothing if `stop` said so before all were known. The same
    /// candidate costs the same on any number of threads and in any company.
    fn costs_until(&self, candidates: &[Candidate], stop: Stop<'_>) -> Option<Vec<f64>>;

    /// The cost of each candidate, in order.
    fn costs(&self, candidates: &[Candidate]) -> Vec<f64> {
        self.costs_until(candidates, NEVER).expect("nothing stops it")
    }

    /// What it has taken so far.
    fn effort(&self) -> Effort;
}

/// What computing costs took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Effort {
    /// Steps of closed loops.
    pub simulated: u64,
    /// Steps saved, because the candidate had lost already.
    pub skipped: u64,
    /// Candidates that diverged.
    pub diverged: u64,
}

impl Effort {
    fn plus(self, other: Self) -> Self {
        Self {
            simulated: self.simulated.saturating_add(other.simulated),
            skipped: self.skipped.saturating_add(other.skipped),
            diverged: self.diverged.saturating_add(other.diverged),
        }
    }
}

/// Where a tuning run stands; everything that a restart needs.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Search {
    /// What is being tuned and how.
    identity: Identity,
    optimiser: Searcher,
    /// Evaluations and cost at every improvement.
    history: Vec<(usize, f64)>,
    effort: Effort,
}

impl Search {
    /// At the beginning.
    pub fn new(identity: Identity, optimiser: Searcher) -> Self {
        Self { identity, optimiser, history: Vec::new(), effort: Effort::default() }
    }

    /// This search, which has only begun, as it stood when [`Search::checkpoint`] was asked.
    ///
    /// # Errors
    ///
    /// If the bytes are damaged, of another version or of another run.
    pub fn resume(self, bytes: &[u8]) -> Outcome<Self> {
        let then: Self = checkpoint::decode(bytes, &self.identity)?;
        if then.identity == self.identity && then.optimiser.continues(&self.optimiser) {
            Ok(then)
        } else {
            Err(checkpoint::damaged())
        }
    }

    /// Where it stands, for [`Search::resume`].
    pub fn checkpoint(&self) -> Vec<u8> {
        checkpoint::encode(&self.identity, self)
    }

    /// Drives the search on, to the end of its budget or until `after`, which is shown where it stands after
    /// every exchange, breaks it off; `stop` ends it in the middle of an exchange, which then has not been.
    pub fn run<B>(
        &mut self,
        problem: &dyn Problem,
        stop: Stop<'_>,
        mut after: impl FnMut(&Self) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let before = self.effort;
        loop {
            let stood = self.optimiser.clone();
            let asked = self.optimiser.ask();
            if asked.is_empty() {
                return ControlFlow::Continue(());
            }
            let Some(costs) = problem.costs_until(&asked, stop) else {
                self.optimiser = stood;
                return after(self);
            };
            self.optimiser.tell(&costs);
            self.note_improvement();
            self.effort = before.plus(problem.effort());
            after(self)?;
        }
    }

    /// Drives the search to the end of its budget.
    pub fn to_the_end(&mut self, problem: &dyn Problem) {
        let _: ControlFlow<()> = self.run(problem, NEVER, |_| ControlFlow::Continue(()));
    }

    /// As [`Search::to_the_end`], after one round more than there were.
    pub fn one_round_more(&mut self, problem: &dyn Problem) {
        self.optimiser.add_round();
        self.to_the_end(problem);
    }

    fn note_improvement(&mut self) {
        let cost = self.cost();
        if self.history.last().is_none_or(|(_, before)| cost < *before) {
            self.history.push((self.optimiser.evaluations(), cost));
        }
    }

    /// The best cost so far; infinity if there is none.
    pub fn cost(&self) -> f64 {
        self.optimiser.best().map_or(f64::INFINITY, |b| b.cost)
    }

    /// The best so far; none if every candidate diverged.
    pub fn best(&self) -> Option<&Best> {
        self.optimiser.best()
    }

    /// Where the best so far lies at a bound of the box that was searched last, coordinate by coordinate:
    /// more is to be had beyond it, or may be.
    pub fn reached(&self) -> Vec<Reached> {
        let bounds = self.optimiser.bounds();
        bounds.zip(self.best()).map_or_else(Vec::new, |(bounds, best)| bounds.reached(&best.position))
    }

    /// The same, of parameters in their own names and units.
    pub fn at_bounds_of(&self, tunable: &Tunable) -> Vec<AtBound> {
        self.best().map_or_else(Vec::new, |best| tunable.at_bounds(&self.reached(), &best.position))
    }

    /// Evaluations used.
    pub fn evaluations(&self) -> usize {
        self.optimiser.evaluations()
    }

    /// Evaluations and cost at every improvement.
    pub fn history(&self) -> &[(usize, f64)] {
        &self.history
    }

    /// Evaluations there will be in all.
    pub fn budget(&self) -> usize {
        self.optimiser.budget()
    }

    /// What it took in all, before a restart too.
    pub fn effort(&self) -> Effort {
        self.effort
    }
}
