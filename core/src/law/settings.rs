//! Which law, and its gains: what a gains file holds under `controller`, `[pitch]` and `[yaw]`.

use super::{IntegralGains, PidGains, StateFeedbackGains, SuperTwistingGains};
use crate::axes::PerAxis;
use crate::gains::Gains;
use crate::real::Real;
use crate::validate::Invalid;
use serde::{Deserialize, Serialize};

/// Which law, and its gains.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum LawSettings<R> {
    /// The paper's, eqs (26)-(27).
    Backstepping(Gains<R>),
    /// The paper's with an integral.
    IntegralBackstepping(PerAxis<IntegralGains<R>>),
    /// PID for each axis.
    Pid(PerAxis<PidGains<R>>),
    /// PD, LQR, LQI in volts.
    StateFeedback(StateFeedbackGains<R>),
    /// Second-order sliding mode.
    SuperTwisting(PerAxis<SuperTwistingGains<R>>),
}

impl<R: Real> LawSettings<R> {
    /// Each number through `f`.
    pub fn map<U: Copy>(self, mut f: impl FnMut(R) -> U) -> LawSettings<U> {
        match self {
            Self::Backstepping(gains) => LawSettings::Backstepping(gains.map_gains(f)),
            Self::IntegralBackstepping(gains) => {
                LawSettings::IntegralBackstepping(gains.map(|g| g.map(&mut f)))
            }
            Self::Pid(gains) => LawSettings::Pid(gains.map(|g| g.map(&mut f))),
            Self::StateFeedback(gains) => LawSettings::StateFeedback(gains.map(f)),
            Self::SuperTwisting(gains) => LawSettings::SuperTwisting(gains.map(|g| g.map(&mut f))),
        }
    }
}

impl<R: Real<Mask = bool>> LawSettings<R> {
    /// Every gain usable.
    ///
    /// # Errors
    /// Names the field.
    pub fn validate(&self) -> Result<(), Invalid<R>> {
        match self {
            Self::Backstepping(gains) => gains.validate(),
            Self::IntegralBackstepping(gains) => {
                gains.pitch.validate(["pitch.position", "pitch.rate", "pitch.weight", "pitch.integral"])?;
                gains.yaw.validate(["yaw.position", "yaw.rate", "yaw.weight", "yaw.integral"])
            }
            Self::Pid(gains) => {
                gains.pitch.validate(["pitch.proportional", "pitch.integral", "pitch.derivative"])?;
                gains.yaw.validate(["yaw.proportional", "yaw.integral", "yaw.derivative"])
            }
            Self::StateFeedback(gains) => gains.validate(),
            Self::SuperTwisting(gains) => {
                gains.pitch.validate([
                    "pitch.surface",
                    "pitch.proportional",
                    "pitch.integral",
                    "pitch.width",
                ])?;
                gains.yaw.validate(["yaw.surface", "yaw.proportional", "yaw.integral", "yaw.width"])
            }
        }
    }
}
