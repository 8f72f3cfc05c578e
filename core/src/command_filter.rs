//! A third-order command filter: from a setpoint that may jump to an angle, a rate and an acceleration that
//! belong together.
//!
//! r''' = ω³ (q_d - r) + (1 + 2 ζ) ω² (q̇_d - ṙ) + (1 + 2 ζ) ω (q̈_d - r̈) + q⃛_d: a pole at -ω and a pair of
//! the same ω with damping ratio ζ, and no lag behind a reference that brings its derivatives. The jerk is
//! held over a tick, so that angle, rate and acceleration are exact integrals of each other. With ζ = 1 a
//! step never overshoots; with ζ = .8 it does by .31 % and, for the same greatest acceleration, is within 2 %
//! in four fifths of the time.
//!
//! What is asked for takes effect late: rotors of lag τ turn a wanted r̈ into r̈/(τ s + 1). The acceleration
//! that is given out is r̈ + T_a r⃛ (jerk feed-forward), which a lag of τ = T_a turns into r̈ itself. It is
//! outside the loop: a lag that differs leaves an error that dies with the jerk, never an instability, as a
//! lead in the loop can ([`lead`](crate::lead)).
//!
//! The error q_d - r is clamped to the filter's reach. Within it nothing changes; a longer way is gone at the
//! steady rate ω reach/(1 + 2 ζ), and for ζ of at least .6 no way asks for more acceleration than 1.02 times
//! what a step of that size asks for: a controller that is tried on the one holds on the other (a command
//! filter with a limited rate, as in Farrell, Polycarpou, Sharma and Dong, "Command filtered backstepping",
//! IEEE Transactions on Automatic Control 54(6), 2009). From that rate it overshoots by no larger a part of
//! the reach than a step does of itself; with ζ = 1 the remaining error is (1 + 2 ωt/3 + (ωt)²/6) exp(-ωt) of
//! the reach.
//!
//! A law that is given a raw jump asks for its full stiffness at once and clips the voltage, where no
//! stability argument holds; a filtered one asks for what the rotors can follow.

use crate::axes::PerAxis;
use crate::real::Real;
use crate::reference::Reference;

settings! {
    /// How fast the filter is.
    pub struct FilterSettings<R> at "filter." {
        /// ω of each axis: its pole, and the size of its pair of poles.
        bandwidth: (PerAxis<R>) "rad/s", (above 0), typical 1.0 to 30.0, default 5.0;
        /// ζ of each axis' pair of poles. Left out, 1: three equal poles.
        damping: (Option<PerAxis<R>>) "-", (above 0), typical 0.6 to 4.0, default 1.0;
        /// T_a of each axis: how far ahead the acceleration is asked for. Left out, 0.
        advance: (Option<PerAxis<R>>) "s", (at least 0), typical 0.0 to 0.6, default 0.0;
        /// Beyond this error each axis goes at a steady rate. Left out, there is no such bound.
        reach: (Option<PerAxis<R>>) "rad", (above 0), typical 0.1 to 3.0, default f64::INFINITY;
    }
}

/// The filter at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandFilter<R> {
    /// ω³, (1 + 2 ζ) ω², (1 + 2 ζ) ω.
    stiffness: PerAxis<R>,
    damping: PerAxis<R>,
    following: PerAxis<R>,
    advance: PerAxis<R>,
    reach: PerAxis<R>,
    /// \[s\], \[s²\], \[s³\]: T, T²/2, T³/6.
    step: [R; 3],
    /// \[1/s\] 1/T.
    rate: R,
    /// \[rad/s²\] Of the operator's command, a tick ago.
    accel: PerAxis<R>,
    now: Reference<R>,
    /// What was asked for last: the same a tick ago, with the acceleration ahead.
    asked: Reference<R>,
}

impl<R: Real> CommandFilter<R> {
    /// At rest at `angle` \[rad\]; `sample_time` \[s\].
    pub fn new(settings: &FilterSettings<R>, angle: PerAxis<R>, sample_time: R) -> Self {
        let one = R::from_f64(1.0);
        let sum = settings.damping.unwrap_or(PerAxis::both(one)).map(|zeta| one + (zeta + zeta));
        let square = sample_time * sample_time;
        Self {
            stiffness: settings.bandwidth.map(|w| w * w * w),
            damping: settings.bandwidth.zip(sum, |w, sum| sum * (w * w)),
            following: settings.bandwidth.zip(sum, |w, sum| sum * w),
            advance: settings.advance.unwrap_or(PerAxis::zero()),
            reach: settings.reach.unwrap_or(PerAxis::both(R::from_f64(f64::INFINITY))),
            step: [sample_time, square * R::from_f64(0.5), square * sample_time * R::from_f64(1.0 / 6.0)],
            rate: one / sample_time,
            accel: PerAxis::zero(),
            now: Reference::at_rest(angle),
            asked: Reference::at_rest(angle),
        }
    }

