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

/// Volts on each motor for an error of each axis.
pub type MotorGains<R> = PerMotor<PerAxis<R>>;

settings! {
    /// The gain matrices.
    pub struct StateFeedbackGains<R> at "" {
        /// G_q, of the angle error: volts of a motor for the error of an axis.
        angle: (MotorGains<R>) "V/rad", (finite), typical -300.0 to 300.0, default 0.0;
        /// G_v, of the rate error.
        rate: (MotorGains<R>) "V s/rad", (finite), typical -300.0 to 300.0, default 0.0;
        /// G_i, of the integral of the angle error.
        integral: (MotorGains<R>) "V/(rad s)", (finite), typical -100.0 to 100.0, default 0.0;
        /// Most that the integral gives each motor.
        integral_limit: (R) "V", (at least 0), typical 0.0 to 24.0, default 20.0;
        /// Is the torque that the model needs at the reference fed forward?
        feed_forward: (bool) "-", (switch), typical 0.0 to 1.0, default 1.0;
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
    type Gains = StateFeedbackGains<R>;

    fn start(gains: Self::Gains, effectiveness: Effectiveness<R>, sample_time: R) -> Self {
        Self::new(gains, effectiveness, sample_time)
    }

    fn integrates(gains: &Self::Gains) -> R::Mask {
        R::zero().lt(gains.integral_limit)
    }

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
        let gained = product(&self.gains.integral, now.measured_error().scaled(self.sample_time));
        self.integral = self.integral.zip(
            gained,
            #[inline(always)]
            |z, e| integrated(z, e, allocation.clipped()).clamp(-limit, limit),
        );
    }
}
