//! Sixteen plants of one controller, flown side by side and scored.

use super::cost::Score;
use super::plants::Draw;
use crate::closed_loop::{ClosedLoop, Hardware, RigLoop};
use crate::lanes::{Group, LANES, gather_plants, gather_rotors};
use crate::scenario::SAMPLE_TIME;
use multiversion::multiversion;
use std::hint::black_box;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::lanes::LaneMask;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{Envelope, Rig};
use twinrotor::plant::{LaggedRotors, RealPlant, State, Thrust};
use twinrotor::real::{Mask, Real};
use twinrotor::reference::Reference;

/// The step, from rest at zero with the rotors at rest: 15 degrees of pitch, 40 of yaw.
pub const STEP_DEG: PerAxis<f64> = PerAxis::new(15.0, 40.0);
/// \[rad\] An error beyond which a flight has diverged: a turn.
const DIVERGED: f64 = core::f64::consts::TAU;
/// \[ticks\] The second before the disturbance, in which holding is judged.
const HOLD: u32 = 1000;

/// The sums of a flight in every lane.
#[derive(Debug, Clone, Copy)]
struct Sums {
    last_outside_2: PerAxis<Group>,
    overshoot: PerAxis<Group>,
    hold_squares: PerAxis<Group>,
    disturbed_squares: PerAxis<Group>,
    variation: Group,
    saturated: Group,
    outside_5: LaneMask<LANES>,
    left_envelope: LaneMask<LANES>,
    diverged: LaneMask<LANES>,
    volts: PerMotor<Group>,
}

/// When what is judged, in ticks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Schedule {
    /// The first tick with the disturbance.
    pub disturbance: u32,
    /// The first tick after the flight.
    pub end: u32,
}

/// The scores of up to [`LANES`] plants.
pub(super) fn scores(rig: &Rig, settings: &Settings<f32>, plants: &[Draw], when: Schedule) -> Vec<Score> {
    let closed_loop = side_by_side(rig, settings, plants);
    let disturbance = each_motor(plants, |d| d.disturbance);
    let limit = settings.volts_limit.map(Group::splat);
    let sums = fly(closed_loop, disturbance, &rig.envelope, limit, when);
    (0..plants.len()).map(|k| score(&sums, k, when)).collect()
}

/// One controller on up to [`LANES`] plants; the last one fills what lanes are left.
fn side_by_side(rig: &Rig, settings: &Settings<f32>, plants: &[Draw]) -> RigLoop<Group> {
    let constants: Vec<_> = plants.iter().map(|d| d.plant.map(f32::from_f64)).collect();
    let rotors: Vec<_> = plants.iter().map(|d| LaggedRotors::<f32>::new(&d.plant, SAMPLE_TIME)).collect();
    let plant = RealPlant::assemble(
        gather_plants(&constants),
        gather_rotors(&rotors),
        State::at_rest(PerAxis::zero()),
        SAMPLE_TIME,
    );
    let phase = PerAxis {
        pitch: each(plants, |d| d.encoder_phase.pitch),
        yaw: each(plants, |d| d.encoder_phase.yaw),
    };
    let hardware = Hardware::of(rig, PerAxis::both(0.5));
    RigLoop::assemble(plant, &hardware, phase, &settings.map(Group::splat))
}

fn each(plants: &[Draw], of: impl Fn(&Draw) -> f64) -> Group {
    Group::from_fn(|lane| f32::from_f64(of(&plants[lane.min(plants.len() - 1)])))
}

fn each_motor(plants: &[Draw], of: impl Fn(&Draw) -> PerMotor<f64>) -> PerMotor<Group> {
    PerMotor { main: each(plants, |d| of(d).main), tail: each(plants, |d| of(d).tail) }
}

