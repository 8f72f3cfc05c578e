//! Gains of an extended state observer: whatever the model does not explain is a disturbance to be found.

use super::bilinear_decay;
use super::observer::ObserverGains;
use crate::real::Real;

/// All three error poles at b = exp(-ωT) (to third order): l₁ = 1 - b³, l₂ = 3/2 (1 - b)² (1 + b)/T, l₃ =
/// (1 - b)³/T². `bandwidth` is ω \[rad/s\]. (Current form of the linear observer of Z. Gao, "Scaling and
/// bandwidth-parameterization based controller tuning", ACC 2003.)
pub fn extended_state<R: Real>(bandwidth: R, sample_time: R) -> ObserverGains<R> {
    let one = R::one();
    let b = bilinear_decay(bandwidth * sample_time);
    let gone = one - b;
    let square = gone * gone;
    ObserverGains {
        angle: one - b * b * b,
        rate: R::from_f64(1.5) * square * (one + b) / sample_time,
        disturbance: square * gone / (sample_time * sample_time),
    }
}
