//! Many plants of one controller, flown side by side and scored.

use super::Trial;
use super::cost::Score;
use super::plants::Draw;
use crate::parallel::{NEVER, Stop};
use std::hint::black_box;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{LaggedRotors, RealPlant, State, Thrust};
use twinrotor::real::{Mask, Real};
use twinrotor::reference::Reference;
use twinrotor::trajectory::ticks;
use twinrotor_sim::closed_loop::{ClosedLoop, Hardware, RigLoop};
use twinrotor_sim::lanes::{Kernel, gather_plants, gather_rotors, in_lanes};
use twinrotor_sim::metrics::{LastOutside, Overshoot};
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
    last_outside_2: PerAxis<LastOutside<R>>,
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

/// When what is judged, in ticks.
#[derive(Debug, Clone, Copy)]
struct Schedule {
    /// The first tick with the disturbance.
    disturbance: u32,
    /// The first tick after the flight.
    end: u32,
}

/// The scores of up to [`LANES`](twinrotor_sim::lanes::LANES) plants.
pub(super) fn scores(
    trial: &Trial,
    settings: &Settings<f32>,
    plants: &[Draw],
    stop: Stop<'_>,
) -> Option<Vec<Score>> {
    in_lanes(Flights { stop, ..Flights::new(trial, settings, plants) })
}

/// One controller on up to [`LANES`](twinrotor_sim::lanes::LANES) plants; the last one fills what lanes are
/// left.
#[derive(Clone, Copy)]
struct Flights<'a> {
    rig: &'a Rig,
    truth: &'a Rig,
    settings: &'a Settings<f32>,
    plants: &'a [Draw],
    /// \[rad\]
    step: PerAxis<f64>,
    when: Schedule,
    stop: Stop<'a>,
}

impl Kernel for Flights<'_> {
    type Output = Option<Vec<Score>>;
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) -> Option<Vec<Score>> {
        let sums = fly::<R>(&self)?;
        Some((0..self.plants.len()).map(|k| score(&sums, k, self.step, self.when)).collect())
    }
}

