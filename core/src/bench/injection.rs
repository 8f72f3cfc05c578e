//! What may befall a rig that is simulated, at the word of its operator.

use super::Faults;
use crate::axes::PerMotor;
use crate::validate::{Invalid, require};
use serde::{Deserialize, Serialize};

/// Something that happens to a simulated rig, and lasts until another of its kind or [`Injection::Rest`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Injection {
    /// Somebody puts the rig back into its rest pose, and everything is sound again. Its encoders count the
    /// way back.
    Rest,
    /// These faults of the wiring, and no others.
    Wiring(Faults),
    /// \[V\] Supply of the amplifiers, 0 to 75.
    Supply(f32),
    /// \[V\] Added to the volts in effect, -60 to 60 each.
    Disturbance(PerMotor<f32>),
    /// The amplifiers' fault line.
    CurrentLimit(bool),
    /// The emergency stop.
    EmergencyStop(bool),
    /// A weight is hung on the rig, beside its own.
    Weight {
        /// \[kg\] Above 0, at most 1.
        mass: f32,
        /// \[m\] In front of the pivot; 0.01 to 0.5, either way.
        arm: f32,
    },
    /// A tick takes so much longer, once.
    Stall {
        /// \[ticks\] 1 to 10.
        ticks: u8,
    },
}

impl Injection {
    /// Every number in its range.
    ///
    /// # Errors
    /// Names the first that is not.
    pub fn validate(&self) -> Result<(), Invalid<f32>> {
        match *self {
            Self::Rest | Self::Wiring(_) | Self::CurrentLimit(_) | Self::EmergencyStop(_) => Ok(()),
            Self::Supply(volts) => {
                require("inject.supply", volts, (0.0..=75.0).contains(&volts), "0 to 75 V")
            }
            Self::Disturbance(PerMotor { main, tail }) => {
                let volts = |field, volts: f32| require(field, volts, volts.abs() <= 60.0, "-60 to 60 V");
                volts("inject.disturbance.main", main)?;
                volts("inject.disturbance.tail", tail)
            }
            Self::Weight { mass, arm } => {
                require("inject.weight.mass", mass, mass > 0.0 && mass <= 1.0, "above 0, at most 1 kg")?;
                let allowed = "0.01 to 0.5 m, either way";
                require("inject.weight.arm", arm, (0.01..=0.5).contains(&arm.abs()), allowed)
            }
            Self::Stall { ticks } => {
                require("inject.stall", ticks.into(), (1..=10).contains(&ticks), "1 to 10 ticks")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_out_of_range_is_named_and_not_a_number_is_out_of_range() {
        let named = |injection: Injection| injection.validate().unwrap_err().field;
        assert_eq!(named(Injection::Supply(f32::NAN)), "inject.supply");
        assert_eq!(named(Injection::Supply(-1.0)), "inject.supply");
        assert_eq!(named(Injection::Disturbance(PerMotor::new(0.0, 61.0))), "inject.disturbance.tail");
        assert_eq!(named(Injection::Disturbance(PerMotor::both(f32::NAN))), "inject.disturbance.main");
        assert_eq!(named(Injection::Weight { mass: 0.0, arm: 0.1 }), "inject.weight.mass");
        assert_eq!(named(Injection::Weight { mass: 0.1, arm: 0.0 }), "inject.weight.arm");
        assert_eq!(named(Injection::Stall { ticks: 0 }), "inject.stall");
        for sound in [Injection::Rest, Injection::Supply(12.0), Injection::Weight { mass: 0.1, arm: -0.1 }] {
            assert!(sound.validate().is_ok(), "{sound:?}");
        }
    }
}
