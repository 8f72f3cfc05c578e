//! Many plants of one controller, flown side by side and scored.

use super::cost::Score;
use super::plants::Draw;
use super::scenes::{Course, SCENES, SceneScore};
use super::{Cut, Trial};
use crate::parallel::{self, NEVER, Stop};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{LaggedRotors, RealPlant, State, Thrust};
use twinrotor::real::Real;
use twinrotor_sim::closed_loop::{Hardware, RigLoop};
use twinrotor_sim::device::{Device, changes};
use twinrotor_sim::guard::Guard;
use twinrotor_sim::judged::{Flown, HOLD, fly};
use twinrotor_sim::lanes::{Kernel, gather_plants, gather_rotors, in_lanes};
use twinrotor_sim::metrics::Settling;
use twinrotor_sim::scenario::SAMPLE_TIME;

/// \[ticks\] From one question whether to stop to the next: milliseconds.
const ASK_EVERY: u32 = 4096;
/// Flights whose scores are worth a thread.
const MANY: usize = 4096;

/// The scores of up to [`LANES`](twinrotor_sim::lanes::LANES) plants.
pub(super) fn scores(
    trial: &Trial,
    courses: &[Course],
    settings: &Settings<f32>,
    plants: &[Draw],
    stop: Stop<'_>,
) -> Option<Vec<Score>> {
    all_scores(courses, |course| in_lanes(Flights { stop, ..Flights::new(trial, course, settings, plants) }))
}

/// The scores of these controllers on every plant of the trial, flown by `device`.
pub(super) fn scores_on(
    device: &dyn Device,
    trial: &Trial,
    courses: &[Course],
    controllers: &[Settings<f32>],
    stop: Stop<'_>,
) -> Option<Vec<Vec<Score>>> {
    if controllers.is_empty() {
        return Some(Vec::new());
    }
    let fly = |course: &Course| {
        let list = changes(course, course.end);
        device.fly(&trial.batch(course, &list, controllers), stop)
    };
    let scores = all_scores(courses, fly)?;
    Some(scores.chunks(trial.plants.len()).map(<[Score]>::to_vec).collect())
}

/// The scores of flights that `fly` flies on each course, in its order.
fn all_scores(courses: &[Course], fly: impl Fn(&Course) -> Option<Vec<Flown>>) -> Option<Vec<Score>> {
    let (step, scenes) = courses.split_first().expect("the step is flown first");
    let mut scores = of_all(&fly(step)?, |flown| score(flown, step))?;
    for (k, course) in scenes.iter().enumerate() {
        let found = of_all(&fly(course)?, |flown| (scene(flown, course), cut(flown, course)))?;
        for (score, (scene, cut)) in scores.iter_mut().zip(found) {
            score.cut = score.cut.or(cut);
            score.failed |= scene.failed || score.cut.is_some();
            score.scenes[k] = Some(scene);
        }
    }
    Some(scores)
}

/// `of` every flight, side by side where they are many.
fn of_all<T: Send>(flown: &[Flown], of: impl Fn(&Flown) -> T + Sync + Send) -> Option<Vec<T>> {
    parallel::by_group(flown, MANY, |group| Some(group.iter().map(&of).collect()))
}

/// One controller on up to [`LANES`](twinrotor_sim::lanes::LANES) plants; the last one fills what lanes are
/// left.
#[derive(Clone, Copy)]
struct Flights<'a> {
    truth: &'a Rig,
    hardware: Hardware,
    settings: &'a Settings<f32>,
    plants: &'a [Draw],
    course: &'a Course,
    stop: Stop<'a>,
}

impl Kernel for Flights<'_> {
    type Output = Option<Vec<Flown>>;
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) -> Option<Vec<Flown>> {
        let limit = self.settings.volts_limit.map(R::splat);
        let bounds = self.course.rules(self.truth.envelope).bounds();
        let (flown, disturbance) = (self.closed_loop::<R>(), self.disturbance::<R>());
        let guard = Guard::new(&self.settings.map(R::splat), &self.hardware);
        let sums = fly(
            flown,
            guard,
            limit,
            disturbance,
            &bounds,
            self.course,
            #[inline(always)]
            |tick, _| !(tick % ASK_EVERY == 0 && (self.stop)()),
        )?;
        Some((0..self.plants.len()).map(|k| sums.lane(k)).collect())
    }
}

