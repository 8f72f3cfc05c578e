//! The parameter record: everything that a board must know of its rig and its controller, as one value with a
//! version.
//!
//! The host builds it from a preset and a gains file, the board keeps it in flash ([`store`]) or, until
//! something is stored, boots with the one that was compiled in. Both decode the same bytes, so both fly the
//! same numbers.

pub mod ram_flash;
mod rig;
pub mod store;

use crate::SAMPLE_TIME;
use crate::axes::{PerAxis, PerMotor};
use crate::first_power::Push;
use crate::pipeline::Settings;
use crate::plant::presets::Rig;
use crate::real::Real;
use crate::rig_port::RigPort;
use crate::supervisor::{Condition, Conditions};
use crate::validate::{Invalid, both, not_negative, positive, require};
use core::fmt;
use embedded_storage::nor_flash::NorFlash;
use serde::{Deserialize, Serialize};
use store::{MAX_PAYLOAD, SLOT_SIZE, Store};

/// Version of the record. Another one on flash is refused ([`ParameterError::Version`]), since its numbers
/// would mean something else; the board then keeps its motors off until a record of this version is stored.
pub const VERSION: u16 = 7;

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
    /// At which kind of port. What was checked at another counts for nothing: [`Parameters::at_port`].
    pub port: RigPort,
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
    /// \[V\] Lowest supply of the amplifiers; above 0. A reading below it counts as this much, so that a
    /// wrong one never gives a motor more than this makes of its demand.
    pub supply_low: f32,
    /// \[V\] Highest supply of the amplifiers; above the lowest.
    pub supply_high: f32,
    /// \[ticks\] How long the host may be silent while the motors may turn; at least 1.
    pub command_timeout: u32,
    /// What is done when it has been silent for so long.
    pub lost_link: LostLink,
    /// \[rad/s\] How fast the reference moves from where the rig lies to the setpoint after arming; above 0.
    pub approach_rate: f32,
    /// What the first-power check gives one motor at a time, and what comes of it.
    pub check: PerMotor<Push>,
}

/// What becomes of a flight whose host has fallen silent. The first-power check always ends at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LostLink {
    /// Motors off.
    #[default]
    Off,
    /// The reference stays where it is for so long, then motors off.
    Hold {
        /// \[ticks\] 1 to 60,000.
        ticks: u32,
    },
    /// The reference goes to the rest pose's pitch at `limits.approach_rate`, yaw stays; there, or after
    /// [`LAND_TICKS`], motors off. A host that comes back within that time has the rig again with its next
    /// setpoint.
    Land,
}

/// \[ticks\] The longest landing.
pub const LAND_TICKS: u32 = 60_000;

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

/// Where the parameters in force come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Provenance {
    /// From flash.
    Stored,
    /// Nothing is stored: they are built in.
    Missing,
    /// What is stored is of another version, so they are built in.
    OtherVersion {
        /// The version stored.
        found: u16,
    },
    /// What is stored is damaged or out of range, so they are built in.
    Damaged,
}

/// The parameters that a board with `port` boots with: those in `store`, or else the built-in ones. `buffer`
/// is room to work in.
pub fn load<F: NorFlash>(
    store: &mut Store<F>,
    buffer: &mut [u8; SLOT_SIZE],
    port: RigPort,
    built_in: impl FnOnce() -> Parameters,
) -> (Parameters, Provenance) {
    let provenance = match store.load(buffer).map(|bytes| bytes.map(Parameters::decode)) {
        Ok(Some(Ok(parameters))) => return (parameters.at_port(port), Provenance::Stored),
        Ok(Some(Err(error))) => Provenance::without(error),
        Ok(None) => Provenance::Missing,
        Err(_) => Provenance::Damaged,
    };
    (built_in().at_port(port), provenance)
}

/// Keeps `parameters` in `store`. `buffer` is room to work in.
///
/// # Errors
/// [`ParameterError::Damaged`] if the flash does not hold them.
pub fn save<F: NorFlash>(
    store: &mut Store<F>,
    parameters: &Parameters,
    buffer: &mut [u8; SLOT_SIZE],
) -> Result<(), ParameterError> {
    let mut payload = [0; MAX_PAYLOAD];
    let payload = parameters.encode(&mut payload)?;
    store.save(payload, buffer).map_err(|_| ParameterError::Damaged)
}

impl Provenance {
    /// Of the parameters that a board falls back on because of `error`.
    #[must_use]
    pub const fn without(error: ParameterError) -> Self {
        match error {
            ParameterError::Version { found } => Self::OtherVersion { found },
            _ => Self::Damaged,
        }
    }

    /// What it says against arming.
    #[must_use]
    pub const fn conditions(self) -> Conditions {
        let (missing, invalid) = match self {
            Self::Stored => (false, false),
            Self::Missing => (true, false),
            Self::OtherVersion { .. } | Self::Damaged => (false, true),
        };
        Conditions::NONE
            .with(Condition::ParametersMissing, missing)
            .with(Condition::ParametersInvalid, invalid)
    }
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
    /// The host may be silent for half a second; then the motors are switched off. The reference approaches
    /// at .5 rad/s. The first-power check gives half of each motor's limit: with less, real friction holds
    /// the yaw axis of an Aero, which needs 7 to 8 V to break away.
    pub fn new(rig: &Rig, settings: &Settings<f64>) -> Self {
        let scale = |counts: u32, rest: f64| {
            let angle_per_count = core::f64::consts::TAU / f64::from(counts);
            EncoderScale {
                angle_per_count: f32::from_f64(angle_per_count),
                rest_counts: round(rest / angle_per_count),
            }
        };
        Self {
            settings: settings.map(f32::from_f64),
            encoders: rig.encoder_counts.zip(rig.rest_angle, scale),
            limits: Limits {
                pitch: f32::from_f64(rig.envelope.pitch),
                rate: rig.envelope.rate.cast(),
                supply_low: f32::from_f64(rig.supply.lowest),
                supply_high: f32::from_f64(rig.supply.highest),
                command_timeout: 500,
                lost_link: LostLink::Off,
                approach_rate: 0.5,
                check: Push::predicted(rig, rig.volts_limit.map(|limit| 0.5 * limit)),
            },
            checked: false,
            port: RigPort::Pwm,
        }
    }

