//! Step 8 of the tick: what the tick saw, decided and did, raw; people's units come later, on the host.

use crate::axes::{PerAxis, PerMotor};
use crate::sequence::Sequence;
use crate::supervisor::{ArmState, Conditions};
use serde::{Deserialize, Serialize};

/// One tick.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Frame {
    /// Which tick, counted from boot.
    pub tick: u32,
    /// Whether the motors may turn.
    pub state: ArmState,
    /// All that is wrong now.
    pub conditions: Conditions,
    /// \[rad\] Estimated angles.
    pub angle: PerAxis<f32>,
    /// \[rad/s\] Estimated rates.
    pub rate: PerAxis<f32>,
    /// \[rad/s²\] Estimated acceleration that the model does not explain.
    pub disturbance: PerAxis<f32>,
    /// \[rad\] Where it should be.
    pub reference: PerAxis<f32>,
    /// \[V\] What the law asked for, before the limits; zero unless armed.
    pub demand: PerMotor<f32>,
    /// \[N m\] What of the torque asked for the limits left over; zero unless armed.
    pub unallocated_torque: PerAxis<f32>,
    /// \[V\] What the motors get from the next tick on.
    pub volts: PerMotor<f32>,
    /// \[V\] Supply of the amplifiers.
    pub supply: f32,
    /// The last of the operator's commands.
    pub taken: Taken,
    /// Which controller decides.
    pub controller: InForce,
}

/// Which message the loop took last, and in which tick: a host that knows what it said can compute the flight
/// once more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Taken {
    /// Number of the message.
    pub sequence: Sequence,
    /// \[ticks\] Before the frame's; 0 in the frame's own, 255 for as long ago or longer, or never.
    pub ago: u8,
}

impl Default for Taken {
    fn default() -> Self {
        Self { sequence: Sequence(0), ago: u8::MAX }
    }
}

/// Which controller drives the motors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct InForce {
    /// The one to go back to.
    pub accepted: Kept,
    /// What a trial is doing.
    pub trial: TrialPhase,
    /// \[%\] The candidate's share in the volts, 0 to 100.
    pub blend: u8,
}

/// Whether flash has the accepted controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Kept {
    /// It is that of the parameter record, with which the board boots.
    #[default]
    Stored,
    /// It was accepted in flight and is lost with the power.
    Unsaved,
}

/// How far a trial is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum TrialPhase {
    /// There is none.
    #[default]
    None,
    /// The candidate computes and is not listened to.
    Shadow,
    /// Its share grows.
    FadingIn,
    /// It flies alone.
    Flying,
    /// Its share shrinks: the trial is over.
    FadingOut,
}