/// Flies to the end.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn fly(
    mut closed_loop: RigLoop<Group>,
    disturbance: PerMotor<Group>,
    envelope: &Envelope,
    limit: PerMotor<Group>,
    when: Schedule,
) -> Sums {
    let goal = STEP_DEG.map(f64::to_radians);
    let reference = Reference::at_rest(goal.cast::<Group>());
    let band = |part: f64| goal.map(|g| Group::from_f64(part * g.abs()));
    let (band_2, band_5) = (band(0.02), band(0.05));
    let zero = PerAxis::both(Group::zero());
    let none = LaneMask::splat(false);
    let mut s = Sums {
        last_outside_2: zero,
        overshoot: zero,
        hold_squares: zero,
        disturbed_squares: zero,
        variation: Group::zero(),
        saturated: Group::zero(),
        outside_5: none,
        left_envelope: none,
        diverged: none,
        volts: PerMotor::zero(),
    };
    for tick in 0..when.end {
        let disturbed = tick >= when.disturbance;
        let push = if disturbed { disturbance } else { PerMotor::zero() };
        // Hidden from the optimiser: it would compile the loop once for every combination of laws, estimators and allocations.
        let happened = black_box(&mut closed_loop).tick(&reference, push);
        let error = happened.error();
        let square = error.map(|e| e * e);
        if disturbed {
            s.disturbed_squares = s.disturbed_squares.plus(square);
        } else {
            let now = Group::from_f64(f64::from(tick));
            let outside = error.zip(band_2, |e, band| band.lt(e.abs()));
            s.last_outside_2 =
                s.last_outside_2.zip(outside, |last, outside| Group::select(outside, now, last));
            // Both steps are upwards: beyond the goal the error is negative.
            s.overshoot = s.overshoot.zip(error, |most, e| most.max(-e));
            let outside = error.zip(band_5, |e, band| band.lt(e.abs()));
            s.outside_5 = outside.pitch | outside.yaw;
            if tick + HOLD >= when.disturbance {
                s.hold_squares = s.hold_squares.plus(square);
                let change = happened.applied.zip(s.volts, |v, before| (v - before).abs());
                s.variation = s.variation + (change.main + change.tail);
            }
        }
        s.volts = happened.applied;
        let over = happened.command.allocation.saturated(limit);
        s.saturated = s.saturated + Group::select(over.main | over.tail, Group::one(), Group::zero());
        let state = &happened.state;
        let far = |e: Group| !e.abs().lt(Group::from_f64(DIVERGED));
        s.diverged = s.diverged | far(error.pitch) | far(error.yaw);
        let beyond = |x: Group, most: f64| Group::from_f64(most).lt(x.abs());
        s.left_envelope = s.left_envelope
            | beyond(state.angle.pitch, envelope.pitch)
            | beyond(state.rate.pitch, envelope.rate.pitch)
            | beyond(state.rate.yaw, envelope.rate.yaw);
    }
    s
}

fn score(s: &Sums, lane: usize, when: Schedule) -> Score {
    let allowance = f64::from(when.disturbance) * SAMPLE_TIME;
    if s.diverged.lane(lane) {
        return Score::diverged(allowance);
    }
    let of = |x: Group| f64::from(x.lane(lane));
    let rms =
        |squares: PerAxis<Group>, ticks: u32| squares.map(|x| (of(x) / f64::from(ticks)).sqrt().to_degrees());
    let settled = |last: Group| {
        let last = of(last);
        if last >= f64::from(when.disturbance - 1) { allowance } else { last * SAMPLE_TIME }
    };
    let hold = HOLD.min(when.disturbance);
    Score {
        settling_time: s.last_outside_2.map(settled),
        overshoot_percent: s.overshoot.zip(STEP_DEG, |most, step| 100.0 * of(most).to_degrees() / step),
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
    use super::super::{CATALOGUE, draw};
    use super::*;
    use crate::closed_loop::BoardLoop;
    use twinrotor::plant::presets;

    /// In every lane the drawn plant flies, bit for bit, as it does with the board's own control loop.
    #[test]
    fn a_lane_is_the_boards_flight() {
        for (name, rig) in
            [("integral", presets::PAPER), ("cancelling", presets::AERO_LAB), ("lqi", presets::AERO2)]
        {
            let design = CATALOGUE.iter().find(|(n, _)| *n == name).expect("it is there").1;
            let settings = Settings::new(&rig, design(&rig), SAMPLE_TIME).map(f32::from_f64);
            let plants = draw(&rig, 3, 11);
            let mut lanes = side_by_side(&rig, &settings, &plants);
            let push = each_motor(&plants, |d| d.disturbance);
            let mut boards: Vec<BoardLoop> = plants
                .iter()
                .map(|d| {
                    let plant = RealPlant::new(&d.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
                    BoardLoop::new(plant, &Hardware::of(&rig, d.encoder_phase), &settings)
                })
                .collect();
            let goal = STEP_DEG.map(f64::to_radians);
            for tick in 0..1500 {
                let disturbed = tick >= 1000;
                let group = if disturbed { push } else { PerMotor::zero() };
                let together = lanes.tick(&Reference::at_rest(goal.cast()), group);
                for (k, board) in boards.iter_mut().enumerate() {
                    let alone_push = if disturbed { plants[k].disturbance.cast() } else { PerMotor::zero() };
                    let alone = board.tick(&Reference::at_rest(goal.cast()), alone_push);
                    let bits = |x: f32| x.to_bits();
                    assert_eq!(
                        alone.state.angle.map(bits),
                        together.state.angle.map(|x| bits(x.lane(k))),
                        "{name}, plant {k}, tick {tick}"
                    );
                    assert_eq!(
                        alone.applied.map(bits),
                        together.applied.map(|x| bits(x.lane(k))),
                        "{name}, plant {k}, tick {tick}"
                    );
                }
            }
        }
    }
}
