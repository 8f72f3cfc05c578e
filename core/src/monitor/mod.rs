//! What the tick itself can see going wrong: each rule with its time. (A board adds what only it can see:
//! emergency stop, amplifier's current limit, stale sensors, overrun, stack, parameters, the last reset's
//! cause.)
//!
//! | condition | rule | time |
//! |---|---|---|
//! | `PitchJump`, `YawJump` | an encoder moved in one tick further than [`JUMP_MARGIN`] times the largest rate allows, plus [`JUMP_COUNTS`] counts | the tick it happens |
//! | `PitchMotion`, `YawMotion` | armed, and the voltages of the last [`MOTION_WINDOW`] s should have given over [`MOTION_PUSH`] of what full voltage gives, the encoder shows less than [`MOTION_SHARE`] of that or the opposite, and no disturbance of [`DISTURBANCE_VOLTS`] at each motor, nor a weight that can be held, explains it | [`MOTION_TICKS`] in a row |
//! | the same | armed, the encoder has not left its neighbouring counts for [`STILL_TICKS`], and what the voltages give has changed since by over [`STUCK_PUSH`] of what full voltage gives while the axis was wanted [`STUCK_COUNTS`] elsewhere | when that should have moved it by [`STUCK_COUNTS`] |
//! | `AngleEnvelope` | zeroed, and pitch beyond `limits.pitch` | the tick it happens |
//! | `RateEnvelope` | an estimated rate beyond `limits.rate` | the tick it happens |
//! | `NonFinite` | estimate, reference, torque or volts hold a NaN or an infinity (those volts are zero already) | the next tick |
//! | `SupplyRange` | supply outside `limits.supply_low..=supply_high`, or not a number | [`SUPPLY_TICKS`] more such than sound readings |
//! | `SupplyJump` | the supply read differs from the last one by over [`SUPPLY_JUMP`] of it, or is not a number: a wire or a converter, no supply | the tick it happens |
//! | `CurrentLimit` | the amplifier's signal is on | [`CURRENT_TICKS`] in a row |
//! | `CommandTimeout` | armed or checking, and no message for `limits.command_timeout`; armed, with `limits.lost_link` other than `off`, when holding or landing has ended | that many ticks |

mod motion;
mod persistence;
mod watch;

pub use motion::{
    DISTURBANCE_VOLTS, LOAD_WINDOW, MOTION_EVERY, MOTION_PUSH, MOTION_SHARE, MOTION_TICKS, MOTION_WINDOW,
    STILL_TICKS, STOP_MARGIN, STUCK_COUNTS, STUCK_PUSH,
};

use crate::axes::{PerAxis, PerMotor};
use crate::parameters::{LAND_TICKS, LostLink, Parameters};
use crate::supervisor::{Condition, Conditions};
use core::hint::cold_path;
use motion::Motion;
use persistence::Persistence;

/// How many times the largest rate an encoder may show in one tick.
pub const JUMP_MARGIN: f32 = 2.0;
/// \[counts\] Beyond that: quantisation, and an edge that bounces.
pub const JUMP_COUNTS: f32 = 3.0;
/// \[ticks\] A supply dips for a moment whenever a motor starts.
pub const SUPPLY_TICKS: u32 = 10;
/// Share of the last reading by which the supply may change in one tick. 24 V on 1 mF, with both motors of an
/// Aero at their peak current (4 A) and nothing coming after, fall by 4 V in that time, which is 17 %; a
/// loose wire or a wrong sample knows no such limit.
pub const SUPPLY_JUMP: f32 = 0.2;
/// \[ticks\] An amplifier may limit for a moment at every step.
pub const CURRENT_TICKS: u32 = 5;

/// What the rules look at in one tick.
#[derive(Debug, Clone, Copy)]
pub struct Observation {
    /// Which tick it is.
    pub tick: u32,
    /// \[counts\] Motion of each encoder since the last tick.
    pub moved: PerAxis<i32>,
    /// \[rad\] Estimated angles.
    pub angle: PerAxis<f32>,
    /// \[rad/s\] Estimated rates.
    pub rate: PerAxis<f32>,
    /// \[rad\] Where the last tick wanted to be.
    pub wanted: PerAxis<f32>,
    /// \[V\] What acted on the motors since the last tick.
    pub applied: PerMotor<f32>,
    /// \[V\] Supply of the amplifiers.
    pub supply: f32,
    /// \[V\] What it was in the last tick.
    pub supply_before: f32,
    /// The amplifier says that it limits the current.
    pub current_limit: bool,
    /// \[V\] What the last tick's pipeline asked for.
    pub demand: PerMotor<f32>,
    /// The encoders have a zero.
    pub zeroed: bool,
    /// The law turns the motors.
    pub armed: bool,
    /// The law or the check turns them.
    pub motors_may_turn: bool,
    /// A message came since the last tick.
    pub heard: bool,
}

