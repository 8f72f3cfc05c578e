//! Rotors that are slower or quicker than believed by more than drawn plants are: the same plants with every
//! lag at one multiple of what the controller believes.

use super::{Score, Trial, total};
use crate::parallel::Stop;
use serde::Serialize;
use twinrotor::controller::ControllerSettings;
use twinrotor_sim::error::{Error, Outcome};

/// \[-\] The multiples within which a lag may be wrong.
const MULTIPLES: std::ops::RangeInclusive<f64> = 0.05..=10.0;

/// One multiple over all plants.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LagRow {
    /// \[-\] The true lag of both rotors, in what is believed of each.
    pub multiple: f64,
    /// Plants on which it failed.
    pub failures: usize,
    /// Of these, on how many a board would have cut the motors, where that was looked at.
    pub cuts: usize,
    /// mean(c) + q90(c)/2.
    #[serde(rename = "J")]
    pub total: f64,
}

impl LagRow {
    /// From the scores of its flights.
    pub fn new(multiple: f64, scores: &[Score]) -> Self {
        Self {
            multiple,
            failures: scores.iter().filter(|s| s.failed).count(),
            cuts: scores.iter().filter(|s| s.cut.is_some()).count(),
            total: total(scores),
        }
    }
}

/// Could lags be wrong by `multiple`?
///
/// # Errors
///
/// If it is out of range.
pub fn check_multiple(multiple: f64) -> Outcome<f64> {
    if MULTIPLES.contains(&multiple) {
        return Ok(multiple);
    }
    let allowed = format_args!("{} to {} times what is believed", MULTIPLES.start(), MULTIPLES.end());
    Err(Error::invalid("true_lags", multiple, allowed))
}

impl Trial {
    /// The same plants, with rotors whose lags are all at `multiple` of those believed.
    #[must_use]
    pub fn with_lags(&self, multiple: f64) -> Self {
        let lag = self.rig.plant.rotor_time_constant.map(|lag| multiple * lag);
        let mut trial = self.clone();
        trial.truth.plant.rotor_time_constant = lag;
        trial.plants.iter_mut().for_each(|draw| draw.plant.rotor_time_constant = lag);
        trial
    }

    /// The rows of `multiples`, as a board flies them; nothing if `stop` says so before all are known.
    pub fn lag_rows(
        &self,
        controller: &ControllerSettings<f64>,
        multiples: &[f64],
        stop: Stop<'_>,
    ) -> Option<Vec<LagRow>> {
        let row = |multiple: f64| {
            Some(LagRow::new(multiple, &self.with_lags(multiple).scores_until(controller, stop)?))
        };
        multiples.iter().copied().map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Limit, Row, UNSEEN, allowance};
    use super::*;
    use crate::parallel::NEVER;
    use twinrotor::defaults;
    use twinrotor::plant::presets::{self, PAPER};

    /// All but the lag stays as it was drawn, and what is flown is what `--true-lag` flies.
    #[test]
    fn only_lags_differ() {
        let trial = Trial::new(&PAPER, 5, 4, 1.0);
        let slow = trial.with_lags(3.0);
        assert_eq!(slow.rig, trial.rig);
        for (drawn, slow) in trial.plants.iter().zip(&slow.plants) {
            let lag = slow.plant.rotor_time_constant;
            assert_eq!(lag, PAPER.plant.rotor_time_constant.map(|lag| 3.0 * lag));
            let mut same = *slow;
            same.plant.rotor_time_constant = drawn.plant.rotor_time_constant;
            assert_eq!(same, *drawn);
        }
        for bad in [0.0, 11.0, f64::NAN] {
            assert!(check_multiple(bad).unwrap_err().to_string().contains("allowed: 0.05 to 10 times"));
        }
    }

    /// On plants that nothing was tuned on: `paper`, `paper-fixed` and `heli` from a fifth of the lag to
    /// three times, and every other preset from a fifth to twice (docs/rig-law.md, "Lag that is wrong by
    /// far").
    #[test]
    fn what_boards_boot_with_holds_where_lags_are_wrong_by_far() {
        for ((name, rig), (_, controller)) in presets::ALL.into_iter().zip(defaults::ALL) {
            let far = ["paper", "paper-fixed", "heli"].contains(&name);
            let (plants, multiples): (_, &[f64]) =
                if far { (60, &[0.2, 0.5, 2.0, 3.0]) } else { (12, &[0.2, 2.0]) };
            let trial = Trial::new(&rig, plants, UNSEEN + 1, allowance(name, &rig));
            for row in trial.lag_rows(&controller, multiples, NEVER).unwrap() {
                assert_eq!((row.failures, row.cuts), (0, 0), "{name}: {row:?}");
            }
        }
    }

    /// A lag ten times as long as believed costs more and fails; limits see the worst lag and all failures.
    #[test]
    fn limits_act_on_the_worst_lag_and_on_all_failures() {
        let trial = Trial::new(&PAPER, 4, 4, 2.0);
        let controller = defaults::PAPER;
        let rows = trial.lag_rows(&controller, &[1.0, 10.0], NEVER).unwrap();
        assert!(rows[0].failures == 0 && rows[1].failures == 4 && rows[1].total > 2.0 * rows[0].total);
        let row = Row { lags: rows.clone(), ..Row::new("it", &trial.scores(&controller), None, Vec::new()) };
        let excess = |text: &str| Limit::parse(text).unwrap().excess(&row);
        assert_eq!(excess("lags.failures=0"), 4.0);
        assert_eq!(excess("lags.failures=2"), 1.0);
        let half = 0.5 * rows[1].total;
        assert!((excess(&format!("lags.J={half}")) - 1.0).abs() < 1e-12);
    }
}
