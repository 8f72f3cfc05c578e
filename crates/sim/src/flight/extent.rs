//! How far a flight went of what its envelope allows.

use super::{Flight, Moment, Reading};
use serde::Serialize;
use twinrotor::axes::PerAxis;
use twinrotor::plant::presets::Envelope;

/// How far a flight went of what its envelope allows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extent {
    /// \[deg\] Largest pitch, either way.
    pub pitch_deg: f64,
    /// \[deg/s\] Largest rates.
    pub rate_deg: PerAxis<f64>,
    /// \[deg\] Largest pitch that is allowed.
    pub allowed_pitch_deg: f64,
    /// \[deg/s\] Largest rates that are allowed.
    pub allowed_rate_deg: PerAxis<f64>,
}

impl Extent {
    /// In a line.
    pub fn text(&self, left: Option<Moment>) -> String {
        let verdict = match left {
            Some(left) => format!("left at {:.3} s (tick {})", left.time, left.tick),
            None => "kept".to_owned(),
        };
        format!(
            "envelope: {verdict}; pitch up to {:.1} of {:.0}°, rates up to {:.0} and {:.0} of {:.0} and \
             {:.0} °/s\n",
            self.pitch_deg,
            self.allowed_pitch_deg,
            self.rate_deg.pitch,
            self.rate_deg.yaw,
            self.allowed_rate_deg.pitch,
            self.allowed_rate_deg.yaw
        )
    }
}

impl Flight {
    /// How far it went of what `envelope` allows.
    pub fn extent(&self, envelope: &Envelope) -> Extent {
        let most = |of: Reading| self.rows.iter().map(|row| of(row).abs()).fold(0.0, f64::max).to_degrees();
        Extent {
            pitch_deg: most(|row| row.state.angle.pitch),
            rate_deg: PerAxis::new(most(|row| row.state.rate.pitch), most(|row| row.state.rate.yaw)),
            allowed_pitch_deg: envelope.pitch.to_degrees(),
            allowed_rate_deg: envelope.rate.map(f64::to_degrees),
        }
    }
}
