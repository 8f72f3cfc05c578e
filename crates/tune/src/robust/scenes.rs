//! What the robust objective flies on every plant: the step, and five scenes beside it.
//!
//! A scene begins at rest at zero, as the step does. With the step's angles θ = 15°, ψ = 40° and T_d:
//!
//! | scene | what is asked for | for |
//! |---|---|---|
//! | away | -θ, -ψ | T_d/2 |
//! | far | 5/3 θ, 13/4 ψ (25°, 130°) | T_d |
//! | gust | θ, ψ; from T_d/8 on, for T_d/4, the plant's disturbance comes and goes as 1 - cos | T_d/2 |
//! | sine | θ sin(2π t/T_d), ψ sin(2π t/T_d), with its rates | T_d |
//! | hot reversals | θ, ψ, then the other way and back, T_d/2 each, with motors at 90 % of the heat that their continuous current gives | 3/2 T_d |
//!
//! Each adds [`WEIGHT`] (e_pitch + e_yaw) to the plant's cost, e the RMS error over the scene in parts of the
//! goal, and [`LEFT`] where the rig leaves its envelope. Of the gust, the RMS error from its middle on
//! counts, in parts of a fifth of the goal: what the move itself costs is in the other scenes.

use super::Trial;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use twinrotor::axes::PerAxis;
use twinrotor::plant::presets::Envelope;
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::trajectory::{Profile, Trajectory, ticks};
use twinrotor_sim::judged::{self, Rules};
use twinrotor_sim::scenario::SAMPLE_TIME;

/// What the RMS error of one axis counts, where it is as large as the goal.
pub const WEIGHT: f64 = 0.5;
/// What a scene costs in which the rig leaves its envelope, besides its error.
pub const LEFT: f64 = 5.0;
/// Part of the goal that the error after a gust is set beside.
const GUST_UNIT: f64 = 0.2;
/// What the error of a scene that diverges counts as, in parts of the goal.
const LOST: f64 = 5.0;

/// What the flight is called that scenes are flown beside.
pub(super) const STEP: &str = "step";

/// What is flown on every plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scenes {
    /// The cold step from rest alone.
    #[default]
    Step,
    /// The step and every [`Scene`].
    All,
}

/// A flight beside the step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scene {
    /// The step the other way.
    Away,
    /// Further than the command filter reaches at once.
    Far,
    /// A gust while the step is under way.
    Gust,
    /// A reference that moves.
    Sine,
    /// From one side to the other with hot motors.
    HotReversals,
}

/// All of them, in the order in which scores have them.
pub const SCENES: [Scene; 5] = [Scene::Away, Scene::Far, Scene::Gust, Scene::Sine, Scene::HotReversals];

impl Scene {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Away => "away",
            Self::Far => "far",
            Self::Gust => "gust",
            Self::Sine => "sine",
            Self::HotReversals => "hot reversals",
        }
    }

    /// \[T_d\] How long it lasts.
    fn length(self) -> f64 {
        match self {
            Self::Away | Self::Gust => 0.5,
            Self::Far | Self::Sine => 1.0,
            Self::HotReversals => 1.5,
        }
    }

    /// \[-\] Its goal, in parts of the step's.
    fn goal(self) -> PerAxis<f64> {
        match self {
            Self::Far => PerAxis::new(5.0 / 3.0, 13.0 / 4.0),
            _ => PerAxis::both(1.0),
        }
    }
}

/// A scene's flight in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SceneScore {
    /// \[-\] RMS error over the scene in parts of its goal; after a gust, of a fifth of it.
    pub error: PerAxis<f64>,
    /// The rig left its envelope.
    pub failed: bool,
}

impl SceneScore {
    /// What a diverged flight counts as.
    pub(super) fn diverged() -> Self {
        Self { error: PerAxis::both(LOST), failed: true }
    }

    /// What it adds to its plant's cost.
    pub fn cost(&self) -> f64 {
        WEIGHT * (self.error.pitch + self.error.yaw) + if self.failed { LEFT } else { 0.0 }
    }
}

