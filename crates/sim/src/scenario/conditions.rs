//! How a flight begins, and how good the rig's hardware is.

use super::ranges::{are_zero, pair, within};
use crate::error::{Error, Outcome};
use serde::Deserialize;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{LONGEST_DELAY, Wear};
use twinrotor::plant::Cable;
use twinrotor::trajectory::ticks;

/// How a flight begins; at rest, level and cold by default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Start {
    /// \[deg\] Pitch, up to 90 either way, and yaw, up to 360.
    pub angle_deg: [f64; 2],
    /// \[deg/s\] Of pitch and yaw, up to 500 either way.
    pub rate_deg: [f64; 2],
    /// \[V\] In effect at the main and the tail rotor, up to 60 either way: rotors that turn already.
    pub rotor_volts: [f64; 2],
    /// After a minute of squares of ±25° and ±60° every 2.5 s, which warm the motors, and 4 s of rest at
    /// `angle_deg`.
    pub hot: bool,
    /// \[counts\] 0..1: where between two counts the pitch and the yaw encoder begin; drawn by the seed of a
    /// flight where nothing is said.
    pub encoder_phase: Option<[f64; 2]>,
}

impl Start {
    /// Refuses what no flight begins with.
    ///
    /// # Errors
    ///
    /// Which number, and what is allowed.
    pub fn validate(&self) -> Outcome<()> {
        within("start.angle_deg[0]", self.angle_deg[0], [-90.0, 90.0], "degrees")?;
        within("start.angle_deg[1]", self.angle_deg[1], [-360.0, 360.0], "degrees")?;
        pair("start.rate_deg", self.rate_deg, [-500.0, 500.0], "degrees a second")?;
        pair("start.rotor_volts", self.rotor_volts, [-60.0, 60.0], "V")?;
        if let Some(phase) = self.encoder_phase {
            pair("start.encoder_phase", phase, [0.0, 1.0], "counts")?;
        }
        if self.hot && !(are_zero(self.rate_deg) && are_zero(self.rotor_volts)) {
            let allowed = "false beside start.rate_deg or start.rotor_volts: who has flown to where it \
                           begins hovers there";
            return Err(Error::invalid("start.hot", true, allowed));
        }
        Ok(())
    }

    /// \[rad\]
    pub fn angle(&self) -> PerAxis<f64> {
        PerAxis::new(self.angle_deg[0], self.angle_deg[1]).map(f64::to_radians)
    }

    /// \[rad/s\]
    pub fn rate(&self) -> PerAxis<f64> {
        PerAxis::new(self.rate_deg[0], self.rate_deg[1]).map(f64::to_radians)
    }

    /// \[V\] In effect at the rotors.
    pub fn rotors(&self) -> PerMotor<f64> {
        PerMotor::new(self.rotor_volts[0], self.rotor_volts[1])
    }
}

/// What the rig's hardware does worse than the ideal one; nothing by default. The rig's world alone has it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Hardware {
    /// \[counts\] Largest error of the pitch and the yaw encoder, 0 to 1000: each tick another, uniform.
    pub noise_counts: [u32; 2],
    /// \[deg\] Play between the shafts and the encoders, from one end to the other, 0 to 10.
    pub backlash_deg: [f64; 2],
    /// \[V\] What friction takes of the main and the tail motor's volts, 0 to 10: less does not turn it.
    pub dead_zone: [f64; 2],
    /// \[s\] By how much later than they should the volts act, 0 to .031, in whole ticks.
    pub delay: f64,
    /// \[s\] By how much more, each tick another whole number of ticks, uniform; with `delay` to .031.
    pub jitter: f64,
    /// \[N m/rad\] Stiffness of the cable that yaw winds up, 0 to 10.
    pub cable_stiffness: f64,
    /// \[deg\] How far yaw turns either way before the cable is taut, 0 to 3600.
    pub cable_free_deg: f64,
}

/// Most counts that an encoder may be wrong by.
const MOST_NOISE: f64 = 1e3;

impl Hardware {
    /// Refuses what no rig would fly with.
    ///
    /// # Errors
    ///
    /// Which number, and what is allowed.
    pub fn validate(&self) -> Outcome<()> {
        pair("hardware.noise_counts", self.noise_counts.map(f64::from), [0.0, MOST_NOISE], "counts")?;
        pair("hardware.backlash_deg", self.backlash_deg, [0.0, 10.0], "degrees")?;
        pair("hardware.dead_zone", self.dead_zone, [0.0, 10.0], "V")?;
        let longest = f64::from(LONGEST_DELAY) * SAMPLE_TIME;
        within("hardware.delay", self.delay, [0.0, longest], "s")?;
        let left = f64::from(LONGEST_DELAY - ticks(self.delay, SAMPLE_TIME)) * SAMPLE_TIME;
        within("hardware.jitter", self.jitter, [0.0, left], "s, with hardware.delay to .031")?;
        within("hardware.cable_stiffness", self.cable_stiffness, [0.0, 10.0], "N m/rad")?;
        within("hardware.cable_free_deg", self.cable_free_deg, [0.0, 3600.0], "degrees")
    }

    /// What of it a bench knows: all but what is random.
    pub fn wear(&self) -> Wear {
        Wear {
            backlash: PerAxis::new(self.backlash_deg[0], self.backlash_deg[1]).map(f64::to_radians),
            dead_zone: PerMotor::new(self.dead_zone[0], self.dead_zone[1]),
            delay: ticks(self.delay, SAMPLE_TIME),
            jitter: ticks(self.jitter, SAMPLE_TIME),
            cable: Cable { stiffness: self.cable_stiffness, free: self.cable_free_deg.to_radians() },
            limit: None,
        }
    }
}
