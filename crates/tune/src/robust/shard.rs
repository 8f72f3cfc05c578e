//! A part of a comparison's plants, for one of many machines.

use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::str::FromStr;

/// Most parts of a comparison.
const MOST: usize = 100_000;

/// One of so many parts of the plants: neighbours in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which, from 1.
    pub number: usize,
    /// Of how many.
    pub of: usize,
}

impl Shard {
    /// Is it one that there is?
    pub fn is_sound(self) -> bool {
        (1..=MOST).contains(&self.of) && (1..=self.of).contains(&self.number)
    }

    /// Which of `count` plants are its own: as many as any other part has, or one more.
    pub fn range(self, count: usize) -> Range<usize> {
        let until = |parts: usize| count * parts / self.of;
        until(self.number - 1)..until(self.number)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers =
            text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        match numbers {
            Some((number, of)) if (Self { number, of }).is_sound() => Ok(Self { number, of }),
            _ => Err(format!("allowed: 1/N to N/N, N at most {MOST}, such as 3/16")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::NEVER;
    use crate::robust::{Scenes, Trial};
    use twinrotor::defaults;
    use twinrotor::plant::presets::AERO2;
    use twinrotor_sim::scenario::Scenario;

    #[test]
    fn parts_are_the_whole_in_its_order() {
        for (count, of) in [(300, 16), (7, 3), (3, 7), (100_000, 1)] {
            let parts = (1..=of).flat_map(|number| Shard { number, of }.range(count));
            assert!(parts.eq(0..count));
        }
        assert_eq!("3/16".parse(), Ok(Shard { number: 3, of: 16 }));
        for wrong in ["0/3", "4/3", "1/0", "3", "1/2/3", "-1/3", "1/200000", "a/b"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    /// Whatever lanes its neighbours were in, and whatever is random in a scenario.
    #[test]
    fn a_part_has_the_whole_trials_scores() {
        let trial = Trial::new(&AERO2, 21, 5, 1.5).flying(Scenes::All);
        let turn = "duration = 1\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = [[0.1, 9]]\n\
             [hardware]\nnoise_counts = [3, 3]\n";
        let turn = Scenario::parse("it.toml", turn).unwrap();
        let parts: Vec<Trial> = (1..=4).map(|number| trial.only(Shard { number, of: 4 }.range(21))).collect();
        let whole = trial.scores(&defaults::AERO2);
        let scores = parts.iter().flat_map(|part| part.scores(&defaults::AERO2));
        assert_eq!(scores.collect::<Vec<_>>(), whole);
        let flown = trial.survey(&defaults::AERO2, &turn, NEVER).unwrap();
        let judged = parts.iter().flat_map(|part| part.survey(&defaults::AERO2, &turn, NEVER).unwrap());
        assert_eq!(judged.collect::<Vec<_>>(), flown);
    }
}
