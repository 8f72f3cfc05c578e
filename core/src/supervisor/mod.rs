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

mod conditions;

pub use conditions::{Condition, Conditions};

use serde::{Deserialize, Serialize};

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
