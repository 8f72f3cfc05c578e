//! What the motors can follow: the setpoint, before the command filter shapes it.
//!
//! The filter alone keeps one step of its reach, from rest and with cold motors, within what the motors give.
//! The governor keeps the rest there. With h the mean square of the warmer motor's current as a share of what
//! the continuous limit allows ([`CurrentLimit::load`](crate::allocation::CurrentLimit::load)):
//!
//! - **Reach.** A step of the reach costs heat: it is asked for as long as there is room for one
//!   (`STEP_HEAT`), and a smaller one where there is less, down to `CRAWL` of it.
//! - **Rate and acceleration** that a setpoint brings are bounded: the rate by twice what a far goal is gone
//!   at, the acceleration by what a step of the reach asks for and by what the volts leave beside those that
//!   hold the pose. A setpoint that moves faster is followed as if its amplitude were less: both are scaled
//!   by one factor, which recovers more slowly than a swing, and with warm motors hardly at all. (A factor
//!   that follows the heat of every swing is another on the way out than on the way back, and what is asked
//!   for walks away from the setpoint, out of the envelope.) Near the continuous limit (`WARM`) the bounds
//!   shrink; where the volts leave more for pitch than a step of the reach asks for, there is more to catch a
//!   swing with, and they do so nearer to it, at most twice as near (`MOST_EASE`). For a setpoint that has
//!   just begun to move they are a part (`BEGIN`), since a jump of the rate asks for more than the motion
//!   that follows.
//! - **The error** that the law sees is at most the reach, and less with warm motors. A motor whose current
//!   is limited follows slowly; a loop that asks for its full stiffness there swings for ever, and keeps the
//!   motors hot by doing so. With the error bounded the damping outweighs the stiffness in large swings, they
//!   die, and the motors cool. While a setpoint moves by itself, it shrinks as late as the motion does;
//!   where no heat is known that would bound it, it is .35 of the reach then (`MOVING_ERROR`), since who
//!   is a whole reach beyond a goal that turns has too little of the way left to be caught on. While the
//!   bound is in force the rig has been left behind: of any motion less is asked for (`SLOWING`), and in full
//!   again only after `RECOVERY` seconds.
//! - **Pitch** stays where the motors can hold it for long ([`StaticReach`]).
//!
//! A step within the reach, with cold motors, is governed by nothing of this.

use crate::allocation::CurrentLimit;
use crate::axes::{PerAxis, PerMotor};
use crate::command_filter::FilterSettings;
use crate::pipeline::settings::Settings;
use crate::plant::{RigidBody, State};
use crate::real::Real;
use crate::reference::Reference;
use crate::static_reach::{StaticReach, hold_volts};

/// \[-\] Heat that a step of the reach may cost, as a share of the continuous limit's.
const STEP_HEAT: f64 = 0.7;
/// \[-\] Least share of the reach that is asked for, however warm the motors are.
const CRAWL: f64 = 0.12;
/// \[-\] Room below the continuous limit's heat at which a setpoint's own motion begins to be bounded more.
const WARM: f64 = 0.12;
/// \[-\] Of that room, what is kept in any case.
const MARGIN: f64 = 0.02;
/// \[-\] Least share of the reach that an error is taken for.
const LEAST_ERROR: f64 = 0.03;
/// \[-\] The same while the setpoint moves by itself: what rotors quicker than believed need to follow a sine
/// that the motors can just bear.
const LEAST_MOVING_ERROR: f64 = 0.08;
/// \[-\] Of the reach, what an error counts to while the setpoint moves by itself and no heat bounds it.
const MOVING_ERROR: f64 = 0.35;
/// \[-\] Most by which the room that heat leaves for motion may count for more.
const MOST_EASE: f64 = 2.0;
/// \[-\] Largest rate of a setpoint, for each rad/s at which a far goal is gone at.
const RATE_MARGIN: f64 = 2.0;
/// \[-\] Largest acceleration of a setpoint, for what a step of the reach asks for.
const ACCEL_MARGIN: f64 = 1.5;
/// \[-\] Part of the volts beside the hold volts that an axis' acceleration may take.
const AUTHORITY: f64 = 0.7;
/// \[-\] Greatest acceleration in a step's response, for ω² of it: .2331 for three equal poles, rounded up.
const STEP_ACCEL: f64 = 0.24;
/// \[s\] In which a setpoint that was too fast is followed in full again.
const RECOVERY: f64 = 10.0;
/// \[-\] Share of the bounds that a setpoint may use as it begins to move.
const BEGIN: f64 = 0.25;
/// \[s\] In which it may use all of them.
const GENTLE: f64 = 3.0;
/// \[s\] Time constant with which motion is followed less while the rig is left behind.
const SLOWING: f64 = 0.25;

