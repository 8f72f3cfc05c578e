//! The robust objective: how a controller does on many plants that are not the one it believes in, in the
//! rig's world.
//!
//! The step is 15° of pitch and 40° of yaw from rest at zero with the rotors at rest; at T_d a constant
//! disturbance sets in, and the flight lasts 2 T_d. For each plant
//!
//! c = ts_pitch + ts_yaw + .05 (overshoot, both) + (RMS error after T_d, both) + .5 (RMS error in the last
//! second before T_d, both) + .001 (voltage variation in that second) + .5 (time in saturation)
//!
//! in s, %, deg, V/s and s; J = mean(c) + .5 q90(c). [`Score`] says how each term is measured, [`draw`] which
//! plants there are. With [`Scenes::All`] five scenes beside the step add to c (`scenes.rs`).

mod board;
mod comparison;
mod cost;
mod kernel;
mod lags;
mod limits;
mod plants;
mod proportion;
mod ratio;
mod scenes;
mod shard;
mod survey;
mod tuned;
mod tuning;

pub use board::Cut;
pub use comparison::{Row, SceneRow, Spread, signed_rank};
pub use cost::{Score, Terms, quantile, step_total, total};
pub use lags::{LagRow, check_multiple};
pub use limits::Limit;
pub use plants::{DISTURBANCE, Draw, LAG_SPREAD, SPREAD, Scatter, UNSEEN, allowance, draw, draw_within};
pub use proportion::{SURE, upper_bound};
pub use ratio::{Measure, Ratio};
pub use scenes::{LEFT, SCENES, Scene, SceneScore, Scenes, WEIGHT};
pub use shard::Shard;
pub use survey::{Judged, Surveyed};
pub use tuned::{Tuned, Tuning, objective};
pub use tuning::{Plan, Robust};

use crate::parallel::{self, NEVER, Stop};
use scenes::Course;
use std::ops::Range;
use std::sync::Arc;
use twinrotor::axes::PerAxis;
use twinrotor::bench::{Hardware, Wear};
use twinrotor::controller::ControllerSettings;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::real::Real;
use twinrotor_sim::device::{Batch, Change, Device};
use twinrotor_sim::lanes::LANES;
use twinrotor_sim::scenario::SAMPLE_TIME;

/// A cost must exceed its bound by this part before the rest is left out: its sums are rounded.
const SURELY: f64 = 1.0 + 1e-9;

/// A rig and the plants around it.
#[derive(Debug, Clone)]
pub struct Trial {
    /// What the controller believes.
    pub rig: Rig,
    /// What it flies, but for the plant: encoders, supply, limits, envelope.
    pub truth: Rig,
    /// The plants of it.
    pub plants: Vec<Draw>,
    /// How many were drawn before the first of them, which are another part's.
    pub before: usize,
    /// \[rad\] Where to, from rest at zero with the rotors at rest; both positive.
    pub step: PerAxis<f64>,
    /// \[s\] T_d.
    pub allowance: f64,
    /// What is flown on each plant.
    pub scenes: Scenes,
    /// What flies them; nothing for this processor. The scores are the same bits.
    pub device: Option<Arc<dyn Device>>,
}

/// Is J with these costs sure not to be below `bound`?
fn is_above(costs: &[f64], bound: f64) -> bool {
    cost::of(costs) > bound * SURELY
}

/// After how many of these flights J is sure not to be below `bound`, asked group by group, if ever: with
/// more of them it only rises, since no cost is negative.
fn enough(costs: &[f64], bound: f64) -> Option<usize> {
    if bound == f64::INFINITY {
        return None;
    }
    let after = |groups: usize| (groups * LANES).min(costs.len());
    let above = |groups: usize| {
        let mut known = costs.to_vec();
        known[after(groups)..].fill(0.0);
        is_above(&known, bound)
    };
    let all = costs.len().div_ceil(LANES);
    let (mut not, mut yes) = (0, all);
    if all == 0 || !above(all) {
        return None;
    }
    while yes - not > 1 {
        let middle = usize::midpoint(not, yes);
        if above(middle) { yes = middle } else { not = middle }
    }
    Some(after(yes))
}

/// \[deg\] The objective's step.
pub const STEP_DEG: PerAxis<f64> = PerAxis::new(15.0, 40.0);

impl Trial {
    /// `count` plants around `rig`, drawn by `seed`, with the disturbance at `allowance` \[s\].
    pub fn new(rig: &Rig, count: usize, seed: u64, allowance: f64) -> Self {
        Self::within(rig, count, seed, allowance, &Scatter::default())
    }

    /// As [`Trial::new`], with plants within `scatter` of `rig`.
    pub fn within(rig: &Rig, count: usize, seed: u64, allowance: f64, scatter: &Scatter) -> Self {
        let plants = draw_within(rig, count, seed, scatter);
        let step = STEP_DEG.map(f64::to_radians);
        Self {
            rig: *rig,
            truth: *rig,
            plants,
            before: 0,
            step,
            allowance,
            scenes: Scenes::Step,
            device: None,
        }
    }

    /// The same, with these scenes.
    #[must_use]
    pub fn flying(self, scenes: Scenes) -> Self {
        Self { scenes, ..self }
    }

    /// The same, flown by `device`.
    #[must_use]
    pub fn on(self, device: Option<Arc<dyn Device>>) -> Self {
        Self { device, ..self }
    }

    /// A part of it: these of its plants alone.
    #[must_use]
    pub fn only(&self, plants: Range<usize>) -> Self {
        let before = self.before + plants.start;
        Self { plants: self.plants[plants].to_vec(), before, ..self.clone() }
    }

    /// The scores of a controller, in the order of the plants.
    pub fn scores(&self, controller: &ControllerSettings<f64>) -> Vec<Score> {
        self.scores_until(controller, NEVER).expect("nothing stops it")
    }

