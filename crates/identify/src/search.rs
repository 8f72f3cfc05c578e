//! From logs to constants: a search by flower pollination for where to begin, descents from there and from
//! what regression and preset say, and the best of them.
//!
//! Search and descent begin with short windows. Over these even a poor plant stays near the log, so there are
//! fewer minima that are not the right one; where a descent ends, one over longer windows begins, up to those
//! that were asked for.

use super::constants::to_array;
use super::descent::descend;
use super::first_guess::first_guess;
use super::problem::{Guess, Problem};
use super::training_windows;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use twinrotor::plant::PlantParameters;
use twinrotor_sim::Outcome;
use twinrotor_tune::checkpoint::{self, Identity};
use twinrotor_tune::optimise::{Bounds, Draws, FlowerPollination, FpaSettings, Optimiser, Variant};
use twinrotor_tune::parallel::Stop;

/// How much is searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Flowers, at least 2.
    pub population: usize,
    /// Generations after the first; 0 with no search but the descents.
    pub iterations: usize,
    /// Of everything random.
    pub seed: u64,
}

/// Where a search stands; everything that a restart needs.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Search {
    identity: Identity,
    pollination: FlowerPollination,
    starts: Vec<Vec<f64>>,
    descents: Vec<(Guess, f64)>,
}

/// \[s\] Lengths of the windows that descents pass through, as far as they are shorter than those asked for.
const LENGTHS: [f64; 2] = [1.5, 2.7];
/// By how much of a constant's size, beyond the two guesses, it is searched.
const MARGIN: f64 = 0.5;

impl Search {
    /// At the beginning: around what regression and `preset` say.
    pub fn new(
        identity: Identity,
        problem: &Problem<'_>,
        preset: &PlantParameters<f64>,
        effort: Effort,
    ) -> Self {
        let free = |plant: &PlantParameters<f64>| -> Vec<f64> {
            let all = to_array(plant);
            problem.free().iter().map(|k| all[*k]).collect()
        };
        let starts = vec![free(&first_guess(problem.logs(), preset)), free(preset)];
        let range = |k: usize| {
            let [least, most] = problem.bounds()[k];
            let (a, b) = (starts[0][k].clamp(least, most), starts[1][k].clamp(least, most));
            let margin = MARGIN * a.abs().max(b.abs()).max(1e-4 * (most - least));
            [(a.min(b) - margin).max(least), (a.max(b) + margin).min(most)]
        };
        let bounds =
            Bounds::new((0..problem.free().len()).map(range).collect()).expect("a range with some width");
        let settings = FpaSettings {
            population_size: effort.population,
            evaluations: effort.population * (effort.iterations + 1),
            ..FpaSettings::published(Variant::Yang)
        };
        let pollination = FlowerPollination::new(settings, bounds, Draws::new(effort.seed));
        Self { identity, pollination, starts, descents: Vec::new() }
    }

    /// This search of `problem`, which has only begun, as it stood when [`Search::checkpoint`] was asked.
    ///
    /// # Errors
    ///
    /// If the bytes are damaged, of another version or of another run.
    pub fn resume(self, bytes: &[u8], problem: &Problem<'_>) -> Outcome<Self> {
        let then: Self = checkpoint::decode(bytes, &self.identity)?;
        let finite = |numbers: &[f64], count| numbers.len() == count && numbers.iter().all(|x| x.is_finite());
        let constants = problem.free().len();
        let sound = then.identity == self.identity
            && then.pollination.continues(&self.pollination)
            && (2..=3).contains(&then.starts.len())
            && then.starts.iter().all(|start| finite(start, constants))
            && then.descents.len() <= then.starts.len()
            && then
                .descents
                .iter()
                .all(|(at, _)| finite(&at.values, constants) && finite(&at.offsets, problem.runs()));
        if sound { Ok(then) } else { Err(checkpoint::damaged()) }
    }

    /// Where it stands, for [`Search::resume`].
    pub fn checkpoint(&self) -> Vec<u8> {
        checkpoint::encode(&self.identity, self)
    }

    /// Searches to the end (a problem with windows of `window` \[s\]), or until `after` breaks it off, which
    /// is shown where it stands after every exchange, what was done and the best cost; then the best so far
    /// is what has been found. `stop` ends it in the middle of an exchange, which then has not been.
    ///
    /// # Errors
    ///
    /// If the logs have no windows short enough to begin with.
    pub fn run<B>(
        &mut self,
        problem: &Problem<'_>,
        window: f64,
        stop: Stop<'_>,
        mut after: impl FnMut(&Self, &str, f64) -> ControlFlow<B>,
    ) -> Outcome<ControlFlow<B>> {
        let offsets = vec![0.0; problem.runs()];
        let with_length = |length: &f64| {
            training_windows(problem.logs(), *length).map(|windows| problem.with_windows(windows))
        };
        let lengths = LENGTHS.iter().filter(|length| **length < window);
        let mut stages: Vec<Problem<'_>> = lengths.map(with_length).collect::<Outcome<_>>()?;
        stages.push(problem.clone());
        let cost = |search: &Self| search.pollination.best().map_or(f64::INFINITY, |b| b.cost);
        loop {
            let stood = self.pollination.clone();
            let asked = self.pollination.ask();
            if asked.is_empty() {
                break;
            }
            let guess = |values: &[f64]| Guess { values: values.to_vec(), offsets: offsets.clone() };
            let costs: Option<Vec<f64>> =
                asked.iter().map(|c| stages[0].cost_until(&guess(&c.position), stop)).collect();
            match costs {
                Some(costs) => self.pollination.tell(&costs),
                None => self.pollination = stood,
            }
            if let ControlFlow::Break(why) = after(self, "search", cost(self)) {
                return Ok(ControlFlow::Break(why));
            }
        }
        if let Some(best) = self.pollination.best() {
            let found = best.position.clone();
            self.starts.truncate(2);
            self.starts.push(found);
        }
        while let Some(start) = self.starts.get(self.descents.len()) {
            let from = (Guess { values: start.clone(), offsets: offsets.clone() }, f64::INFINITY);
            let ended = stages.iter().try_fold(from, |(at, _), stage| descend(stage, &at, stop));
            self.descents.extend(ended);
            let best = self.best().map_or(f64::INFINITY, |(_, cost)| *cost);
            if let ControlFlow::Break(why) = after(self, "descent", best) {
                return Ok(ControlFlow::Break(why));
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// The best descent so far.
    pub fn best(&self) -> Option<&(Guess, f64)> {
        self.descents.iter().filter(|(_, cost)| cost.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Where every descent ended: costs, in the order regression, preset, search.
    pub fn descents(&self) -> Vec<f64> {
        self.descents.iter().map(|(_, cost)| *cost).collect()
    }
}
