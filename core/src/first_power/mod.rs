//! The first-power check: before a rig is armed for the first time, each motor in turn gets a low voltage for
//! a moment, and what the encoders show says whether the wiring is right.
//!
//! For each motor: wait until the rig lies still, push with the volts of `limits.check` until it has moved
//! far enough or [`PUSH_TICKS`] are over, let it come to rest. The directions in which the two pushes turned
//! the rig are compared with those that the preset's whole model predicts ([`Push::predicted`]), under each
//! way of connecting things wrongly. Two ways look the same from here: both motors reversed, or both
//! encoders; the verdict names the motors.

mod prediction;

use crate::axes::{PerAxis, PerMotor};
use crate::real::Real;
use serde::{Deserialize, Serialize};

/// \[ticks\] Longest push of a motor.
pub const PUSH_TICKS: u32 = 1_500;
/// \[ticks\] Without a count on either encoder: the rig lies still. Long enough that the turning point of a
/// slow swing (an Aero's period is 5 s) does not count as rest.
pub const REST_TICKS: u32 = 1_500;
/// \[ticks\] Longest wait for that: an Aero 2 swings on for two minutes. A hand may stop it.
pub const SETTLE_TICKS: u32 = 180_000;
/// \[rad\] Motion on one axis that ends a push: enough to tell, too little to swing about.
pub const FAR_ENOUGH: f32 = 0.15;
/// \[rad\] The least motion of a push that says anything.
pub const LEAST_MOTION: f32 = 0.02;

/// One motor's push: what it is given, and what the rig should make of it, connected rightly or not.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Push {
    /// \[V\] Above 0.
    pub volts: f32,
    /// \[rad\] How far it turns a rig that is connected as it should be.
    pub motion: PerAxis<f32>,
    /// \[rad\] The same if the motors are swapped.
    pub swapped: PerAxis<f32>,
    /// \[rad\] The same if this motor turns backwards.
    pub reversed: PerAxis<f32>,
}

/// What the check found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// Both motors turn the rig as the model says.
    Passed,
    /// A push moved nothing, or not what it should move: supply, amplifier, motor or encoder not connected.
    NoMotion {
        /// Which motor's push.
        motor: Motor,
    },
    /// One wrong connection explains what was observed better than none.
    Wrong(Fault),
    /// The rig did not come to rest.
    Restless,
}

/// One of the two motors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Motor {
    /// See [`PerMotor::main`].
    Main,
    /// See [`PerMotor::tail`].
    Tail,
}

/// What is connected wrongly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Fault {
    /// Main and tail motor are swapped.
    MotorsSwapped,
    /// The main motor turns backwards.
    MainReversed,
    /// The tail motor turns backwards.
    TailReversed,
    /// Both motors turn backwards, or both encoders count backwards.
    BothReversed,
    /// The pitch encoder counts backwards.
    PitchReversed,
    /// The yaw encoder counts backwards.
    YawReversed,
    /// The pitch and the yaw encoder are swapped.
    EncodersSwapped,
}

/// Every explanation, the right wiring first: a later one must fit better, not as well.
const EXPLANATIONS: [Option<Fault>; 8] = [
    None,
    Some(Fault::MotorsSwapped),
    Some(Fault::MainReversed),
    Some(Fault::TailReversed),
    Some(Fault::BothReversed),
    Some(Fault::PitchReversed),
    Some(Fault::YawReversed),
    Some(Fault::EncodersSwapped),
];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    Settle(Motor),
    Push(Motor),
    Done,
}

/// The check at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstPowerCheck {
    pushes: PerMotor<Push>,
    phase: Phase,
    ticks: u32,
    start: PerAxis<f32>,
    observed: PerMotor<PerAxis<f32>>,
}

impl FirstPowerCheck {
    /// With these pushes, ready to start.
    #[must_use]
    pub fn new(pushes: PerMotor<Push>) -> Self {
        Self {
            pushes,
            phase: Phase::Settle(Motor::Main),
            ticks: 0,
            start: PerAxis::zero(),
            observed: PerMotor::both(PerAxis::zero()),
        }
    }

    /// From the beginning.
    pub fn restart(&mut self) {
        self.phase = Phase::Settle(Motor::Main);
        self.ticks = 0;
    }

