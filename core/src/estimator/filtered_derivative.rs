//! The estimator that needs no model: differences of the measured angle through a first-order low pass.

use super::Estimate;
use crate::axes::PerAxis;
use crate::plant::State;
use crate::plant::bilinear_decay;
use crate::real::Real;

/// Rate by ω s/(s + ω), discretised by the bilinear rule:
/// v ← a v + (1 - a)(q - q₋)/T, a = (2 - ωT)/(2 + ωT).
///
/// One encoder count (2π/2880 rad) in one tick of 1 ms is a raw rate of 2.2 rad/s, so ω trades noise against
/// lag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilteredDerivative<R> {
    /// a.
    keep: PerAxis<R>,
    /// \[1/s\] (1 - a)/T.
    take: PerAxis<R>,
    last: PerAxis<R>,
    rate: PerAxis<R>,
}

impl<R: Real> FilteredDerivative<R> {
    /// At rest at `angle` \[rad\]; `bandwidth` \[rad/s\], `sample_time` \[s\].
    pub fn new(bandwidth: PerAxis<R>, angle: PerAxis<R>, sample_time: R) -> Self {
        let keep = bandwidth.map(|w| bilinear_decay(w * sample_time));
        Self { keep, take: keep.map(|a| (R::one() - a) / sample_time), last: angle, rate: PerAxis::zero() }
    }

    /// Starts afresh at `angle` \[rad\], at rest.
    pub fn restart(&mut self, angle: PerAxis<R>) {
        self.last = angle;
        self.rate = PerAxis::zero();
    }

    /// Takes the measured angles \[rad\].
    #[inline(always)]
    pub fn update(&mut self, measured: PerAxis<R>) -> Estimate<R> {
        let moved = measured.minus(self.last);
        self.last = measured;
        self.rate = self.keep.zip(self.rate, |a, v| a * v).plus(self.take.zip(moved, |b, d| b * d));
        Estimate::exact(State { angle: measured, rate: self.rate })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_gives_its_slope_and_a_step_in_slope_takes_one_time_constant() {
        let mut e = FilteredDerivative::new(PerAxis::both(100.0), PerAxis::zero(), 1e-3);
        let mut rate = 0.0;
        for k in 1..=300 {
            let angle = 0.5e-3 * f64::from(k);
            rate = e.update(PerAxis::both(angle)).state.rate.pitch;
            if k == 10 {
                assert!((rate / 0.5 - 0.632).abs() < 0.003);
            }
        }
        assert!((rate - 0.5).abs() < 1e-9);
    }
}
