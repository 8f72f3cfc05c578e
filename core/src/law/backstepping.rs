//! The backstepping law of "Backstepping control of Quanser's 2-DOF Helicopter under disturbance and actuator
//! saturation based on Flower Pollination Algorithm", eqs (12)-(27).
//!
//! Per axis, with ξ_a = x_d - x (12), virtual rate x_2d = ẋ_d + μ_a ξ_a (16) and ξ_b = x_2d - ẋ (17), the
//! function M = (ξ_a² + ξ_b²)/2 (18) falls by Ṁ = -μ_a ξ_a² - μ_b ξ_b² under eqs (26)-(27), as long as no
//! voltage clips, the model is exact and nothing disturbs. Substituting shows what it is: computed torque
//! with a PD law of K_p = 1 + μ_a μ_b and K_d = μ_a + μ_b. It has no integral, so a constant disturbance
//! leaves an offset.
//!
//! We differ from the paper in one term: opposing torque includes K_sp sin θ where the rig has it.

use super::{ControlLaw, Situation};
use crate::axes::PerAxis;
use crate::estimator::Estimate;
use crate::gains::{AxisGains, Gains};
use crate::plant::Effectiveness;
use crate::real::{Mask, Real};
use crate::reference::Reference;

/// Eqs (26)-(27).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Backstepping<R> {
    gains: Gains<R>,
}

/// The two errors of each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors<R> {
    /// \[rad\] ξ1, ξ3: reference minus actual.
    pub angle: PerAxis<R>,
    /// \[rad/s\] ξ2, ξ4: virtual rate minus actual.
    pub rate: PerAxis<R>,
}

impl<R: Real> Errors<R> {
    /// M of eq. (18), both axes: (ξ1² + ξ2² + ξ3² + ξ4²)/2.
    pub fn lyapunov(&self) -> R {
        let square = |x: R| x * x;
        let sum = |e: PerAxis<R>| square(e.pitch) + square(e.yaw);
        R::from_f64(0.5) * (sum(self.angle) + sum(self.rate))
    }
}

impl<R: Real> Backstepping<R> {
    /// With these gains \[1/s\].
    pub fn new(gains: Gains<R>) -> Self {
        Self { gains }
    }

    /// ξ1..ξ4 of eqs (12) and (17).
    #[inline(always)]
    pub fn errors(&self, estimate: &Estimate<R>, reference: &Reference<R>) -> Errors<R> {
        let angle = reference.angle.minus(estimate.state.angle);
        let virtual_rate = reference.rate.plus(self.gains.zip(angle, |g, e| g.position * e));
        Errors { angle, rate: virtual_rate.minus(estimate.state.rate) }
    }
}

/// \[rad/s²\] ẍ_d + μ_a ξ̇_a + ξ_a + μ_b ξ_b, the bracket of eqs (26)-(27).
#[inline(always)]
fn accel<R: Real>(accel: R, g: &AxisGains<R>, angle_error: R, its_rate: R, rate_error: R) -> R {
    accel + g.position * its_rate + angle_error + g.rate * rate_error
}

impl<R: Real> ControlLaw<R> for Backstepping<R> {
    type Gains = Gains<R>;

    fn start(gains: Self::Gains, _effectiveness: Effectiveness<R>, _sample_time: R) -> Self {
        Self::new(gains)
    }

    fn integrates(_gains: &Self::Gains) -> R::Mask {
        R::Mask::splat(false)
    }

