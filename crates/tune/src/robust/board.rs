//! Flights that a board ends, as lanes and devices say of them (`crates/sim/src/guard.rs`).

use super::Scene;
use super::scenes::{Course, SCENES, STEP};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use twinrotor::supervisor::Condition;
use twinrotor_sim::judged::Ended;
use twinrotor_sim::scenario::SAMPLE_TIME;

/// A flight's name. By another name than its own, so that serde does not take it for text that it may borrow.
type Name = &'static str;

/// A flight that the board ended.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cut {
    /// Which: `step`, or a scene's name.
    #[serde(deserialize_with = "flight")]
    pub flight: Name,
    /// What the motors were cut for.
    pub condition: Condition,
    /// \[s\] From its beginning.
    pub time: f64,
}

/// One of the names that a flight has.
fn flight<'de, D: Deserializer<'de>>(from: D) -> Result<&'static str, D::Error> {
    let name = String::deserialize(from)?;
    let known = std::iter::once(STEP).chain(SCENES.map(Scene::name)).find(|known| *known == name);
    known.ok_or_else(|| D::Error::custom("a flight of no such name"))
}

impl Cut {
    pub(super) fn of(course: &Course, Ended { tick, condition }: Ended) -> Self {
        Self { flight: course.name, condition, time: f64::from(tick) * SAMPLE_TIME }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robust::{DISTURBANCE, Scenes, Trial};
    use twinrotor::defaults;
    use twinrotor::plant::presets::AERO2;

    /// What boards boot with is cut nowhere; a rig whose tail motor turns the other way is, on every plant.
    #[test]
    fn a_rig_that_does_not_do_as_it_should_is_cut_and_no_other() {
        let mut trial = Trial::new(&AERO2, 4, 5, 3.0).flying(Scenes::All);
        assert!(trial.plants.iter().all(|d| d.disturbance.main.abs() < DISTURBANCE));
        assert!(trial.scores(&defaults::AERO2).iter().all(|score| score.cut.is_none()));
        for draw in &mut trial.plants {
            let thrust = &mut draw.plant.effectiveness;
            (thrust.tail_on_yaw, thrust.tail_on_pitch) = (-thrust.tail_on_yaw, -thrust.tail_on_pitch);
        }
        for score in trial.scores(&defaults::AERO2) {
            assert!(score.failed);
            let cut = score.cut.expect("the yaw runs the wrong way");
            assert!(
                cut.flight == "step" && cut.condition == Condition::YawMotion && cut.time < 2.0,
                "{cut:?}"
            );
        }
    }
}
