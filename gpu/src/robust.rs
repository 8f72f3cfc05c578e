//! One flight of the robust objective, as one thread flies it: numbers out of memory, the closed loop of
//! `twinrotor-sim`, sums into memory.

#[cfg(doc)]
use crate::told::CHANGE;
use crate::told::{Changes, Common};
use crate::words;
use core::borrow::BorrowMut;
use serde::Deserialize;
use twinrotor::SAMPLE_TIME;
use twinrotor::allocation::AllocationSettings;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::controller::ControllerSettings;
use twinrotor::estimator::EstimatorSettings;
use twinrotor::law::LawSettings;
use twinrotor::monitor::Motion;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::PAPER;
use twinrotor::plant::{LaggedRotors, PlantParameters, RealPlant, State, Thrust as _};
use twinrotor::supervisor::Condition;
use twinrotor_sim::closed_loop::{RigLoop, Tick};
use twinrotor_sim::guard::Guard;
use twinrotor_sim::judged::{Ended, Flown, fly};
use twinrotor_sim::metrics::Settling;

/// What a launch reads.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a> {
    /// A [`Common`] in [words].
    pub common: &'a [u32],
    /// Controllers' settings in [words], each in `each` of them; before those of an integral their bound.
    pub settings: &'a [u32],
    /// Words that each controller has.
    pub each: u32,
    /// Plants' numbers, plant by plant, each in the order in which they are read.
    pub plants: &'a [u32],
    /// How many plants there are.
    pub count: u32,
    /// The course by its changes, [`CHANGE`] words each, in the order of their ticks, the first in tick 0.
    pub course: &'a [u32],
}

/// The same controller, of the kinds that every preset's default has, as far as the compiler knows: it leaves
/// out what else there could be. `None` for one of other kinds.
#[inline(always)]
pub fn usual(settings: Settings<f32>) -> Option<Settings<f32>> {
    let ControllerSettings { law, estimator, filter, allocation, lead, cancellation } = settings.controller;
    let LawSettings::IntegralBackstepping(gains) = law else { return None };
    let gains = LawSettings::IntegralBackstepping(gains);
    let estimator = match estimator {
        EstimatorSettings::Luenberger { bandwidth } => EstimatorSettings::Luenberger { bandwidth },
        EstimatorSettings::ExtendedState { bandwidth } => EstimatorSettings::ExtendedState { bandwidth },
        _ => return None,
    };
    let AllocationSettings::Weighted { pitch_weight } = allocation else { return None };
    let controller = ControllerSettings {
        law: gains,
        estimator,
        filter: Some(filter?),
        allocation: AllocationSettings::Weighted { pitch_weight },
        lead,
        cancellation,
    };
    Some(Settings { controller, ..settings })
}

/// What a flight begins with.
struct Start<'a> {
    settings: Settings<f32>,
    plant: RealPlant<f32>,
    disturbance: PerMotor<f32>,
    phase: PerAxis<f32>,
    common: Common,
    course: Changes<'a>,
}

impl<'a> Given<'a> {
    /// That of the flight of this number: controller by controller, each on every plant. `None` where the
    /// words do not say what they should.
    #[inline(always)]
    fn start(&self, number: u32) -> Option<Start<'a>> {
        let common: Common = words::read(self.common).ok()?;
        let settings = common.belief.within(self.controller(number)?)?;
        let (plant, disturbance, phase) = self.plant(number, State::at_rest(PerAxis::zero()));
        let course = Changes::new(self.course);
        Some(Start { settings, plant, disturbance, phase, common, course })
    }

    /// What the flight of this number has of a controller.
    #[inline(always)]
    pub(crate) fn controller<T: Deserialize<'a>>(&self, number: u32) -> Option<T> {
        let begin = (number / self.count.max(1)) as usize * self.each as usize;
        words::read(self.settings.get(begin..begin + self.each as usize)?).ok()
    }

    /// Its plant at `state`, the disturbance of it \[V\], and where between two counts its encoders are.
    #[inline(always)]
    pub(crate) fn plant(
        &self,
        number: u32,
        state: State<f32>,
    ) -> (RealPlant<f32>, PerMotor<f32>, PerAxis<f32>) {
        let count = self.count.max(1);
        let mut k = (number % count) as usize * (self.plants.len() / count as usize);
        let mut next = || {
            let word = self.plants.get(k).copied().unwrap_or(0);
            k += 1;
            f32::from_bits(word)
        };
        // What these presets say is not read: they are the structures that the numbers fill.
        let constants: PlantParameters<f32> = PAPER.plant.map(|_| next());
        let rotors = LaggedRotors::<f32>::new(&PAPER.plant, SAMPLE_TIME).map(|_| next());
        let disturbance = PerMotor::new(next(), next());
        let phase = PerAxis::new(next(), next());
        (RealPlant::assemble(constants, rotors, state, SAMPLE_TIME), disturbance, phase)
    }
}

