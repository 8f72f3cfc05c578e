//! Backstepping with an integral of its own: the paper's construction with one step more.
//!
//! Per axis, with the integral χ of ξ_a, virtual rate x_2d = ẋ_d + μ_a ξ_a + λ χ and ξ_b = x_2d - ẋ, take
//! M = (γ λ χ² + γ ξ_a² + ξ_b²)/2. Since ξ̇_a = ξ_b - μ_a ξ_a - λ χ, its cross terms cancel and
//! Ṁ = -γ μ_a ξ_a² - μ_b ξ_b² under
//!
//! ẍ = ẍ_d + μ_a ξ̇_a + λ ξ_a + γ ξ_a + μ_b ξ_b,
//!
//! as long as no voltage clips, the model is exact and nothing disturbs. A constant disturbance moves the
//! resting point of χ alone: no offset is left. γ = 1 and λ = 0 is eqs (26)-(27). The weight γ frees the
//! damping: the closed loop has K_p = γ + λ + μ_a μ_b, K_d = μ_a + μ_b, K_i = λ μ_b.

use super::integrator::integrated;
use super::{ControlLaw, Situation};
use crate::allocation::Allocation;
use crate::axes::PerAxis;
use crate::plant::Effectiveness;
use crate::real::Real;

settings! {
    /// The gains of one axis.
    pub struct IntegralGains<R> at "pitch.", "yaw." {
        /// μ_a, of the angle error.
        position: (R) "1/s", (above 0), typical 0.3 to 30.0, default 5.0;
        /// μ_b, of the rate error.
        rate: (R) "1/s", (above 0), typical 0.5 to 60.0, default 10.0;
        /// γ, weight of the angle error in the Lyapunov function; 1 in the paper.
        weight: (R) "1/s²", (at least 0), typical 0.0 to 5.0, default 1.0;
        /// λ, of the integral of the angle error.
        integral: (R) "1/s²", (at least 0), typical 0.0 to 50.0, default 10.0;
    }
}

/// The law at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntegralBackstepping<R> {
    gains: PerAxis<IntegralGains<R>>,
    sample_time: R,
    /// χ \[rad s\].
    integral: PerAxis<R>,
}

impl<R: Real> IntegralBackstepping<R> {
    /// With an empty integral; `sample_time` \[s\].
    pub fn new(gains: PerAxis<IntegralGains<R>>, sample_time: R) -> Self {
        Self { gains, sample_time, integral: PerAxis::zero() }
    }
}

/// \[rad/s²\] What one axis' error, its rate and its integral ask for.
#[inline(always)]
fn accel<R: Real>(g: &IntegralGains<R>, error: R, slope: R, integral: R) -> R {
    let rate_error = slope + g.position * error + g.integral * integral;
    g.position * slope + (g.weight + g.integral) * error + g.rate * rate_error
}

impl<R: Real> ControlLaw<R> for IntegralBackstepping<R> {
    type Gains = PerAxis<IntegralGains<R>>;

    fn start(gains: Self::Gains, _effectiveness: Effectiveness<R>, sample_time: R) -> Self {
        Self::new(gains, sample_time)
    }

    fn integrates(gains: &Self::Gains) -> R::Mask {
        R::zero().lt(gains.pitch.integral + gains.yaw.integral)
    }

    #[inline(always)]
    fn torque(&mut self, now: &Situation<'_, R>) -> PerAxis<R> {
        let (error, slope) = (now.angle_error(), now.rate_error());
        let PerAxis { pitch, yaw } = self.gains;
        let feedback = PerAxis {
            pitch: accel(&pitch, error.pitch, slope.pitch, self.integral.pitch),
            yaw: accel(&yaw, error.yaw, slope.yaw, self.integral.yaw),
        };
        now.dynamics.torque(now.reference.accel.plus(feedback))
    }

    #[inline(always)]
    fn restart(&mut self) {
        self.integral = PerAxis::zero();
    }

    #[inline(always)]
    fn settle(&mut self, now: &Situation<'_, R>, allocation: &Allocation<R>) {
        let gained = now.measured_error().scaled(self.sample_time);
        self.integral = self.integral.zip(
            gained,
            #[inline(always)]
            |z, e| integrated(z, e, allocation.clipped()),
        );
    }
}
