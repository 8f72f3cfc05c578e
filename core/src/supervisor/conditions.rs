//! What can be wrong, and sets of it.

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
pub struct Conditions(pub(super) u32);

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
