//! What rotors do to a body that tilts with them, beside eqs (1)-(2).
//!
//! # Equations
//!
//! The main rotor's axis is the body's vertical one, so it turns in space by ω = Ω + ψ̇ cos θ; the tail rotor's
//! lies along the pitch axis, so it turns by Ω + θ̇. With H = J Ω, the main rotor's angular momentum, Lagrange's
//! equations (Goldstein, *Classical Mechanics*, 2nd ed., 1.4) of the term H ψ̇ cos θ in the kinetic energy give
//!
//! ```text
//! on pitch:  -H sin θ ψ̇
//! on yaw:     H sin θ θ̇ - Ḣ cos θ
//! ```
//!
//! The first two, the gyroscopic torques, do no work between them; the last is the reaction of a rotor that
//! speeds up. The tail rotor's thrust is level and acts on an arm of cos θ, and the main rotor's drag torque
//! has cos θ of itself about the vertical: all that the rotors do to yaw goes with cos θ.

use super::{PlantParameters, RotorEffect};
use crate::axes::PerAxis;
use crate::real::{Mask, Real};

/// Constants of these torques.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tilt<R> {
    /// \[N m s/V\] H for each volt in effect.
    momentum: R,
    /// \[-\] 1 for cos θ, 0 for none of it.
    thrust: R,
}

impl<R: Real> Tilt<R> {
    /// None where none of them is there: then a torque keeps its bits.
    pub(super) fn of(parameters: &PlantParameters<R>) -> Option<Self> {
        let PlantParameters { rotor_momentum, tilting_thrust, .. } = *parameters;
        let there = R::zero().lt(rotor_momentum.abs()) | R::zero().lt(tilting_thrust.abs());
        there.any().then_some(Self { momentum: rotor_momentum, thrust: tilting_thrust })
    }

