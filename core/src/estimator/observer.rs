//! The machinery of every model-based estimator: predict by the model, correct by what is measured.
//!
//! With ε = y - q⁻: q̂ = q⁻ + l₁ ε, v̂ = v⁻ + l₂ ε, σ̂ = σ⁻ + l₃ ε; then, for the acceleration â that the model gives for the
//! volts in effect, q⁻ = q̂ + T v̂ + T²/2 (â + σ̂), v⁻ = v̂ + T (â + σ̂), σ⁻ = σ̂. Luenberger observer, extended state observer
//! and stationary Kalman filter differ in l₁, l₂, l₃ alone.

use super::Estimate;
use crate::axes::PerAxis;
use crate::plant::State;
use crate::real::Real;
use crate::validate::{Invalid, not_negative};
use serde::{Deserialize, Serialize};

/// How much of what the model did not foresee goes where.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObserverGains<R> {
    /// \[-\] l₁, of the angle; at least 0.
    pub angle: R,
    /// \[1/s\] l₂, of the rate; at least 0.
    pub rate: R,
    /// \[1/s²\] l₃, of the disturbance; at least 0, and 0 for none.
    pub disturbance: R,
}

impl<R: Real> ObserverGains<R> {
    /// Each number through `f`.
    pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> ObserverGains<U> {
        ObserverGains { angle: f(self.angle), rate: f(self.rate), disturbance: f(self.disturbance) }
    }
}

impl<R: Real<Mask = bool>> ObserverGains<R> {
    /// Usable gains, under the names of one axis.
    pub(super) fn validate(&self, fields: [&'static str; 3]) -> Result<(), Invalid<R>> {
        let [angle, rate, disturbance] = fields;
        not_negative(angle, self.angle)?;
        not_negative(rate, self.rate)?;
        not_negative(disturbance, self.disturbance)
    }
}

/// An observer at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observer<R> {
    gains: PerAxis<ObserverGains<R>>,
    /// T \[s\] and T²/2 [s²].
    step: R,
    half_square: R,
    /// q⁻, v⁻ and σ⁻: what is expected at the next tick.
    expected: Estimate<R>,
}

impl<R: Real> Observer<R> {
    /// At rest at `angle` \[rad\]; `sample_time` \[s\].
    pub fn new(gains: PerAxis<ObserverGains<R>>, angle: PerAxis<R>, sample_time: R) -> Self {
        Self {
            gains,
            step: sample_time,
            half_square: sample_time * sample_time * R::from_f64(0.5),
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

    /// Moves on to the next tick from `estimate`, with `accel` \[rad/s²\] as the model has it for the time between.
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