/// The governor at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Governor<R> {
    /// \[rad\] Pitch that can be held.
    low: R,
    high: R,
    /// \[rad/s\], \[rad/s²\] Most of a setpoint's own motion.
    rate: PerAxis<R>,
    accel: PerAxis<R>,
    /// \[rad\]
    reach: PerAxis<R>,
    /// \[-\] By how much the room that heat leaves for motion counts for more.
    ease: R,
    /// Gained by `follow` and by `scale` in a tick.
    recovery: R,
    gentle: R,
    /// \[-\] How much of the setpoint's motion is followed.
    scale: PerAxis<R>,
    /// \[-\] How much of the bounds a setpoint that has begun to move may use.
    open: PerAxis<R>,
    /// Left of `follow` after a tick in which the rig was left behind.
    slowing: R,
    /// \[-\] How much of any motion is followed, as the rig keeps up.
    follow: R,
}

impl<R: Real> Governor<R> {
    /// What the motors' heat leaves, with a `limit` where the motors are known.
    #[inline(always)]
    pub fn leave(&self, limit: Option<&CurrentLimit<R>>) -> Leave<R> {
        Leave::new(limit, self.ease)
    }

    /// \[-\] Share of the filter's reach that counts.
    #[inline(always)]
    pub fn reach(&self, leave: &Leave<R>) -> R {
        (leave.reach * self.follow).max(R::from_f64(CRAWL))
    }
}

/// What the motors' heat leaves.
#[derive(Debug, Clone, Copy)]
pub struct Leave<R> {
    /// \[-\] Of the reach of a step.
    pub reach: R,
    motion: R,
    error: R,
    /// Of a setpoint that moves by itself.
    moving_error: R,
}

impl<R: Real> Leave<R> {
    /// With a `limit` where the motors are known, for a governor that counts motion's room `ease` times.
    #[inline(always)]
    fn new(limit: Option<&CurrentLimit<R>>, ease: R) -> Self {
        let one = R::one();
        let Some(limit) = limit else {
            return Self { reach: one, motion: one, error: one, moving_error: R::from_f64(MOVING_ERROR) };
        };
        let room = one - limit.load();
        let share = |room: R, whole: f64| (room * R::from_f64(1.0 / whole)).clamp(R::from_f64(CRAWL), one);
        let reach = share(room, STEP_HEAT);
        let eased = share(room * ease, STEP_HEAT);
        Self {
            reach,
            motion: share(room * ease - R::from_f64(MARGIN), WARM),
            error: (reach * reach).max(R::from_f64(LEAST_ERROR)),
            moving_error: (eased * eased).max(R::from_f64(LEAST_MOVING_ERROR)),
        }
    }
}

impl<R: Real> Governor<R> {
    /// For a rig as it is believed to be and the filter that follows.
    pub fn new(settings: &Settings<R>, filter: &FilterSettings<R>) -> Self {
        let held = StaticReach::new(settings);
        let sum = filter.damping.unwrap_or(PerAxis::both(R::one())).map(|zeta| R::one() + (zeta + zeta));
        let reach = filter.reach.unwrap_or(PerAxis::both(R::from_f64(f64::INFINITY)));
        let speed = filter.bandwidth.zip(reach, |w, reach| w * reach);
        let step =
            filter.bandwidth.zip(speed, |w, speed| R::from_f64(ACCEL_MARGIN * STEP_ACCEL) * (w * speed));
        let most = authority(settings).scaled(R::from_f64(AUTHORITY));
        let accel = step.zip(most, R::min);
        Self {
            low: held.low,
            high: held.high,
            rate: speed.zip(sum, |speed, sum| R::from_f64(RATE_MARGIN) * speed / sum),
            accel,
            ease: (most.pitch / accel.pitch).min(R::from_f64(MOST_EASE)),
            reach,
            recovery: settings.sample_time * R::from_f64(1.0 / RECOVERY),
            slowing: R::one() - settings.sample_time * R::from_f64(1.0 / SLOWING),
            gentle: settings.sample_time * R::from_f64(1.0 / GENTLE),
            scale: PerAxis::both(R::one()),
            open: PerAxis::both(R::from_f64(BEGIN)),
            follow: R::one(),
        }
    }

    /// Starts afresh.
    pub fn restart(&mut self) {
        self.scale = PerAxis::both(R::one());
        self.open = PerAxis::both(R::from_f64(BEGIN));
        self.follow = R::one();
    }

    /// Goes on from where `other` is.
    pub fn continue_from(&mut self, other: &Self) {
        self.scale = other.scale;
        self.open = other.open;
        self.follow = other.follow;
    }