    /// Starts afresh at `angle` \[rad\], at rest.
    pub fn restart(&mut self, angle: PerAxis<R>) {
        self.now = Reference::at_rest(angle);
        self.asked = self.now;
        self.accel = PerAxis::zero();
    }

    /// Goes on from where `other` is.
    pub fn continue_from(&mut self, other: &Self) {
        self.now = other.now;
        self.asked = other.asked;
        self.accel = other.accel;
    }

    /// What to follow in this tick, in which `wanted` is the operator's command; `share` of the reach counts,
    /// 0 to 1.
    #[inline(always)]
    pub fn step(&mut self, wanted: &Reference<R>, share: R) -> &Reference<R> {
        let now = self.now;
        let reach = self.reach.scaled(share);
        let error = wanted.angle.minus(now.angle).zip(reach, |e, reach| e.clamp(-reach, reach));
        let pull = self.stiffness.zip(error, |k, e| k * e);
        let damp = self.damping.zip(wanted.rate.minus(now.rate), |k, e| k * e);
        let follow = self.following.zip(wanted.accel.minus(now.accel), |k, e| k * e);
        let own = pull.plus(damp).plus(follow);
        let [t, half_square, sixth_cube] = self.step;
        self.asked = Reference { accel: now.accel.plus(self.advance.zip(own, |ahead, j| ahead * j)), ..now };
        let jerk = own.plus(wanted.accel.minus(self.accel).scaled(self.rate));
        self.accel = wanted.accel;
        self.now = Reference {
            angle: now
                .angle
                .plus(now.rate.scaled(t).plus(now.accel.scaled(half_square)).plus(jerk.scaled(sixth_cube))),
            rate: now.rate.plus(now.accel.scaled(t).plus(jerk.scaled(half_square))),
            accel: now.accel.plus(jerk.scaled(t)),
        };
        &self.asked
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::Trajectory;
    use std::vec::Vec;

    const T: f64 = 1e-3;

    fn settings(bandwidth: f64) -> FilterSettings<f64> {
        FilterSettings { bandwidth: PerAxis::both(bandwidth), damping: None, advance: None, reach: None }
    }

    /// What becomes of a jump to `goal` \[rad\] on both axes.
    fn jump(settings: &FilterSettings<f64>, goal: f64, ticks: usize) -> Vec<Reference<f64>> {
        let mut filter = CommandFilter::new(settings, PerAxis::zero(), T);
        (0..ticks).map(|_| *filter.step(&Reference::at_rest(PerAxis::both(goal)), 1.0)).collect()
    }

    fn most(flight: &[Reference<f64>], of: fn(&Reference<f64>) -> f64) -> f64 {
        flight.iter().map(of).fold(0.0, |most: f64, x| most.max(x.abs()))
    }

    /// Three equal poles: r = 1 - (1 + ωt + (ωt)²/2) exp(-ωt), no overshoot; ζ = ½, Butterworth's:
    /// r = 1 - exp(-ωt) - (2/√3) exp(-ωt/2) sin(√3 ωt/2).
    #[test]
    fn a_jump_becomes_the_response_of_the_poles_that_are_asked_for() {
        let half = FilterSettings { damping: Some(PerAxis::new(1.0, 0.5)), ..settings(12.0) };
        let flight = jump(&half, 1.0, 2000);
        assert_eq!(
            flight.iter().map(|r| r.angle.pitch).collect::<Vec<_>>(),
            jump(&settings(12.0), 1.0, 2000).iter().map(|r| r.angle.pitch).collect::<Vec<_>>(),
        );
        let root = 3.0_f64.sqrt();
        for (k, r) in flight.iter().enumerate() {
            let x = 12.0 * T * k as f64;
            let equal = 1.0 - (1.0 + x + 0.5 * x * x) * (-x).exp();
            let butterworth = 1.0 - (-x).exp() - 2.0 / root * (-0.5 * x).exp() * (0.5 * root * x).sin();
            assert!((r.angle.pitch - equal).abs() < 3e-3, "{k} {} {equal}", r.angle.pitch);
            assert!((r.angle.yaw - butterworth).abs() < 5e-3, "{k} {} {butterworth}", r.angle.yaw);
            assert!(r.angle.pitch < 1.0 + 1e-9);
        }
    }

    #[test]
    fn its_rate_and_acceleration_are_derivatives_of_its_angle() {
        let damped = FilterSettings { damping: Some(PerAxis::both(0.7)), ..settings(15.0) };
        for pair in jump(&damped, 0.7, 500).windows(2) {
            let [last, now] = pair else { unreachable!("windows of two") };
            let slope = (now.angle.pitch - last.angle.pitch) / T;
            let mean = 0.5 * (now.rate.pitch + last.rate.pitch);
            assert!((slope - mean).abs() < 1e-3);
            let bend = (now.rate.pitch - last.rate.pitch) / T;
            assert!((bend - 0.5 * (now.accel.pitch + last.accel.pitch)).abs() < 1e-9);
        }
    }

    /// Rotors of that lag turn the advanced acceleration into the filter's own; those without make of it what
    /// they are asked for.
    #[test]
    fn an_advance_is_undone_by_a_lag_of_its_size() {
        let lag = 0.12;
        let ahead = FilterSettings { advance: Some(PerAxis::new(0.0, lag)), ..settings(9.0) };
        let mut behind = 0.0;
        for r in jump(&ahead, 0.7, 1500) {
            assert!((behind - r.accel.pitch).abs() < 0.1, "{behind} {}", r.accel.pitch);
            behind += (r.accel.yaw - behind) * -(-T / lag).exp_m1();
        }
        let [plain, ahead] = [settings(9.0), ahead].map(|s| jump(&s, 0.7, 1500));
        assert!(most(&plain, |r| r.accel.yaw) > 10.0 && most(&ahead, |r| r.accel.yaw) > 20.0);
        for (plain, ahead) in plain.iter().zip(&ahead) {
            assert_eq!((plain.angle, plain.rate), (ahead.angle, ahead.rate));
        }
    }

    /// Within its reach a step is what it would be without; beyond, the rate is ω reach/(1 + 2 ζ), and the
    /// acceleration hardly more than a step of its reach asks for (for equal poles in closed form .2306 and
    /// .2331 of ω² reach).
    #[test]
    fn a_far_goal_asks_for_hardly_more_than_one_within_reach() {
        let reach = 0.5;
        for damping in [3.0, 1.0, 0.8, 0.6] {
            let free = FilterSettings { damping: Some(PerAxis::both(damping)), ..settings(4.0) };
            let limited = FilterSettings { reach: Some(PerAxis::both(reach)), ..free };
            let [near, far] = [reach, -3.0].map(|goal| jump(&limited, goal, 12_000));
            assert_eq!(near, jump(&free, reach, 12_000));
            let [gentle, strong] = [&near, &far].map(|flight| most(flight, |r| r.accel.yaw) / (16.0 * reach));
            assert!(gentle < strong && strong < 1.021 * gentle, "ζ = {damping}: {strong} {gentle}");
            if damping > 1.0 {
                continue; // It creeps.
            }
            assert!(damping < 1.0 || ((gentle - 0.2306).abs() < 1e-3 && (strong - 0.2331).abs() < 1e-3));
            let steady = 4.0 * reach / (1.0 + 2.0 * damping);
            let swing = most(&near, |r| r.angle.yaw) - reach;
            assert!((most(&far, |r| r.rate.yaw) - steady).abs() < 0.045 * steady, "ζ = {damping}");
            assert!(most(&far, |r| r.angle.yaw) < 3.0 + swing.max(1e-9), "ζ = {damping}");
            assert!((far[11_999].angle.yaw + 3.0).abs() < 1e-5);
        }
    }

    #[test]
    fn a_smooth_reference_is_followed_without_lag() {
        let wanted = Trajectory::<f64>::paper_sine(T);
        let smooth = FilterSettings { damping: Some(PerAxis::new(1.0, 0.7)), ..settings(12.0) };
        let mut f = CommandFilter::new(&smooth, PerAxis::zero(), T);
        for tick in 0..20_000 {
            let reference = wanted.at(tick);
            let r = f.step(&reference, 1.0);
            if tick > 3_000 {
                assert!((r.angle.yaw - reference.angle.yaw).abs() < 2e-6, "{tick}");
            }
        }
    }

    #[test]
    fn what_no_filter_can_be_is_refused_by_name() {
        let with = |damping: f64, advance: f64| FilterSettings {
            damping: Some(PerAxis::both(damping)),
            advance: Some(PerAxis::new(0.0, advance)),
            ..settings(12.0)
        };
        let field = |s: FilterSettings<f64>| s.validate().map_err(|e| e.field);
        assert_eq!(field(with(0.7, 0.0)), Ok(()));
        assert_eq!(field(with(0.0, 0.0)), Err("filter.damping.pitch"));
        assert_eq!(field(with(0.7, -0.1)), Err("filter.advance.yaw"));
        assert_eq!(field(with(0.7, f64::NAN)), Err("filter.advance.yaw"));
    }
}
