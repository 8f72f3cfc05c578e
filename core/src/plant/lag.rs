//! First-order lag and torque of rotors, shared by the plant, by the controller's model of them and by the
//! monitor. They differ in how they round exp(-T/τ), and in what moves a rotor's reaction.

use super::{Effectiveness, PlantParameters};
use crate::axes::{PerAxis, PerMotor};
use crate::real::Real;

/// exp(-time/tau): what is left of a first-order lag's difference after `time` \[s\]; 0 for a `tau` of 0. The
/// plant's: exact.
pub fn decay(time: f64, tau: f64) -> f64 {
    if tau > 0.0 { libm::exp(-time / tau) } else { 0.0 }
}

/// (2τ - T)/(2τ + T), at least 0: [`decay`] to third order in T/τ, by basic arithmetic only, so that the
/// board and the host agree on it to the bit. The controller's, where τ may be 0.
#[inline(always)]
pub(crate) fn tustin_decay<R: Real>(time: R, tau: R) -> R {
    ((tau + tau - time) / (tau + tau + time)).max(R::zero())
}

/// (2 - ωT)/(2 + ωT): the same for a bandwidth, from `phase` = ωT.
#[inline(always)]
pub(crate) fn bilinear_decay<R: Real>(phase: R) -> R {
    let two = R::from_f64(2.0);
    (two - phase) / (two + phase)
}

/// \[V\] In effect after a time in which `decay` is what is left of a difference from the volts `applied`.
#[inline(always)]
pub(crate) fn follow<R: Real>(volts: PerMotor<R>, applied: PerMotor<R>, decay: PerMotor<R>) -> PerMotor<R> {
    applied.plus(volts.minus(applied).zip(decay, |missing, decay| missing * decay))
}

/// Torque of the rotors on the body: thrust a v + b v|v| of the volts in effect, and the reaction of a rotor
/// that speeds up, on the *other* axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RotorTorque<R> {
    linear: Effectiveness<R>,
    quadratic: Effectiveness<R>,
    /// \[N m/V\] For each volt of what the caller takes for the rotor's acceleration: r/τ for the volts that
    /// it has yet to follow, r/T for those that it gains in a tick.
    reaction: PerMotor<R>,
}

impl<R: Real> RotorTorque<R> {
    pub(crate) fn new(plant: &PlantParameters<R>, reaction: PerMotor<R>) -> Self {
        Self { linear: plant.effectiveness, quadratic: plant.quadratic_effectiveness, reaction }
    }

    /// Thrust becomes that of these constants; the reaction stays.
    pub(super) fn become_plant(&mut self, plant: &PlantParameters<R>) {
        *self = Self::new(plant, self.reaction);
    }

    /// Each number through `f`, in a fixed order.
    pub(super) fn map<U>(self, mut f: impl FnMut(R) -> U) -> RotorTorque<U> {
        RotorTorque {
            linear: self.linear.map(&mut f),
            quadratic: self.quadratic.map(&mut f),
            reaction: self.reaction.map(&mut f),
        }
    }

    /// \[N m\] Of `volts` in effect, while the rotors accelerate by `acceleration` \[V\].
    #[inline(always)]
    pub(crate) fn torque(&self, volts: PerMotor<R>, acceleration: PerMotor<R>) -> PerAxis<R> {
        let reaction = PerAxis {
            pitch: self.reaction.tail * acceleration.tail,
            yaw: self.reaction.main * acceleration.main,
        };
        self.linear(volts).plus(self.quadratic.torque(volts.map(|v| v * v.abs()))).plus(reaction)
    }

    /// \[N m\] The part that is proportional to the volts in effect.
    #[inline(always)]
    pub(crate) fn linear(&self, volts: PerMotor<R>) -> PerAxis<R> {
        self.linear.torque(volts)
    }
}
