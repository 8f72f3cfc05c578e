//! Gains of a Luenberger observer: the model is trusted but for its state.

use super::observer::ObserverGains;
use crate::plant::bilinear_decay;
use crate::real::Real;

/// Both error poles at b = exp(-ωT) (to third order): l₁ = 1 - b², l₂ = (1 - b)²/T, l₃ = 0. `bandwidth` is ω
/// \[rad/s\].
///
/// The quietest of the estimators for its bandwidth, since the volts tell it what the encoder cannot. A wrong
/// model biases its rate, which an integral in the law makes good.
pub fn luenberger<R: Real>(bandwidth: R, sample_time: R) -> ObserverGains<R> {
    let one = R::one();
    let b = bilinear_decay(bandwidth * sample_time);
    let gone = one - b;
    ObserverGains { angle: one - b * b, rate: gone * gone / sample_time, disturbance: R::zero() }
}