    /// As [`Trial::scores`], or nothing if `stop` says so before all are known.
    pub fn scores_until(&self, controller: &ControllerSettings<f64>, stop: Stop<'_>) -> Option<Vec<Score>> {
        let (settings, courses) = (self.settings(controller), Course::all(self));
        if let Some(device) = self.fitting_device() {
            return kernel::scores_on(&*device, self, &courses, &[settings], stop)?.pop();
        }
        parallel::by_group(&self.plants, LANES, |group| {
            kernel::scores(self, &courses, &settings, group, stop)
        })
    }

    /// As [`Trial::scores_until`], without scores as soon as J is sure not to be below `bound`; and how many
    /// plants were flown.
    ///
    /// The plants still to be flown cost nothing less than nothing, and J falls with none of its costs.
    pub fn scores_below(
        &self,
        controller: &ControllerSettings<f64>,
        bound: f64,
        stop: Stop<'_>,
    ) -> Option<(Option<Vec<Score>>, usize)> {
        if bound == f64::INFINITY {
            return Some((Some(self.scores_until(controller, stop)?), self.plants.len()));
        }
        let (settings, courses) = (self.settings(controller), Course::all(self));
        self.below(bound, |group| kernel::scores(self, &courses, &settings, group, stop))
    }

    /// Those of many controllers, each with its bound: what [`Trial::scores_below`] gives for each, whether
    /// this processor flies them one by one or a device all of them together.
    pub fn all_below(
        &self,
        controllers: &[(ControllerSettings<f64>, f64)],
        stop: Stop<'_>,
    ) -> Option<Vec<(Option<Vec<Score>>, usize)>> {
        let Some(device) = self.fitting_device() else {
            return parallel::try_map(controllers, |(c, bound)| self.scores_below(c, *bound, stop));
        };
        let courses = Course::all(self);
        let settings: Vec<_> = controllers.iter().map(|(c, _)| self.settings(c)).collect();
        let all = kernel::scores_on(&*device, self, &courses, &settings, stop)?;
        let spared: Vec<Option<usize>> = parallel::by_index(controllers.len(), |k| {
            let costs: Vec<f64> = all[k].iter().map(Score::cost).collect();
            enough(&costs, controllers[k].1)
        });
        let bounded = |(scores, enough): (Vec<Score>, Option<usize>)| match enough {
            Some(flown) => (None, flown),
            None => {
                let flown = scores.len();
                (Some(scores), flown)
            }
        };
        Some(all.into_iter().zip(spared).map(bounded).collect())
    }

    /// Group by group until J is sure not to be below `bound`.
    fn below(
        &self,
        bound: f64,
        mut fly: impl FnMut(&[Draw]) -> Option<Vec<Score>>,
    ) -> Option<(Option<Vec<Score>>, usize)> {
        let mut scores = Vec::with_capacity(self.plants.len());
        for group in self.plants.chunks(LANES) {
            scores.extend(fly(group)?);
            let mut costs: Vec<f64> = scores.iter().map(Score::cost).collect();
            costs.resize(self.plants.len(), 0.0);
            if is_above(&costs, bound) {
                return Some((None, scores.len()));
            }
        }
        let flown = scores.len();
        Some((Some(scores), flown))
    }

    /// What flies this trial's flights, if that is not this processor: worn hardware, as amplifiers are that
    /// give less than the controller knows, is only flown here.
    fn fitting_device(&self) -> Option<Arc<dyn Device>> {
        self.device.clone().filter(|_| self.hardware().wear == Wear::default())
    }

    /// Sensors and amplifiers of every plant, but for the encoders' phase.
    fn hardware(&self) -> Hardware {
        Hardware::of(&self.truth, PerAxis::both(0.5)).taken_for(&self.rig, &self.truth)
    }

    /// What a device flies of it on this course, whose changes are `list`.
    fn batch<'a>(
        &'a self,
        course: &Course,
        list: &'a [Change],
        controllers: &'a [Settings<f32>],
    ) -> Batch<'a> {
        let (rules, hardware) = (course.rules(self.truth.envelope), self.hardware());
        Batch { rules, course: list, hardware, controllers, plants: &self.plants }
    }

    fn settings(&self, controller: &ControllerSettings<f64>) -> Settings<f32> {
        Settings::new(&self.rig, *controller, SAMPLE_TIME).map(f32::from_f64)
    }

    /// J.
    pub fn cost(&self, controller: &ControllerSettings<f64>) -> f64 {
        total(&self.scores(controller))
    }

    /// Closed-loop steps that each plant takes.
    pub fn steps(&self) -> u64 {
        Course::all(self).iter().map(|course| u64::from(course.end)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::SmallRng};

    /// As when they are flown group by group.
    #[test]
    fn halving_finds_the_group_after_which_a_candidate_has_lost() {
        let mut random = SmallRng::seed_from_u64(5);
        for count in [1, 15, 16, 17, 40, 333] {
            let costs: Vec<f64> = (0..count).map(|_| random.random_range(0.0..10.0)).collect();
            for part in [0.0, 0.01, 0.3, 0.7, 0.99, 1.0, 1.01, f64::INFINITY] {
                let bound = part * cost::of(&costs);
                let lost = |flown: &usize| {
                    let known = costs.iter().take(*flown).copied();
                    is_above(&known.chain(std::iter::repeat(0.0)).take(count).collect::<Vec<_>>(), bound)
                };
                let groups = (1..=count.div_ceil(LANES)).map(|groups| (groups * LANES).min(count));
                assert_eq!(enough(&costs, bound), groups.into_iter().find(lost), "{count} costs, {part}");
            }
        }
    }
}
