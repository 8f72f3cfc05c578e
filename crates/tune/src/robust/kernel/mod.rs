//! Many plants of one controller, flown side by side and scored.

use super::Trial;
use super::cost::Score;
use super::plants::Draw;
use super::scenes::{Course, HOT, SCENES, SceneScore};
use crate::parallel::{NEVER, Stop};
use std::hint::black_box;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{LaggedRotors, RealPlant, State, Thrust};
use twinrotor::real::{Mask, Real};
use twinrotor::reference::Reference;
use twinrotor_sim::closed_loop::{ClosedLoop, Hardware, RigLoop};
use twinrotor_sim::lanes::{Kernel, gather_plants, gather_rotors, in_lanes};
use twinrotor_sim::metrics::{Overshoot, Settling};
use twinrotor_sim::scenario::SAMPLE_TIME;

/// \[rad\] An error beyond which a flight has diverged: a turn.
const DIVERGED: f64 = core::f64::consts::TAU;
/// \[ticks\] The second before the disturbance, in which holding is judged.
const HOLD: u32 = 1000;
/// \[ticks\] From one question whether to stop to the next: milliseconds.
const ASK_EVERY: u32 = 4096;

/// The sums of a flight in every lane.
#[derive(Debug, Clone, Copy)]
struct Sums<R: Real> {
    settling_2: PerAxis<Settling<R>>,
    overshoot: PerAxis<Overshoot<R>>,
    hold_squares: PerAxis<R>,
    disturbed_squares: PerAxis<R>,
    variation: R,
    saturated: R,
    outside_5: R::Mask,
    left_envelope: R::Mask,
    diverged: R::Mask,
    volts: PerMotor<R>,
}

/// One lane of them.
struct Lane {
    /// \[ticks\] None where the error was still outside when the disturbance came.
    settling_2: PerAxis<Option<f64>>,
    overshoot: PerAxis<f64>,
    hold_squares: PerAxis<f64>,
    disturbed_squares: PerAxis<f64>,
    variation: f64,
    saturated: f64,
    outside_5: bool,
    left_envelope: bool,
    diverged: bool,
}

impl<R: Real> Sums<R> {
    /// A lane, with the disturbance at `disturbance` \[ticks\].
    fn lane(&self, lane: usize, disturbance: u32) -> Lane {
        let of = |x: R| -> f64 { x.lane(lane).into() };
        Lane {
            settling_2: self.settling_2.map(|settling| settling.time(lane, disturbance.saturating_sub(1))),
            overshoot: self.overshoot.map(|overshoot| of(overshoot.most)),
            hold_squares: self.hold_squares.map(of),
            disturbed_squares: self.disturbed_squares.map(of),
            variation: of(self.variation),
            saturated: of(self.saturated),
            outside_5: self.outside_5.lane(lane),
            left_envelope: self.left_envelope.lane(lane),
            diverged: self.diverged.lane(lane),
        }
    }
}

/// The scores of up to [`LANES`](twinrotor_sim::lanes::LANES) plants.
pub(super) fn scores(
    trial: &Trial,
    courses: &[Course],
    settings: &Settings<f32>,
    plants: &[Draw],
    stop: Stop<'_>,
) -> Option<Vec<Score>> {
    let (step, scenes) = courses.split_first().expect("the step is flown first");
    let fly = |course| in_lanes(Flights { stop, ..Flights::new(trial, course, settings, plants) });
    let mut scores: Vec<Score> = fly(step)?.iter().map(|lane| lane.score(step)).collect();
    for (k, course) in scenes.iter().enumerate() {
        for (score, lane) in scores.iter_mut().zip(fly(course)?) {
            let scene = lane.scene(course);
            score.failed |= scene.failed;
            score.scenes[k] = Some(scene);
        }
    }
    Some(scores)
}

/// One controller on up to [`LANES`](twinrotor_sim::lanes::LANES) plants; the last one fills what lanes are
/// left.
#[derive(Clone, Copy)]
struct Flights<'a> {
    rig: &'a Rig,
    truth: &'a Rig,
    settings: &'a Settings<f32>,
    plants: &'a [Draw],
    course: &'a Course,
    stop: Stop<'a>,
}

impl Kernel for Flights<'_> {
    type Output = Option<Vec<Lane>>;
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) -> Option<Vec<Lane>> {
        let sums = fly::<R>(&self)?;
        Some((0..self.plants.len()).map(|k| sums.lane(k, self.course.disturbance)).collect())
    }
}

impl<'a> Flights<'a> {
    fn new(trial: &'a Trial, course: &'a Course, settings: &'a Settings<f32>, plants: &'a [Draw]) -> Self {
        let Trial { rig, truth, .. } = trial;
        Self { rig, truth, settings, plants, course, stop: NEVER }
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
        let sound = Hardware::of(self.truth, PerAxis::both(0.5));
        let hardware = sound.taken_for(self.rig, self.truth);
        RigLoop::assemble(plant, &hardware, phase, &self.settings.map(R::splat))
    }

    fn disturbance<R: Real<Scalar = f32>>(&self) -> PerMotor<R> {
        PerMotor { main: self.each(|d| d.disturbance.main), tail: self.each(|d| d.disturbance.tail) }
    }

