//! Controllers tuned to be compared: each with one budget, on the same plants, and with what says whether
//! that was enough.

use super::{Plan, Robust, Scatter, Scenes, Trial};
use crate::checkpoint::Identity;
use crate::optimise::{Algorithm, Setup, Variant};
use crate::search::Search;
use crate::tunable::{AtBound, Tunable};
use twinrotor::controller::ControllerSettings;
use twinrotor::plant::presets::Rig;
use twinrotor_sim::Outcome;
use twinrotor_sim::gains_file::{GainsFile, Provenance};
use twinrotor_sim::rig::NamedRig;

/// Everything that is the same for all controllers that are to be compared: plants, budget, algorithm.
#[derive(Debug, Clone)]
pub struct Tuning {
    trial: Trial,
    scatter: Scatter,
    plan: Plan,
    preset: String,
    rig: Rig,
}

/// The robust objective, as gains files name it.
pub fn objective(plants: usize, scenes: Scenes, scatter: &Scatter) -> String {
    let scenes = (scenes == Scenes::All).then(|| "all scenes".to_owned());
    let parts = std::iter::once(format!("robust, {plants} plants")).chain(scenes).chain(scatter.told());
    parts.collect::<Vec<_>>().join(", ")
}

/// Plants that a comparison's controllers are tuned on.
const PLANTS: usize = 32;

impl Tuning {
    /// `rounds` searches of 500 evaluations each, on plants within `scatter`.
    pub fn standard(named: &NamedRig, rounds: usize, seed: u64, scatter: &Scatter) -> Self {
        let algorithm = Algorithm::Fpa(Variant::Yang);
        let setup = Setup { algorithm, population: Some(25), evaluations: 500 };
        let allowance = super::allowance(&named.name, &named.rig);
        Self {
            trial: Trial::within(&named.rig, PLANTS, seed, allowance, scatter),
            scatter: *scatter,
            plan: Plan { setup, rounds, range: 4.0, seed },
            preset: named.name.clone(),
            rig: named.rig,
        }
    }

    /// The same with so many evaluations in each round.
    #[must_use]
    pub fn of(mut self, evaluations: usize) -> Self {
        self.plan.setup.evaluations = evaluations;
        self
    }

    /// Tunes every parameter of a controller, from what `design` makes of the rig.
    ///
    /// # Errors
    ///
    /// If the design has no parameter to tune.
    pub fn run(&self, design: fn(&Rig) -> ControllerSettings<f64>) -> Outcome<Tuned> {
        let tunable = Tunable::new(&design(&self.rig), &[])?;
        let search = Search::new(Identity::new(), self.plan.start(tunable.names().len()));
        let mut tuned = Tuned { search, tunable, rounds: self.plan.rounds };
        tuned.search.to_the_end(&Robust::new(&self.trial, &tuned.tunable));
        Ok(tuned)
    }

    /// The same with one round more: what comes out had there been so many from the first.
    pub fn more(&self, tuned: &mut Tuned) {
        tuned.search.one_round_more(&Robust::new(&self.trial, &tuned.tunable));
        tuned.rounds += 1;
    }

    /// On how many of the plants that it was tuned on it fails.
    pub fn failures(&self, tuned: &Tuned) -> usize {
        self.trial.scores(&tuned.controller()).iter().filter(|score| score.failed).count()
    }

    /// Tuned gains as a file.
    pub fn file(&self, tuned: &Tuned) -> GainsFile {
        let provenance = Provenance {
            preset: self.preset.clone(),
            objective: objective(PLANTS, self.trial.scenes, &self.scatter),
            algorithm: format!("fpa-yang, {} rounds", tuned.rounds),
            seed: self.plan.seed,
            evaluations: tuned.evaluations(),
            cost: tuned.cost(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        GainsFile { controller: tuned.controller(), provenance: Some(provenance) }
    }
}

/// A controller that has been tuned, and the search, which can go on.
#[derive(Debug, Clone)]
pub struct Tuned {
    search: Search,
    tunable: Tunable,
    rounds: usize,
}

impl Tuned {
    /// It itself.
    pub fn controller(&self) -> ControllerSettings<f64> {
        self.search.best().map_or_else(
            || self.tunable.controller(&vec![0.0; self.tunable.names().len()]),
            |best| self.tunable.controller(&best.position),
        )
    }

    /// Rounds that it had.
    pub fn rounds(&self) -> usize {
        self.rounds
    }

    /// Evaluations that it had.
    pub fn evaluations(&self) -> usize {
        self.search.evaluations()
    }

    /// J on the plants that it was tuned on.
    pub fn cost(&self) -> f64 {
        self.search.cost()
    }

    /// The parameters that its last round has left at a bound of its box.
    pub fn at_bounds(&self) -> Vec<AtBound> {
        self.search.at_bounds_of(&self.tunable)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::plant::presets::PAPER;

    /// The paper's gains divided by ten: further off than a box of a factor of 4 reaches.
    fn far_off(_: &Rig) -> ControllerSettings<f64> {
        let paper = ControllerSettings::paper(twinrotor::gains::PAPER);
        Tunable::new(&paper, &[]).unwrap().controller(&[-f64::ln(10.0); 4])
    }

    /// A round that is added is the round that would have been; what one round leaves at its bounds, more
    /// rounds get past.
    #[test]
    fn a_tuning_says_what_it_left_at_a_bound_and_can_go_on() {
        let named = NamedRig { name: "paper".to_owned(), rig: PAPER };
        let tuning = |rounds| Tuning::standard(&named, rounds, 1, &Scatter::default()).of(50);
        let mut one = tuning(1).run(far_off).unwrap();
        let at = one.at_bounds();
        assert!(!at.is_empty(), "gains a tenth of what is wanted are within reach");
        for end in &at {
            let factor = end.bound / end.value;
            assert!((0.9..1.15).contains(&factor), "{end}");
            assert!(end.to_string().contains(&format!("{} = ", end.name)), "{end}");
        }
        let before = one.cost();
        tuning(1).more(&mut one);
        let both = tuning(2).run(far_off).unwrap();
        assert_eq!(one.controller(), both.controller());
        assert_eq!((one.rounds(), one.evaluations()), (2, both.evaluations()));
        assert!(one.cost() < before);
        assert_eq!(tuning(1).file(&one), tuning(2).file(&both));
    }
}