/// One flight of a trial, tick by tick.
#[derive(Debug, Clone)]
pub(super) struct Course {
    /// What it is called.
    pub(super) name: &'static str,
    /// \[rad\] Where to.
    pub(super) goal: PerAxis<f64>,
    /// \[rad\] What a scene's errors are set beside.
    pub(super) unit: PerAxis<f64>,
    asked: Asked,
    /// \[ticks\] When a gust comes and has gone.
    gust: Option<[u32; 2]>,
    /// With hot motors from the second tick on; the board arms in the first.
    pub(super) hot: bool,
    /// The first tick with the step's disturbance. From here on errors are summed: in a scene, from its first
    /// tick or from a gust's middle.
    pub(super) disturbance: u32,
    /// The first tick after the flight.
    pub(super) end: u32,
}

#[derive(Debug, Clone)]
enum Asked {
    /// One goal, then its opposite, and so on, this many ticks each.
    Goal(u32),
    Moving(Box<Trajectory<f32>>),
}

impl Course {
    /// The objective's step.
    pub(super) fn step(trial: &Trial) -> Self {
        let disturbance = ticks(trial.allowance, SAMPLE_TIME);
        Self {
            name: STEP,
            goal: trial.step,
            unit: trial.step,
            asked: Asked::Goal(u32::MAX),
            gust: None,
            hot: false,
            disturbance,
            end: 2 * disturbance,
        }
    }

    /// A scene beside it.
    pub(super) fn scene(trial: &Trial, scene: Scene) -> Self {
        let after = |part: f64| ticks(part * trial.allowance, SAMPLE_TIME);
        let goal = trial.step.zip(scene.goal(), |step, part| step * part);
        let swing = |size: f64| Profile::sine(0.0, size, TAU / trial.allowance, 0.0, SAMPLE_TIME);
        Self {
            name: scene.name(),
            goal: if scene == Scene::Away { goal.scaled(-1.0) } else { goal },
            unit: if scene == Scene::Gust { goal.scaled(GUST_UNIT) } else { goal },
            asked: match scene {
                Scene::Sine => Asked::Moving(Box::new(Trajectory::new(swing(goal.pitch), swing(goal.yaw)))),
                Scene::HotReversals => Asked::Goal(after(0.5)),
                _ => Asked::Goal(u32::MAX),
            },
            gust: (scene == Scene::Gust).then(|| [after(0.125), after(0.375)]),
            hot: scene == Scene::HotReversals,
            disturbance: if scene == Scene::Gust { after(0.25) } else { 0 },
            end: after(scene.length()),
        }
    }

    /// Every flight of a trial.
    pub(super) fn all(trial: &Trial) -> Vec<Self> {
        let beside = match trial.scenes {
            Scenes::Step => &[][..],
            Scenes::All => &SCENES,
        };
        let scenes = beside.iter().map(|scene| Self::scene(trial, *scene));
        std::iter::once(Self::step(trial)).chain(scenes).collect()
    }

    /// What it is judged by, for a rig that may be in `envelope`.
    pub(super) fn rules(&self, envelope: Envelope) -> Rules {
        Rules { goal: self.goal, envelope, disturbance: self.disturbance, end: self.end, hot: self.hot }
    }

    /// What is asked for from this tick on, where that changes.
    #[inline(always)]
    pub(super) fn asked(&self, tick: u32) -> Option<Reference<f32>> {
        match &self.asked {
            Asked::Goal(each) => tick.is_multiple_of(*each).then(|| {
                let side = if (tick / each).is_multiple_of(2) { 1.0 } else { -1.0 };
                Reference::at_rest(self.goal.scaled(side).cast())
            }),
            Asked::Moving(trajectory) => Some(trajectory.at(tick)),
        }
    }

    /// \[-\] What pushes in this tick, in parts of the plant's disturbance; `None` for nothing.
    #[inline(always)]
    pub(super) fn push(&self, tick: u32) -> Option<f32> {
        match self.gust {
            Some([from, to]) => (from..to).contains(&tick).then(|| {
                let part = f64::from(tick - from) / f64::from(to - from);
                f32::from_f64(1.0 - Real::sin_cos(TAU * part).1)
            }),
            None => (self.disturbance > 0 && tick >= self.disturbance).then_some(1.0),
        }
    }
}