    fn each<R: Real<Scalar = f32>>(&self, of: impl Fn(&Draw) -> f64) -> R {
        R::from_fn(|lane| f32::from_f64(of(&self.plants[lane.min(self.plants.len() - 1)])))
    }
}

/// Flies to the end, unless nobody waits for it.
#[inline(always)]
fn fly<R: Real<Scalar = f32>>(flights: &Flights<'_>) -> Option<Sums<R>> {
    let Flights { course, truth: Rig { envelope, .. }, .. } = *flights;
    let mut closed_loop = flights.closed_loop::<R>();
    let disturbance = flights.disturbance::<R>();
    let limit = flights.settings.volts_limit.map(R::splat);
    let goal = course.goal;
    let mut reference = Reference::at_rest(goal.cast::<R>());
    let band = |part: f64| goal.map(|g| R::from_f64(part * g.abs()));
    let band_5 = band(0.05);
    let zero = PerAxis::both(R::zero());
    let none = R::Mask::splat(false);
    let mut s = Sums {
        settling_2: band(0.02).map(Settling::new),
        overshoot: goal.map(Overshoot::new),
        hold_squares: zero,
        disturbed_squares: zero,
        variation: R::zero(),
        saturated: R::zero(),
        outside_5: none,
        left_envelope: none,
        diverged: none,
        volts: PerMotor::zero(),
    };
    for tick in 0..course.end {
        if tick % ASK_EVERY == 0 && (flights.stop)() {
            return None;
        }
        if let Some(asked) = course.asked(tick) {
            reference = Reference::splat(&asked);
        }
        let push = match course.push(tick) {
            Some(part) => disturbance.scaled(R::splat(part)),
            None => PerMotor::zero(),
        };
        if course.hot && tick == 1 {
            closed_loop.warm(R::from_f64(HOT));
        }
        let disturbed = tick >= course.disturbance;
        // Hidden from the optimiser: it would compile the loop once for every combination of laws, estimators
        // and allocations.
        let happened = black_box(&mut closed_loop).tick(&reference, push);
        let error = happened.error();
        let square = error.map(|e| e * e);
        if disturbed {
            s.disturbed_squares = s.disturbed_squares.plus(square);
        } else {
            let now = R::from_f64(f64::from(tick));
            s.settling_2.pitch.add(now, error.pitch.abs());
            s.settling_2.yaw.add(now, error.yaw.abs());
            s.overshoot.pitch.add(error.pitch);
            s.overshoot.yaw.add(error.yaw);
            let outside = error.zip(band_5, |e, band| band.lt(e.abs()));
            s.outside_5 = outside.pitch | outside.yaw;
            if tick + HOLD >= course.disturbance {
                s.hold_squares = s.hold_squares.plus(square);
                let change = happened.applied.zip(s.volts, |v, before| (v - before).abs());
                s.variation = s.variation + (change.main + change.tail);
            }
        }
        s.volts = happened.applied;
        let over = happened.decision.allocation.saturated(limit);
        s.saturated = s.saturated + R::select(over.main | over.tail, R::one(), R::zero());
        let state = &happened.state;
        let far = |e: R| !e.abs().lt(R::from_f64(DIVERGED));
        s.diverged = s.diverged | far(error.pitch) | far(error.yaw);
        let beyond = |x: R, most: f64| R::from_f64(most).lt(x.abs());
        s.left_envelope = s.left_envelope
            | beyond(state.angle.pitch, envelope.pitch)
            | beyond(state.rate.pitch, envelope.rate.pitch)
            | beyond(state.rate.yaw, envelope.rate.yaw);
    }
    Some(s)
}

impl Lane {
    fn score(&self, course: &Course) -> Score {
        let allowance = f64::from(course.disturbance) * SAMPLE_TIME;
        if self.diverged {
            return Score::diverged(allowance);
        }
        let settled = |ticks: Option<f64>| ticks.map_or(allowance, |ticks| ticks * SAMPLE_TIME);
        let hold = HOLD.min(course.disturbance);
        Score {
            settling_time: self.settling_2.map(settled),
            overshoot_percent: self.overshoot.zip(course.goal, |most, step| 100.0 * most / step),
            disturbance_rms_deg: rms(self.disturbed_squares, course.end - course.disturbance)
                .map(f64::to_degrees),
            hold_rms_deg: rms(self.hold_squares, hold).map(f64::to_degrees),
            voltage_variation: self.variation / (2.0 * f64::from(hold) * SAMPLE_TIME),
            saturation_time: self.saturated * SAMPLE_TIME,
            scenes: [None; SCENES.len()],
            diverged: false,
            cut: None,
            failed: self.left_envelope || self.outside_5,
        }
    }

    fn scene(&self, course: &Course) -> SceneScore {
        if self.diverged {
            return SceneScore::diverged();
        }
        let error = rms(self.disturbed_squares, course.end - course.disturbance)
            .zip(course.unit, |rms, unit| rms / unit);
        SceneScore { error, failed: self.left_envelope }
    }
}

fn rms(squares: PerAxis<f64>, ticks: u32) -> PerAxis<f64> {
    squares.map(|sum| (sum / f64::from(ticks)).sqrt())
}

#[cfg(test)]
mod tests;
