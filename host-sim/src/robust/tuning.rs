//! Tuning any controller on the robust objective by flower pollination, in rounds.
//!
//! Each round searches the logarithms of the parameters within a range around the best controller so far, and each round's range is
//! smaller than the last one's: the paper's FPA contracts fast (its population by .7 an iteration), so a search in a dozen
//! dimensions gains more from starting anew around what it found than from more iterations.

use super::Trial;
use crate::error::{Outcome, known_name};
use crate::gains_file::{GainsFile, Provenance};
use crate::optimise::{Bounds, Candidate, Draws, FlowerPollination, FpaSettings, Optimiser, Variant};
use crate::rig::NamedRig;
use crate::tunable::Tunable;
use rayon::prelude::*;
use twinrotor::controller::ControllerSettings;
use twinrotor::plant::presets::Rig;

/// How to search.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The algorithm and its numbers, for each round.
    pub fpa: FpaSettings,
    /// How many rounds, at least 1.
    pub rounds: usize,
    /// Factor within which each parameter is searched in the first round, above 1.
    pub range: f64,
    /// Of everything random.
    pub seed: u64,
}

/// What came out.
#[derive(Debug, Clone)]
pub struct Tuned {
    /// The best controller.
    pub controller: ControllerSettings<f64>,
    /// Its J on the plants it was tuned on.
    pub cost: f64,
    /// Evaluations used.
    pub evaluations: usize,
    /// Evaluations and cost at every improvement.
    pub history: Vec<(usize, f64)>,
    /// Was it stopped before its end?
    pub stopped: bool,
}

/// From round to round the range's logarithm shrinks to this part.
const SHRINK: f64 = 0.6;

/// Tunes; what no gains file could hold costs infinity. `seen` is shown evaluations and best cost after every exchange, and stops the search by returning false.
pub fn tune(
    trial: &Trial,
    tunable: &Tunable,
    plan: &Plan,
    mut seen: impl FnMut(usize, f64) -> bool,
) -> Tuned {
    let dimension = tunable.names().len();
    let mut center = vec![0.0; dimension];
    let cost = |position: &[f64]| {
        let controller = tunable.controller(position);
        if controller.validate().is_ok() { trial.cost(&controller) } else { f64::INFINITY }
    };
    let mut best = cost(&center);
    let mut evaluations = 1;
    let mut history = vec![(evaluations, best)];
    let mut reach = plan.range.ln();
    let mut stopped = false;
    for round in 0..plan.rounds as u64 {
        let bounds = Bounds::new(center.iter().map(|c| [c - reach, c + reach]).collect());
        let bounds = bounds.expect("a range around finite numbers");
        let draws = Draws::new(plan.seed.wrapping_mul(1000).wrapping_add(round));
        let mut search = FlowerPollination::new(plan.fpa.clone(), bounds, draws);
        loop {
            let asked = search.ask();
            if asked.is_empty() {
                break;
            }
            search.tell(&costs(&asked, &cost));
            let now = evaluations + search.evaluations();
            if let Some(found) = search.best().filter(|b| b.cost < best) {
                best = found.cost;
                center.clone_from(&found.position);
                history.push((now, best));
            }
            if !seen(now, best) {
                stopped = true;
                break;
            }
        }
        evaluations += search.evaluations();
        reach *= SHRINK;
        if stopped {
            break;
        }
    }
    Tuned { controller: tunable.controller(&center), cost: best, evaluations, history, stopped }
}

/// In order, on all threads.
fn costs(asked: &[Candidate], cost: &(impl Fn(&[f64]) -> f64 + Sync)) -> Vec<f64> {
    asked.par_iter().map(|candidate| cost(&candidate.position)).collect()
}

/// Everything that is the same for all controllers that are to be compared: plants, budget, algorithm.
#[derive(Debug, Clone)]
pub struct Tuning {
    trial: Trial,
    plan: Plan,
    preset: String,
    rig: Rig,
}

/// Plants that a comparison's controllers are tuned on.
const PLANTS: usize = 32;

impl Tuning {
    /// `rounds` searches of 500 evaluations each.
    pub fn standard(named: &NamedRig, rounds: usize, seed: u64) -> Self {
        let fpa =
            FpaSettings { population_size: 25, iterations: 19, ..FpaSettings::published(Variant::Yang) };
        let allowance = super::allowance(&named.name, &named.rig);
        Self {
            trial: Trial::new(&named.rig, PLANTS, seed, allowance),
            plan: Plan { fpa, rounds, range: 4.0, seed },
            preset: named.name.clone(),
            rig: named.rig,
        }
    }

    /// Tunes every parameter of a controller of the catalogue, from its design.
    pub fn run(&self, name: &str) -> Outcome<GainsFile> {
        let design = known_name("controller", name, &super::CATALOGUE)?;
        let tunable = Tunable::new(&design(&self.rig), &[])?;
        let tuned = tune(&self.trial, &tunable, &self.plan, |_, _| true);
        let provenance = Provenance {
            preset: self.preset.clone(),
            objective: format!("robust, {PLANTS} plants"),
            algorithm: format!("fpa-yang, {} rounds", self.plan.rounds),
            seed: self.plan.seed,
            evaluations: tuned.evaluations,
            cost: tuned.cost,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        Ok(GainsFile { controller: tuned.controller, provenance: Some(provenance) })
    }
}
