//! Step 3 of the tick: may the motors turn? Conditions -> [`ArmState`], by one table.
//!
//! - A [`Condition`] is one named thing that is wrong now. [`crate::monitor`] detects them, with the
//!   rule and the time written there; the firmware adds those that only a board can see.
//! - While motors are off, every present condition is a *reason* not to arm, and the list of them
//!   goes out with the telemetry. Reasons come and go by themselves.
//! - While motors turn, a present *hazard* latches [`ArmState::Fault`] with its name in the same tick.
//!   A fault stays until an explicit [`Request::ClearFault`] that arrives when no hazard is left.
//!
//! Each tick sees exactly one [`Event`], the first that applies in the order of their declaration,
//! and [`TRANSITIONS`] says the rest.

use core::hint::cold_path;
use serde::{Deserialize, Serialize};

/// What can be wrong, by name. The number is the bit in [`Conditions`] and the number on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Condition {
    /// The emergency stop is pressed or its cable is broken.
    EmergencyStop,
    /// The amplifier reports its current limit or a fault of its own.
    CurrentLimit,
    /// The supply is below or above the range of [`crate::parameters::Limits`].
    SupplyRange,
    /// The supply's reading changed by more in one tick than a supply can.
    SupplyJump,
    /// The supply was not measured anew, or an encoder timer does not count.
    SensorStale,
    /// Pitch moved further in one tick than the rig can.
    PitchJump,
    /// Yaw moved further in one tick than the rig can.
    YawJump,
    /// The pitch encoder does not show the motion that the voltages must cause: stuck or sign-swapped.
    PitchMotion,
    /// The yaw encoder does not show the motion that the voltages must cause: stuck or sign-swapped.
    YawMotion,
    /// An angle is outside the envelope.
    AngleEnvelope,
    /// A rate is outside the envelope.
    RateEnvelope,
    /// A NaN or an infinity turned up in estimate, reference or torque.
    NonFinite,
    /// A tick did not end before the next one was due, or one was left out.
    TickOverrun,
    /// Armed or checking, and the host has been silent for too long.
    CommandTimeout,
    /// The stack has come close to its end.
    StackGuard,
    /// The stored parameters are of another version, damaged, or outside their range.
    ParametersInvalid,
    /// Nothing is stored: the built-in defaults are in force.
    ParametersMissing,
    /// The encoders have no zero yet.
    NotZeroed,
    /// The first-power check has not been passed.
    NotChecked,
    /// The watchdog ended a stalled loop before this boot.
    ResetByWatchdog,
    /// A panic ended the firmware before this boot.
    ResetByPanic,
    /// A fault exception ended the firmware before this boot.
    ResetByFault,
    /// The stack overflowed before this boot.
    ResetByStackOverflow,
    /// The board's own supply broke down before this boot.
    ResetByBrownOut,
    /// The board's crystal stopped before this boot.
    ResetByClock,
    /// The board's crystal is missing or of another frequency: it runs from its inexact internal oscillator.
    ClockFallback,
    /// The firmware is built for a debugger, which may stop it at any place.
    DebugBuild,
}

impl Condition {
    /// Every condition, in the order of its bit.
    pub const ALL: [Self; 27] = [
        Self::EmergencyStop,
        Self::CurrentLimit,
        Self::SupplyRange,
        Self::SupplyJump,
        Self::SensorStale,
        Self::PitchJump,
        Self::YawJump,
        Self::PitchMotion,
        Self::YawMotion,
        Self::AngleEnvelope,
        Self::RateEnvelope,
        Self::NonFinite,
        Self::TickOverrun,
        Self::CommandTimeout,
        Self::StackGuard,
        Self::ParametersInvalid,
        Self::ParametersMissing,
        Self::NotZeroed,
        Self::NotChecked,
        Self::ResetByWatchdog,
        Self::ResetByPanic,
        Self::ResetByFault,
        Self::ResetByStackOverflow,
        Self::ResetByBrownOut,
        Self::ResetByClock,
        Self::ClockFallback,
        Self::DebugBuild,
    ];

    const fn bit(self) -> u32 {
        1_u32.wrapping_shl(self as u32)
    }
}

