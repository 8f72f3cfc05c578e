//! What the tick itself can see going wrong: each rule with its time. (A board adds what only it can see:
//! emergency stop, amplifier's current limit, stale sensors, overrun, stack, parameters, the last reset's
//! cause.)
//!
//! | condition | rule | time |
//! |---|---|---|
//! | `PitchJump`, `YawJump` | an encoder moved in one tick further than [`JUMP_MARGIN`] times the largest rate allows, plus [`JUMP_COUNTS`] counts | the tick it happens |
//! | `PitchMotion`, `YawMotion` | armed, and the voltages of the last [`MOTION_WINDOW`] s should have given over [`MOTION_PUSH`] of what full voltage gives, the encoder shows less than [`MOTION_SHARE`] of that or the opposite, and no disturbance of [`DISTURBANCE_VOLTS`] at each motor, nor a weight that can be held, nor rotors [`LATE`] times as slow as believed, explains it | [`MOTION_TICKS`] in a row; [`AGAINST_TICKS`] while the axis moves against its motors |
//! | the same | armed, the encoder has not left its neighbouring counts for [`STILL_TICKS`], and what the voltages give has changed since by over [`STUCK_PUSH`] of what full voltage gives while the axis was wanted [`STUCK_COUNTS`] elsewhere | when that should have moved it by [`STUCK_COUNTS`] |
//! | `AngleEnvelope` | zeroed, and pitch beyond `limits.pitch` | the tick it happens |
//! | `RateEnvelope` | an estimated rate beyond `limits.rate` | the tick it happens |
//! | `NonFinite` | estimate, reference, torque or volts hold a NaN or an infinity (those volts are zero already) | the next tick |
//! | `SupplyRange` | supply outside `limits.supply_low..=supply_high`, or not a number | [`SUPPLY_TICKS`] more such than sound readings |
//! | `SupplyJump` | the supply read differs from the last one by over [`SUPPLY_JUMP`] of it, or is not a number: a wire or a converter, no supply | the tick it happens |
//! | `CurrentLimit` | the amplifier's signal is on | [`CURRENT_TICKS`] in a row |
//! | `CommandTimeout` | armed or checking, and no message for `limits.command_timeout`; armed, with `limits.lost_link` other than `off`, when holding or landing has ended | that many ticks |

mod against;
mod flight;
mod motion;
mod persistence;
mod watch;

pub use flight::{FlightRules, JUMP_COUNTS, JUMP_MARGIN, Seen, Wrong};
pub use motion::{
    AGAINST_TICKS, DISTURBANCE_VOLTS, DRIFT, LATE, LOAD_WINDOW, MOTION_EVERY, MOTION_PUSH, MOTION_SHARE,
    MOTION_TICKS, MOTION_WINDOW, Motion, STILL_TICKS, STOP_MARGIN, STUCK_COUNTS, STUCK_PUSH,
};

use crate::parameters::{LAND_TICKS, LostLink, Parameters};
use crate::supervisor::{Condition, Conditions};
use core::hint::cold_path;
use persistence::Exception;

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
    /// What a flight shows.
    pub seen: Seen<f32>,
    /// \[V\] Supply of the amplifiers.
    pub supply: f32,
    /// \[V\] What it was in the last tick.
    pub supply_before: f32,
    /// The amplifier says that it limits the current.
    pub current_limit: bool,
    /// The encoders have a zero.
    pub zeroed: bool,
    /// The law or the check turns them.
    pub motors_may_turn: bool,
    /// A message came since the last tick.
    pub heard: bool,
}

/// The rules' memory: what every tick looks at first (see [`ControlLoop`](crate::control_loop::ControlLoop)).
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Monitor {
    /// \[V\]
    supply_low: f32,
    supply_high: f32,
    command_timeout: u32,
    /// \[ticks\] Of silence, after which a flight ends.
    flight_timeout: u32,
    supply: Exception,
    current: Exception,
    silent: u32,
    flight: FlightRules<f32>,
}

impl Monitor {
    /// For these parameters; the supply counts as out of range until it has been seen within it.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let limits = &parameters.limits;
        Self {
            flight: FlightRules::new(&parameters.settings, &parameters.encoders, limits),
            supply_low: limits.supply_low,
            supply_high: limits.supply_high,
            command_timeout: limits.command_timeout,
            flight_timeout: limits.command_timeout.saturating_add(match limits.lost_link {
                LostLink::Off => 0,
                LostLink::Hold { ticks } => ticks,
                LostLink::Land => LAND_TICKS,
            }),
            supply: Exception::of(SUPPLY_TICKS),
            current: Exception::of(0),
            silent: 0,
        }
    }

    /// Arming and the check start afresh, at this pitch \[rad\]: no motion is expected yet, and the host has
    /// just spoken.
    pub fn restart(&mut self, pitch: f32) {
        self.flight.restart(pitch);
        self.silent = 0;
    }

    /// The flight has ended: no motion is compared any more.
    pub fn end_flight(&mut self) {
        self.flight.end();
    }

    /// The link has been silent for `limits.command_timeout`, and was not in the last tick.
    #[inline(always)]
    #[must_use]
    pub fn has_just_lost_link(&self) -> bool {
        self.silent == self.command_timeout
    }

    /// What is wrong in this tick. `landed`: the link is lost, and has the reference come to the rest pose?
    #[inline(always)]
    pub fn check(&mut self, observed: &Observation, landed: impl FnOnce() -> bool) -> Conditions {
        let outside = !(observed.supply >= self.supply_low && observed.supply <= self.supply_high);
        let wrong = self.flight.check(&observed.seen);
        self.silent = if observed.heard { 0 } else { self.silent.saturating_add(1) };
        let silent = self.silent >= self.command_timeout && {
            cold_path();
            observed.motors_may_turn
                && (self.silent >= self.flight_timeout || !observed.seen.armed || landed())
        };
        // False with a NaN.
        let steady = (observed.supply - observed.supply_before).abs() <= SUPPLY_JUMP * observed.supply_before;
        Conditions::NONE
            .with(Condition::PitchJump, wrong.jumped.pitch)
            .with(Condition::YawJump, wrong.jumped.yaw)
            .with(Condition::PitchMotion, self.flight.contradicted().pitch)
            .with(Condition::YawMotion, self.flight.contradicted().yaw)
            .with(Condition::AngleEnvelope, observed.zeroed && wrong.steep)
            .with(Condition::RateEnvelope, wrong.fast.pitch || wrong.fast.yaw)
            .with(Condition::NonFinite, !wrong.finite)
            .with(Condition::SupplyRange, self.supply.more_often(outside, SUPPLY_TICKS))
            .with(Condition::SupplyJump, !steady)
            .with(Condition::CurrentLimit, self.current.in_a_row(observed.current_limit, CURRENT_TICKS))
            .with(Condition::CommandTimeout, silent)
    }
}