    #[inline(always)]
    fn torque(&mut self, now: &Situation<'_, R>) -> PerAxis<R> {
        let reference = &now.reference;
        let errors = self.errors(&now.estimate, reference);
        let rate_of_angle_error = now.rate_error();
        now.dynamics.torque(PerAxis {
            pitch: accel(
                reference.accel.pitch,
                &self.gains.pitch,
                errors.angle.pitch,
                rate_of_angle_error.pitch,
                errors.rate.pitch,
            ),
            yaw: accel(
                reference.accel.yaw,
                &self.gains.yaw,
                errors.angle.yaw,
                rate_of_angle_error.yaw,
                errors.rate.yaw,
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::Belief;
    use crate::gains;
    use crate::plant::{RigidBody, State, presets};
    use proptest::prelude::*;

    fn pair(range: core::ops::Range<f64>) -> impl Strategy<Value = PerAxis<f64>> {
        (range.clone(), range).prop_map(|(p, y)| PerAxis::new(p, y))
    }

    proptest! {
        /// Eqs (26)-(27) give Ṁ = -μ1 ξ1² - μ2 ξ2² - μ3 ξ3² - μ4 ξ4² exactly, with an exact model.
        #[test]
        fn the_lyapunov_function_falls_as_designed(
            k in prop::array::uniform4(0.5..30.0_f64),
            angle in pair(-1.0..1.0), rate in pair(-3.0..3.0),
            want in pair(-1.0..1.0), want_rate in pair(-1.0..1.0), want_accel in pair(-2.0..2.0),
        ) {
            for (_, rig) in presets::ALL {
                let body = RigidBody::new(&rig.plant);
                let mut law = Backstepping::new(Gains::from_paper_order(k));
                let estimate = Estimate::exact(State { angle, rate });
                let reference = Reference { angle: want, rate: want_rate, accel: want_accel };
                let torque = law.torque(&Situation::new(&body, Belief::new(&body, estimate), reference));
                let accel = body.at(&estimate.state).accel(torque);

                let e = law.errors(&estimate, &reference);
                let [x1, x3] = e.angle.to_array();
                let [x2, x4] = e.rate.to_array();
                let slope1 = want_rate.minus(rate);
                let [m1, m2, m3, m4] = k;
                let d2 = want_accel.pitch + m1 * slope1.pitch - accel.pitch;
                let d4 = want_accel.yaw + m3 * slope1.yaw - accel.yaw;
                let falling = x1 * slope1.pitch + x2 * d2 + x3 * slope1.yaw + x4 * d4;
                let designed = -(m1 * x1 * x1 + m2 * x2 * x2 + m3 * x3 * x3 + m4 * x4 * x4);
                prop_assert!((falling - designed).abs() <= 1e-9 * (1.0 + designed.abs()));
            }
        }

        /// The law is symmetric in the two gains of an axis.
        #[test]
        fn swapping_the_gains_of_an_axis_changes_nothing(
            angle in pair(-1.0..1.0), rate in pair(-3.0..3.0), want in pair(-1.0..1.0),
        ) {
            let body = RigidBody::new(&presets::PAPER.plant);
            let [a, b, c, d] = gains::PAPER.to_paper_order();
            let estimate = Estimate::exact(State { angle, rate });
            let reference = Reference::at_rest(want);
            let now = Situation::new(&body, Belief::new(&body, estimate), reference);
            let torque = |k| Backstepping::new(Gains::from_paper_order(k)).torque(&now);
            let (one, other) = (torque([a, b, c, d]), torque([b, a, d, c]));
            prop_assert!((one.pitch - other.pitch).abs() < 1e-12);
            prop_assert!((one.yaw - other.yaw).abs() < 1e-12);
        }
    }

    #[test]
    fn at_the_goal_the_law_holds_the_weight() {
        let body = RigidBody::new(&presets::PAPER.plant);
        let angle = PerAxis::new(0.3, -0.5);
        let mut law = Backstepping::new(gains::PAPER);
        let (estimate, reference) = (Estimate::exact(State::at_rest(angle)), Reference::at_rest(angle));
        let torque = law.torque(&Situation::new(&body, Belief::new(&body, estimate), reference));
        assert!((torque.pitch - 1.075 * 9.8 * 0.002 * 0.3_f64.cos()).abs() < 1e-15);
        assert_eq!(torque.yaw, 0.0);
    }
}
