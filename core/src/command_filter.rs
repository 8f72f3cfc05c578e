//! A third-order command filter: from a setpoint that may jump to an angle, a rate and an acceleration that belong together.
//!
//! r''' = ω³ (q_d - r) + 3 ω² (q̇_d - ṙ) + 3 ω (q̈_d - r̈): three poles at -ω, and no lag behind a reference that brings
//! its derivatives. The jerk is held over a tick, so that angle, rate and acceleration are exact integrals of each other.
//!
//! A law that is given a raw jump asks for its full stiffness at once and clips the voltage, where no stability argument
//! holds; a filtered one asks for what the rotors can follow.

use crate::axes::PerAxis;
use crate::real::Real;
use crate::reference::Reference;
use crate::validate::{Invalid, both, positive};
use serde::{Deserialize, Serialize};

/// How fast the filter is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilterSettings<R> {
    /// \[rad/s\] ω of each axis, above 0.
    pub bandwidth: PerAxis<R>,
}

/// The filter at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandFilter<R> {
    /// ω³, 3 ω², 3 ω.
    stiffness: PerAxis<R>,
    damping: PerAxis<R>,
    following: PerAxis<R>,
    /// \[s\], \[s²\], \[s³\]: T, T²/2, T³/6.
    step: [R; 3],
    now: Reference<R>,
}

impl<R: Real> FilterSettings<R> {
    /// Each number through `f`.
    pub fn map<U>(self, f: impl FnMut(R) -> U) -> FilterSettings<U> {
        FilterSettings { bandwidth: self.bandwidth.map(f) }
    }
}

impl<R: Real<Mask = bool>> FilterSettings<R> {
    /// Usable bandwidths.
    ///
    /// # Errors
    /// Names the field.
    pub fn validate(&self) -> Result<(), Invalid<R>> {
        both(["filter.bandwidth.pitch", "filter.bandwidth.yaw"], self.bandwidth, positive)
    }
}

impl<R: Real> CommandFilter<R> {
    /// At rest at `angle` \[rad\]; `sample_time` \[s\].
    pub fn new(settings: &FilterSettings<R>, angle: PerAxis<R>, sample_time: R) -> Self {
        let three = R::from_f64(3.0);
        let square = sample_time * sample_time;
        Self {
            stiffness: settings.bandwidth.map(|w| w * w * w),
            damping: settings.bandwidth.map(|w| three * (w * w)),
            following: settings.bandwidth.map(|w| three * w),
            step: [sample_time, square * R::from_f64(0.5), square * sample_time * R::from_f64(1.0 / 6.0)],
            now: Reference::at_rest(angle),
        }
    }

    /// Starts afresh at `angle` \[rad\], at rest.
    pub fn restart(&mut self, angle: PerAxis<R>) {
        self.now = Reference::at_rest(angle);
    }

    /// What to follow in this tick, in which `wanted` is the operator's wish.
    #[inline(always)]
    pub fn step(&mut self, wanted: &Reference<R>) -> Reference<R> {
        let now = self.now;
        let pull = self.stiffness.zip(wanted.angle.minus(now.angle), |k, e| k * e);
        let damp = self.damping.zip(wanted.rate.minus(now.rate), |k, e| k * e);
        let follow = self.following.zip(wanted.accel.minus(now.accel), |k, e| k * e);
        let jerk = pull.plus(damp).plus(follow);
        let [t, half_square, sixth_cube] = self.step;
        self.now = Reference {
            angle: now
                .angle
                .plus(now.rate.scaled(t).plus(now.accel.scaled(half_square)).plus(jerk.scaled(sixth_cube))),
            rate: now.rate.plus(now.accel.scaled(t).plus(jerk.scaled(half_square))),
            accel: now.accel.plus(jerk.scaled(t)),
        };
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::Trajectory;

    const T: f64 = 1e-3;

    fn filter(bandwidth: f64) -> CommandFilter<f64> {
        let settings = FilterSettings { bandwidth: PerAxis::both(bandwidth) };
        CommandFilter::new(&settings, PerAxis::zero(), T)
    }

    /// Three equal poles: r = 1 - (1 + ωt + (ωt)²/2) exp(-ωt), no overshoot.
    #[test]
    fn a_jump_becomes_the_response_of_three_equal_poles() {
        let mut f = filter(12.0);
        for k in 0..2000 {
            let r = f.step(&Reference::at_rest(PerAxis::both(1.0)));
            let x = 12.0 * T * f64::from(k);
            let exact = 1.0 - (1.0 + x + 0.5 * x * x) * (-x).exp();
            assert!((r.angle.yaw - exact).abs() < 3e-3, "{k} {} {exact}", r.angle.yaw);
            assert!(r.angle.yaw < 1.0 + 1e-9);
        }
    }

    #[test]
    fn its_rate_and_acceleration_are_derivatives_of_its_angle() {
        let mut f = filter(15.0);
        let jump = Reference::at_rest(PerAxis::both(0.7));
        let mut last = f.step(&jump);
        for _ in 0..500 {
            let now = f.step(&jump);
            let slope = (now.angle.pitch - last.angle.pitch) / T;
            let mean = 0.5 * (now.rate.pitch + last.rate.pitch);
            assert!((slope - mean).abs() < 1e-3);
            let bend = (now.rate.pitch - last.rate.pitch) / T;
            assert!((bend - 0.5 * (now.accel.pitch + last.accel.pitch)).abs() < 1e-9);
            last = now;
        }
    }

    #[test]
    fn a_smooth_reference_is_followed_without_lag() {
        let wanted = Trajectory::<f64>::paper_sine(T);
        let mut f = filter(12.0);
        for tick in 0..20_000 {
            let reference = wanted.at(tick);
            let r = f.step(&reference);
            if tick > 3_000 {
                assert!((r.angle.yaw - reference.angle.yaw).abs() < 2e-6, "{tick}");
            }
        }
    }
}
