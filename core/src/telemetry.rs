//! Step 8 of the tick: what the tick saw, decided and did, raw; people's units come later, on the host.

use crate::axes::{PerAxis, PerMotor};
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
    /// \[rad\] Where it should be.
    pub reference: PerAxis<f32>,
    /// \[V\] What the law asked for, before the limits; zero unless armed.
    pub demand: PerMotor<f32>,
    /// \[V\] What the motors get from the next tick on.
    pub volts: PerMotor<f32>,
    /// \[V\] Supply of the amplifiers.
    pub supply: f32,
}
