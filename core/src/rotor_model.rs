//! The rotors as the controller believes them: from the volts really applied to the volts in effect, and to
//! torque.
//!
//! Thrust follows the volts with a lag of .05 to .16 s, which is longer than the closed loop takes to react.
//! An observer that is fed the volts asked for, or takes them to act at once, mistakes the lag for a
//! disturbance.

use crate::axes::{PerAxis, PerMotor};
use crate::plant::{PlantParameters, RotorTorque, follow, tustin_decay};
use crate::real::{Mask, Real};

/// First-order lag for each motor, and the torque of what is in effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotorModel<R> {
    /// What is left of a difference after one tick: (2τ - T)/(2τ + T), at least 0.
    keep: PerMotor<R>,
    /// Its reaction goes with the volts that the volts in effect gain in a tick: r/T for each.
    torque: RotorTorque<R>,
    /// Has it no more than thrust in proportion to volts? Then nothing else is computed.
    linear: bool,
    volts: PerMotor<R>,
}

impl<R: Real> RotorModel<R> {
    /// At rest; `sample_time` \[s\].
    pub fn new(model: &PlantParameters<R>, sample_time: R) -> Self {
        let q = &model.quadratic_effectiveness;
        let r = &model.rotor_reaction;
        let present = [q.main_on_pitch, q.tail_on_pitch, q.main_on_yaw, q.tail_on_yaw, r.main, r.tail]
            .into_iter()
            .fold(R::Mask::splat(false), |found, x| found | R::zero().lt(x.abs()))
            .any();
        Self {
            keep: model.rotor_time_constant.map(|tau| tustin_decay(sample_time, tau)),
            torque: RotorTorque::new(model, r.map(|r| r / sample_time)),
            linear: !present,
            volts: PerMotor::zero(),
        }
    }

    /// Somebody has stopped them.
    pub fn stop(&mut self) {
        self.volts = PerMotor::zero();
    }

    /// \[V\] In effect at the end of the tick that [`RotorModel::advance`] has entered: when the command that
    /// is worked out in this tick begins to act.
    #[inline(always)]
    pub fn volts(&self) -> PerMotor<R> {
        self.volts
    }

    /// One tick on, with `applied` \[V\] from its beginning to its end: the mean torque of that time \[N m\].
    #[inline(always)]
    pub fn advance(&mut self, applied: PerMotor<R>) -> PerAxis<R> {
        let before = self.volts;
        self.volts = follow(before, applied, self.keep);
        let mean = before.plus(self.volts).scaled(R::from_f64(0.5));
        if self.linear {
            self.torque.linear(mean)
        } else {
            self.torque.torque(mean, self.volts.minus(before))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{LaggedRotors, Thrust, presets};

    /// Over any tick, the model's mean torque is the plant's (Simpson's mean of its three), where the model
    /// is right.
    #[test]
    fn gives_the_torque_of_the_plants_rotors() {
        for (name, rig) in presets::ALL {
            let mut model = RotorModel::<f64>::new(&rig.plant, 1e-3);
            let mut plant = LaggedRotors::<f64>::new(&rig.plant, 1e-3);
            for k in 0..500 {
                let volts = PerMotor::new(
                    if k % 100 < 50 { 12.0 } else { -5.0 },
                    if k % 70 < 30 { -9.0 } else { 14.0 },
                );
                let [begin, middle, end] =
                    plant.over_step(volts, PerMotor::zero()).map(|effect| effect.torque);
                let mean = begin.plus(middle.scaled(4.0)).plus(end).scaled(1.0 / 6.0);
                let got = model.advance(volts);
                let scale = rig.plant.effectiveness_at(10.0).torque(PerMotor::both(24.0));
                let near = |a: f64, b: f64, s: f64| (a - b).abs() < 2e-4 * (s.abs() + 0.01);
                assert!(near(got.pitch, mean.pitch, scale.pitch), "{name} {k} {got:?} {mean:?}");
                assert!(near(got.yaw, mean.yaw, scale.yaw), "{name} {k} {got:?} {mean:?}");
            }
            assert!((model.volts().main - plant.volts.main).abs() < 1e-3);
        }
    }

    #[test]
    fn without_lag_the_volts_are_in_effect_after_one_tick() {
        let mut model = RotorModel::<f32>::new(&presets::PAPER.plant.ideal(0.0).map(|x| x as f32), 1e-3);
        model.advance(PerMotor::new(7.0, -3.0));
        assert_eq!(model.volts(), PerMotor::new(7.0, -3.0));
    }
}
