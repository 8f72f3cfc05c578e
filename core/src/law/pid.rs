//! PID for each axis on its own: U = U_ff + I (k_p e + k_i ∫e + k_d ė), where U_ff is the torque that the
//! model needs at the reference, decoupled by the allocation's V = K⁻¹ U.

use super::integrator::integrated;
use super::{ControlLaw, Situation};
use crate::allocation::Allocation;
use crate::axes::PerAxis;
use crate::real::Real;
use crate::validate::{Invalid, not_negative};
use serde::{Deserialize, Serialize};

/// The gains of one axis; in acceleration, so that they mean the same on every machine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PidGains<R> {
    /// \[1/s²\] k_p; at least 0.
    pub proportional: R,
    /// \[1/s³\] k_i; at least 0.
    pub integral: R,
    /// \[1/s\] k_d; at least 0.
    pub derivative: R,
}

impl<R: Real> PidGains<R> {
    /// Each number through `f`.
    pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> PidGains<U> {
        PidGains {
            proportional: f(self.proportional),
            integral: f(self.integral),
            derivative: f(self.derivative),
        }
    }
}

impl<R: Real<Mask = bool>> PidGains<R> {
    /// Usable gains, under the names of one axis.
    pub(super) fn validate(&self, fields: [&'static str; 3]) -> Result<(), Invalid<R>> {
        let [proportional, integral, derivative] = fields;
        not_negative(proportional, self.proportional)?;
        not_negative(integral, self.integral)?;
        not_negative(derivative, self.derivative)
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
        let gained = self.gains.zip(now.angle_error().scaled(self.sample_time), |g, e| g.integral * e);
        self.integral = self.integral.zip(
            gained,
            #[inline(always)]
            |z, e| integrated(z, e, allocation.clipped()),
        );
    }
}
