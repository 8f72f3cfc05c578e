//! Linear state feedback in volts: PD, LQR and LQR with integral (LQI) are gains of this law.
//!
//! V = V_ff + G_q e + G_v ė + w, ẇ = G_i e with |w| limited, where V_ff = K⁻¹ (torque of the model at the
//! reference). The classic laboratory controller of the 2-DOF helicopter ("FF+LQR+I" in its manual) is this
//! with an integrator limit of 20 V.

use super::integrator::integrated;
use super::{ControlLaw, Situation};
use crate::allocation::Allocation;
use crate::axes::{PerAxis, PerMotor};
use crate::plant::Effectiveness;
use crate::real::Real;
use crate::validate::{Invalid, finite, not_negative};
use serde::{Deserialize, Serialize};

/// Volts on each motor for an error of each axis.
pub type MotorGains<R> = PerMotor<PerAxis<R>>;

/// The gain matrices.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateFeedbackGains<R> {
    /// \[V/rad\] G_q, of the angle error.
    pub angle: MotorGains<R>,
    /// \[V s/rad\] G_v, of the rate error.
    pub rate: MotorGains<R>,
    /// \[V/(rad s)\] G_i, of the integral of the angle error.
    pub integral: MotorGains<R>,
    /// \[V\] Most that the integral gives each motor; at least 0.
    pub integral_limit: R,
    /// Is the torque that the model needs at the reference fed forward?
    pub feed_forward: bool,
}

impl<R: Real> StateFeedbackGains<R> {
    /// Each number through `f`.
    pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> StateFeedbackGains<U> {
        let mut matrix = |m: MotorGains<R>| m.map(|row| row.map(&mut f));
        StateFeedbackGains {
            angle: matrix(self.angle),
            rate: matrix(self.rate),
            integral: matrix(self.integral),
            integral_limit: f(self.integral_limit),
            feed_forward: self.feed_forward,
        }
    }
}

impl<R: Real<Mask = bool>> StateFeedbackGains<R> {
    /// Usable gains.
    pub(super) fn validate(&self) -> Result<(), Invalid<R>> {
        for (field, matrix) in [("angle", self.angle), ("rate", self.rate), ("integral", self.integral)] {
            for row in matrix.to_array() {
                finite(field, row.pitch)?;
                finite(field, row.yaw)?;
            }
        }
        not_negative("integral_limit", self.integral_limit)
    }
}

/// The law at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateFeedback<R> {
    gains: StateFeedbackGains<R>,
    effectiveness: Effectiveness<R>,
    sample_time: R,
    /// \[V\] w.
    integral: PerMotor<R>,
}

#[inline(always)]
fn product<R: Real>(matrix: &MotorGains<R>, error: PerAxis<R>) -> PerMotor<R> {
    matrix.map(
        #[inline(always)]
        |row| row.pitch * error.pitch + row.yaw * error.yaw,
    )
}

impl<R: Real> StateFeedback<R> {
    /// With an empty integral; `sample_time` \[s\]. The volts are handed on as the torque that
    /// `effectiveness` makes of them.
    pub fn new(gains: StateFeedbackGains<R>, effectiveness: Effectiveness<R>, sample_time: R) -> Self {
        Self { gains, effectiveness, sample_time, integral: PerMotor::zero() }
    }
}

impl<R: Real> ControlLaw<R> for StateFeedback<R> {
    #[inline(always)]
    fn torque(&mut self, now: &Situation<'_, R>) -> PerAxis<R> {
        let volts = product(&self.gains.angle, now.angle_error())
            .plus(product(&self.gains.rate, now.rate_error()))
            .plus(self.integral);
        let feedback = self.effectiveness.torque(volts);
        if self.gains.feed_forward { now.feed_forward().plus(feedback) } else { feedback }
    }

    #[inline(always)]
    fn restart(&mut self) {
        self.integral = PerMotor::zero();
    }

    #[inline(always)]
    fn settle(&mut self, now: &Situation<'_, R>, allocation: &Allocation<R>) {
        let limit = self.gains.integral_limit;
        let gained = product(&self.gains.integral, now.angle_error().scaled(self.sample_time));
        self.integral = self.integral.zip(
            gained,
            #[inline(always)]
            |z, e| integrated(z, e, allocation.clipped()).clamp(-limit, limit),
        );
    }
}
