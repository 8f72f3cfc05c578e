//! What following a setpoint takes on this rig, beside what the model says: learned in flight.
//!
//! The law asks for the acceleration ẍ_d of a setpoint that moves by itself. A rig whose thrust, inertia,
//! damping or lag are not what is believed gives another one, and a loop that is not much quicker than the
//! setpoint leaves a part of the difference. Both are multiples of what is asked for, and so are what would
//! mend them: of each axis the setpoint's own acceleration and rate, weighted to be of a size,
//!
//!   φ = (ẍ_d, ω ẋ_d/2),    ẍ = ẍ_d + θ φ,    θ' = ω s φ/(T (φ² + φ₀²)),    s = ξ̇ + ω ξ,
//!
//! with ξ the error that the law sees and ω the command filter's bandwidth: the gradient of adaptive
//! backstepping (Krstić, Kanellakopoulos and Kokotović, "Nonlinear and Adaptive Control Design", 1995,
//! chapters 3 and 4: an estimate moves by error times regressor), normalised as in Ioannou and Sun, "Robust
//! Adaptive Control", 1996, chapter 4, so that how fast it learns does not depend on how large the
//! setpoint is. A step that would make |θ| larger than `MOST` is not taken (their projection).
//!
//! - A goal that stands or jumps has no motion of its own: nothing is learned, nothing is added, and a step's
//!   response is what it is without, to the bit. What has been learned is kept for the next motion.
//! - It learns only while the setpoint is followed in full ([`Governor`](crate::governor::Governor)) and
//!   motors gave the volts that were asked for: a rig that can't follow would teach it to ask for more.
//! - It is slow beside the loop. s answers θ φ by the closed loop, which is quick enough where its phase at
//!   the setpoint's frequency is below 90 degrees, as for an average over a swing it must be.

use crate::axes::PerAxis;
use crate::command_filter::FilterSettings;
use crate::plant::State;
use crate::real::Real;
use crate::reference::Reference;

/// \[s\] T. With a third of it `aero2`'s slow loop swings on some drawn plants; with twice as much one of
/// `paper` is not yet within 15 % after half a minute (the governor's grid, docs/rig-law.md).
const LEARNING: f64 = 2.0;
/// \[-\] Largest part of the setpoint's motion that is added or taken away.
const MOST: f64 = 1.5;
/// \[-\] Weight of the rate, in bandwidths.
const RATE_WEIGHT: f64 = 0.5;
/// \[-\] φ₀ for the size of a step's acceleration, ω² reach: a motion far below it teaches little.
const FLOOR: f64 = 0.03;

/// The feed-forward at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdaptiveFeedForward<R> {
    /// \[-\] θ.
    of_accel: PerAxis<R>,
    of_rate: PerAxis<R>,
    /// \[-\] 1 if the motors gave in the last tick what they were asked for, else 0.
    given: R,
    /// \[1/s\] ω.
    bandwidth: PerAxis<R>,
    /// \[1/s\] ω/2.
    weight: PerAxis<R>,
    /// \[rad²/s⁴\] φ₀².
    floor: PerAxis<R>,
    /// \[-\] Of a tick, ω times the sample time in T.
    pace: PerAxis<R>,
}

impl<R: Real> AdaptiveFeedForward<R> {
    /// That has learned nothing; `sample_time` \[s\].
    pub fn new(filter: &FilterSettings<R>, sample_time: R) -> Self {
        let reach = filter.reach.unwrap_or(PerAxis::both(R::one()));
        let floor = filter.bandwidth.zip(reach, |w, reach| R::from_f64(FLOOR) * (w * w * reach));
        Self {
            of_accel: PerAxis::zero(),
            of_rate: PerAxis::zero(),
            given: R::one(),
            bandwidth: filter.bandwidth,
            weight: filter.bandwidth.scaled(R::from_f64(RATE_WEIGHT)),
            floor: floor.zip(floor, |a, b| a * b),
            pace: filter.bandwidth.scaled(sample_time * R::from_f64(1.0 / LEARNING)),
        }
    }

    /// Forgets what it has learned.
    pub fn restart(&mut self) {
        self.of_accel = PerAxis::zero();
        self.of_rate = PerAxis::zero();
        self.given = R::one();
    }

    /// Goes on with what `other` has learned.
    pub fn continue_from(&mut self, other: &Self) {
        self.of_accel = other.of_accel;
        self.of_rate = other.of_rate;
        self.given = other.given;
    }

    /// What a setpoint that moves as `wanted` has been found to take \[rad/s²\], beside its acceleration.
    /// Learns from where the rig is, `state`, on its way along `reference`, on each axis that is followed
    /// `in_full`. An axis that stands teaches nothing and gets 0.
    #[inline(always)]
    pub fn learn(
        &mut self,
        reference: &Reference<R>,
        wanted: &Reference<R>,
        state: &State<R>,
        in_full: PerAxis<R::Mask>,
    ) -> PerAxis<R> {
        let error = reference.angle.minus(state.angle);
        let error = reference.rate.minus(state.rate).plus(self.bandwidth.zip(error, |w, e| w * e));
        let rate = self.weight.zip(wanted.rate, |weight, rate| weight * rate);
        let size = wanted.accel.zip(rate, |a, r| a * a + r * r).plus(self.floor);
        let step = self.pace.scaled(self.given).zip(error, |pace, e| pace * e).zip(size, |s, size| s / size);
        let step = step.zip(in_full, |step, full| R::select(full, step, R::zero()));
        let learn = |share: PerAxis<R>, of: PerAxis<R>| {
            let most = R::from_f64(MOST);
            let moved = share.plus(step.zip(of, |step, of| step * of));
            moved.zip(share, |moved, share| R::select(moved.abs().le(most), moved, share))
        };
        self.of_accel = learn(self.of_accel, wanted.accel);
        self.of_rate = learn(self.of_rate, rate);
        let more = self.of_accel.zip(wanted.accel, |share, a| share * a);
        more.plus(self.of_rate.zip(rate, |share, r| share * r))
    }

