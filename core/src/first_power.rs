//! The first-power check: before a rig is armed for the first time, each motor in turn gets a low voltage for a moment,
//! and what the encoders show says whether the wiring is right.
//!
//! For each motor: wait until the rig lies still, push with `limits.check_volts` until it has moved far enough or
//! [`PUSH_TICKS`] are over, let it come to rest. The motion of the two pushes is compared with that which the model
//! predicts, K V by axis, under each way of connecting things wrongly. Two ways look the same from here: both motors
//! reversed, or both encoders; the verdict names the motors.

use crate::axes::{PerAxis, PerMotor};
use crate::parameters::Parameters;
use crate::plant::Effectiveness;
use crate::real::Real;
use serde::{Deserialize, Serialize};

/// \[ticks\] Longest push of a motor.
pub const PUSH_TICKS: u32 = 1_500;
/// \[ticks\] Without a count on either encoder: the rig lies still. Long enough that the turning point of a slow swing (an
/// Aero's period is 5 s) does not count as rest.
pub const STILL_TICKS: u32 = 1_500;
/// \[ticks\] Longest wait for that: an Aero 2 swings on for two minutes. A hand may stop it.
pub const SETTLE_TICKS: u32 = 180_000;
/// \[rad\] Motion on one axis that ends a push: enough to tell, too little to swing about.
pub const FAR_ENOUGH: f32 = 0.15;
/// \[rad\] The least motion of a push that says anything.
pub const LEAST_MOTION: f32 = 0.02;

/// What the check found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// Both motors turn the rig as the model says.
    Passed,
    /// A push moved nothing: supply, amplifier, motor or encoder not connected.
    NoMotion {
        /// Which motor's push.
        motor: Motor,
    },
    /// One wrong connection explains what was seen better than none.
    Wrong(Fault),
    /// The rig did not come to rest.
    Restless,
}

/// One of the two motors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Motor {
    /// See [`PerMotor::main`].
    Main,
    /// See [`PerMotor::tail`].
    Tail,
}

/// What is connected wrongly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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

/// What the motion of both pushes would be under one explanation: (swap motors, swap encoders, signs of main, tail,
/// pitch, yaw).
type Explanation = (bool, bool, [f32; 4]);

/// Every explanation, the right wiring first: a later one must fit better, not as well.
const EXPLANATIONS: [(Verdict, Explanation); 8] = [
    (Verdict::Passed, (false, false, [1.0, 1.0, 1.0, 1.0])),
    (Verdict::Wrong(Fault::MotorsSwapped), (true, false, [1.0, 1.0, 1.0, 1.0])),
    (Verdict::Wrong(Fault::MainReversed), (false, false, [-1.0, 1.0, 1.0, 1.0])),
    (Verdict::Wrong(Fault::TailReversed), (false, false, [1.0, -1.0, 1.0, 1.0])),
    (Verdict::Wrong(Fault::BothReversed), (false, false, [-1.0, -1.0, 1.0, 1.0])),
    (Verdict::Wrong(Fault::PitchReversed), (false, false, [1.0, 1.0, -1.0, 1.0])),
    (Verdict::Wrong(Fault::YawReversed), (false, false, [1.0, 1.0, 1.0, -1.0])),
    (Verdict::Wrong(Fault::EncodersSwapped), (false, true, [1.0, 1.0, 1.0, 1.0])),
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
    volts: PerMotor<f32>,
    /// \[rad/s²\] for each motor's push, on each axis.
    expected: PerMotor<PerAxis<f32>>,
    phase: Phase,
    ticks: u32,
    start: PerAxis<f32>,
    seen: PerMotor<PerAxis<f32>>,
}

impl FirstPowerCheck {
    /// For these parameters, ready to start.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let volts = parameters.limits.check_volts;
        let s = &parameters.settings;
        Self {
            volts,
            expected: predictions(&s.effectiveness, s.model.inertia, volts),
            phase: Phase::Settle(Motor::Main),
            ticks: 0,
            start: PerAxis::zero(),
            seen: PerMotor::both(PerAxis::zero()),
        }
    }

    /// From the beginning.
    pub fn restart(&mut self) {
        self.phase = Phase::Settle(Motor::Main);
        self.ticks = 0;
    }

    /// One tick: `angle` \[rad\], and for how many ticks no encoder has moved. Gives the volts for the motors and, at
    /// the end, the verdict.
    pub fn step(&mut self, angle: PerAxis<f32>, still: u32) -> (PerMotor<f32>, Option<Verdict>) {
        self.ticks = self.ticks.saturating_add(1);
        match self.phase {
            Phase::Settle(motor) if still >= STILL_TICKS => {
                self.start = angle;
                self.enter(Phase::Push(motor));
            }
            Phase::Push(motor) => {
                let moved = angle.minus(self.start);
                let farthest = Real::max(moved.pitch.abs(), moved.yaw.abs());
                let far = farthest > FAR_ENOUGH;
                if !far && self.ticks < PUSH_TICKS {
                    return (only(motor, self.volts), None);
                }
                if farthest <= LEAST_MOTION {
                    self.enter(Phase::Done);
                    return (PerMotor::zero(), Some(Verdict::NoMotion { motor }));
                }
                match motor {
                    Motor::Main => {
                        self.seen.main = moved;
                        self.enter(Phase::Settle(Motor::Tail));
                    }
                    Motor::Tail => {
                        self.seen.tail = moved;
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
        let mut best = (Verdict::Passed, f32::NEG_INFINITY);
        for (verdict, explanation) in EXPLANATIONS {
            let told = explain(&self.expected, explanation);
            let fit = likeness(told.main, self.seen.main) + likeness(told.tail, self.seen.tail);
            if fit > best.1 + 1e-3 {
                best = (verdict, fit);
            }
        }
        best.0
    }
}

/// \[rad/s²\] Acceleration that each motor's push gives each axis.
fn predictions(
    k: &Effectiveness<f32>,
    inertia: PerAxis<f32>,
    volts: PerMotor<f32>,
) -> PerMotor<PerAxis<f32>> {
    let one = |volts| k.torque(volts).zip(inertia, |torque, inertia| torque / inertia);
    PerMotor::new(one(only(Motor::Main, volts)), one(only(Motor::Tail, volts)))
}

fn only(motor: Motor, volts: PerMotor<f32>) -> PerMotor<f32> {
    match motor {
        Motor::Main => PerMotor::new(volts.main, 0.0),
        Motor::Tail => PerMotor::new(0.0, volts.tail),
    }
}

/// What the encoders would show of `expected` if things were connected so.
fn explain(
    expected: &PerMotor<PerAxis<f32>>,
    (motors, encoders, [main, tail, pitch, yaw]): Explanation,
) -> PerMotor<PerAxis<f32>> {
    let pushed = if motors { PerMotor::new(expected.tail, expected.main) } else { *expected };
    let signed = PerMotor::new(pushed.main.scaled(main), pushed.tail.scaled(tail));
    signed.map(|moved| {
        let shown = PerAxis::new(moved.pitch * pitch, moved.yaw * yaw);
        if encoders { PerAxis::new(shown.yaw, shown.pitch) } else { shown }
    })
}

/// Cosine of the angle between two motions, -1 to 1.
fn likeness(a: PerAxis<f32>, b: PerAxis<f32>) -> f32 {
    let dot = a.pitch * b.pitch + a.yaw * b.yaw;
    let squares = (a.pitch * a.pitch + a.yaw * a.yaw) * (b.pitch * b.pitch + b.yaw * b.yaw);
    if squares > 0.0 { dot / Real::sqrt(squares) } else { 0.0 }
}
