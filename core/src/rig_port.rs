//! What a board's port to its rig is.

use serde::{Deserialize, Serialize};

/// The kind of rig that a board turns the motors of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "kebab-case")]
pub enum RigPort {
    /// One that is wired to it: encoders that it counts, amplifiers that its PWM drives.
    #[default]
    Pwm,
    /// One that the board computes itself: nothing leaves the chip.
    Simulated,
}
