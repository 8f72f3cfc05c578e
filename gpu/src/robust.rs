//! One flight of the robust objective, as one thread flies it: numbers out of memory, the closed loop of
//! `twinrotor-sim`, sums into memory.

use crate::words;
use serde::{Deserialize, Serialize};
use twinrotor::SAMPLE_TIME;
use twinrotor::allocation::AllocationSettings;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{Hardware, Wear};
use twinrotor::controller::ControllerSettings;
use twinrotor::estimator::EstimatorSettings;
use twinrotor::law::LawSettings;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{Envelope, PAPER};
use twinrotor::plant::{LaggedRotors, PlantParameters, RealPlant, State, Thrust as _};
use twinrotor::reference::Reference;
use twinrotor_sim::closed_loop::RigLoop;
use twinrotor_sim::judged::{Course, Flown, Rules, fly};

/// What all flights of a launch have in common.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Common {
    /// \[rad\] Where to.
    pub goal: PerAxis<f64>,
    /// Where the rig may be.
    pub envelope: Envelope,
    /// \[ticks\] From here on errors are summed as those after a disturbance.
    pub disturbance: u32,
    /// The first tick after the flight.
    pub end: u32,
    /// With hot motors from the second tick on.
    pub hot: bool,
    /// Counts a revolution, as they are and as the controller has them.
    pub encoder_counts: PerAxis<u32>,
    /// The same, as the controller has them.
    pub believed_counts: PerAxis<u32>,
    /// Compare steps between zero and full voltage.
    pub pwm_steps: u32,
    /// \[V\] Supply of the amplifiers.
    pub supply: f64,
}

impl Common {
    #[inline(always)]
    fn rules(&self) -> Rules {
        let Self { goal, envelope, disturbance, end, hot, .. } = *self;
        Rules { goal, envelope, disturbance, end, hot }
    }

    /// Nothing of it is worn.
    #[inline(always)]
    fn hardware(&self) -> Hardware {
        Hardware {
            encoder_counts: self.encoder_counts,
            encoder_phase: PerAxis::both(0.5),
            pwm_steps: self.pwm_steps,
            supply: self.supply,
            believed_counts: self.believed_counts,
            wear: Wear::default(),
        }
    }
}

/// What a launch reads.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a> {
    /// A [`Common`] in [words].
    pub common: &'a [u32],
    /// Controllers' settings in [words], each in `each` of them.
    pub settings: &'a [u32],
    /// Words that each controller has.
    pub each: u32,
    /// Plants' numbers ([`plant_numbers`]): number k of plant p at k x `count` + p, so that neighbours read
    /// side by side.
    pub plants: &'a [u32],
    /// How many plants there are.
    pub count: u32,
    /// The course, in [changes](Changes).
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

/// The flight of this number: controller by controller, each on every plant. `narrow` gives the controller
/// back, of fewer kinds than there are. `None` where it does not, or the words do not say what they should.
#[inline(always)]
pub fn flight(
    given: &Given<'_>,
    number: u32,
    narrow: impl Fn(Settings<f32>) -> Option<Settings<f32>>,
) -> Option<Flown> {
    let count = given.count.max(1);
    let (controller, plant) = (number / count, number % count);
    let begin = controller as usize * given.each as usize;
    let settings = words::read(given.settings.get(begin..begin + given.each as usize)?).ok()?;
    let settings = narrow(settings)?;
    let common: Common = words::read(given.common).ok()?;
    let mut k = plant as usize;
    let mut next = || {
        let word = given.plants.get(k).copied().unwrap_or(0);
        k += count as usize;
        f32::from_bits(word)
    };
    let plant: PlantParameters<f32> = PAPER.plant.map(|_| next());
    let rotors = LaggedRotors::<f32>::new(&PAPER.plant, SAMPLE_TIME).map(|_| next());
    let disturbance = PerMotor::new(next(), next());
    let phase = PerAxis::new(next(), next());
    let plant = RealPlant::assemble(plant, rotors, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
    let closed_loop = RigLoop::assemble(plant, &common.hardware(), phase, &settings);
    let course = Changes { words: given.course, next: 0, at: first_tick(given.course), push: None };
    let sums = fly(closed_loop, settings.volts_limit, disturbance, &common.rules(), course, || false)?;
    Some(sums.lane(0))
}

/// Words of a [change](Changes).
pub const CHANGE: usize = 9;

/// A course by its changes, in the order of their ticks. Each is [`CHANGE`] words: the tick; 1 where
/// something else is asked for from then on, plus 2 where something pushes; angle, rate and acceleration asked
/// for, pitch and yaw each; the push.
#[derive(Debug)]
struct Changes<'a> {
    words: &'a [u32],
    /// The change to come, and its tick.
    next: usize,
    at: u32,
    push: Option<f32>,
}

#[inline(always)]
fn first_tick(words: &[u32]) -> u32 {
    words.first().copied().unwrap_or(u32::MAX)
}

impl Course for Changes<'_> {
    #[inline(always)]
    fn asked(&mut self, tick: u32) -> Option<Reference<f32>> {
        if tick != self.at {
            return None;
        }
        let here = self.words.get(self.next..)?;
        self.next += CHANGE;
        self.at = here.get(CHANGE).copied().unwrap_or(u32::MAX);
        let flags = here.get(1).copied().unwrap_or(0);
        let number = |k: usize| f32::from_bits(here.get(k).copied().unwrap_or(0));
        self.push = (flags & 2 != 0).then(|| number(8));
        (flags & 1 != 0).then(|| Reference {
            angle: PerAxis::new(number(2), number(3)),
            rate: PerAxis::new(number(4), number(5)),
            accel: PerAxis::new(number(6), number(7)),
        })
    }

    #[inline(always)]
    fn push(&mut self, _tick: u32) -> Option<f32> {
        self.push
    }
}

/// Words of a [`Flown`].
pub const FLOWN: usize = 11;

/// A flight's sums in words.
#[inline(always)]
pub fn to_words(flown: &Flown) -> [u32; FLOWN] {
    let flags =
        u32::from(flown.outside_5) | u32::from(flown.left_envelope) << 1 | u32::from(flown.diverged) << 2;
    [
        flown.last_outside_2.pitch.to_bits(),
        flown.last_outside_2.yaw.to_bits(),
        flown.overshoot.pitch.to_bits(),
        flown.overshoot.yaw.to_bits(),
        flown.hold_squares.pitch.to_bits(),
        flown.hold_squares.yaw.to_bits(),
        flown.disturbed_squares.pitch.to_bits(),
        flown.disturbed_squares.yaw.to_bits(),
        flown.variation.to_bits(),
        flown.saturated.to_bits(),
        flags,
    ]
}