    /// What of a setpoint is asked for.
    #[inline(always)]
    pub fn govern(&mut self, wanted: &Reference<R>, leave: &Leave<R>) -> Reference<R> {
        // Sums, so that what is not a number stays one.
        let pitch = wanted.angle.pitch;
        let beyond = pitch.clamp(self.low, self.high) - pitch;
        // A setpoint at rest has no motion to scale: when it begins to move fast, it does so gently.
        let motion = wanted.rate.zip(wanted.accel, |rate, accel| rate.abs() + accel.abs());
        self.open = self.open.zip(motion, |open, motion| {
            let opened = (open + self.gentle).min(R::one());
            R::select(R::zero().lt(motion), opened, R::from_f64(BEGIN))
        });
        let share = self.open.scaled(leave.motion);
        #[cfg(target_arch = "nvptx64")]
        let at_rest = crate::real::Mask::all((motion.pitch + motion.yaw).le(R::zero()));
        let most = |limit: PerAxis<R>, now: PerAxis<R>| {
            limit.zip(share, |limit, share| limit * share).zip(now, |limit, now| {
                #[cfg(target_arch = "nvptx64")]
                if at_rest {
                    return over_zero(limit);
                }
                limit / now.abs()
            })
        };
        let rate = most(self.rate, wanted.rate);
        let accel = most(self.accel, wanted.accel);
        let gained = self.gentle * leave.error;
        // `follow` is at most 1, and so the whole.
        let recovered = self.scale.map(|s| s + gained);
        self.scale = rate.zip(accel, R::min).zip(recovered, R::min).map(|s| s.min(self.follow));
        let held = R::zero().lt(beyond.abs());
        let scale = PerAxis::new(R::select(held, R::zero(), self.scale.pitch), self.scale.yaw);
        Reference {
            angle: PerAxis::new(pitch + beyond, wanted.angle.yaw),
            rate: wanted.rate.zip(scale, |rate, s| rate * s),
            accel: wanted.accel.zip(scale, |accel, s| accel * s),
        }
    }

    /// Does the setpoint move by itself?
    #[inline(always)]
    pub fn moving(&self) -> PerAxis<R::Mask> {
        self.open.map(|open| R::from_f64(BEGIN).lt(open))
    }

    /// Is the setpoint's motion followed as it is, and the rig not left behind?
    #[inline(always)]
    pub fn in_full(&self) -> PerAxis<R::Mask> {
        self.scale.map(|scale| R::one().le(scale.min(self.follow)))
    }

    /// `reference` with no further to go than the law should see at once, from `angle` \[rad\].
    #[inline(always)]
    pub fn within(&mut self, reference: &Reference<R>, angle: PerAxis<R>, leave: &Leave<R>) -> Reference<R> {
        let error = reference.angle.minus(angle);
        let share = self.moving().map(|moving| R::select(moving, leave.moving_error, leave.error));
        let most = self.reach.zip(share, |reach, share| reach * share);
        let beyond = error.zip(most, |e, most| e.clamp(-most, most) - e);
        let lost = R::zero().lt(beyond.pitch.abs() + beyond.yaw.abs());
        let slowed = (self.follow * self.slowing).max(R::from_f64(CRAWL));
        self.follow = R::select(lost, slowed, (self.follow + self.recovery).min(R::one()));
        Reference { angle: reference.angle.plus(beyond), ..*reference }
    }
}

/// x/0, to the bit. A GPU divides by most numbers in ten instructions, but by 0 in a subroutine of some 40;
/// and most setpoints are at rest.
#[cfg(any(target_arch = "nvptx64", test))]
#[inline(always)]
fn over_zero<R: Real>(x: R) -> R {
    x * R::from_f64(f64::INFINITY)
}