impl<'a> Flights<'a> {
    fn new(trial: &'a Trial, course: &'a Course, settings: &'a Settings<f32>, plants: &'a [Draw]) -> Self {
        Self { truth: &trial.truth, hardware: trial.hardware(), settings, plants, course, stop: NEVER }
    }

    fn closed_loop<R: Real<Scalar = f32>>(&self) -> RigLoop<R> {
        let constants: Vec<_> = self.plants.iter().map(|d| d.plant.map(f32::from_f64)).collect();
        let rotors: Vec<_> =
            self.plants.iter().map(|d| LaggedRotors::<f32>::new(&d.plant, SAMPLE_TIME)).collect();
        let plant = RealPlant::assemble(
            gather_plants(&constants),
            gather_rotors(&rotors),
            State::at_rest(PerAxis::zero()),
            SAMPLE_TIME,
        );
        let phase =
            PerAxis { pitch: self.each(|d| d.encoder_phase.pitch), yaw: self.each(|d| d.encoder_phase.yaw) };
        RigLoop::assemble(plant, &self.hardware, phase, &self.settings.map(R::splat))
    }

    fn disturbance<R: Real<Scalar = f32>>(&self) -> PerMotor<R> {
        PerMotor { main: self.each(|d| d.disturbance.main), tail: self.each(|d| d.disturbance.tail) }
    }

    fn each<R: Real<Scalar = f32>>(&self, of: impl Fn(&Draw) -> f64) -> R {
        R::from_fn(|lane| f32::from_f64(of(&self.plants[lane.min(self.plants.len() - 1)])))
    }
}

/// A flight's sums as the step's score.
fn score(flown: &Flown, course: &Course) -> Score {
    let allowance = f64::from(course.disturbance) * SAMPLE_TIME;
    let cut = cut(flown, course);
    if flown.diverged {
        return Score { cut, ..Score::diverged(allowance) };
    }
    let settled = |settling: Settling<f32>| {
        settling.time(0, course.disturbance.saturating_sub(1)).map_or(allowance, |ticks| ticks * SAMPLE_TIME)
    };
    let hold = HOLD.min(course.disturbance);
    Score {
        settling_time: flown.settling_2.map(settled),
        overshoot_percent: flown.overshoot.zip(course.goal, |most, step| 100.0 * f64::from(most) / step),
        disturbance_rms_deg: rms(flown.disturbed_squares, course.end - course.disturbance)
            .map(f64::to_degrees),
        hold_rms_deg: rms(flown.hold_squares, hold).map(f64::to_degrees),
        voltage_variation: f64::from(flown.variation) / (2.0 * f64::from(hold) * SAMPLE_TIME),
        saturation_time: f64::from(flown.saturated) * SAMPLE_TIME,
        scenes: [None; SCENES.len()],
        diverged: false,
        cut,
        failed: flown.left_envelope || flown.outside_5 || cut.is_some(),
    }
}

/// A flight's sums as a scene's score.
fn scene(flown: &Flown, course: &Course) -> SceneScore {
    if flown.diverged {
        return SceneScore::diverged();
    }
    let error = rms(flown.disturbed_squares, course.end - course.disturbance)
        .zip(course.unit, |rms, unit| rms / unit);
    SceneScore { error, failed: flown.left_envelope }
}

fn cut(flown: &Flown, course: &Course) -> Option<Cut> {
    flown.ended.map(|ended| Cut::of(course, ended))
}

fn rms(squares: PerAxis<f32>, ticks: u32) -> PerAxis<f64> {
    squares.map(|sum| (f64::from(sum) / f64::from(ticks)).sqrt())
}

#[cfg(test)]
mod cuts;
#[cfg(test)]
mod tests;
