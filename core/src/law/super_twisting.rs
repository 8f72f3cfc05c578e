//! Super-twisting sliding mode on s = ξ̇ + λ ξ, with the model as equivalent control: ẍ = ẍ_d + λ ξ̇ + k₁
//! √|s| sgn s + w, ẇ = k₂ sgn s (A. Levant, "Sliding order and sliding accuracy in sliding mode control",
//! Int. J. Control 58, 1993).
//!
//! In samples and with encoders the switch chatters, so sgn s is s/(|s| + ε): ε is a width to be tuned, not a
//! number to be small.

use super::integrator::integrated;
use super::{ControlLaw, Situation};
use crate::allocation::Allocation;
use crate::axes::PerAxis;
use crate::real::Real;
use crate::validate::{Invalid, not_negative, positive};
use serde::{Deserialize, Serialize};

/// The gains of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuperTwistingGains<R> {
    /// \[1/s\] λ, slope of the sliding surface. Above 0.
    pub surface: R,
    /// \[rad^½/s^{3/2}\] k₁. At least 0.
    pub proportional: R,
    /// \[rad/s³\] k₂. At least 0.
    pub integral: R,
    /// \[rad/s\] ε, width of the smoothed switch. Above 0.
    pub width: R,
}

impl<R: Real> SuperTwistingGains<R> {
    /// Each number through `f`.
    pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> SuperTwistingGains<U> {
        SuperTwistingGains {
            surface: f(self.surface),
            proportional: f(self.proportional),
            integral: f(self.integral),
            width: f(self.width),
        }
    }
}

impl<R: Real<Mask = bool>> SuperTwistingGains<R> {
    /// Usable gains, under the names of one axis.
    pub(super) fn validate(&self, fields: [&'static str; 4]) -> Result<(), Invalid<R>> {
        let [surface, proportional, integral, width] = fields;
        positive(surface, self.surface)?;
        not_negative(proportional, self.proportional)?;
        not_negative(integral, self.integral)?;
        positive(width, self.width)
    }
}

/// The law at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SuperTwisting<R> {
    gains: PerAxis<SuperTwistingGains<R>>,
    sample_time: R,
    /// \[rad/s²\] w.
    integral: PerAxis<R>,
}

impl<R: Real> SuperTwisting<R> {
    /// With an empty integral; `sample_time` \[s\].
    pub fn new(gains: PerAxis<SuperTwistingGains<R>>, sample_time: R) -> Self {
        Self { gains, sample_time, integral: PerAxis::zero() }
    }

    /// s of each axis.
    #[inline(always)]
    fn surface(&self, now: &Situation<'_, R>) -> PerAxis<R> {
        let angle = self.gains.zip(now.angle_error(), |g, e| g.surface * e);
        now.rate_error().plus(angle)
    }
}

impl<R: Real> ControlLaw<R> for SuperTwisting<R> {
    #[inline(always)]
    fn torque(&mut self, now: &Situation<'_, R>) -> PerAxis<R> {
        let reaching = self.gains.zip(
            self.surface(now),
            #[inline(always)]
            |g, s| g.proportional * s / (s.abs() + g.width).sqrt(),
        );
        let along = self.gains.zip(now.rate_error(), |g, e| g.surface * e);
        let accel = now.reference.accel.plus(along).plus(reaching).plus(self.integral);
        now.dynamics.torque(accel)
    }

    #[inline(always)]
    fn restart(&mut self) {
        self.integral = PerAxis::zero();
    }

    #[inline(always)]
    fn settle(&mut self, now: &Situation<'_, R>, allocation: &Allocation<R>) {
        let gained = self.gains.zip(
            self.surface(now),
            #[inline(always)]
            |g, s| g.integral * self.sample_time * s / (s.abs() + g.width),
        );
        self.integral = self.integral.zip(
            gained,
            #[inline(always)]
            |z, e| integrated(z, e, allocation.clipped()),
        );
    }
}
