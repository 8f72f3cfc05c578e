//! The paper's search, an exchange at a time, so that it can be watched.

use serde::Serialize;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::gains::{NAMES, PAPER_BOUNDS};
use twinrotor::plant::State;
use twinrotor::plant::presets::{self, Rig};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor_sim::Outcome;
use twinrotor_sim::closed_loop::{ClosedLoop, IdealLoop};
use twinrotor_sim::error::known_name;
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::{GainsFile, Provenance};
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::scenario::{SAMPLE_TIME, Scenario};
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::{Bounds, Draws, FlowerPollination, FpaSettings, Optimiser, Variant};
use twinrotor_tune::search::Problem;

/// Of a response that is drawn: every so many ticks.
const DRAWN_EVERY: u32 = 20;

/// A search and what it minimises: what `host-sim tune` does with nothing but `--preset` and `--seed`.
pub struct Tuner {
    preset: String,
    rig: Rig,
    scenario: Scenario,
    seed: u64,
    objective: Objective,
    bounds: Bounds,
    searcher: FlowerPollination,
}

/// How far it is.
#[derive(Debug, Serialize)]
pub struct Progress {
    /// Evaluations used.
    pub evaluations: usize,
    /// And there will be.
    pub budget: usize,
    /// What was asked for in this exchange, in the paper's order k1..k4.
    pub asked: Vec<Vec<f64>>,
    /// The best so far, if any flies.
    pub best: Option<Vec<f64>>,
    /// Its cost \[rad² s\].
    pub cost: Option<f64>,
    /// Its step response, when it is a new one.
    pub response: Option<Response>,
    /// Which coordinates of the best are at a bound: what is beyond, no search has seen.
    pub at_bounds: Vec<usize>,
    /// It is done, and this is what the command line would write.
    pub gains_toml: Option<String>,
}

/// A flight to be drawn.
#[derive(Debug, Default, Serialize)]
pub struct Response {
    /// \[s\]
    pub time: Vec<f64>,
    /// \[deg\]
    pub pitch: Vec<f64>,
    /// \[deg\]
    pub yaw: Vec<f64>,
}

impl Tuner {
    /// At the beginning: ISE of the paper's law over the paper's step, in the paper's world.
    ///
    /// # Errors
    ///
    /// If there is no preset of that name.
    pub fn new(preset: &str, seed: u64) -> Outcome<Self> {
        let rig = *known_name("preset", preset, &presets::ALL)?;
        let scenario = Scenario::named("step")?;
        let bounds = Bounds::new(vec![PAPER_BOUNDS; NAMES.len()])?;
        Ok(Self {
            preset: preset.to_owned(),
            rig,
            objective: Objective::new(Criterion::Ise, &rig, &scenario, Fidelity::Ideal, seed),
            scenario,
            seed,
            bounds: bounds.clone(),
            searcher: FlowerPollination::new(
                FpaSettings::published(Variant::Paper),
                bounds,
                Draws::new(seed),
            ),
        })
    }

    /// One exchange further.
    pub fn go_on(&mut self) -> Progress {
        let before = self.cost();
        let asked = self.searcher.ask();
        if !asked.is_empty() {
            let costs = self.objective.costs(&asked);
            self.searcher.tell(&costs);
        }
        let (evaluations, budget) = (self.searcher.evaluations(), self.searcher.budget());
        let improved = self.cost() != before;
        let best = self.searcher.best().filter(|best| best.cost.is_finite());
        Progress {
            evaluations,
            budget,
            asked: asked.into_iter().map(|candidate| candidate.position).collect(),
            best: best.map(|best| best.position.clone()),
            cost: best.map(|best| best.cost),
            at_bounds: best.map_or_else(Vec::new, |best| self.at_bounds(&best.position)),
            response: best.filter(|_| improved).map(|best| self.response(&best.position)),
            gains_toml: best.filter(|_| evaluations >= budget).map(|_| self.file().to_toml()),
        }
    }

    fn at_bounds(&self, position: &[f64]) -> Vec<usize> {
        self.bounds.reached(position).iter().map(|reached| reached.coordinate).collect()
    }

    fn cost(&self) -> Option<f64> {
        self.searcher.best().map(|best| best.cost)
    }

    /// The best as the command line writes it.
    #[must_use]
    pub fn file(&self) -> GainsFile {
        let Some(best) = self.searcher.best() else { return GainsFile::paper() };
        let mut found = Objective::controller(&best.position);
        found.provenance = Some(Provenance {
            preset: self.preset.clone(),
            objective: "ise".to_owned(),
            algorithm: "fpa-paper".to_owned(),
            seed: self.seed,
            evaluations: self.searcher.evaluations(),
            cost: best.cost,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        });
        found
    }

    /// The step response to gains of the paper's order, as it was judged.
    fn response(&self, position: &[f64]) -> Response {
        let settings = Objective::controller(position).settings(&self.rig).map(f32::from_f64);
        let start = State::at_rest(PerAxis::zero());
        let mut closed_loop = IdealLoop::<f32>::new(&self.rig, &settings, start, SAMPLE_TIME);
        let references: Vec<Reference<f32>> = self.scenario.references();
        let mut response = Response::default();
        for (tick, reference) in (0_u32..).zip(&references) {
            let angle = closed_loop.tick(reference, PerMotor::zero()).state.angle;
            if tick.is_multiple_of(DRAWN_EVERY) {
                response.time.push(f64::from(tick) * SAMPLE_TIME);
                response.pitch.push(f64::from(angle.pitch).to_degrees());
                response.yaw.push(f64::from(angle.yaw).to_degrees());
            }
        }
        response
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor_tune::checkpoint::Identity;
    use twinrotor_tune::optimise::{Algorithm, Setup};
    use twinrotor_tune::search::Search;

    /// Table 2 of the paper: N (T + 1).
    const EVALUATIONS: usize = 50 * (30 + 1);

    /// The command line drives the same search by [`Search`].
    #[test]
    fn watching_it_does_not_change_what_it_finds() {
        let mut tuner = Tuner::new("paper", 7).unwrap();
        let (last, mut seen) = loop {
            let progress = tuner.go_on();
            if progress.gains_toml.is_some() {
                break (progress, tuner.searcher.evaluations());
            }
        };
        let begun = Tuner::new("paper", 7).unwrap();
        let algorithm = Algorithm::Fpa(Variant::Paper);
        let setup = Setup { algorithm, population: None, evaluations: EVALUATIONS };
        let bounds = Bounds::new(vec![PAPER_BOUNDS; NAMES.len()]).unwrap();
        let mut search = Search::new(Identity::new(), setup.start(bounds, Draws::new(7)));
        search.to_the_end(&begun.objective);
        let best = search.best().unwrap();
        assert_eq!((last.best.as_ref(), last.cost), (Some(&best.position), Some(best.cost)));
        assert_eq!((seen, search.evaluations()), (EVALUATIONS, EVALUATIONS));
        let reached: Vec<usize> = search.reached().iter().map(|reached| reached.coordinate).collect();
        assert!(!reached.is_empty() && last.at_bounds == reached, "{reached:?}");
        // Asked once more, it stays where it is.
        seen = tuner.go_on().evaluations;
        assert_eq!(seen, EVALUATIONS);
    }
}
