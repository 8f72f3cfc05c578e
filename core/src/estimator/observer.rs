//! The machinery of every model-based estimator: predict by the model, correct by what is measured.
//!
//! With ε = y - q⁻: q̂ = q⁻ + l₁ ε, v̂ = v⁻ + l₂ ε, σ̂ = σ⁻ + l₃ ε; then, for the acceleration â that the
//! model gives for the volts in effect, q⁻ = q̂ + T v̂ + T²/2 (â + σ̂), v⁻ = v̂ + T (â + σ̂), σ⁻ = σ̂.
//! Luenberger observer, extended state observer and stationary Kalman filter differ in l₁, l₂, l₃ alone.
//!
//! Coulomb friction, where the model has any, is part of â: left out, it biases the rate of a Luenberger
//! observer by 2 F/(I ω), on an Aero's yaw half of all its error (docs/identify.md). The law does not push
//! against it.

use super::Estimate;
use crate::axes::PerAxis;
use crate::plant::State;
use crate::real::{Mask, Real};

settings! {
    /// How much of what the model did not foresee goes where.
    pub struct ObserverGains<R> at "estimator.gains.pitch.", "estimator.gains.yaw." {
        /// l₁, of the angle.
        angle: (R) "-", (at least 0), typical 0.0 to 1.0, default 0.2;
        /// l₂, of the rate.
        rate: (R) "1/s", (at least 0), typical 0.0 to 300.0, default 10.0;
        /// l₃, of the disturbance; 0 for none.
        disturbance: (R) "1/s²", (at least 0), typical 0.0 to 10000.0, default 0.0;
    }
}

/// \[rad/s\] Width of the friction that an observer believes in, F ω/√(ω² + w²): about what it does not know
/// the rate by. One as narrow as the plant's would jump from one side to the other while the rig stands
/// still.
pub const BELIEVED_FRICTION_WIDTH: f64 = 0.02;

/// An observer at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observer<R> {
    gains: PerAxis<ObserverGains<R>>,
    /// T \[s\] and T²/2 [s²].
    step: R,
    half_square: R,
    /// \[N m\] Coulomb friction, where there is any.
    friction: Option<PerAxis<R>>,
    /// q⁻, v⁻ and σ⁻: what is expected at the next tick.
    expected: Estimate<R>,
}

impl<R: Real> Observer<R> {
    /// At rest at `angle` \[rad\]; `friction` is Coulomb's \[N m\], `sample_time` in s.
    pub fn new(
        gains: PerAxis<ObserverGains<R>>,
        friction: PerAxis<R>,
        angle: PerAxis<R>,
        sample_time: R,
    ) -> Self {
        let rubs = R::zero().lt(friction.pitch) | R::zero().lt(friction.yaw);
        Self {
            gains,
            step: sample_time,
            half_square: sample_time * sample_time * R::from_f64(0.5),
            friction: rubs.any().then_some(friction),
            expected: Estimate::exact(State::at_rest(angle)),
        }
    }

    /// Starts afresh at `angle` \[rad\], at rest.
    pub fn restart(&mut self, angle: PerAxis<R>) {
        self.expected = Estimate::exact(State::at_rest(angle));
    }

    /// Takes the measured angles \[rad\].
    #[inline(always)]
    pub fn correct(&self, measured: PerAxis<R>) -> Estimate<R> {
        let expected = &self.expected;
        let surprise = measured.minus(expected.state.angle);
        let by = |gain: fn(&ObserverGains<R>) -> R| self.gains.zip(surprise, |g, e| gain(&g) * e);
        Estimate {
            state: State {
                angle: expected.state.angle.plus(by(|g| g.angle)),
                rate: expected.state.rate.plus(by(|g| g.rate)),
            },
            disturbance: expected.disturbance.plus(by(|g| g.disturbance)),
        }
    }

    /// What is left of the motors' `torque` \[N m\] when friction has taken its part.
    #[inline(always)]
    pub fn moving(&self, torque: PerAxis<R>, rate: PerAxis<R>) -> PerAxis<R> {
        let Some(friction) = self.friction else { return torque };
        let width = R::from_f64(BELIEVED_FRICTION_WIDTH);
        torque.minus(friction.zip(
            rate,
            #[inline(always)]
            |f, w| f * w / (w * w + width * width).sqrt(),
        ))
    }

    /// Moves on to the next tick from `estimate`, with `accel` \[rad/s²\] as the model has it for the time
    /// between.
    #[inline(always)]
    pub fn predict(&mut self, estimate: &Estimate<R>, accel: PerAxis<R>) {
        let accel = accel.plus(estimate.disturbance);
        let State { angle, rate } = estimate.state;
        self.expected = Estimate {
            state: State {
                angle: angle.plus(rate.scaled(self.step).plus(accel.scaled(self.half_square))),
                rate: rate.plus(accel.scaled(self.step)),
            },
            disturbance: estimate.disturbance,
        };
    }
}
