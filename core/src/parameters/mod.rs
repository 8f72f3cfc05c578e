//! The parameter record: everything that a board must know of its rig and its controller, as one value with a
//! version.
//!
//! The host builds it from a preset and a gains file, the board keeps it in flash ([`store`]) or, until
//! something is stored, boots with the one that was compiled in. Both decode the same bytes, so both fly the
//! same numbers.

pub mod ram_flash;
pub mod store;

use crate::SAMPLE_TIME;
use crate::axes::{PerAxis, PerMotor};
use crate::first_power::Push;
use crate::pipeline::Settings;
use crate::plant::presets::Rig;
use crate::real::Real;
use crate::validate::Invalid;
use core::fmt;
use serde::{Deserialize, Serialize};

/// Version of the record. Another one on flash is refused ([`ParameterError::Version`]), since its numbers would
/// mean something else; the board then keeps its motors off until a record of this version is stored.
pub const VERSION: u16 = 4;

/// What a board runs with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// The controller, and the plant as it believes it to be.
    pub settings: Settings<f32>,
    /// The encoders.
    pub encoders: PerAxis<EncoderScale>,
    /// What must not be left.
    pub limits: Limits,
    /// Has the first-power check been passed with this wiring?
    pub checked: bool,
}

/// One encoder and the pose in which it is zeroed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EncoderScale {
    /// \[rad\] Angle of one count, all four edges counted; above 0.
    pub angle_per_count: f32,
    /// \[counts\] Where the rig lies with its motors off, seen from its zero.
    pub rest_counts: i32,
}

/// Bounds of safe operation; see [`crate::monitor`] for the rules.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// \[rad\] Largest pitch from the horizontal, either way; above 0.
    pub pitch: f32,
    /// \[rad/s\] Largest rate about each axis; above 0.
    pub rate: PerAxis<f32>,
    /// \[V\] Lowest supply of the amplifiers; above 0.
    pub supply_low: f32,
    /// \[V\] Highest supply of the amplifiers; above the lowest.
    pub supply_high: f32,
    /// \[ticks\] How long the host may be silent while armed; at least 1.
    pub command_timeout: u32,
    /// \[rad/s\] How fast the reference moves from where the rig lies to the setpoint after arming; above 0.
    pub approach_rate: f32,
    /// What the first-power check gives one motor at a time, and what comes of it.
    pub check: PerMotor<Push>,
}

/// A parameter that cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterError {
    /// The bytes are no record.
    Damaged,
    /// A record of another version.
    Version {
        /// The version found.
        found: u16,
    },
    /// A value out of its range.
    Range {
        /// Name of the field.
        field: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The record does not fit its place on flash.
    TooLong,
}

/// What is wrong, and what to do about it.
impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Damaged => f.write_str(
                "the bytes are no parameter record: make one from the gains file and store it again",
            ),
            Self::Version { found } => write!(
                f,
                "the parameter record is of version {found}, and only version {VERSION} is read: make it \
                 anew from its gains file with this program, and store it again"
            ),
            Self::Range { field, allowed } => {
                write!(f, "{field} cannot be used on a board; allowed: {allowed}")
            }
            Self::TooLong => f.write_str("the parameter record does not fit its place on flash"),
        }
    }
}

impl core::error::Error for ParameterError {}

impl Parameters {
    /// For a rig and a controller: settings as given, the rest as the rig has it.
    ///
    /// The supply may be between half the motors' limit and 25 % above it. The host may be silent for half a
    /// second. The reference approaches at .5 rad/s. The first-power check gives half of each motor's limit:
    /// with less, real friction holds the yaw axis of an Aero, which needs 7 to 8 V to break away.
    pub fn new(rig: &Rig, settings: &Settings<f64>) -> Self {
        let scale = |counts: u32, rest: f64| {
            let angle_per_count = core::f64::consts::TAU / f64::from(counts);
            EncoderScale {
                angle_per_count: f32::from_f64(angle_per_count),
                rest_counts: round(rest / angle_per_count),
            }
        };
        let highest = rig.volts_limit.main.max(rig.volts_limit.tail);
        Self {
            settings: settings.map(f32::from_f64),
            encoders: rig.encoder_counts.zip(rig.rest_angle, scale),
            limits: Limits {
                pitch: f32::from_f64(rig.envelope.pitch),
                rate: rig.envelope.rate.cast(),
                supply_low: f32::from_f64(0.5 * highest),
                supply_high: f32::from_f64(1.25 * highest),
                command_timeout: 500,
                approach_rate: 0.5,
                check: Push::predicted(rig, rig.volts_limit.map(|limit| 0.5 * limit)),
            },
            checked: false,
        }
    }

