//! The law against others, against its own definition, and against what it must not do.

use super::*;
use crate::estimator::{Belief, Estimate};
use crate::law::{Law, LawSettings, MotorGains, StateFeedback, StateFeedbackGains};
use crate::plant::presets;
use proptest::prelude::*;

const T: f64 = 1e-3;

fn pair(range: core::ops::Range<f64>) -> impl Strategy<Value = PerAxis<f64>> {
    (range.clone(), range).prop_map(|(p, y)| PerAxis::new(p, y))
}

fn matrix() -> impl Strategy<Value = MotorGains<f64>> {
    prop::array::uniform4(-100.0..100.0_f64)
        .prop_map(|[a, b, c, d]| PerMotor { main: PerAxis::new(a, b), tail: PerAxis::new(c, d) })
}

/// State feedback with integrals as matrices: a state for each motor's integral.
fn as_matrices(gains: &StateFeedbackGains<f64>) -> StateSpaceGains<f64> {
    let mut law = StateSpaceGains::none();
    (law.states, law.inputs) = (2, 4);
    law.signals =
        [Signal::AngleErrorPitch, Signal::AngleErrorYaw, Signal::RateErrorPitch, Signal::RateErrorYaw];
    law.feed_forward = gains.feed_forward;
    let row = |angle: PerAxis<f64>, rate: PerAxis<f64>| [angle.pitch, angle.yaw, rate.pitch, rate.yaw];
    law.d = PerMotor {
        main: row(gains.angle.main, gains.rate.main),
        tail: row(gains.angle.tail, gains.rate.tail),
    };
    for (k, integral) in [gains.integral.main, gains.integral.tail].into_iter().enumerate() {
        law.a[k][k] = 1.0;
        law.b[k] = row(integral.scaled(T), PerAxis::zero());
    }
    (law.c.main[0], law.c.tail[1]) = (1.0, 1.0);
    law
}

proptest! {
    /// The same controller written as gains and as matrices asks for the same torque, tick by tick.
    #[test]
    fn state_feedback_as_matrices_is_state_feedback(
        (angle, rate, integral) in (matrix(), matrix(), matrix()), feed_forward in any::<bool>(),
        flight in prop::collection::vec((pair(-0.5..0.5), pair(-2.0..2.0), pair(-0.5..0.5)), 1..40),
    ) {
        let rig = presets::AERO2;
        let body = RigidBody::new(&rig.plant);
        let gains = StateFeedbackGains { angle, rate, integral, integral_limit: 1e9, feed_forward };
        let mut one = StateFeedback::new(gains, rig.plant.effectiveness, T);
        let mut other = StateSpace::new(as_matrices(&gains), rig.plant.effectiveness);
        for (angle, rate, want) in flight {
            let estimate = Estimate::exact(State { angle, rate });
            let now = Situation::new(&body, Belief::new(&body, estimate), Reference::at_rest(want));
            let (a, b) = (one.torque(&now), other.torque(&now));
            let scale = 1.0 + a.pitch.abs() + a.yaw.abs();
            prop_assert!((a.pitch - b.pitch).abs() < 1e-12 * scale, "{a:?} {b:?}");
            prop_assert!((a.yaw - b.yaw).abs() < 1e-12 * scale, "{a:?} {b:?}");
            one.settle(&now, &Allocation::none());
            other.settle(&now, &Allocation::none());
        }
    }

    /// x⁺ = A x + B u + L (given - asked), y = C x + D u, all of eight states and four inputs, as the
    /// definition has it.
    #[test]
    fn a_tick_is_its_definition(seed in prop::collection::vec(-1.0..1.0_f64, 64 + 32 + 16 + 8 + 16 + 4)) {
        let mut numbers = seed.into_iter();
        let mut next = || numbers.next().unwrap();
        let mut gains = StateSpaceGains::none();
        (gains.states, gains.inputs, gains.corrected, gains.feed_forward) = (8, 4, true, false);
        gains.signals =
            [Signal::AnglePitch, Signal::RateYaw, Signal::ReferencePitch, Signal::ReferenceRateYaw];
        gains.a = core::array::from_fn(|_| core::array::from_fn(|_| next()));
        gains.b = core::array::from_fn(|_| core::array::from_fn(|_| next()));
        gains.c = PerMotor { main: core::array::from_fn(|_| next()), tail: core::array::from_fn(|_| next()) };
        gains.d = PerMotor { main: core::array::from_fn(|_| next()), tail: core::array::from_fn(|_| next()) };
        gains.anti_windup = core::array::from_fn(|_| PerMotor::new(next(), next()));
        let u = [next(), next(), next(), next()];
        let rig = presets::AERO;
        let body = RigidBody::new(&rig.plant);
        let state = State { angle: PerAxis::new(u[0], 0.3), rate: PerAxis::new(0.2, u[1]) };
        let (angle, rate) = (PerAxis::new(u[2], 0.1), PerAxis::new(-0.4, u[3]));
        let reference = Reference { angle, rate, accel: PerAxis::zero() };
        let now = Situation::new(&body, Belief::new(&body, Estimate::exact(state)), reference);
        let mut law = StateSpace::new(gains, rig.plant.effectiveness);
        let mut x = [0.0; 8];
        let dot = |row: &[f64], values: &[f64]| row.iter().zip(values).map(|(a, b)| a * b).sum::<f64>();
        for _ in 0..5 {
            let y = PerMotor {
                main: dot(&gains.c.main, &x) + dot(&gains.d.main, &u),
                tail: dot(&gains.c.tail, &x) + dot(&gains.d.tail, &u),
            };
            let (torque, expected) = (law.torque(&now), rig.plant.effectiveness.torque(y));
            prop_assert!((torque.pitch - expected.pitch).abs() < 1e-12, "{torque:?} {expected:?}");
            prop_assert!((torque.yaw - expected.yaw).abs() < 1e-12);
            let given = Allocation { volts: PerMotor::new(1.0, -2.0), demand: PerMotor::new(1.5, -2.25) };
            law.settle(&now, &given);
            x = core::array::from_fn(|k| {
                let gain = gains.anti_windup[k];
                dot(&gains.a[k], &x) + dot(&gains.b[k], &u) - 0.5 * gain.main + 0.25 * gain.tail
            });
            for (a, b) in law.state().iter().zip(x) {
                prop_assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()));
            }
        }
    }
}