/// A set of conditions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Conditions(u32);

impl Conditions {
    /// Nothing is wrong.
    pub const NONE: Self = Self(0);

    /// What stops turning motors at once. The rest only prevents arming.
    pub const HAZARDS: Self = Self::of(&[
        Condition::EmergencyStop,
        Condition::CurrentLimit,
        Condition::SupplyRange,
        Condition::SupplyJump,
        Condition::SensorStale,
        Condition::PitchJump,
        Condition::YawJump,
        Condition::PitchMotion,
        Condition::YawMotion,
        Condition::AngleEnvelope,
        Condition::RateEnvelope,
        Condition::NonFinite,
        Condition::TickOverrun,
        Condition::CommandTimeout,
        Condition::StackGuard,
        Condition::ParametersInvalid,
    ]);

    /// What prevents the first-power check beside the hazards: without the rig's parameters, nobody knows how
    /// far its motors may be driven, and a board that is not as it should be drives none.
    pub const NO_CHECK: Self =
        Self::of(&[Condition::ParametersMissing, Condition::ClockFallback, Condition::DebugBuild]);

    /// The set of these conditions.
    #[must_use]
    pub const fn of(list: &[Condition]) -> Self {
        let mut bits = 0;
        let mut rest = list;
        while let [first, tail @ ..] = rest {
            bits |= first.bit();
            rest = tail;
        }
        Self(bits)
    }

    /// This set with `condition` in it if `present`, which is the exception.
    #[inline(always)]
    #[must_use]
    pub const fn with(self, condition: Condition, present: bool) -> Self {
        if present {
            cold_path();
            Self(self.0 | condition.bit())
        } else {
            self
        }
    }

    /// What is in either set.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// What is in both sets.
    #[must_use]
    pub const fn intersection(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Whether the set is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether `condition` is in the set.
    #[must_use]
    pub const fn contains(self, condition: Condition) -> bool {
        self.0 & condition.bit() != 0
    }

    /// The conditions of the set, in the order of their bits.
    pub fn iter(self) -> impl Iterator<Item = Condition> {
        Condition::ALL.into_iter().filter(move |&condition| self.contains(condition))
    }

    /// The first condition of the set: the name that a fault latches.
    #[must_use]
    pub fn first(self) -> Option<Condition> {
        Condition::ALL.get(self.0.trailing_zeros() as usize).copied()
    }
}

/// By their names.
#[cfg(feature = "defmt")]
impl defmt::Format for Conditions {
    fn format(&self, to: defmt::Formatter<'_>) {
        defmt::write!(to, "[ ");
        self.iter().for_each(|condition| defmt::write!(to, "{} ", condition));
        defmt::write!(to, "]");
    }
}

/// Whether the motors may turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ArmState {
    /// Motors off; at least one reason prevents arming.
    #[default]
    Disarmed,
    /// Motors off; nothing prevents arming.
    Ready,
    /// The first-power check turns one motor at a low voltage. Left for `Disarmed` only.
    Checking,
    /// The control law turns the motors.
    Armed,
    /// Motors off until the fault is cleared; the cause is the hazard that was found first.
    Fault(Condition),
}

impl ArmState {
    /// The core's own yes to turning motors; the enable pin is the other one.
    #[must_use]
    pub const fn motors_may_turn(self) -> bool {
        matches!(self, Self::Armed | Self::Checking)
    }

    /// Whether parameters may be written now, which stops the tick: motors off, and no fault to be cleared.
    #[must_use]
    pub const fn lets_flash_be_written(self) -> bool {
        matches!(self, Self::Disarmed | Self::Ready)
    }

    const fn row(self) -> usize {
        match self {
            Self::Disarmed => 0,
            Self::Ready => 1,
            Self::Checking => 2,
            Self::Armed => 3,
            Self::Fault(_) => 4,
        }
    }
}

/// What the operator asks of the supervisor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Request {
    /// Let the law turn the motors.
    Arm,
    /// Motors off.
    Disarm,
    /// Forget the latched fault.
    ClearFault,
    /// Start the first-power check.
    Check,
}

