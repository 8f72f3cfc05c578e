//! Tuning any controller on the robust objective, over the logarithms of its parameters.

use super::{LagRow, Limit, Row, Score, Trial};
use crate::optimise::{Candidate, Rounds, Searcher, Setup};
use crate::parallel::{self, Stop};
use crate::search::{Effort, Problem};
use crate::tunable::Tunable;
use std::sync::atomic::{AtomicU64, Ordering};
use twinrotor::controller::ControllerSettings;

/// J of a controller's parameters on a set of plants.
#[derive(Debug)]
pub struct Robust<'a> {
    /// The plants.
    pub trial: &'a Trial,
    /// The controller.
    pub tunable: &'a Tunable,
    limits: &'a [Limit],
    lags: Vec<(f64, Trial)>,
    simulated: AtomicU64,
    skipped: AtomicU64,
    diverged: AtomicU64,
}

/// A candidate's flights in numbers; the row where limits ask for it.
struct Judged {
    total: f64,
    diverged: bool,
    row: Option<Row>,
}

impl<'a> Robust<'a> {
    /// Positions are logarithms of factors on the start values of `tunable`.
    pub fn new(trial: &'a Trial, tunable: &'a Tunable) -> Self {
        Self {
            trial,
            tunable,
            limits: &[],
            lags: Vec::new(),
            simulated: AtomicU64::new(0),
            skipped: AtomicU64::new(0),
            diverged: AtomicU64::new(0),
        }
    }

    /// The same, with limits: for each, J is raised by the part of itself by which it is exceeded.
    #[must_use]
    pub fn within(self, limits: &'a [Limit]) -> Self {
        Self { limits, ..self }
    }

    /// The same, flying also with rotors whose lags are at these multiples of those believed: the numbers
    /// `lags.failures` and `lags.J`, which only limits act on.
    #[must_use]
    pub fn with_lags(self, multiples: &[f64]) -> Self {
        let lags = multiples.iter().map(|m| (*m, self.trial.with_lags(*m))).collect();
        Self { lags, ..self }
    }

    fn cost(
        &self,
        controller: &ControllerSettings<f64>,
        bound: f64,
        judged: Option<Judged>,
        flown: usize,
        stop: Stop<'_>,
    ) -> Option<f64> {
        let left = self.trial.plants.len() - flown;
        self.count(flown, left);
        let Some(Judged { total, diverged, row }) = judged else { return Some(f64::INFINITY) };
        self.diverged.fetch_add(u64::from(diverged), Ordering::Relaxed);
        let Some(mut row) = row else { return Some(total) };
        let raised =
            |row: &Row| total * (1.0 + self.limits.iter().map(|limit| limit.excess(row)).sum::<f64>());
        for (multiple, trial) in &self.lags {
            // Each can only raise it.
            if raised(&row) > bound * super::SURELY {
                self.count(0, trial.plants.len());
                continue;
            }
            row.lags.push(LagRow::new(*multiple, &trial.scores_until(controller, stop)?));
            self.count(trial.plants.len(), 0);
        }
        Some(raised(&row))
    }

    fn judged(&self, scores: &[Score]) -> Judged {
        Judged {
            total: super::total(scores),
            diverged: scores.iter().any(|s| s.diverged),
            row: (!self.limits.is_empty()).then(|| Row::new("", scores, None, Vec::new())),
        }
    }

    fn count(&self, flown: usize, left: usize) {
        self.simulated.fetch_add(self.trial.steps() * flown as u64, Ordering::Relaxed);
        self.skipped.fetch_add(self.trial.steps() * left as u64, Ordering::Relaxed);
    }
}

impl Problem for Robust<'_> {
    /// A candidate that diverges on some plant is charged for it (see [`Score::diverged`]), so that the
    /// search learns in which direction fewer do.
    fn costs_until(&self, candidates: &[Candidate], stop: Stop<'_>) -> Option<Vec<f64>> {
        let controllers: Vec<_> =
            candidates.iter().map(|c| (self.tunable.controller(&c.position), c.bound)).collect();
        // What no gains file could hold is no candidate.
        let sound: Vec<_> = controllers.iter().copied().filter(|(c, _)| c.validate().is_ok()).collect();
        let flown = self.trial.all_below(&sound, stop)?;
        let judged = parallel::map(&flown, |(scores, flown)| {
            (scores.as_ref().map(|scores| self.judged(scores)), *flown)
        });
        let mut judged = judged.into_iter();
        let cost = |(controller, bound): &(ControllerSettings<f64>, f64)| {
            if controller.validate().is_err() {
                return Some(f64::INFINITY);
            }
            let (judged, flown) = judged.next()?;
            self.cost(controller, *bound, judged, flown, stop)
        };
        controllers.iter().map(cost).collect()
    }

    fn effort(&self) -> Effort {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        Effort { simulated: of(&self.simulated), skipped: of(&self.skipped), diverged: of(&self.diverged) }
    }
}

/// How to search: in rounds, each around the best so far and within less.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The method and what it may use in each round.
    pub setup: Setup,
    /// How many rounds, at least 1.
    pub rounds: usize,
    /// Factor within which each parameter is searched in the first round, above 1.
    pub range: f64,
    /// Of everything random.
    pub seed: u64,
}

impl Plan {
    /// The search over `dimension` parameters at its beginning.
    pub fn start(&self, dimension: usize) -> Searcher {
        let reach = self.range.ln();
        Searcher::Rounds(Box::new(Rounds::new(self.setup, self.rounds, dimension, reach, self.seed)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::NEVER;
    use twinrotor::defaults;
    use twinrotor::plant::presets::AERO2;

    #[test]
    fn plants_are_spared_only_where_the_candidate_cannot_win() {
        let trial = Trial::new(&AERO2, 40, 1, 1.5);
        let tunable = Tunable::new(&defaults::AERO2, &[]).unwrap();
        let mut spared = 0;
        for factor in [0.3, 1.0, 2.0] {
            let controller = tunable.controller(&vec![f64::ln(factor); tunable.names().len()]);
            let all = trial.scores(&controller);
            let cost = super::super::total(&all);
            for part in [0.2, 0.5, 0.8, 1.0 - 1e-6, 1.0, 1.0 + 1e-6, f64::INFINITY] {
                let (scores, flown) = trial.scores_below(&controller, part * cost, NEVER).unwrap();
                spared += all.len() - flown;
                match scores {
                    Some(scores) => assert_eq!(scores, all),
                    None => assert!(part < 1.0, "factor {factor}: {part} of its cost is above it"),
                }
            }
        }
        assert!(spared > 0);
    }
}
