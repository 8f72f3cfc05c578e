//! The paper's search, an exchange at a time, so that it can be watched.

use serde::Serialize;
use twinrotor::axes::PerAxis;
use twinrotor::gains::{NAMES, PAPER_BOUNDS};
use twinrotor::plant::presets::{self, Rig};
use twinrotor_sim::error::known_name;
use twinrotor_sim::flight::{self, Fidelity, Plan, Scalar};
use twinrotor_sim::gains_file::{GainsFile, Provenance};
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::{Error, Outcome};
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::{Algorithm, Bounds, Draws, Optimiser, Searcher, Setup, Variant};
use twinrotor_tune::search::Problem;

/// Table 2 of the paper: N (T + 1).
const EVALUATIONS: usize = 50 * (30 + 1);
/// Of a response that is drawn: every so many ticks.
const DRAWN_EVERY: usize = 20;

/// A search and what it minimises: what `host-sim tune` does with nothing but `--preset` and `--seed`.
pub struct Tuner {
    preset: String,
    rig: Rig,
    scenario: Scenario,
    seed: u64,
    objective: Objective,
    searcher: Searcher,
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
    /// It is done, and this is what the command line would write.
    pub gains_toml: Option<String>,
}

/// A flight to be drawn.
#[derive(Debug, Serialize)]
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
        let setup =
            Setup { algorithm: Algorithm::Fpa(Variant::Paper), population: None, evaluations: EVALUATIONS };
        let bounds = Bounds::new(vec![PAPER_BOUNDS; NAMES.len()])?;
        Ok(Self {
            preset: preset.to_owned(),
            rig,
            objective: Objective::new(Criterion::Ise, &rig, &scenario, Fidelity::Ideal, seed),
            scenario,
            seed,
            searcher: setup.start(bounds, Draws::new(seed)),
        })
    }

    /// One exchange further.
    ///
    /// # Errors
    ///
    /// If the best flight cannot be flown again.
    pub fn go_on(&mut self) -> Outcome<Progress> {
        let before = self.cost();
        let asked = self.searcher.ask();
        if !asked.is_empty() {
            let costs = self.objective.costs(&asked);
            self.searcher.tell(&costs);
        }
        let (evaluations, budget) = (self.searcher.evaluations(), self.searcher.budget());
        let improved = self.cost() != before;
        let best = self.searcher.best().filter(|best| best.cost.is_finite());
        Ok(Progress {
            evaluations,
            budget,
            asked: asked.into_iter().map(|candidate| candidate.position).collect(),
            best: best.map(|best| best.position.clone()),
            cost: best.map(|best| best.cost),
            response: best.filter(|_| improved).map(|best| self.response(&best.position)).transpose()?,
            gains_toml: best.filter(|_| evaluations >= budget).map(|_| self.file().to_toml()),
        })
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

    fn response(&self, position: &[f64]) -> Result<Response, Error> {
        let settings = Objective::controller(position).settings(&self.rig);
        let plan = Plan {
            rig: &self.rig,
            settings: &settings,
            scenario: &self.scenario,
            initial: PerAxis::zero(),
            fidelity: Fidelity::Ideal,
            seed: self.seed,
        };
        let flown = flight::fly(&plan, Scalar::F32)?;
        let rows = flown.rows.iter().step_by(DRAWN_EVERY);
        Ok(Response {
            time: rows.clone().map(|row| row.time).collect(),
            pitch: rows.clone().map(|row| row.state.angle.pitch.to_degrees()).collect(),
            yaw: rows.map(|row| row.state.angle.yaw.to_degrees()).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor_tune::checkpoint::Identity;
    use twinrotor_tune::search::Search;

    /// The command line drives the same search by [`Search`].
    #[test]
    fn watching_it_does_not_change_what_it_finds() {
        let mut tuner = Tuner::new("paper", 7).unwrap();
        let (last, mut seen) = loop {
            let progress = tuner.go_on().unwrap();
            if progress.gains_toml.is_some() {
                break (progress, tuner.searcher.evaluations());
            }
        };
        let begun = Tuner::new("paper", 7).unwrap();
        let mut search = Search::new(Identity::new(), begun.searcher);
        search.to_the_end(&begun.objective);
        let best = search.best().unwrap();
        assert_eq!((last.best.as_ref(), last.cost), (Some(&best.position), Some(best.cost)));
        assert_eq!((seen, search.evaluations()), (EVALUATIONS, EVALUATIONS));
        // Asked once more, it stays where it is.
        seen = tuner.go_on().unwrap().evaluations;
        assert_eq!(seen, EVALUATIONS);
    }
}