    /// Ends the tick: were the motors given other volts than were asked for?
    #[inline(always)]
    pub fn settle(&mut self, clipped: R::Mask) {
        self.given = R::select(clipped, R::zero(), R::one());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: f64 = 1e-3;
    const OMEGA: f64 = 4.0;

    fn new() -> AdaptiveFeedForward<f64> {
        let filter = FilterSettings {
            bandwidth: PerAxis::both(10.0),
            damping: None,
            advance: None,
            reach: Some(PerAxis::both(0.5)),
        };
        AdaptiveFeedForward::new(&filter, T)
    }

    /// A sine of `amplitude` \[rad\] and its derivatives.
    fn sine(tick: u32, amplitude: f64) -> Reference<f64> {
        let (sine, cosine) = (OMEGA * T * f64::from(tick)).sin_cos();
        Reference {
            angle: PerAxis::both(amplitude * sine),
            rate: PerAxis::both(amplitude * OMEGA * cosine),
            accel: PerAxis::both(-amplitude * OMEGA * OMEGA * sine),
        }
    }

    /// A rig that accelerates by `gain` times what it is asked for, less `damping` \[1/s\] times its rate,
    /// under a law with two poles at -10 rad/s, through `seconds` of a sine. The largest error \[rad\] of the
    /// last period.
    fn fly(learner: &mut AdaptiveFeedForward<f64>, gain: f64, damping: f64, seconds: f64) -> f64 {
        let mut state = State { angle: PerAxis::zero(), rate: PerAxis::both(0.2 * OMEGA) };
        let (end, mut most) = ((seconds / T) as u32, 0.0_f64);
        for tick in 0..end {
            let wanted = sine(tick, 0.2);
            let more = learner.learn(&wanted, &wanted, &state, PerAxis::both(true));
            let error = wanted.angle.minus(state.angle);
            let back = error.scaled(100.0).plus(wanted.rate.minus(state.rate).scaled(20.0));
            let accel = wanted.accel.plus(more).plus(back);
            let accel = accel.scaled(gain).minus(state.rate.scaled(damping));
            state.angle = state.angle.plus(state.rate.scaled(T)).plus(accel.scaled(0.5 * T * T));
            state.rate = state.rate.plus(accel.scaled(T));
            if tick + 1_600 > end {
                most = most.max(error.pitch.abs().max(error.yaw.abs()));
            }
        }
        most
    }

    /// gain ((1 + θ₁) ẍ_d + θ₂ ω/2 ẋ_d) - damping ẋ_d = ẍ_d gives both in closed form.
    #[test]
    fn it_learns_what_the_rig_takes() {
        for (gain, damping) in [(0.8, 0.0), (1.3, 1.0), (0.7, -0.6)] {
            let without = fly(&mut new(), gain, damping, 1.7);
            let mut learner = new();
            let with = fly(&mut learner, gain, damping, 120.0);
            assert!(with < 0.02 * without, "{with} of {without} rad");
            for (got, wanted) in [
                (learner.of_accel.pitch, 1.0 / gain - 1.0),
                (learner.of_rate.yaw, damping / gain / (RATE_WEIGHT * 10.0)),
            ] {
                assert!((got - wanted).abs() < 0.01, "{got} for {wanted}");
            }
        }
    }

    #[test]
    fn a_goal_that_stands_teaches_nothing_and_gets_nothing() {
        let mut learner = new();
        fly(&mut learner, 0.8, 0.5, 20.0);
        let taught = learner;
        let jump = Reference { accel: PerAxis::new(3.0, -0.7), ..Reference::at_rest(PerAxis::both(0.5)) };
        let goal = Reference::at_rest(PerAxis::both(0.5));
        let far = State { angle: PerAxis::both(-0.2), rate: PerAxis::both(0.4) };
        assert_eq!(learner.learn(&jump, &goal, &far, PerAxis::both(true)), PerAxis::zero());
        assert_eq!(learner, taught);
    }

    #[test]
    fn who_cannot_follow_teaches_nothing() {
        let (wanted, stuck) = (sine(200, 0.2), State::default());
        let teach = |clipped: bool, in_full: PerAxis<bool>| {
            let mut learner = new();
            learner.settle(clipped);
            learner.learn(&wanted, &wanted, &stuck, in_full);
            learner
        };
        let taught = |l: &AdaptiveFeedForward<f64>| l.of_accel.map(|share| share != 0.0);
        assert_eq!(taught(&teach(false, PerAxis::both(true))), PerAxis::both(true));
        assert_eq!(taught(&teach(true, PerAxis::both(true))), PerAxis::both(false));
        assert_eq!(taught(&teach(false, PerAxis::new(false, true))), PerAxis::new(false, true));
    }

    #[test]
    fn what_is_added_is_bounded_and_forgotten_by_a_new_start() {
        let mut learner = new();
        for tick in 0..100_000 {
            let wanted = sine(tick, 0.2);
            let more = learner.learn(&wanted, &wanted, &State::default(), PerAxis::both(true));
            let most = MOST * (wanted.accel.yaw.abs() + RATE_WEIGHT * 10.0 * wanted.rate.yaw.abs());
            assert!(more.yaw.abs() <= most * (1.0 + 1e-12));
        }
        assert!(learner != new());
        learner.restart();
        assert_eq!(learner, new());
    }
}