/// The rules' memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Monitor {
    limits: Bounds,
    motion: Motion,
    disagrees: PerAxis<bool>,
    supply: Persistence,
    current: Persistence,
    silent: u32,
}

/// Limits in the units in which a tick compares.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bounds {
    pitch: f32,
    rate: PerAxis<f32>,
    jump: PerAxis<u32>,
    supply_low: f32,
    supply_high: f32,
    command_timeout: u32,
    /// \[ticks\] Of silence, after which a flight ends.
    flight_timeout: u32,
}

impl Monitor {
    /// For these parameters; the supply counts as out of range until it has been seen within it.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let limits = &parameters.limits;
        let jump = |rate: f32, angle_per_count: f32| {
            let counts = JUMP_MARGIN * rate * parameters.settings.sample_time / angle_per_count + JUMP_COUNTS;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates, and then never trips"
            )]
            let counts = counts as u32;
            counts
        };
        Self {
            limits: Bounds {
                pitch: limits.pitch,
                rate: limits.rate,
                jump: limits.rate.zip(parameters.encoders.map(|e| e.angle_per_count), jump),
                supply_low: limits.supply_low,
                supply_high: limits.supply_high,
                command_timeout: limits.command_timeout,
                flight_timeout: limits.command_timeout.saturating_add(match limits.lost_link {
                    LostLink::Off => 0,
                    LostLink::Hold { ticks } => ticks,
                    LostLink::Land => LAND_TICKS,
                }),
            },
            motion: Motion::new(parameters),
            disagrees: PerAxis::both(false),
            supply: Persistence::of(SUPPLY_TICKS),
            current: Persistence::default(),
            silent: 0,
        }
    }

    /// Arming and the check start afresh: no motion is expected yet, and the host has just spoken.
    pub fn restart(&mut self) {
        self.motion.restart();
        self.disagrees = PerAxis::both(false);
        self.silent = 0;
    }

    /// The link has been silent for `limits.command_timeout`, and was not in the last tick.
    #[inline(always)]
    #[must_use]
    pub fn has_just_lost_link(&self) -> bool {
        self.silent == self.limits.command_timeout
    }

    /// What is wrong in this tick. `landed`: the link is lost, and has the reference come to the rest pose?
    #[inline(always)]
    pub fn check(&mut self, observed: &Observation, landed: impl FnOnce() -> bool) -> Conditions {
        let b = &self.limits;
        let Observation { angle, rate, .. } = *observed;
        let mut jumped = PerAxis::both(false);
        if observed.moved != PerAxis::both(0) {
            jumped = observed.moved.zip(b.jump, |moved, limit| moved.unsigned_abs() > limit);
            self.motion.moved(observed.moved);
        }
        let outside = !(observed.supply >= b.supply_low && observed.supply <= b.supply_high);
        let fast = rate.zip(b.rate, |rate, limit| rate.abs() > limit);
        let steep = observed.zeroed && angle.pitch.abs() > b.pitch;
        // One NaN or infinity makes the sum one; rates, angles and demands of this world do not overflow it.
        let sum = (angle.pitch + angle.yaw)
            + (rate.pitch + rate.yaw)
            + (observed.demand.main + observed.demand.tail);
        if observed.tick % MOTION_EVERY == MOTION_EVERY - 1 {
            self.disagrees = self.motion.disagrees(observed);
        }
        self.silent = if observed.heard { 0 } else { self.silent.saturating_add(1) };
        let silent = self.silent >= b.command_timeout && {
            cold_path();
            observed.motors_may_turn && (self.silent >= b.flight_timeout || !observed.armed || landed())
        };
        // False with a NaN.
        let steady = (observed.supply - observed.supply_before).abs() <= SUPPLY_JUMP * observed.supply_before;
        Conditions::NONE
            .with(Condition::PitchJump, jumped.pitch)
            .with(Condition::YawJump, jumped.yaw)
            .with(Condition::PitchMotion, observed.armed && self.disagrees.pitch)
            .with(Condition::YawMotion, observed.armed && self.disagrees.yaw)
            .with(Condition::AngleEnvelope, steep)
            .with(Condition::RateEnvelope, fast.pitch || fast.yaw)
            .with(Condition::NonFinite, !sum.is_finite())
            .with(Condition::SupplyRange, self.supply.over_more_often(outside, SUPPLY_TICKS))
            .with(Condition::SupplyJump, !steady)
            .with(Condition::CurrentLimit, self.current.over(observed.current_limit, CURRENT_TICKS))
            .with(Condition::CommandTimeout, silent)
    }
}