/// What a tick brings, first the one that goes before all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Event {
    /// A hazard is present.
    Hazard,
    /// The operator disarms, or the check has ended.
    Disarm,
    /// The operator clears the fault.
    ClearFault,
    /// The operator starts the first-power check.
    Check,
    /// Something prevents arming.
    Blocked,
    /// The operator arms.
    Arm,
    /// Nothing prevents arming.
    Free,
}

/// Where an event leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Nothing changes.
    Stay,
    /// To this state.
    To(ArmState),
    /// To `Fault` with the first hazard's name.
    Latch,
}

use ArmState::{Armed, Checking, Disarmed, Ready};
use Next::{Latch, Stay, To};

/// Every transition there is: a row for each state, a column for each event.
#[rustfmt::skip]
pub const TRANSITIONS: [[Next; 7]; 5] = [
    // Hazard     Disarm        ClearFault    Check         Blocked       Arm        Free
    /* Disarmed */
    [Stay,        Stay,         Stay,         To(Checking), Stay,         Stay,      To(Ready)],
    /* Ready */
    [To(Disarmed),To(Disarmed), To(Disarmed), To(Checking), To(Disarmed), To(Armed), Stay],
    /* Checking */
    [Latch,       To(Disarmed), Stay,         Stay,         Stay,         Stay,      Stay],
    /* Armed */
    [Latch,       To(Disarmed), Stay,         Stay,         Stay,         Stay,      Stay],
    /* Fault */
    [Stay,        Stay,         To(Disarmed), Stay,         Stay,         Stay,      Stay],
];

/// The state and its table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Supervisor {
    state: ArmState,
    /// What was present at the last step.
    present: Conditions,
    /// The last step brought another state or other conditions.
    changed: bool,
    /// It did not, and nothing was asked: the same again changes nothing.
    settled: bool,
}

impl Supervisor {
    /// Starts disarmed, or with the last reset's cause latched when that was no ordinary one.
    #[must_use]
    pub const fn new(reset_cause: Option<Condition>) -> Self {
        let state = match reset_cause {
            None => ArmState::Disarmed,
            Some(cause) => ArmState::Fault(cause),
        };
        Self { state, present: Conditions::NONE, changed: false, settled: false }
    }

    /// The state after the last step.
    #[must_use]
    pub const fn state(&self) -> ArmState {
        self.state
    }

    /// What was wrong at the last step.
    #[inline(always)]
    #[must_use]
    pub const fn present(&self) -> Conditions {
        self.present
    }

    /// Whether the last step brought another state or other conditions.
    #[inline(always)]
    #[must_use]
    pub const fn has_changed(&self) -> bool {
        self.changed
    }

    /// Whether a step with `present` and no request would change nothing, and need not be made.
    #[inline(always)]
    #[must_use]
    pub const fn is_settled(&self, present: Conditions) -> bool {
        self.settled && self.present.0 == present.0
    }

    /// One tick: `present` is all that is wrong now, `request` what the operator asks. Tells whether the
    /// state changes.
    pub fn step(&mut self, present: Conditions, request: Option<Request>) -> bool {
        let before = self.state;
        let hazards = present.intersection(Conditions::HAZARDS);
        let event = event(hazards, present, request);
        self.state = match (
            TRANSITIONS.get(self.state.row()).and_then(|row| row.get(event as usize)),
            hazards.first(),
        ) {
            (Some(To(next)), _) => *next,
            (Some(Latch), Some(cause)) => ArmState::Fault(cause),
            _ => before,
        };
        let changes = self.state != before;
        self.changed = changes || present != self.present;
        self.settled = request.is_none() && !self.changed;
        self.present = present;
        changes
    }
}

/// The first event that applies.
fn event(hazards: Conditions, present: Conditions, request: Option<Request>) -> Event {
    match request {
        _ if !hazards.is_empty() => Event::Hazard,
        Some(Request::Disarm) => Event::Disarm,
        Some(Request::ClearFault) => Event::ClearFault,
        Some(Request::Check) if present.intersection(Conditions::NO_CHECK).is_empty() => Event::Check,
        _ if !present.is_empty() => Event::Blocked,
        Some(Request::Arm) => Event::Arm,
        Some(Request::Check) | None => Event::Free,
    }
}

#[cfg(test)]
mod tests;
