//! What every law must do, and what each is said to be.

use super::*;
use crate::gains::{self, AxisGains};
use crate::plant::presets;
use proptest::prelude::*;

fn pair(range: core::ops::Range<f64>) -> impl Strategy<Value = PerAxis<f64>> {
    (range.clone(), range).prop_map(|(p, y)| PerAxis::new(p, y))
}

const T: f64 = 1e-3;

fn integral(gains: AxisGains<f64>, weight: f64, integral: f64) -> IntegralGains<f64> {
    IntegralGains { position: gains.position, rate: gains.rate, weight, integral }
}

proptest! {
    #[test]
    fn without_integral_and_with_weight_one_it_is_the_papers_law(
        angle in pair(-1.0..1.0), rate in pair(-3.0..3.0), want in pair(-1.0..1.0), accel in pair(-2.0..2.0),
    ) {
        let body = RigidBody::new(&presets::PAPER.plant);
        let estimate = Estimate::exact(State { angle, rate });
        let reference = Reference { angle: want, rate: PerAxis::new(0.3, -0.2), accel };
        let now = Situation::new(&body, Belief::new(&body, estimate), reference);
        let paper = Backstepping::new(gains::PAPER).torque(&now);
        let ours = IntegralBackstepping::new(gains::PAPER.map(|g| integral(g, 1.0, 0.0)), T).torque(&now);
        prop_assert!((paper.pitch - ours.pitch).abs() < 1e-12 && (paper.yaw - ours.yaw).abs() < 1e-12);
    }

    /// M = (γ λ χ² + γ ξ_a² + ξ_b²)/2 falls by γ μ_a ξ_a² + μ_b ξ_b².
    #[test]
    fn the_integral_laws_lyapunov_function_falls_as_designed(
        [position, rate_gain, weight, lambda] in prop::array::uniform4(0.1..30.0_f64),
        angle in pair(-1.0..1.0), rate in pair(-3.0..3.0),
        want in pair(-1.0..1.0), history in pair(-0.2..0.2),
    ) {
        for (_, rig) in presets::ALL {
            let body = RigidBody::new(&rig.plant);
            let g = integral(AxisGains { position, rate: rate_gain }, weight, lambda);
            let mut law = IntegralBackstepping::new(PerAxis::both(g), 1.0);
            let estimate = Estimate::exact(State { angle, rate });
            // One step of 1 s with these errors makes the integral what the test wants it to be.
            let past = Reference::at_rest(angle.plus(history));
            law.settle(&Situation::new(&body, Belief::new(&body, estimate), past), &Allocation::none());
            let reference = Reference::at_rest(want);
            let now = Situation::new(&body, Belief::new(&body, estimate), reference);
            let accel = now.dynamics.accel(law.torque(&now)).to_array();
            let (chi, xa, v) = (history.to_array(), now.angle_error().to_array(), rate.to_array());
            for k in 0..2 {
                let slope = -v[k];
                let xb = slope + position * xa[k] + lambda * chi[k];
                let xb_slope = -accel[k] + position * slope + lambda * xa[k];
                let falling = weight * lambda * chi[k] * xa[k] + weight * xa[k] * slope + xb * xb_slope;
                let designed = -(weight * position * xa[k] * xa[k] + rate_gain * xb * xb);
                prop_assert!((falling - designed).abs() <= 1e-9 * (1.0 + designed.abs() + weight * lambda));
            }
        }
    }
}

fn every_integrating_law() -> [LawSettings<f64>; 4] {
    let pid = PidGains { proportional: 80.0, integral: 120.0, derivative: 20.0 };
    let twisting = SuperTwistingGains { surface: 4.0, proportional: 8.0, integral: 30.0, width: 0.3 };
    // PI-like volts on the Aero: the inverse of its thrust gains times inertia, times the PID's gains.
    let k = presets::AERO.plant.effectiveness;
    let inverse = PerMotor {
        main: PerAxis::new(k.tail_on_yaw, -k.tail_on_pitch),
        tail: PerAxis::new(-k.main_on_yaw, k.main_on_pitch),
    };
    let matrix = |gain: f64| inverse.map(|row| row.map(|x| x / k.determinant() * 0.022 * gain));
    [
        LawSettings::IntegralBackstepping(PerAxis::both(IntegralGains {
            position: 6.0,
            rate: 12.0,
            weight: 1.0,
            integral: 12.0,
        })),
        LawSettings::Pid(PerAxis::both(pid)),
        LawSettings::SuperTwisting(PerAxis::both(twisting)),
        LawSettings::StateFeedback(StateFeedbackGains {
            angle: matrix(80.0),
            rate: matrix(20.0),
            integral: matrix(120.0),
            integral_limit: 20.0,
            feed_forward: true,
        }),
    ]
}

use crate::axes::PerMotor;

/// Every law that integrates holds the goal against a constant push, on a rig without lag.
#[test]
fn a_constant_disturbance_leaves_no_offset() {
    let rig = presets::AERO;
    let body = RigidBody::new(&rig.plant);
    let goal = Reference::at_rest(PerAxis::new(0.2, -0.4));
    let push = PerAxis::new(0.004, -0.003);
    for settings in every_integrating_law() {
        let mut law = Law::new(&settings, rig.plant.effectiveness, T);
        let mut state = State::<f64>::default();
        for _ in 0..20_000 {
            let estimate = Estimate::exact(state);
            let now = Situation::new(&body, Belief::new(&body, estimate), goal);
            let torque = law.torque(&now).plus(push);
            let accel = now.dynamics.accel(torque);
            law.settle(&now, &Allocation::none());
            state.rate = state.rate.plus(accel.scaled(T));
            state.angle = state.angle.plus(state.rate.scaled(T));
        }
        let error = goal.angle.minus(state.angle);
        assert!(error.pitch.abs() < 1e-5 && error.yaw.abs() < 1e-5, "{settings:?} {error:?}");
    }
}

#[test]
fn what_is_fed_forward_holds_the_reference() {
    let body = RigidBody::new(&presets::HELI.plant);
    let goal = PerAxis::new(0.2, 0.0);
    let (estimate, reference) = (Estimate::exact(State::at_rest(goal)), Reference::at_rest(goal));
    let now = Situation::new(&body, Belief::new(&body, estimate), reference);
    assert_eq!(now.feed_forward(), now.dynamics.opposing);
}