/// Flies the flight of this number. `narrow` gives the controller back, of fewer kinds than there are. `None`
/// where it does not, or the words do not say what they should.
#[inline(always)]
pub fn flight<M: BorrowMut<Motion<f32>>>(
    given: &Given<'_>,
    number: u32,
    narrow: impl Fn(Settings<f32>) -> Option<Settings<f32>>,
    keep: impl FnOnce(Motion<f32>) -> M,
) -> Option<Flown> {
    let Start { settings, plant, disturbance, phase, common, course } = given.start(number)?;
    let settings = narrow(settings)?;
    let closed_loop = RigLoop::assemble(plant, &common.instruments, phase, &settings);
    let guard = Guard::new(&settings, &common.instruments).keeping(keep);
    let limit = settings.volts_limit;
    let sums = fly(
        closed_loop,
        guard,
        limit,
        disturbance,
        &common.bounds,
        course,
        #[inline(always)]
        |_, _| true,
    )?;
    Some(sums.lane(0))
}

/// Words of a [`trace`].
pub const TRACE: usize = 2;

/// Flies the flight of this number, for a hash of the state and the volts in effect in each of its ticks
/// (64-bit FNV-1a, word by word), lower half first.
#[inline(always)]
pub fn trace(given: &Given<'_>, number: u32) -> Option<[u32; TRACE]> {
    let Start { settings, plant, disturbance, phase, common, course } = given.start(number)?;
    let closed_loop = RigLoop::assemble(plant, &common.instruments, phase, &settings);
    let guard = Guard::new(&settings, &common.instruments);
    let limit = settings.volts_limit;
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    fly(
        closed_loop,
        guard,
        limit,
        disturbance,
        &common.bounds,
        course,
        #[inline(always)]
        |_, tick: &Tick<f32>| {
            let State { angle, rate } = tick.state;
            let volts = tick.applied;
            for number in [angle.pitch, angle.yaw, rate.pitch, rate.yaw, volts.main, volts.tail] {
                // What a NaN holds besides is not the same everywhere.
                let bits = if number.is_nan() { f32::NAN.to_bits() } else { number.to_bits() };
                hash = (hash ^ u64::from(bits)).wrapping_mul(0x100_0000_01b3);
            }
            true
        },
    )?;
    let [a, b, c, d, e, f, g, h] = hash.to_le_bytes();
    Some([u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])])
}

/// Words of where the board ends a flight: the tick and the condition's number, or [`u32::MAX`] twice.
const CUT: usize = 2;

#[inline(always)]
fn ended_words(ended: Option<Ended>) -> [u32; CUT] {
    ended.map_or([u32::MAX; CUT], |ended| [ended.tick, ended.condition as u32])
}

fn ended([tick, condition]: [u32; CUT]) -> Option<Ended> {
    let condition = *Condition::ALL.get(condition as usize)?;
    Some(Ended { tick, condition })
}

/// Words of a [`Flown`].
pub const FLOWN: usize = 21;

/// A flight's sums in words.
#[inline(always)]
pub fn to_words(flown: &Flown) -> [u32; FLOWN] {
    let flags =
        u32::from(flown.outside_5) | u32::from(flown.left_envelope) << 1 | u32::from(flown.diverged) << 2;
    let [tick, condition] = ended_words(flown.ended);
    let [pitch, yaw] = [flown.settling_2.pitch, flown.settling_2.yaw].map(|s| s.numbers().map(f32::to_bits));
    let [[p0, p1, p2, p3, p4], [y0, y1, y2, y3, y4]] = [pitch, yaw];
    [
        p0,
        p1,
        p2,
        p3,
        p4,
        y0,
        y1,
        y2,
        y3,
        y4,
        flown.overshoot.pitch.to_bits(),
        flown.overshoot.yaw.to_bits(),
        flown.hold_squares.pitch.to_bits(),
        flown.hold_squares.yaw.to_bits(),
        flown.disturbed_squares.pitch.to_bits(),
        flown.disturbed_squares.yaw.to_bits(),
        flown.variation.to_bits(),
        flown.saturated.to_bits(),
        flags,
        tick,
        condition,
    ]
}

/// The other way round.
pub fn from_words(words: [u32; FLOWN]) -> Flown {
    let number = |k: usize| words.get(k).map_or(0.0, |word| f32::from_bits(*word));
    let pair = |k: usize| PerAxis::new(number(k), number(k + 1));
    let [.., flags, tick, condition] = words;
    let settling = |k: usize| Settling::of_numbers([0, 1, 2, 3, 4].map(|i| number(k + i)));
    Flown {
        settling_2: PerAxis::new(settling(0), settling(5)),
        overshoot: pair(10),
        hold_squares: pair(12),
        disturbed_squares: pair(14),
        variation: number(16),
        saturated: number(17),
        outside_5: flags & 1 != 0,
        left_envelope: flags & 2 != 0,
        diverged: flags & 4 != 0,
        ended: ended([tick, condition]),
    }
}