    /// \[N m\] Of the rotors on the body, with sine and cosine of its pitch, at `rate` \[rad/s\].
    #[inline(always)]
    pub(super) fn torque(
        &self,
        effect: RotorEffect<R>,
        (sine, cosine): (R, R),
        rate: PerAxis<R>,
    ) -> PerAxis<R> {
        let gyroscopic = self.momentum * effect.main_volts * sine;
        let part = R::one() + self.thrust * (cosine - R::one());
        PerAxis {
            pitch: effect.torque.pitch - gyroscopic * rate.yaw,
            yaw: effect.torque.yaw * part + gyroscopic * rate.pitch,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::axes::{PerAxis, PerMotor};
    use crate::plant::{Effectiveness, PlantParameters, RealPlant, State, presets};

    /// Everything that tilts, and a centre of mass so far out that m L² matters.
    fn tilting() -> PlantParameters<f64> {
        PlantParameters {
            center_of_mass: 0.05,
            coulomb_friction: PerAxis::zero(),
            tilting_inertia: 0.0146,
            rotor_momentum: 7.1e-4,
            tilting_thrust: 1.0,
            ..presets::AERO_LAB.plant
        }
    }

    /// \[kg m²\] I_yy + m L² cos² θ - J sin² θ.
    fn yaw_inertia(p: &PlantParameters<f64>, pitch: f64) -> f64 {
        let (sine, cosine) = (libm::sin(pitch), libm::cos(pitch));
        let square = p.mass * p.center_of_mass * p.center_of_mass;
        p.inertia.yaw + square * cosine * cosine - p.tilting_inertia * sine * sine
    }

    /// \[J\] Of body and weight; the rotors' own spin is the motors' affair.
    fn energy(p: &PlantParameters<f64>, s: &State<f64>) -> f64 {
        let (sine, cosine) = (libm::sin(s.angle.pitch), libm::cos(s.angle.pitch));
        let square = p.mass * p.center_of_mass * p.center_of_mass;
        0.5 * (p.inertia.pitch + square) * s.rate.pitch * s.rate.pitch
            + 0.5 * yaw_inertia(p, s.angle.pitch) * s.rate.yaw * s.rate.yaw
            + p.mass * p.gravity * p.center_of_mass * sine
            - p.stiffness * cosine
    }

    /// Rotors that only turn, on a body that nothing brakes: the gyroscopic torques do no work, and what the
    /// body gains about the vertical the rotor has lost, also while it speeds up.
    #[test]
    fn turning_rotors_do_no_work_and_keep_the_momentum() {
        let p = PlantParameters {
            damping: PerAxis::zero(),
            effectiveness: Effectiveness::zero(),
            quadratic_effectiveness: Effectiveness::zero(),
            rotor_reaction: PerMotor::new(-7.1e-4, 0.0),
            ..tilting()
        };
        let start = State { angle: PerAxis::new(0.4, 0.1), rate: PerAxis::new(-0.7, 2.0) };
        let momentum = |plant: &RealPlant<f64>| {
            let s = plant.state();
            yaw_inertia(&p, s.angle.pitch) * s.rate.yaw
                + p.rotor_momentum * plant.rotor_volts().main * libm::cos(s.angle.pitch)
        };
        for (turning, volts) in [(15.0, 15.0), (0.0, 20.0)] {
            let mut plant = RealPlant::<f64>::new(&p, start, 1e-3);
            plant.set_rotors(PerMotor::new(turning, -8.0));
            let before = momentum(&plant);
            (0..10_000).for_each(|_| plant.advance(PerMotor::new(volts, -8.0), PerMotor::zero()));
            let end = plant.state();
            assert!((end.angle.yaw - start.angle.yaw).abs() > 1.0, "it moved: {end:?}");
            assert!((momentum(&plant) - before).abs() < 1e-9, "{}", momentum(&plant) - before);
            let gained = energy(&p, &end) - energy(&p, &start);
            if turning == volts {
                assert!(gained.abs() < 1e-8, "{gained}");
            } else {
                assert!(gained.abs() > 1e-4, "a rotor that speeds up works on the body: {gained}");
            }
        }
    }

    /// The body's energy is the rotors' work, by closed forms of their torque, without what friction takes.
    #[test]
    fn energy_is_what_the_rotors_gave_without_what_friction_took() {
        let p = PlantParameters { damping: PerAxis::new(0.004, 0.006), ..tilting() };
        let start = State { angle: PerAxis::new(0.3, 0.0), rate: PerAxis::new(0.2, 3.0) };
        let (volts, h) = (PerMotor::new(11.0, -9.0), 1e-4);
        let mut plant = RealPlant::<f64>::new(&p, start, h);
        let power = |plant: &RealPlant<f64>| {
            let (s, v) = (plant.state(), plant.rotor_volts());
            let k = |linear: f64, quadratic: f64, v: f64| linear * v + quadratic * v * v.abs();
            let (a, b) = (p.effectiveness, p.quadratic_effectiveness);
            let spin = volts.minus(v).zip(p.rotor_time_constant, |dv, tau| dv / tau);
            let pitch = k(a.main_on_pitch, b.main_on_pitch, v.main)
                + k(a.tail_on_pitch, b.tail_on_pitch, v.tail)
                + p.rotor_reaction.tail * spin.tail;
            let yaw = k(a.main_on_yaw, b.main_on_yaw, v.main)
                + k(a.tail_on_yaw, b.tail_on_yaw, v.tail)
                + p.rotor_reaction.main * spin.main;
            let given = pitch * s.rate.pitch + libm::cos(s.angle.pitch) * yaw * s.rate.yaw;
            let taken =
                p.damping.pitch * s.rate.pitch * s.rate.pitch + p.damping.yaw * s.rate.yaw * s.rate.yaw;
            (given - taken, taken)
        };
        let (mut work, mut lost, mut before) = (0.0, 0.0, power(&plant));
        for _ in 0..20_000 {
            plant.advance(volts, PerMotor::zero());
            let now = power(&plant);
            work += 0.5 * h * (before.0 + now.0);
            lost += 0.5 * h * (before.1 + now.1);
            before = now;
        }
        let gained = energy(&p, &plant.state()) - energy(&p, &start);
        assert!(lost > 0.02 && gained.abs() > 0.01, "there is something to balance: {gained} {lost}");
        assert!((gained - work).abs() < 1e-7, "{gained} {work}");
    }

    /// At 30° a body that is all arm has lost a quarter of its yaw inertia, and turning at 1 rad/s it pulls
    /// itself level with J sin θ cos θ.
    #[test]
    fn an_arm_that_turns_pulls_itself_level() {
        let p = PlantParameters { center_of_mass: 0.0, tilting_inertia: 0.0219, ..presets::AERO.plant };
        let pitch = 30.0 * crate::DEGREE;
        let state = State { angle: PerAxis::new(pitch, 0.0), rate: PerAxis::new(0.0, 1.0) };
        let at = crate::plant::RigidBody::new(&p).at(&state);
        assert!((at.inertia.yaw - (p.inertia.yaw - 0.25 * 0.0219)).abs() < 1e-15);
        let pulls = 0.0219 * 0.5 * libm::cos(pitch);
        assert!((at.opposing.pitch - p.stiffness * 0.5 - pulls).abs() < 1e-12, "{at:?}");
    }
}
