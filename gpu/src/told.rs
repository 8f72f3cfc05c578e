//! What flights of the robust objective are told: what all of a launch have in common, and its course.

use serde::{Deserialize, Serialize};
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{Hardware, Wear};
use twinrotor::pipeline::Settings;
use twinrotor::plant::Effectiveness;
use twinrotor::real::Real as _;
use twinrotor::reference::Reference;
use twinrotor_sim::fittings::Fittings;
use twinrotor_sim::judged::{Bounds, Course};

/// What all flights of a launch have in common.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Common {
    /// What they are judged by.
    pub bounds: Bounds,
    /// Sensors and amplifiers, none of them worn.
    pub instruments: Instruments,
    /// Of what every controller believes of the rig, what is used as it is.
    pub belief: Belief,
}

/// A part of [`Settings`] that controllers on one rig have alike.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Belief {
    effectiveness: Effectiveness<f32>,
    volts_limit: PerMotor<f32>,
}

impl Belief {
    /// What these settings say.
    pub fn of(settings: &Settings<f32>) -> Self {
        Self { effectiveness: settings.effectiveness, volts_limit: settings.volts_limit }
    }

    /// The same settings, if they say so and have the board's sample time: all that is made of these numbers
    /// then needs no register, or fewer.
    #[inline(always)]
    pub(crate) fn within(self, settings: Settings<f32>) -> Option<Settings<f32>> {
        let sample_time = f32::from_f64(SAMPLE_TIME);
        let Self { effectiveness, volts_limit } = self;
        let same = (settings.sample_time, Self::of(&settings)) == (sample_time, self);
        same.then_some(Settings { sample_time, effectiveness, volts_limit, ..settings })
    }
}

/// What a closed loop has of hardware that is not worn, in the numbers that it reckons with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Instruments {
    counts_per_angle: PerAxis<f32>,
    angle_per_count: PerAxis<f32>,
    pwm_steps: u32,
    supply: f32,
}

impl Instruments {
    /// Those of `hardware`.
    pub fn new(hardware: &Hardware) -> Self {
        let fittings: &dyn Fittings<f32> = hardware;
        Self {
            counts_per_angle: fittings.counts_per_angle(),
            angle_per_count: fittings.angle_per_count(),
            pwm_steps: fittings.pwm_steps(),
            supply: fittings.supply(),
        }
    }
}

impl Fittings<f32> for Instruments {
    fn counts_per_angle(&self) -> PerAxis<f32> {
        self.counts_per_angle
    }

    fn angle_per_count(&self) -> PerAxis<f32> {
        self.angle_per_count
    }

    fn pwm_steps(&self) -> u32 {
        self.pwm_steps
    }

    fn supply(&self) -> f32 {
        self.supply
    }

    fn wear(&self) -> Wear {
        Wear::default()
    }
}

/// Words that there are for a [`Common`], of this kind or of [`integral`](crate::integral)'s.
pub const COMMON: usize = 96;

/// Words of a change of a course: the tick; 1 where something pushes from then on, and the push; angle, rate
/// and acceleration asked for, pitch and yaw each.
pub const CHANGE: u32 = 9;

/// A course by its changes, in the order of their ticks, the first in tick 0. What is asked for is read in
/// every tick where it stands: all threads read the same, and none has to keep it.
#[derive(Debug)]
pub(crate) struct Changes<'a> {
    words: &'a [u32],
    /// Where the change in force begins, and the tick of the one to come.
    now: u32,
    at: u32,
    push: Option<f32>,
}

impl<'a> Changes<'a> {
    #[inline(always)]
    pub(crate) fn new(words: &'a [u32]) -> Self {
        Self { words, now: 0, at: Self::ends(words, 0), push: None }
    }

    /// The tick of the change after the one that begins there.
    #[inline(always)]
    fn ends(words: &[u32], begins: u32) -> u32 {
        words.get((begins + CHANGE) as usize).copied().unwrap_or(u32::MAX)
    }
}

impl Course for Changes<'_> {
    #[inline(always)]
    fn asked(&mut self, tick: u32) -> Option<Reference<f32>> {
        if tick == self.at {
            self.now += CHANGE;
            self.at = Self::ends(self.words, self.now);
        }
        let here = self.words.get(self.now as usize..).and_then(<[u32]>::first_chunk);
        let [_, pushes, push, asked @ ..]: [u32; CHANGE as usize] = here.copied().unwrap_or_default();
        self.push = (pushes != 0).then_some(f32::from_bits(push));
        let [a, b, c, d, e, f] = asked.map(f32::from_bits);
        Some(Reference { angle: PerAxis::new(a, b), rate: PerAxis::new(c, d), accel: PerAxis::new(e, f) })
    }

    #[inline(always)]
    fn push(&mut self, _tick: u32) -> Option<f32> {
        self.push
    }
}