/// An integral of each error, in volts.
fn integrals() -> StateSpaceGains<f64> {
    as_matrices(&StateFeedbackGains {
        angle: PerMotor::both(PerAxis::zero()),
        rate: PerMotor::both(PerAxis::zero()),
        integral: PerMotor { main: PerAxis::new(10.0, 0.0), tail: PerAxis::new(0.0, 10.0) },
        integral_limit: 0.0,
        feed_forward: false,
    })
}

/// Ticks at rest at the level pose with that goal.
fn settle(law: &mut StateSpace<f64>, goal: PerAxis<f64>, given: &Allocation<f64>, ticks: usize) {
    let body = RigidBody::new(&presets::AERO2.plant);
    let belief = Belief::new(&body, Estimate::exact(State::default()));
    let now = Situation::new(&body, belief, Reference::at_rest(goal));
    for _ in 0..ticks {
        law.torque(&now);
        law.settle(&now, given);
    }
}

#[test]
fn held_while_volts_clip_the_state_only_moves_back() {
    let mut law = StateSpace::new(integrals(), presets::AERO2.plant.effectiveness);
    let clipped = Allocation { volts: PerMotor::new(18.0, 0.0), demand: PerMotor::new(20.0, 0.0) };
    settle(&mut law, PerAxis::new(0.1, 0.0), &Allocation::none(), 1_000);
    let full = law.state()[0];
    assert!((full - 1.0).abs() < 1e-9, "{full}");
    settle(&mut law, PerAxis::new(0.1, 0.0), &clipped, 1_000);
    assert_eq!(law.state()[0], full, "what clips is not asked for more of");
    settle(&mut law, PerAxis::new(-0.1, 0.0), &clipped, 500);
    assert!((law.state()[0] - 0.5).abs() < 1e-9, "and may fall: {}", law.state()[0]);
}

/// The law's own saturation clips too: what it took counts as not given.
#[test]
fn the_laws_own_saturation_limits_its_volts_and_what_winds_up() {
    let effectiveness = presets::AERO2.plant.effectiveness;
    let mut gains = integrals();
    gains.saturation = PerMotor::new(0.25, 9.0);
    let mut law = StateSpace::new(gains, effectiveness);
    settle(&mut law, PerAxis::new(0.1, 0.1), &Allocation::none(), 5_000);
    assert!((0.25..0.252).contains(&law.state()[0]), "{:?}", law.state());
    let body = RigidBody::new(&presets::AERO2.plant);
    let belief = Belief::new(&body, Estimate::exact(State::default()));
    let torque = law.torque(&Situation::new(&body, belief, Reference::default()));
    let expected = effectiveness.torque(PerMotor::new(0.25, law.state()[1]));
    assert!((torque.pitch - expected.pitch).abs() < 1e-15 && (torque.yaw - expected.yaw).abs() < 1e-15);

    // With a matrix of its own the state is led back to what was given: x⁺ = x + e + L (given - asked).
    gains.corrected = true;
    gains.anti_windup[0].main = 0.1;
    let mut law = StateSpace::new(gains, effectiveness);
    settle(&mut law, PerAxis::new(0.1, 0.0), &Allocation::none(), 5_000);
    let rest = 0.25 + 0.001 / 0.1;
    assert!((law.state()[0] - rest).abs() < 1e-9, "{} for {rest}", law.state()[0]);
}