    /// As a board with `port` takes them: what was checked at another kind of port is not checked.
    #[must_use]
    pub fn at_port(self, port: RigPort) -> Self {
        Self { checked: self.checked && self.port == port, port, ..self }
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
        Ok(self.check_ranges()?)
    }

    fn check_ranges(&self) -> Result<(), Invalid<f32>> {
        let mut example = 0.0;
        let _ = self.settings.map(|number| example = if number.is_finite() { example } else { number });
        require("settings", example, true, "finite numbers")?;
        let s = &self.settings;
        #[expect(clippy::cast_possible_truncation, reason = "the nearest f32 is what the host writes")]
        let exact = s.sample_time.to_bits() == (SAMPLE_TIME as f32).to_bits();
        require("sample_time", s.sample_time, exact, "0.001 s, the board's tick")?;
        positive("model.mass", s.model.mass)?;
        both(["model.inertia.pitch", "model.inertia.yaw"], s.model.inertia, positive)?;
        not_negative("model.rotor_time_constant.main", s.model.rotor_time_constant.main)?;
        not_negative("model.rotor_time_constant.tail", s.model.rotor_time_constant.tail)?;
        let determinant = s.effectiveness.determinant();
        let invertible = (1.0 / determinant).is_finite();
        require("effectiveness", determinant, invertible, "a matrix with a determinant other than 0")?;
        for (field, volts) in
            [("volts_limit.main", s.volts_limit.main), ("volts_limit.tail", s.volts_limit.tail)]
        {
            require(field, volts, volts > 0.0 && volts <= MOST_VOLTS, "above 0, at most 60 V")?;
        }
        s.current_limit.map_or(Ok(()), |limit| limit.validate())?;
        s.controller.validate()?;
        let scale = |field, angle| {
            require(field, angle, angle > 6e-6 && angle < 0.4, "6e-6 to 0.4 rad, 16 to 1000000 counts a turn")
        };
        let counts = self.encoders.map(|encoder| encoder.angle_per_count);
        both(["encoders.pitch.angle_per_count", "encoders.yaw.angle_per_count"], counts, scale)?;
        self.limits.check_ranges(s.volts_limit)
    }
}

/// \[V\] and \[rad/s\]: what [`plausible`](crate::plant::plausible) has as the most of any rig.
const MOST_VOLTS: f32 = 60.0;
const MOST_RATE: f32 = 30.0;

impl Limits {
    fn check_ranges(&self, volts_limit: PerMotor<f32>) -> Result<(), Invalid<f32>> {
        let pitch = self.pitch > 0.0 && self.pitch <= core::f32::consts::FRAC_PI_2;
        require("limits.pitch", self.pitch, pitch, "above 0, at most pi/2 rad")?;
        // Beyond these a monitor would never trip.
        let rate =
            |field, rate| require(field, rate, rate > 0.0 && rate <= MOST_RATE, "above 0, at most 30 rad/s");
        both(["limits.rate.pitch", "limits.rate.yaw"], self.rate, rate)?;
        positive("limits.supply_low", self.supply_low)?;
        let above = self.supply_low < self.supply_high && self.supply_high <= 1.25 * MOST_VOLTS;
        require("limits.supply_high", self.supply_high, above, "above limits.supply_low, at most 75 V")?;
        let ticks = |field, ticks: u32| {
            #[expect(clippy::cast_precision_loss, reason = "exact where it is allowed")]
            require(field, ticks as f32, (1..=60_000).contains(&ticks), "1 to 60000 ticks")
        };
        ticks("limits.command_timeout", self.command_timeout)?;
        let hold = if let LostLink::Hold { ticks } = self.lost_link { ticks } else { 1 };
        ticks("limits.lost_link.ticks", hold)?;
        rate("limits.approach_rate", self.approach_rate)?;
        let volts = |field, push: Push, limit, allowed| {
            require(field, push.volts, push.volts > 0.0 && push.volts <= limit, allowed)
        };
        let PerMotor { main, tail } = self.check;
        volts("limits.check.main.volts", main, volts_limit.main, "above 0, at most volts_limit.main")?;
        volts("limits.check.tail.volts", tail, volts_limit.tail, "above 0, at most volts_limit.tail")?;
        let turns = |field, push: Push| {
            let squares = push.motion.pitch * push.motion.pitch + push.motion.yaw * push.motion.yaw;
            require(field, squares, squares > 0.0, "a motion about one axis or both")
        };
        turns("limits.check.main.motion", main)?;
        turns("limits.check.tail.motion", tail)
    }
}

impl From<Invalid<f32>> for ParameterError {
    fn from(invalid: Invalid<f32>) -> Self {
        Self::Range { field: invalid.field, allowed: invalid.allowed }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "saturating is what a count out of range should do")]
fn round(counts: f64) -> i32 {
    libm::round(counts) as i32
}

#[cfg(test)]
mod tests;
