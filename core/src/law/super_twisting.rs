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
use crate::plant::Effectiveness;
use crate::real::{Mask, Real};

settings! {
    /// The gains of one axis.
    pub struct SuperTwistingGains<R> at "pitch.", "yaw." {
        /// λ, slope of the sliding surface.
        surface: (R) "1/s", (above 0), typical 0.5 to 20.0, default 4.0;
        /// k₁, of the root of the distance to the surface.
        proportional: (R) "rad^½/s^{3/2}", (at least 0), typical 0.0 to 30.0, default 6.0;
        /// k₂, of the integral of the switch.
        integral: (R) "rad/s³", (at least 0), typical 0.0 to 60.0, default 15.0;
        /// ε, width of the smoothed switch.
        width: (R) "rad/s", (above 0), typical 0.05 to 3.0, default 0.5;
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
    type Gains = PerAxis<SuperTwistingGains<R>>;

    fn start(gains: Self::Gains, _effectiveness: Effectiveness<R>, sample_time: R) -> Self {
        Self::new(gains, sample_time)
    }

    fn integrates(_gains: &Self::Gains) -> R::Mask {
        R::Mask::splat(true)
    }

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