#[test]
fn a_restart_forgets_everything() {
    let mut law = StateSpace::new(integrals(), presets::AERO2.plant.effectiveness);
    let new = law;
    settle(&mut law, PerAxis::new(0.1, 0.2), &Allocation::none(), 10);
    assert_ne!(law, new);
    law.restart();
    assert_eq!(law, new);
}

/// Where a law saturates by itself, what is not finite stays so, in the tick and in what it remembers: the
/// allocation then gives zero volts and a fault.
#[test]
fn what_is_not_finite_stays_so_through_the_saturation() {
    let mut gains = integrals();
    gains.saturation = PerMotor::both(5.0);
    (gains.d.main[0], gains.d.tail[1]) = (1.0, 1.0);
    let body = RigidBody::new(&presets::AERO2.plant);
    let seen = |angle| {
        let belief = Belief::new(&body, Estimate::exact(State::at_rest(angle)));
        Situation::new(&body, belief, Reference::default())
    };
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut law = StateSpace::new(gains, presets::AERO2.plant.effectiveness);
        for now in [seen(PerAxis::new(bad, 0.0)), seen(PerAxis::zero())] {
            let torque = law.torque(&now);
            assert!(!torque.pitch.is_finite(), "{bad}: {torque:?}");
            law.settle(&now, &Allocation::none());
        }
    }
}

#[test]
fn counts_and_numbers_out_of_range_are_refused_by_name() {
    type Spoil = fn(&mut StateSpaceGains<f64>);
    let cases: [(Spoil, &str, &str); 9] = [
        (|g| g.states = 9, "states", "0 to 8"),
        (|g| g.inputs = 0, "inputs", "1 to 4"),
        (|g| g.inputs = u32::MAX, "inputs", "1 to 4"),
        (|g| g.saturation.tail = 0.0, "saturation", "a finite number above 0"),
        (|g| g.a[7][0] = f64::NAN, "A", "a finite number of at most 1e9 in size"),
        (|g| g.b[1][3] = 2e9, "B", "a finite number of at most 1e9 in size"),
        (|g| g.c.tail[0] = f64::INFINITY, "C", "a finite number of at most 1e9 in size"),
        (|g| g.d.main[2] = -2e9, "D", "a finite number of at most 1e9 in size"),
        (|g| g.anti_windup[3].tail = f64::NAN, "anti_windup", "a finite number of at most 1e9 in size"),
    ];
    for (spoil, field, allowed) in cases {
        let mut gains = integrals();
        assert_eq!(gains.validate(), Ok(()));
        spoil(&mut gains);
        let told = gains.validate().unwrap_err();
        assert_eq!((told.field, told.allowed), (field, allowed));
        let controller = crate::controller::ControllerSettings {
            law: LawSettings::StateSpace(gains),
            ..crate::defaults::AERO2
        };
        assert_eq!(controller.validate().unwrap_err().field, field);
    }
}

/// Every signal has a name of its own, and is what it says.
#[test]
fn every_signal_is_what_its_name_says() {
    let body = RigidBody::new(&presets::AERO2.plant);
    let seen = Seen {
        model: &body,
        measured: PerAxis::new(1.0, 2.0),
        rate: PerAxis::new(4.0, 8.0),
        reference: Reference {
            angle: PerAxis::new(16.0, 32.0),
            rate: PerAxis::new(64.0, 128.0),
            accel: PerAxis::zero(),
        },
    };
    let found: std::vec::Vec<(&str, f64)> =
        Signal::ALL.iter().map(|(name, signal)| (*name, signal.of(&seen))).collect();
    let expected = [
        ("angle_error.pitch", 15.0),
        ("angle_error.yaw", 30.0),
        ("rate_error.pitch", 60.0),
        ("rate_error.yaw", 120.0),
        ("angle.pitch", 1.0),
        ("angle.yaw", 2.0),
        ("rate.pitch", 4.0),
        ("rate.yaw", 8.0),
        ("reference.pitch", 16.0),
        ("reference.yaw", 32.0),
        ("reference_rate.pitch", 64.0),
        ("reference_rate.yaw", 128.0),
    ];
    assert_eq!(found, expected);
}

/// What a choice begins with asks for what the model needs, and no more.
#[test]
fn the_default_is_the_feed_forward() {
    let settings = LawSettings::<f64>::named("state-space").unwrap();
    let body = RigidBody::new(&presets::HELI.plant);
    let belief = Belief::new(&body, Estimate::exact(State::default()));
    let now = Situation::new(&body, belief, Reference::at_rest(PerAxis::new(0.2, 0.0)));
    let mut law = Law::new(&settings, presets::HELI.plant.effectiveness, T);
    assert_eq!(law.torque(&now), now.feed_forward());
}
