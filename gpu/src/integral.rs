//! One flight of which the integral of the error counts, as one thread flies it.

use crate::robust::Given;
use crate::words;
use serde::{Deserialize, Serialize};
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{Hardware, Wear};
use twinrotor::compensated::Compensated;
use twinrotor::controller::ControllerSettings;
use twinrotor::law::LawSettings;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{PAPER, Rig};
use twinrotor::plant::{PlantParameters, State};
use twinrotor::reference::Reference;
use twinrotor_sim::closed_loop::{ClosedLoop, IdealLoop, RigLoop};
use twinrotor_sim::integrated::{has_lost, integrate, is_look};
use twinrotor_sim::metrics::{Criterion, Integral};

/// What all flights of a launch have in common.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Common {
    /// Which integral.
    pub criterion: Criterion,
    /// How many ticks.
    pub ticks: u32,
    /// What is flown.
    pub plant: PlantParameters<f64>,
    /// \[V\] Where its thrust's slope is taken, for the paper's world.
    pub nominal_volts: f64,
    /// \[rad\] Where from.
    pub angle: PerAxis<f64>,
    /// \[rad/s\] How fast then.
    pub rate: PerAxis<f64>,
    /// \[V\] In effect at the rotors then.
    pub rotors: PerMotor<f64>,
    /// Counts a revolution.
    pub encoder_counts: PerAxis<u32>,
    /// Compare steps between zero and full voltage.
    pub pwm_steps: u32,
    /// \[V\] Supply of the amplifiers.
    pub supply: f64,
}

/// Words of a flight: of both axes the sum and its excess; the first tick with a look in which it had lost,
/// and the last one in which it had not, [`u32::MAX`] for none.
pub const INTEGRATED: usize = 6;
/// Words of an instant of the course: the tick; angle, rate and acceleration asked for, pitch and yaw each;
/// the volts, main and tail.
pub const INSTANT: usize = 9;

/// Flies in the paper's world.
#[inline(always)]
pub fn ideal(given: &Given<'_>, number: u32) -> Option<[u32; INTEGRATED]> {
    let (common, settings, bound) = read(given, number)?;
    let rig = Rig { plant: common.plant, nominal_volts: common.nominal_volts, ..PAPER };
    let start = State { angle: common.angle.cast(), rate: common.rate.cast() };
    Some(fly(given, &common, bound, IdealLoop::new(&rig, &settings, start, SAMPLE_TIME)))
}

/// Flies in the rig's.
#[inline(always)]
pub fn rig(given: &Given<'_>, number: u32) -> Option<[u32; INTEGRATED]> {
    let (common, settings, bound) = read(given, number)?;
    let start = State { angle: common.angle.cast(), rate: common.rate.cast() };
    let (mut plant, ..) = given.plant(number, start);
    plant.set_rotors(common.rotors.cast());
    let hardware = Hardware {
        encoder_counts: common.encoder_counts,
        encoder_phase: PerAxis::both(0.5),
        pwm_steps: common.pwm_steps,
        supply: common.supply,
        believed_counts: common.encoder_counts,
        wear: Wear::default(),
    };
    Some(fly(given, &common, bound, RigLoop::new(plant, &hardware, &settings)))
}

/// The controller with nothing but the paper's law, as far as the compiler knows.
#[inline(always)]
fn read(given: &Given<'_>, number: u32) -> Option<(Common, Settings<f32>, f64)> {
    let common: Common = words::read(given.common).ok()?;
    let (bound, settings): (f64, Settings<f32>) = given.controller(number)?;
    let LawSettings::Backstepping(gains) = settings.controller.law else { return None };
    let settings = Settings { controller: ControllerSettings::paper(gains), ..settings };
    Some((common, settings, bound))
}

#[inline(always)]
fn fly<L: ClosedLoop<f32>>(
    given: &Given<'_>,
    common: &Common,
    bound: f64,
    closed_loop: L,
) -> [u32; INTEGRATED] {
    let word = |k: usize| given.course.get(k).copied().unwrap_or(u32::MAX);
    let number = |k: usize| f32::from_bits(word(k));
    let (mut next, mut at) = (0, word(0));
    let (mut reference, mut volts) = (Reference::default(), PerMotor::zero());
    let (mut first_lost, mut last_in_play) = (u32::MAX, u32::MAX);
    let (integral, _) = integrate(
        closed_loop,
        common.criterion,
        common.ticks,
        #[inline(always)]
        |tick, _: &mut L| {
            if tick == at {
                let pair = |k: usize| PerAxis::new(number(next + k), number(next + k + 1));
                reference = Reference { angle: pair(1), rate: pair(3), accel: pair(5) };
                volts = PerMotor::new(number(next + 7), number(next + 8));
                next += INSTANT;
                at = word(next);
            }
            (reference, volts)
        },
        #[inline(always)]
        |tick, integral| {
            if is_look(tick) {
                if !has_lost(integral, 0, bound) {
                    last_in_play = tick;
                } else if first_lost == u32::MAX {
                    first_lost = tick;
                }
            }
            true
        },
    );
    let PerAxis { pitch, yaw } = integral.sums().map(|s| [s.value().to_bits(), s.excess().to_bits()]);
    [pitch[0], pitch[1], yaw[0], yaw[1], first_lost, last_in_play]
}

/// What the words of a flight say: its integral, the first tick in which it had lost, the last in which it
/// had not.
pub fn from_words(
    criterion: Criterion,
    words: [u32; INTEGRATED],
) -> (Integral<f32>, Option<u32>, Option<u32>) {
    let [a, b, c, d, first, last] = words;
    let sum = |value: u32, excess: u32| Compensated::again(f32::from_bits(value), f32::from_bits(excess));
    let integral = Integral::new(criterion).with(PerAxis::new(sum(a, b), sum(c, d)));
    let tick = |tick: u32| (tick != u32::MAX).then_some(tick);
    (integral, tick(first), tick(last))
}
