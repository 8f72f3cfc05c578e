//! Flights that a board ends: what the lanes say of them (`crates/sim/src/guard.rs`), and the same once more
//! by the board's own loop.

use super::scenes::{Course, SCENES, STEP};
use super::{Draw, Scene, Trial};
use crate::parallel::{self, Stop};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use twinrotor::axes::PerAxis;
use twinrotor::controller::ControllerSettings;
use twinrotor::pipeline::Settings;
use twinrotor::plant::{RealPlant, State};
use twinrotor::supervisor::Condition;
use twinrotor_sim::closed_loop::{BoardLoop, Hardware};
use twinrotor_sim::device::changes;
use twinrotor_sim::judged::{self, Ended};
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

impl Trial {
    /// For each plant, in their order, the first of the trial's flights in which a board would cut the
    /// motors; nothing if `stop` says so before all have flown.
    ///
    /// What [`Score::cut`](super::Score) says, to the tick; but here the board's own loop has flown each
    /// flight alone, which takes many times as long. It is what the lanes and a device are held against.
    pub fn cuts(&self, controller: &ControllerSettings<f64>, stop: Stop<'_>) -> Option<Vec<Option<Cut>>> {
        let settings = self.settings(controller);
        let courses = Course::all(self);
        if let Some(device) = self.fitting_device() {
            let mut cuts = vec![None; self.plants.len()];
            for course in &courses {
                let list = changes(course, course.end);
                let ended = device.cuts(&self.batch(course, &list, &[settings]), stop)?;
                for (cut, ended) in cuts.iter_mut().zip(ended) {
                    *cut = cut.or(ended.map(|ended| Cut::of(course, ended)));
                }
            }
            return Some(cuts);
        }
        parallel::try_map(&self.plants, |draw| {
            if stop() {
                return None;
            }
            Some(courses.iter().find_map(|course| self.cut(&settings, course, draw)))
        })
    }

    pub(super) fn cut(&self, settings: &Settings<f32>, course: &Course, draw: &Draw) -> Option<Cut> {
        let plant = RealPlant::new(&draw.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
        let hardware = Hardware::of(&self.truth, draw.encoder_phase).taken_for(&self.rig, &self.truth);
        let board = BoardLoop::new(plant, &hardware, settings);
        let ended = judged::cut(board, draw.disturbance.cast(), &course.rules(self.truth.envelope), course)?;
        Some(Cut::of(course, ended))
    }
}

impl Cut {
    pub(super) fn of(course: &Course, Ended { tick, condition }: Ended) -> Self {
        Self { flight: course.name, condition, time: f64::from(tick) * SAMPLE_TIME }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robust::{DISTURBANCE, Scenes};
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
        assert!(trial.cuts(&defaults::AERO2, &|| true).is_none());
    }
}
