//! A third-order command filter: from a setpoint that may jump to an angle, a rate and an acceleration that belong together.
//!
//! r''' = ω³ (q_d - r) + 3 ω² (q̇_d - ṙ) + 3 ω (q̈_d - r̈): three poles at -ω, and no lag behind a reference that brings
//! its derivatives. The jerk is held over a tick, so that angle, rate and acceleration are exact integrals of each other.
//!
//! The error q_d - r is clamped to the filter's reach. Within it nothing changes; a longer way is gone at the steady rate ω reach/3,
//! and no way asks for more acceleration than .2331 ω² reach, where a step of that size asks for .2306: a controller that is tried on
//! the one holds on the other
//! (a command filter with a limited rate, as in Farrell, Polycarpou, Sharma and Dong, "Command filtered backstepping", IEEE
//! Transactions on Automatic Control 54(6), 2009). It does not overshoot: from that rate
//! the remaining error is (1 + 2 ωt/3 + (ωt)²/6) exp(-ωt) of the reach.
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
    /// \[rad\] Beyond this error each axis goes at a steady rate; above 0. Left out, there is none.
    pub reach: Option<PerAxis<R>>,
}

/// The filter at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandFilter<R> {
    /// ω³, 3 ω², 3 ω.
    stiffness: PerAxis<R>,
    damping: PerAxis<R>,
    following: PerAxis<R>,
    reach: PerAxis<R>,
    /// \[s\], \[s²\], \[s³\]: T, T²/2, T³/6.
    step: [R; 3],
    now: Reference<R>,
}

impl<R: Real> FilterSettings<R> {
    /// Each number through `f`.
    pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> FilterSettings<U> {
        FilterSettings { bandwidth: self.bandwidth.map(&mut f), reach: self.reach.map(|reach| reach.map(f)) }
    }
}

impl<R: Real<Mask = bool>> FilterSettings<R> {
    /// Usable bandwidths and reaches.
    ///
    /// # Errors
    /// Names the field.
    pub fn validate(&self) -> Result<(), Invalid<R>> {
        both(["filter.bandwidth.pitch", "filter.bandwidth.yaw"], self.bandwidth, positive)?;
        self.reach.map_or(Ok(()), |reach| both(["filter.reach.pitch", "filter.reach.yaw"], reach, positive))
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
            reach: settings.reach.unwrap_or(PerAxis::both(R::from_f64(f64::INFINITY))),
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
        let error = wanted.angle.minus(now.angle).zip(self.reach, |e, reach| e.clamp(-reach, reach));
        let pull = self.stiffness.zip(error, |k, e| k * e);
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
        let settings = FilterSettings { bandwidth: PerAxis::both(bandwidth), reach: None };
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

    /// Within its reach a step is what it would be without; beyond, the rate is ω reach/3, and the acceleration (closed forms) hardly
    /// more than a step of its reach asks for.
    #[test]
    fn a_far_goal_asks_for_hardly_more_than_one_within_reach() {
        let reach = 0.5;
        let settings = FilterSettings { bandwidth: PerAxis::both(4.0), reach: Some(PerAxis::both(reach)) };
        let fly = |goal: f64| {
            let mut f = CommandFilter::new(&settings, PerAxis::zero(), T);
            (0..8_000)
                .map(move |_| f.step(&Reference::at_rest(PerAxis::both(goal))))
                .collect::<std::vec::Vec<_>>()
        };
        let mut free = filter(4.0);
        for r in fly(reach) {
            assert_eq!(r, free.step(&Reference::at_rest(PerAxis::both(reach))));
        }
        let most = |flight: &[Reference<f64>], of: fn(&Reference<f64>) -> f64| {
            flight.iter().map(of).fold(0.0, |most: f64, x| most.max(x.abs()))
        };
        let (near, far) = (fly(reach), fly(-3.0));
        for (flight, peak) in [(&near, 0.2306), (&far, 0.2331)] {
            assert!((most(flight, |r| r.accel.yaw) / (16.0 * reach) - peak).abs() < 1e-3);
        }
        let steady = 4.0 * reach / 3.0;
        assert!((most(&far, |r| r.rate.yaw) - steady).abs() < 5e-3 * steady);
        assert!(most(&far, |r| r.angle.yaw) < 3.0 + 1e-9);
        assert!((far[7_999].angle.yaw + 3.0).abs() < 1e-5);
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