impl judged::Course for &Course {
    #[inline(always)]
    fn asked(&mut self, tick: u32) -> Option<Reference<f32>> {
        Course::asked(self, tick)
    }

    #[inline(always)]
    fn push(&mut self, tick: u32) -> Option<f32> {
        Course::push(self, tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robust::{step_total, total};
    use twinrotor::defaults;
    use twinrotor::pipeline::Settings;
    use twinrotor::plant::presets::{AERO2, PAPER};
    use twinrotor::plant::{RealPlant, State};
    use twinrotor_sim::closed_loop::{ClosedLoop as _, Hardware, RigLoop};

    fn trial() -> Trial {
        Trial::new(&AERO2, 20, 3, 4.0)
    }

    #[test]
    fn scenes_add_to_the_steps_cost_and_change_nothing_of_it() {
        let step = trial().scores(&defaults::AERO2);
        let all = trial().flying(Scenes::All).scores(&defaults::AERO2);
        assert_eq!(total(&step), step_total(&all));
        for (step, all) in step.iter().zip(&all) {
            assert!(step.scenes.iter().all(Option::is_none));
            let scenes: f64 = all.scenes.iter().map(|scene| scene.unwrap().cost()).sum();
            assert!((all.cost() - step.cost() - scenes).abs() < 1e-12 && scenes > 0.5);
        }
    }

    /// The far step's errors once more, in f64 and by a loop of its own.
    #[test]
    fn an_error_is_that_of_the_flight_in_parts_of_its_goal() {
        let trial = trial().flying(Scenes::All);
        let [_, far, ..] = trial.scores(&defaults::AERO2)[0].scenes;
        let draw = &trial.plants[0];
        let plant = RealPlant::<f64>::new(&draw.plant, State::default(), SAMPLE_TIME);
        let settings = Settings::new(&AERO2, defaults::AERO2, SAMPLE_TIME);
        let mut flown = RigLoop::new(plant, &Hardware::of(&AERO2, draw.encoder_phase), &settings);
        let goal = PerAxis::new(25.0, 130.0).map(f64::to_radians);
        let mut squares = PerAxis::zero();
        for _ in 0..4000 {
            let error = flown.tick(&Reference::at_rest(goal), twinrotor::axes::PerMotor::zero()).error();
            squares = squares.plus(error.map(|e| e * e));
        }
        let expected = squares.zip(goal, |sum, goal| (sum / 4000.0_f64).sqrt() / goal);
        let error = far.unwrap().error;
        assert!((error.pitch / expected.pitch - 1.0).abs() < 1e-2, "{error:?} {expected:?}");
        assert!((error.yaw / expected.yaw - 1.0).abs() < 1e-2, "{error:?} {expected:?}");
    }

    /// The gust pushes while the step is under way, and is over before the scene is.
    #[test]
    fn a_gust_comes_and_goes() {
        let course = Course::scene(&trial(), Scene::Gust);
        let pushes: Vec<f32> = (0..course.end).map(|tick| course.push(tick).unwrap_or(0.0)).collect();
        let most = pushes.iter().position(|push| *push >= 2.0).unwrap();
        assert_eq!((most, course.disturbance, course.end), (1000, 1000, 2000));
        assert!(pushes[..500].iter().chain(&pushes[1500..]).all(|push| *push == 0.0));
        assert!((pushes.iter().sum::<f32>() - 1000.0).abs() < 1.0);
    }

    /// Heat matters where the rig knows its motors, and nowhere else.
    #[test]
    fn hot_motors_fly_otherwise_where_they_are_known() {
        for (rig, controller) in [(AERO2, defaults::AERO2), (PAPER, defaults::PAPER)] {
            let trial = Trial::new(&rig, 4, 3, 4.0).flying(Scenes::All);
            let settings = Settings::new(&rig, controller, SAMPLE_TIME).map(f32::from_f64);
            let fly = |hot| {
                let reversals = Course { hot, ..Course::scene(&trial, Scene::HotReversals) };
                let courses = [Course::step(&trial), reversals];
                let never = crate::parallel::NEVER;
                super::super::kernel::scores(&trial, &courses, &settings, &trial.plants, never)
            };
            assert_eq!(fly(true) != fly(false), rig.motor.is_some());
        }
    }
}
