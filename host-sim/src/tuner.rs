//! The tuner: an optimiser and a problem, driven to the end, with progress, interruption, time limit and
//! checkpoints.

use crate::checkpoint;
use crate::error::Outcome;
use crate::optimise::{Best, Candidate, Optimiser, Searcher};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Something to minimise.
pub trait Problem: Sync {
    /// The cost of each candidate, in order. The same candidate costs the same on any number of threads and
    /// in any company.
    fn costs(&self, candidates: &[Candidate]) -> Vec<f64>;

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
            simulated: self.simulated + other.simulated,
            skipped: self.skipped + other.skipped,
            diverged: self.diverged + other.diverged,
        }
    }
}

/// Where a tuning run stands; everything that a restart needs.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Search {
    /// What is being tuned and how, in words.
    identity: String,
    optimiser: Searcher,
    /// Evaluations and cost at every improvement.
    history: Vec<(usize, f64)>,
    effort: Effort,
}

/// When to stop and what to leave behind on the way.
pub struct Conduct<'a> {
    /// Where to write the state of the search every few seconds.
    pub checkpoint: Option<PathBuf>,
    /// Stop after this.
    pub time_limit: Option<Duration>,
    /// Is asked after every exchange whether to stop at once.
    pub interrupted: &'a dyn Fn() -> bool,
    /// Is shown evaluations and best cost after every exchange.
    pub progress: &'a dyn Fn(usize, f64),
}

impl Conduct<'_> {
    /// Without a checkpoint, a limit or anyone watching.
    pub fn to_the_end() -> Self {
        Self { checkpoint: None, time_limit: None, interrupted: &|| false, progress: &|_, _| () }
    }
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The budget is used up.
    Complete,
    /// The time limit came first.
    TimeLimit,
    /// It was interrupted.
    Interrupted,
}

/// From one checkpoint to the next.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(3);

impl Search {
    /// At the beginning.
    pub fn new(identity: String, optimiser: Searcher) -> Self {
        Self { identity, optimiser, history: Vec::new(), effort: Effort::default() }
    }

    /// Drives the search on.
    pub fn run(&mut self, problem: &dyn Problem, conduct: &Conduct<'_>) -> Outcome<End> {
        let begun = Instant::now();
        let before = self.effort;
        let mut saved = begun;
        let mut end = End::Complete;
        let mut trouble = Ok(());
        loop {
            let asked = self.optimiser.ask();
            if asked.is_empty() {
                break;
            }
            self.optimiser.tell(&problem.costs(&asked));
            self.note_improvement();
            self.effort = before.plus(problem.effort());
            (conduct.progress)(self.optimiser.evaluations(), self.cost());
            if let Some(path) = &conduct.checkpoint
                && saved.elapsed() >= CHECKPOINT_EVERY
            {
                trouble = self.save(path);
                saved = Instant::now();
            }
            if trouble.is_err() {
                break;
            }
            if (conduct.interrupted)() {
                end = End::Interrupted;
                break;
            }
            if conduct.time_limit.is_some_and(|limit| begun.elapsed() >= limit) {
                end = End::TimeLimit;
                break;
            }
        }
        trouble?;
        if let Some(path) = &conduct.checkpoint {
            self.save(path)?;
        }
        Ok(end)
    }

    fn note_improvement(&mut self) {
        let cost = self.cost();
        if self.history.last().is_none_or(|(_, before)| cost < *before) {
            self.history.push((self.optimiser.evaluations(), cost));
        }
    }

    fn cost(&self) -> f64 {
        self.optimiser.best().map_or(f64::INFINITY, |b| b.cost)
    }

    /// The best so far; none if every candidate diverged.
    pub fn best(&self) -> Option<&Best> {
        self.optimiser.best()
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

    fn save(&self, path: &Path) -> Outcome<()> {
        checkpoint::write(path, &self.identity, self)
    }
}
