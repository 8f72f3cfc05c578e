//! PID for each axis on its own: U = U_ff + I (k_p e + k_i ∫e + k_d ė), where U_ff is the torque that the
//! model needs at the reference, decoupled by the allocation's V = K⁻¹ U.

use super::integrator::integrated;
use super::{ControlLaw, Situation};
use crate::allocation::Allocation;
use crate::axes::PerAxis;
use crate::plant::Effectiveness;
use crate::real::Real;

settings! {
    /// The gains of one axis; in acceleration, so that they mean the same on every machine.
    pub struct PidGains<R> at "pitch.", "yaw." {
        /// k_p, of the angle error.
        proportional: (R) "1/s²", (at least 0), typical 0.0 to 300.0, default 50.0;
        /// k_i, of the integral of the angle error.
        integral: (R) "1/s³", (at least 0), typical 0.0 to 500.0, default 50.0;
        /// k_d, of the rate error.
        derivative: (R) "1/s", (at least 0), typical 0.0 to 60.0, default 14.0;
    }
}

/// The law at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pid<R> {
    gains: PerAxis<PidGains<R>>,
    sample_time: R,
    /// \[rad/s²\] k_i ∫e.
    integral: PerAxis<R>,
}

impl<R: Real> Pid<R> {
    /// With an empty integral; `sample_time` \[s\].
    pub fn new(gains: PerAxis<PidGains<R>>, sample_time: R) -> Self {
        Self { gains, sample_time, integral: PerAxis::zero() }
    }
}

impl<R: Real> ControlLaw<R> for Pid<R> {
    type Gains = PerAxis<PidGains<R>>;

    fn start(gains: Self::Gains, _effectiveness: Effectiveness<R>, sample_time: R) -> Self {
        Self::new(gains, sample_time)
    }

    fn integrates(gains: &Self::Gains) -> R::Mask {
        R::zero().lt(gains.pitch.integral + gains.yaw.integral)
    }

    #[inline(always)]
    fn torque(&mut self, now: &Situation<'_, R>) -> PerAxis<R> {
        let proportional = self.gains.zip(now.angle_error(), |g, e| g.proportional * e);
        let derivative = self.gains.zip(now.rate_error(), |g, e| g.derivative * e);
        let accel = proportional.plus(derivative).plus(self.integral);
        let feedback = now.dynamics.inertia.zip(accel, |i, a| i * a);
        now.feed_forward().plus(feedback)
    }

    #[inline(always)]
    fn restart(&mut self) {
        self.integral = PerAxis::zero();
    }

    #[inline(always)]
    fn settle(&mut self, now: &Situation<'_, R>, allocation: &Allocation<R>) {
        let gained = self.gains.zip(now.measured_error().scaled(self.sample_time), |g, e| g.integral * e);
        self.integral = self.integral.zip(
            gained,
            #[inline(always)]
            |z, e| integrated(z, e, allocation.clipped()),
        );
    }
}
