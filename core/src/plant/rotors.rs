//! From volts applied to torque on the body: rotor lag, thrust, reaction torque.
//!
//! The paper's rotors answer at once and in proportion (eqs (5)-(6)). Real ones lag by a first-order time
//! constant of .05 to .16 s, thrust grows with the square of the speed, and a motor that accelerates its
//! rotor turns the body the other way at once. Volts are held over a step, so the lag has an exact solution
//! and costs the integrator no state.

use super::lag::{RotorTorque, decay, follow};
use super::{Effectiveness, PlantParameters};
use crate::axes::{PerAxis, PerMotor};
use crate::real::Real;

/// What the rotors do to a level body at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotorEffect<R> {
    /// \[N m\] Thrust and reaction.
    pub torque: PerAxis<R>,
    /// \[V\] In effect at the main rotor: what its speed goes with.
    pub main_volts: R,
}

/// The same at the beginning, the middle and the end of a step.
pub type EffectOverStep<R> = [RotorEffect<R>; 3];

/// What turns the volts of one step into torque.
pub trait Thrust<R: Real> {
    /// From the plant's constants and the length of a step \[s\].
    fn new(parameters: &PlantParameters<f64>, step: f64) -> Self
    where
        Self: Sized;

    /// They push as rotors of these constants do; what they do stays, and so do their lags.
    fn become_plant(&mut self, parameters: &PlantParameters<R>);

    /// Their effect over a step during which `volts` are applied and `disturbance` \[V\] is added to the volts
    /// in effect, after the lag.
    fn over_step(&mut self, volts: PerMotor<R>, disturbance: PerMotor<R>) -> EffectOverStep<R>;
}

/// The paper's rotors, eqs (5)-(6): torque follows volts at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IdealRotors<R> {
    effectiveness: Effectiveness<R>,
}

impl<R: Real> Thrust<R> for IdealRotors<R> {
    fn new(parameters: &PlantParameters<f64>, _step: f64) -> Self {
        Self { effectiveness: parameters.effectiveness.map(R::from_f64) }
    }

    fn become_plant(&mut self, parameters: &PlantParameters<R>) {
        self.effectiveness = parameters.effectiveness;
    }

    #[inline(always)]
    fn over_step(&mut self, volts: PerMotor<R>, disturbance: PerMotor<R>) -> EffectOverStep<R> {
        let torque = self.effectiveness.torque(volts.plus(disturbance));
        [RotorEffect { torque, main_volts: volts.main }; 3]
    }
}

/// Real rotors: first-order lag, thrust a v + b v|v|, reaction torque of an accelerating rotor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaggedRotors<R> {
    /// Its reaction goes with the volts that a rotor has yet to follow: r/τ for each.
    torque: RotorTorque<R>,
    /// exp(-h/2τ): what is left of a difference after half a step.
    half_decay: PerMotor<R>,
    /// \[V\] The volts in effect.
    pub volts: PerMotor<R>,
}

impl<R: Real> LaggedRotors<R> {
    /// Each number through `f`, in a fixed order: what puts rotors of different plants side by side in lanes.
    pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> LaggedRotors<U> {
        LaggedRotors {
            torque: self.torque.map(&mut f),
            half_decay: self.half_decay.map(&mut f),
            volts: self.volts.map(&mut f),
        }
    }

    #[inline(always)]
    fn effect(&self, applied: PerMotor<R>, disturbance: PerMotor<R>) -> RotorEffect<R> {
        let torque = self.torque.torque(self.volts.plus(disturbance), applied.minus(self.volts));
        RotorEffect { torque, main_volts: self.volts.main }
    }
}

impl<R: Real> Thrust<R> for LaggedRotors<R> {
    fn new(parameters: &PlantParameters<f64>, step: f64) -> Self {
        let tau = parameters.rotor_time_constant;
        let per_tau = |r: f64, tau: f64| if tau > 0.0 { r / tau } else { 0.0 };
        Self {
            torque: RotorTorque::new(
                &parameters.map(R::from_f64),
                parameters.rotor_reaction.zip(tau, per_tau).cast(),
            ),
            half_decay: tau.map(|tau| R::from_f64(decay(0.5 * step, tau))),
            volts: PerMotor::zero(),
        }
    }

    fn become_plant(&mut self, parameters: &PlantParameters<R>) {
        self.torque.become_plant(parameters);
    }

    #[inline(always)]
    fn over_step(&mut self, volts: PerMotor<R>, disturbance: PerMotor<R>) -> EffectOverStep<R> {
        let begin = self.effect(volts, disturbance);
        self.volts = follow(self.volts, volts, self.half_decay);
        let middle = self.effect(volts, disturbance);
        self.volts = follow(self.volts, volts, self.half_decay);
        [begin, middle, self.effect(volts, disturbance)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::presets;

    #[test]
    fn lag_reaches_63_percent_after_one_time_constant() {
        let mut p = presets::AERO.plant;
        p.rotor_time_constant = PerMotor::new(0.16, 0.08);
        let mut rotors = LaggedRotors::<f64>::new(&p, 1e-3);
        for _ in 0..160 {
            rotors.over_step(PerMotor::both(10.0), PerMotor::zero());
        }
        assert!((rotors.volts.main - 10.0 * (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
        assert!((rotors.volts.tail - 10.0 * (1.0 - (-2.0_f64).exp())).abs() < 1e-12);
    }

    #[test]
    fn without_lag_the_lagged_rotors_are_the_ideal_ones() {
        let p = presets::PAPER.plant.ideal(0.0);
        let mut lagged = LaggedRotors::<f64>::new(&p, 1e-3);
        let mut ideal = IdealRotors::<f64>::new(&p, 1e-3);
        let (v, d) = (PerMotor::new(7.0, -3.0), PerMotor::new(0.5, 1.0));
        // The first instant still has the old volts in effect; every later one the new.
        lagged.over_step(v, d);
        for effect in lagged.over_step(v, d) {
            assert_eq!(effect, ideal.over_step(v, d)[0]);
        }
    }

    #[test]
    fn a_rotor_that_speeds_up_turns_the_other_axis_at_once() {
        let p = presets::AERO_LAB.plant;
        let mut rotors = LaggedRotors::<f64>::new(&p, 1e-3);
        let [begin, _, _] = rotors.over_step(PerMotor::new(24.0, 0.0), PerMotor::zero());
        // r_y v/τ, before any thrust has built up.
        let torque = begin.torque;
        assert!((torque.yaw - -7.1e-4 * 24.0 / 0.15).abs() < 1e-12 && torque.pitch == 0.0);
    }
}