/// \[rad/s²\] What each axis can be accelerated by alone, either way, from a level pose that is held.
fn authority<R: Real>(settings: &Settings<R>) -> PerAxis<R> {
    let inertia = RigidBody::new(&settings.model).at(&State::default()).inertia;
    let hold = hold_volts(&settings.model, R::zero()).map(Real::abs);
    // However much holding takes, something is left to move with.
    let room = settings.volts_limit.zip(hold, |limit, hold| (limit - hold).max(R::from_f64(0.1) * limit));
    let each = |torque: PerAxis<R>| {
        let volts: PerMotor<R> = settings.effectiveness.volts(torque).map(Real::abs);
        (room.main / volts.main).min(room.tail / volts.tail)
    };
    PerAxis {
        pitch: each(PerAxis::new(inertia.pitch, R::zero())),
        yaw: each(PerAxis::new(R::zero(), inertia.yaw)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allocation::CurrentLimitSettings;
    use crate::defaults;
    use crate::plant::presets::{self, Rig};

    const T: f64 = 1e-3;

    fn governor(rig: &Rig, settings: &Settings<f64>) -> Governor<f64> {
        Governor::new(&Settings { model: rig.plant, ..*settings }, &settings.controller.filter.unwrap())
    }

    fn each() -> impl Iterator<Item = (Rig, Settings<f64>)> {
        presets::ALL
            .into_iter()
            .zip(defaults::ALL)
            .map(|((_, rig), (_, controller))| (rig, Settings::new(&rig, controller, T)))
    }

    #[test]
    fn a_setpoint_at_rest_and_a_slow_one_pass_cold_motors_as_they_are() {
        for (rig, settings) in each() {
            let mut governor = governor(&rig, &settings);
            let leave = governor.leave(None);
            for wanted in [
                Reference::at_rest(PerAxis::new(0.3, 3.0)),
                Reference { rate: PerAxis::new(0.05, -0.1), ..Reference::default() },
            ] {
                assert_eq!(governor.govern(&wanted, &leave), wanted);
                assert_eq!(governor.within(&wanted, wanted.angle, &leave), wanted);
                assert_eq!(governor.reach(&leave), 1.0);
            }
        }
    }

    #[test]
    fn times_infinity_is_by_zero_to_the_bit() {
        let numbers = (0..=u32::MAX).step_by(65_521).map(f32::from_bits);
        for x in numbers.chain([0.0, -0.0, f32::INFINITY, f32::MIN_POSITIVE, f32::from_bits(1), f32::NAN]) {
            let (there, here) = (over_zero(x), x / 0.0);
            assert!(there.to_bits() == here.to_bits() || there.is_nan() && here.is_nan(), "{x:e}");
        }
    }

    #[test]
    fn motion_is_scaled_as_a_whole_and_bounded() {
        for (rig, settings) in each() {
            let mut governor = governor(&rig, &settings);
            let leave = governor.leave(None);
            let fast =
                Reference { angle: PerAxis::zero(), rate: PerAxis::both(9.0), accel: PerAxis::both(-90.0) };
            let asked = governor.govern(&fast, &leave);
            for (rate, accel, most) in [
                (asked.rate.pitch, asked.accel.pitch, governor.accel.pitch),
                (asked.rate.yaw, asked.accel.yaw, governor.accel.yaw),
            ] {
                assert!((accel / rate + 10.0).abs() < 1e-9 && accel < 0.0);
                assert!(accel.abs() <= most * (1.0 + 1e-12));
            }
        }
    }

    #[test]
    fn warm_motors_leave_less_of_everything() {
        let settings = CurrentLimitSettings::new(&presets::AERO2.motor.unwrap());
        let mut limit = CurrentLimit::new(settings, T);
        let leave = |limit: &CurrentLimit<f64>| Leave::new(Some(limit), 1.0);
        let cold = leave(&limit);
        assert_eq!((cold.reach, cold.motion, cold.error), (1.0, 1.0, 1.0));
        for _ in 0..200_000 {
            // 4.2 V with no rotor that turns is the continuous current.
            limit.observe(PerMotor::both(4.2), PerMotor::zero());
        }
        let hot = leave(&limit);
        assert_eq!((hot.reach, hot.motion, hot.error), (CRAWL, CRAWL, LEAST_ERROR));
    }

    #[test]
    fn pitch_stays_where_it_can_be_held() {
        let weak = Rig { volts_limit: PerMotor::both(6.0), ..presets::AERO_LAB };
        let settings = Settings::new(&weak, defaults::AERO_LAB, T);
        let mut governor = governor(&weak, &settings);
        let wanted = Reference { rate: PerAxis::both(0.1), ..Reference::at_rest(PerAxis::both(0.4)) };
        let leave = governor.leave(None);
        let asked = governor.govern(&wanted, &leave);
        assert!((asked.angle.pitch - StaticReach::new(&settings).high).abs() < 1e-12);
        assert_eq!((asked.rate.pitch, asked.rate.yaw, asked.angle.yaw), (0.0, 0.1, 0.4));
    }

    /// What is not a number is not made one.
    #[test]
    fn a_nan_stays_a_nan() {
        let (rig, settings) = each().next().unwrap();
        let mut governor = governor(&rig, &settings);
        let bad = Reference { rate: PerAxis::both(f64::NAN), ..Reference::at_rest(PerAxis::both(f64::NAN)) };
        let leave = governor.leave(None);
        let asked = governor.govern(&bad, &leave);
        assert!(asked.angle.pitch.is_nan() && asked.rate.yaw.is_nan());
        assert!(governor.within(&asked, PerAxis::zero(), &leave).angle.pitch.is_nan());
    }
}