    /// The record as bytes.
    ///
    /// # Errors
    /// [`ParameterError::TooLong`].
    pub fn encode<'b>(&self, buffer: &'b mut [u8; store::MAX_PAYLOAD]) -> Result<&'b [u8], ParameterError> {
        postcard::to_slice(&(VERSION, self), buffer).map(|bytes| &*bytes).map_err(|_| ParameterError::TooLong)
    }

    /// The record in `bytes`, every value of it usable.
    ///
    /// # Errors
    /// Anything but a whole record of this version with every value in its range.
    pub fn decode(bytes: &[u8]) -> Result<Self, ParameterError> {
        let (found, rest) = postcard::take_from_bytes::<u16>(bytes).map_err(|_| ParameterError::Damaged)?;
        if found != VERSION {
            return Err(ParameterError::Version { found });
        }
        let (parameters, rest) =
            postcard::take_from_bytes::<Self>(rest).map_err(|_| ParameterError::Damaged)?;
        if !rest.is_empty() {
            return Err(ParameterError::Damaged);
        }
        parameters.validate()?;
        Ok(parameters)
    }

    /// Every value in its range.
    ///
    /// # Errors
    /// [`ParameterError::Range`], which names the first field that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let mut finite = true;
        let _ = self.settings.map(|number| finite &= number.is_finite());
        require(finite, "settings", "finite numbers")?;
        let s = &self.settings;
        #[expect(clippy::cast_possible_truncation, reason = "the nearest f32 is what the host writes")]
        let exact = s.sample_time.to_bits() == (SAMPLE_TIME as f32).to_bits();
        require(exact, "sample_time", "0.001 s, the board's tick")?;
        positive("model.mass", s.model.mass)?;
        positive("model.inertia.pitch", s.model.inertia.pitch)?;
        positive("model.inertia.yaw", s.model.inertia.yaw)?;
        not_negative("model.rotor_time_constant.main", s.model.rotor_time_constant.main)?;
        not_negative("model.rotor_time_constant.tail", s.model.rotor_time_constant.tail)?;
        let invertible = (1.0 / s.effectiveness.determinant()).is_finite();
        require(invertible, "effectiveness", "a matrix with a determinant other than 0")?;
        for (field, volts) in
            [("volts_limit.main", s.volts_limit.main), ("volts_limit.tail", s.volts_limit.tail)]
        {
            require(volts > 0.0 && volts <= MOST_VOLTS, field, "above 0, at most 60 V")?;
        }
        let in_range = |e: Invalid<f32>| ParameterError::Range { field: e.field, allowed: e.allowed };
        s.current_limit.map_or(Ok(()), |limit| limit.validate()).map_err(in_range)?;
        s.controller.validate().map_err(in_range)?;
        for (field, encoder) in [
            ("encoders.pitch.angle_per_count", self.encoders.pitch),
            ("encoders.yaw.angle_per_count", self.encoders.yaw),
        ] {
            let angle = encoder.angle_per_count;
            require(angle > 6e-6 && angle < 0.4, field, "6e-6 to 0.4 rad, 16 to 1000000 counts a turn")?;
        }
        self.limits.validate(s.volts_limit)
    }
}

/// \[V\] and \[rad/s\]: what [`plausible`](crate::plant::plausible) has as the most of any rig.
const MOST_VOLTS: f32 = 60.0;
const MOST_RATE: f32 = 30.0;

impl Limits {
    fn validate(&self, volts_limit: PerMotor<f32>) -> Result<(), ParameterError> {
        let right_angle = core::f32::consts::FRAC_PI_2;
        require(self.pitch > 0.0 && self.pitch <= right_angle, "limits.pitch", "above 0, at most pi/2 rad")?;
        // Beyond these a monitor would never trip.
        for (field, rate) in [("limits.rate.pitch", self.rate.pitch), ("limits.rate.yaw", self.rate.yaw)] {
            require(rate > 0.0 && rate <= MOST_RATE, field, "above 0, at most 30 rad/s")?;
        }
        positive("limits.supply_low", self.supply_low)?;
        let supply = self.supply_high <= 1.25 * MOST_VOLTS && self.supply_low < self.supply_high;
        require(supply, "limits.supply_high", "above limits.supply_low, at most 75 V")?;
        require((1..=60_000).contains(&self.command_timeout), "limits.command_timeout", "1 to 60000 ticks")?;
        let approach = self.approach_rate > 0.0 && self.approach_rate <= MOST_RATE;
        require(approach, "limits.approach_rate", "above 0, at most 30 rad/s")?;
        let volts = |push: Push, limit| push.volts > 0.0 && push.volts <= limit;
        let allowed = self.check.zip(volts_limit, volts);
        require(allowed.main, "limits.check.main.volts", "above 0, at most volts_limit.main")?;
        require(allowed.tail, "limits.check.tail.volts", "above 0, at most volts_limit.tail")?;
        let turns = |push: Push| {
            let squares = push.motion.pitch * push.motion.pitch + push.motion.yaw * push.motion.yaw;
            squares.is_finite() && squares > 0.0
        };
        require(turns(self.check.main), "limits.check.main.motion", "a motion about one axis or both")?;
        require(turns(self.check.tail), "limits.check.tail.motion", "a motion about one axis or both")
    }
}

// As in `validate`: small, not fast.
#[inline(never)]
fn require(holds: bool, field: &'static str, allowed: &'static str) -> Result<(), ParameterError> {
    if holds { Ok(()) } else { Err(ParameterError::Range { field, allowed }) }
}

#[inline(never)]
fn positive(field: &'static str, value: f32) -> Result<(), ParameterError> {
    require(value.is_finite() && value > 0.0, field, "a finite number above 0")
}

#[inline(never)]
fn not_negative(field: &'static str, value: f32) -> Result<(), ParameterError> {
    require(value.is_finite() && value >= 0.0, field, "a finite number of at least 0")
}

#[expect(clippy::cast_possible_truncation, reason = "saturating is what a count out of range should do")]
fn round(counts: f64) -> i32 {
    libm::round(counts) as i32
}

#[cfg(test)]
mod tests;