    /// One tick: `angle` \[rad\], and for how many ticks no encoder has moved. Gives the volts for the motors
    /// and, at the end, the verdict.
    pub fn step(&mut self, angle: PerAxis<f32>, still: u32) -> (PerMotor<f32>, Option<Verdict>) {
        self.ticks = self.ticks.saturating_add(1);
        match self.phase {
            Phase::Settle(motor) if still >= REST_TICKS => {
                self.start = angle;
                self.enter(Phase::Push(motor));
            }
            Phase::Push(motor) => {
                let moved = angle.minus(self.start);
                let distance = farthest(moved);
                if distance <= FAR_ENOUGH && self.ticks < PUSH_TICKS {
                    return (only(motor, self.pushes.map(|push| push.volts)), None);
                }
                if distance <= LEAST_MOTION {
                    self.enter(Phase::Done);
                    return (PerMotor::zero(), Some(Verdict::NoMotion { motor }));
                }
                match motor {
                    Motor::Main => {
                        self.observed.main = moved;
                        self.enter(Phase::Settle(Motor::Tail));
                    }
                    Motor::Tail => {
                        self.observed.tail = moved;
                        self.enter(Phase::Done);
                        return (PerMotor::zero(), Some(self.verdict()));
                    }
                }
            }
            Phase::Settle(_) if self.ticks >= SETTLE_TICKS => {
                self.enter(Phase::Done);
                return (PerMotor::zero(), Some(Verdict::Restless));
            }
            Phase::Settle(_) | Phase::Done => {}
        }
        (PerMotor::zero(), None)
    }

    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.ticks = 0;
    }

    /// The explanation whose directions of motion fit best.
    fn verdict(&self) -> Verdict {
        let mut best = (None, f32::NEG_INFINITY);
        for fault in EXPLANATIONS {
            let expected = explain(&self.pushes, fault);
            let fit =
                likeness(expected.main, self.observed.main) + likeness(expected.tail, self.observed.tail);
            if fit > best.1 + 1e-3 {
                best = (fault, fit);
            }
        }
        match (best.0, self.silent_encoder()) {
            (Some(fault), _) => Verdict::Wrong(fault),
            (None, Some(motor)) => Verdict::NoMotion { motor },
            (None, None) => Verdict::Passed,
        }
    }

    /// The motor that should have moved an encoder which has shown not one count of either push. The other
    /// encoder's directions can be right all the same.
    fn silent_encoder(&self) -> Option<Motor> {
        let expected = self.pushes.map(|push| push.motion);
        let silent = |of: fn(PerAxis<f32>) -> f32| {
            let [main, tail] = expected.map(|motion| of(motion).abs()).to_array();
            let shown = self.observed.map(|moved| of(moved).abs());
            (shown.main + shown.tail <= 0.0 && Real::max(main, tail) > LEAST_MOTION)
                .then_some(if main > tail { Motor::Main } else { Motor::Tail })
        };
        silent(|motion| motion.pitch).or(silent(|motion| motion.yaw))
    }
}

/// \[rad\] The motion of the axis that moved more.
fn farthest(moved: PerAxis<f32>) -> f32 {
    Real::max(moved.pitch.abs(), moved.yaw.abs())
}

/// For `motor` alone.
fn only(motor: Motor, volts: PerMotor<f32>) -> PerMotor<f32> {
    match motor {
        Motor::Main => PerMotor::new(volts.main, 0.0),
        Motor::Tail => PerMotor::new(0.0, volts.tail),
    }
}

/// What the encoders would show of both pushes.
fn explain(pushes: &PerMotor<Push>, fault: Option<Fault>) -> PerMotor<PerAxis<f32>> {
    let right = pushes.map(|push| push.motion);
    let reversed = pushes.map(|push| push.reversed);
    match fault {
        None => right,
        Some(Fault::MotorsSwapped) => pushes.map(|push| push.swapped),
        Some(Fault::MainReversed) => PerMotor { main: reversed.main, ..right },
        Some(Fault::TailReversed) => PerMotor { tail: reversed.tail, ..right },
        Some(Fault::BothReversed) => reversed,
        Some(Fault::PitchReversed) => right.map(|shown| PerAxis { pitch: -shown.pitch, ..shown }),
        Some(Fault::YawReversed) => right.map(|shown| PerAxis { yaw: -shown.yaw, ..shown }),
        Some(Fault::EncodersSwapped) => right.map(|shown| PerAxis::new(shown.yaw, shown.pitch)),
    }
}

/// Cosine of the angle between two motions, -1 to 1.
fn likeness(a: PerAxis<f32>, b: PerAxis<f32>) -> f32 {
    let dot = a.pitch * b.pitch + a.yaw * b.yaw;
    let squares = (a.pitch * a.pitch + a.yaw * a.yaw) * (b.pitch * b.pitch + b.yaw * b.yaw);
    if squares > 0.0 { dot / Real::sqrt(squares) } else { 0.0 }
}