impl<'a> Flights<'a> {
    fn new(trial: &'a Trial, settings: &'a Settings<f32>, plants: &'a [Draw]) -> Self {
        let disturbance = ticks(trial.allowance, SAMPLE_TIME);
        let when = Schedule { disturbance, end: 2 * disturbance };
        let Trial { rig, truth, step, .. } = trial;
        Self { rig, truth, settings, plants, step: *step, when, stop: NEVER }
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
    let Flights { when, truth: Rig { envelope, .. }, .. } = *flights;
    let mut closed_loop = flights.closed_loop::<R>();
    let disturbance = flights.disturbance::<R>();
    let limit = flights.settings.volts_limit.map(R::splat);
    let goal = flights.step;
    let reference = Reference::at_rest(goal.cast::<R>());
    let band = |part: f64| goal.map(|g| R::from_f64(part * g.abs()));
    let band_5 = band(0.05);
    let zero = PerAxis::both(R::zero());
    let none = R::Mask::splat(false);
    let mut s = Sums {
        last_outside_2: band(0.02).map(LastOutside::new),
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
    for tick in 0..when.end {
        if tick % ASK_EVERY == 0 && (flights.stop)() {
            return None;
        }
        let disturbed = tick >= when.disturbance;
        let push = if disturbed { disturbance } else { PerMotor::zero() };
        // Hidden from the optimiser: it would compile the loop once for every combination of laws, estimators
        // and allocations.
        let happened = black_box(&mut closed_loop).tick(&reference, push);
        let error = happened.error();
        let square = error.map(|e| e * e);
        if disturbed {
            s.disturbed_squares = s.disturbed_squares.plus(square);
        } else {
            let now = R::from_f64(f64::from(tick));
            s.last_outside_2.pitch.add(now, error.pitch.abs());
            s.last_outside_2.yaw.add(now, error.yaw.abs());
            s.overshoot.pitch.add(error.pitch);
            s.overshoot.yaw.add(error.yaw);
            let outside = error.zip(band_5, |e, band| band.lt(e.abs()));
            s.outside_5 = outside.pitch | outside.yaw;
            if tick + HOLD >= when.disturbance {
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

fn score<R: Real<Scalar = f32>>(s: &Sums<R>, lane: usize, step: PerAxis<f64>, when: Schedule) -> Score {
    let allowance = f64::from(when.disturbance) * SAMPLE_TIME;
    if s.diverged.lane(lane) {
        return Score::diverged(allowance);
    }
    let of = |x: R| f64::from(x.lane(lane));
    let rms =
        |squares: PerAxis<R>, ticks: u32| squares.map(|x| (of(x) / f64::from(ticks)).sqrt().to_degrees());
    let settled = |last: LastOutside<R>| {
        let last = of(last.tick).max(0.0);
        if last >= f64::from(when.disturbance - 1) { allowance } else { last * SAMPLE_TIME }
    };
    let hold = HOLD.min(when.disturbance);
    Score {
        settling_time: s.last_outside_2.map(settled),
        overshoot_percent: s.overshoot.zip(step, |overshoot, step| 100.0 * of(overshoot.most) / step),
        disturbance_rms_deg: rms(s.disturbed_squares, when.end - when.disturbance),
        hold_rms_deg: rms(s.hold_squares, hold),
        voltage_variation: of(s.variation) / (2.0 * f64::from(hold) * SAMPLE_TIME),
        saturation_time: of(s.saturated) * SAMPLE_TIME,
        diverged: false,
        failed: s.left_envelope.lane(lane) || s.outside_5.lane(lane),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::CATALOGUE;
    use twinrotor::plant::presets;
    use twinrotor_sim::closed_loop::BoardLoop;
    use twinrotor_sim::lanes::{in_lanes_with, levels};

    /// Every lane against the board's own control loop on that plant, tick by tick.
    struct Compared<'a> {
        flights: Flights<'a>,
        boards: Vec<BoardLoop>,
        name: &'a str,
    }

    impl Kernel for Compared<'_> {
        type Output = ();
        #[inline(always)]
        fn run<R: Real<Scalar = f32>>(mut self) {
            let plants = self.flights.plants;
            let mut lanes = self.flights.closed_loop::<R>();
            let push = self.flights.disturbance::<R>();
            let goal = self.flights.step;
            for tick in 0..1500 {
                let disturbed = tick >= 1000;
                let group = if disturbed { push } else { PerMotor::zero() };
                let together = black_box(&mut lanes).tick(&Reference::at_rest(goal.cast()), group);
                for (k, board) in self.boards.iter_mut().enumerate() {
                    let alone_push = if disturbed { plants[k].disturbance.cast() } else { PerMotor::zero() };
                    let alone = board.tick(&Reference::at_rest(goal.cast()), alone_push);
                    let bits = |x: f32| x.to_bits();
                    assert_eq!(
                        (alone.state.angle.map(bits), alone.applied.map(bits)),
                        (
                            together.state.angle.map(|x| bits(x.lane(k))),
                            together.applied.map(|x| bits(x.lane(k)))
                        ),
                        "{}, plant {k}, tick {tick}",
                        self.name
                    );
                }
            }
        }
    }

    /// In every lane, with every instruction set, the drawn plant flies, bit for bit, as it does with the
    /// board's own control loop.
    #[test]
    fn a_lane_is_the_boards_flight() {
        for (name, rig) in
            [("integral", presets::PAPER), ("cancelling", presets::AERO_LAB), ("lqi", presets::AERO2)]
        {
            let design = CATALOGUE.iter().find(|(n, _)| *n == name).expect("it is there").1;
            let settings = Settings::new(&rig, design(&rig), SAMPLE_TIME).map(f32::from_f64);
            let trial = Trial::new(&rig, 3, 11, 0.75);
            let flights = Flights::new(&trial, &settings, &trial.plants);
            for level in levels() {
                let boards = trial
                    .plants
                    .iter()
                    .map(|d| {
                        let plant = RealPlant::new(&d.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
                        BoardLoop::new(plant, &Hardware::of(&rig, d.encoder_phase), &settings)
                    })
                    .collect();
                in_lanes_with(level, Compared { flights, boards, name });
            }
        }
    }
}
