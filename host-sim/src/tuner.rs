//! The tuner: an optimiser and an objective, driven to the end, with progress, interruption, time limit and checkpoints.

use crate::checkpoint;
use crate::error::Outcome;
use crate::objective::{Objective, Steps};
use crate::optimise::{Best, FlowerPollination, Optimiser};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Where a tuning run stands; everything that a restart needs.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Search {
    /// What is being tuned and how, in words.
    identity: String,
    optimiser: FlowerPollination,
    /// Evaluations and cost at every improvement.
    history: Vec<(usize, f64)>,
    steps_before: [u64; 2],
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
    pub fn new(identity: String, optimiser: FlowerPollination) -> Self {
        Self { identity, optimiser, history: Vec::new(), steps_before: [0; 2] }
    }

    /// Drives the search on.
    pub fn run(&mut self, objective: &Objective, conduct: &Conduct<'_>) -> Outcome<End> {
        let begun = Instant::now();
        let before = self.steps_before;
        let mut saved = begun;
        let mut end = End::Complete;
        let mut trouble = Ok(());
        loop {
            let asked = self.optimiser.ask();
            if asked.is_empty() {
                break;
            }
            self.optimiser.tell(&objective.costs(&asked));
            self.note_improvement();
            let Steps { simulated, skipped } = objective.steps();
            self.steps_before = [before[0] + simulated, before[1] + skipped];
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

    /// Steps of closed loops in all, before a restart too.
    pub fn steps(&self) -> Steps {
        Steps { simulated: self.steps_before[0], skipped: self.steps_before[1] }
    }

    fn save(&self, path: &Path) -> Outcome<()> {
        checkpoint::write(path, &self.identity, self)
    }

    /// Reads a checkpoint of the run that `identity` describes.
    pub fn resume(path: &Path, identity: &str) -> Outcome<Self> {
        checkpoint::read(path, identity)
    }
}
