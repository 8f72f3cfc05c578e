//! What a simulated rig's hardware does worse than the ideal one: play between shaft and encoder, encoders
//! that miscount, motors that do not answer to a small voltage, volts that come late or not in full, a cable
//! that holds yaw back.

use crate::axes::{PerAxis, PerMotor};
use crate::plant::Cable;
use crate::real::Real;

/// How worn it is; nothing by default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wear {
    /// \[rad\] Play between shaft and encoder, from one end to the other, 0 or more.
    pub backlash: PerAxis<f64>,
    /// \[V\] What a motor's friction takes of its volts, 0 or more: less does not turn it.
    pub dead_zone: PerMotor<f64>,
    /// \[ticks\] By how many volts come later than they should; with `jitter` at most [`LONGEST_DELAY`].
    pub delay: u32,
    /// \[ticks\] By how many more they may come late, in each tick as [`Worn::set_jitter`] says.
    pub jitter: u32,
    /// The cable that yaw winds up.
    pub cable: Cable<f64>,
    /// \[V\] Most that the amplifiers give, where that is less than the controller knows.
    pub limit: Option<PerMotor<f64>>,
}

/// \[ticks\] Longest delay of the volts.
pub const LONGEST_DELAY: u32 = 31;

/// Worn hardware at work: between the shafts and the encoders, between the amplifiers and the motors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worn<R> {
    any: bool,
    /// \[rad\] Half of the play.
    half_play: PerAxis<R>,
    /// \[rad\] Where the encoders' side of the play is.
    taken_along: PerAxis<R>,
    dead_zone: PerMotor<R>,
    limit: PerMotor<R>,
    /// What is on its way, the newest first.
    late: [PerMotor<R>; LONGEST_DELAY as usize + 1],
    delay: usize,
    /// \[ticks\] Beside the delay, now; and at most.
    jitter: usize,
    most_jitter: usize,
    /// \[counts\]
    noise: PerAxis<R>,
    noisy: bool,
}

impl<R: Real> Worn<R> {
    /// With shafts at `angle` \[rad\], in the middle of their play.
    pub fn new(wear: &Wear, angle: PerAxis<R>) -> Self {
        let far = PerMotor::both(1e9);
        Self {
            any: *wear != Wear::default(),
            half_play: wear.backlash.map(|play| R::from_f64(0.5 * play)),
            taken_along: angle,
            dead_zone: wear.dead_zone.cast(),
            limit: wear.limit.unwrap_or(far).cast(),
            late: [PerMotor::zero(); LONGEST_DELAY as usize + 1],
            delay: wear.delay.min(LONGEST_DELAY) as usize,
            jitter: 0,
            most_jitter: wear.jitter.min(LONGEST_DELAY - wear.delay.min(LONGEST_DELAY)) as usize,
            noise: PerAxis::zero(),
            noisy: false,
        }
    }

    /// \[rad\] What the encoders see of shafts at `angle`, which have turned since they were last looked at.
    #[inline(always)]
    pub fn seen(&mut self, angle: PerAxis<R>) -> PerAxis<R> {
        if !self.any {
            return angle;
        }
        let half = self.half_play;
        let (low, high) = (angle.minus(half), angle.plus(half));
        self.taken_along = self.taken_along.zip(low, Real::max).zip(high, Real::min);
        self.taken_along
    }

    /// From now on the encoders show so many whole counts \[counts\] beside those there are.
    pub fn set_noise(&mut self, counts: PerAxis<R>) {
        self.noise = counts;
        self.noisy = true;
    }

    /// From now on volts come so many ticks later than they do without jitter.
    pub fn set_jitter(&mut self, ticks: u32) {
        self.jitter = (ticks as usize).min(self.most_jitter);
    }

    /// \[counts\] What the encoders show that have counted so many.
    #[inline(always)]
    pub fn shown(&self, counts: PerAxis<R>) -> PerAxis<R> {
        if self.noisy { counts.plus(self.noise) } else { counts }
    }

    /// \[V\] What turns the motors in a tick in which the amplifiers give `volts`.
    #[inline(always)]
    pub fn driven(&mut self, volts: PerMotor<R>) -> PerMotor<R> {
        if !self.any {
            return volts;
        }
        let given = volts.zip(self.limit, |v, most| v.max(-most).min(most));
        self.late.rotate_right(1);
        if let Some(newest) = self.late.first_mut() {
            *newest = given;
        }
        let late = self.late.get(self.delay + self.jitter).copied().unwrap_or(given);
        late.zip(self.dead_zone, |v, dead| {
            let left = (v.abs() - dead).max(R::zero());
            R::select(v.lt(R::zero()), -left, left)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worn(wear: Wear) -> Worn<f64> {
        Worn::new(&wear, PerAxis::zero())
    }

    #[test]
    fn nothing_is_changed_where_nothing_is_worn() {
        let mut new = worn(Wear::default());
        let (angle, volts) = (PerAxis::new(0.3, -0.2), PerMotor::new(4.0, -0.01));
        assert_eq!((new.seen(angle), new.driven(volts)), (angle, volts));
    }

    /// A shaft that turns about takes its encoder along once it has crossed the play.
    #[test]
    fn an_encoder_with_play_lags_by_half_of_it_each_way() {
        let mut play = worn(Wear { backlash: PerAxis::both(0.2), ..Wear::default() });
        let mut at = |pitch: f64| play.seen(PerAxis::new(pitch, 0.0)).pitch;
        assert_eq!(at(0.05), 0.0);
        assert!((at(0.5) - 0.4).abs() < 1e-15);
        assert!((at(0.35) - 0.4).abs() < 1e-15, "within the play");
        assert!((at(0.2) - 0.3).abs() < 1e-15);
    }

    #[test]
    fn volts_come_late_and_less_a_motors_friction() {
        let wear = Wear { dead_zone: PerMotor::new(0.5, 0.5), delay: 3, ..Wear::default() };
        let mut motors = worn(wear);
        let got: [PerMotor<f64>; 5] =
            core::array::from_fn(|k| motors.driven(PerMotor::new(k as f64 + 1.0, -0.4)));
        assert_eq!(got.map(|v| v.main), [0.0, 0.0, 0.0, 0.5, 1.5]);
        assert!(got.iter().all(|v| v.tail == 0.0), "less than its friction");
        let late = Wear { delay: 1, jitter: 2, ..Wear::default() };
        let mut motors = worn(late);
        let arrived = [(1.0, 0), (2.0, 2), (3.0, 0), (4.0, 5), (5.0, 1)].map(|(volts, jitter)| {
            motors.set_jitter(jitter);
            motors.driven(PerMotor::both(volts)).main
        });
        assert_eq!(arrived, [0.0, 0.0, 2.0, 1.0, 3.0], "no more than the most, and an older one again");
        let longest = Wear { delay: LONGEST_DELAY, limit: Some(PerMotor::both(2.0)), ..Wear::default() };
        let mut motors = worn(longest);
        let arrives = (0..100).position(|_| motors.driven(PerMotor::both(-9.0)).main == -2.0);
        assert_eq!(arrives, Some(LONGEST_DELAY as usize));
    }
}
