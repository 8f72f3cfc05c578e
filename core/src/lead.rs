//! Lead against rotor lag: more than the wanted volts for as long as they are not yet in effect.
//!
//! With the volts in effect V_m and those wanted V_d, u = V_m + κ (V_d - V_m). The lag τ dV_m/dt = u - V_m
//! then becomes (τ/κ) dV_m/dt = V_d - V_m: the rotors answer κ times as fast, as long as nothing clips and τ
//! is the one believed.
//!
//! Where the true lag is shorter than believed, the estimate of V_m trails the truth and the lead pushes at
//! the wrong time: the loop can end in a limit cycle. Use it where the lag is known (identified, or a
//! tachometer fitted).

use crate::axes::PerMotor;
use crate::real::Real;

settings! {
    /// How much lead.
    pub struct Lead<R> at "lead." {
        /// κ: how many times as fast the rotors are to answer; 1 changes nothing.
        factor: (R) "-", (0.1 to 10), typical 1.0 to 4.0, default 1.0;
    }
}

impl<R: Real> Lead<R> {
    /// u \[V\] for `wanted` = V_d and `in_effect` = V_m, both in V.
    #[inline(always)]
    pub fn apply(&self, wanted: PerMotor<R>, in_effect: PerMotor<R>) -> PerMotor<R> {
        in_effect.plus(wanted.minus(in_effect).scaled(self.factor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::presets;
    use crate::rotor_model::RotorModel;

    #[test]
    fn a_lead_of_two_makes_rotors_answer_twice_as_fast() {
        let tau = 0.16;
        let mut plant = presets::AERO.plant;
        plant.rotor_time_constant = PerMotor::both(tau);
        let mut rotors = RotorModel::<f64>::new(&plant, 1e-3);
        let lead = Lead { factor: 2.0 };
        for _ in 0..80 {
            let u = lead.apply(PerMotor::both(5.0), rotors.volts());
            rotors.advance(u);
        }
        let after_half_a_time_constant = 5.0 * (1.0 - (-1.0_f64).exp());
        assert!((rotors.volts().main - after_half_a_time_constant).abs() < 0.02);
    }
}
