//! The rig of which a record speaks.

use super::Parameters;
use crate::board::Board;
use crate::plant::presets::{Envelope, Rig, Supply};

impl Parameters {
    /// The rig as the record has it, at `board`: the whole plant, the encoders, the rest pose to a count. A
    /// supply that just reaches the larger voltage limit.
    #[must_use]
    pub fn rig(&self, board: Board) -> Rig {
        let volts_limit = self.settings.volts_limit.map(f64::from);
        Rig {
            plant: self.settings.model.map(f64::from),
            volts_limit,
            supply: Supply {
                nominal: volts_limit.main.max(volts_limit.tail),
                lowest: self.limits.supply_low.into(),
                highest: self.limits.supply_high.into(),
            },
            nominal_volts: 0.0,
            encoder_counts: self.encoders.map(|scale| counts_per_turn(scale.angle_per_count)),
            board,
            rest_angle: self
                .encoders
                .map(|scale| f64::from(scale.rest_counts) * f64::from(scale.angle_per_count)),
            envelope: Envelope { pitch: self.limits.pitch.into(), rate: self.limits.rate.map(f64::from) },
            motor: None,
        }
    }
}

/// A whole number, whose `f32` reciprocal is exact enough up to the 1,000,000 that a record may have.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "16 to 1,000,000 in a record")]
fn counts_per_turn(angle_per_count: f32) -> u32 {
    libm::round(core::f64::consts::TAU / f64::from(angle_per_count)) as u32
}
