//! Step 4 of the tick on a board: the operator's setpoint, reached from where the rig is.

use crate::axes::PerAxis;
use crate::real::Real;
use crate::reference::Reference;

/// The setpoint in force, and what is left of the way to it after arming.
///
/// At arming the reference begins where the rig is and runs to the setpoint at a limited rate, each axis on
/// its own; from then on a new setpoint counts as it is. A setpoint with a rate or an acceleration moves on
/// by itself, so that a host that sends a hundred a second gives a smooth reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    setpoint: Reference<f32>,
    /// It has a rate or an acceleration.
    moves: bool,
    /// \[rad\] Reference minus setpoint.
    offset: PerAxis<f32>,
    /// \[rad/s\]
    rate: f32,
    /// \[s\]
    sample_time: f32,
}

impl Approach {
    /// Level, and nothing left of the way; `rate` \[rad/s\] is that of the way, `sample_time` in s.
    #[must_use]
    pub fn new(rate: f32, sample_time: f32) -> Self {
        Self { setpoint: Reference::default(), moves: false, offset: PerAxis::zero(), rate, sample_time }
    }

    /// The way begins at `angle` \[rad\], and a setpoint that moves begins to.
    pub fn begin(&mut self, angle: PerAxis<f32>) {
        self.offset = angle.minus(self.setpoint.angle);
    }

    /// Forgets the setpoint: level, at rest.
    pub fn level(&mut self) {
        self.setpoint = Reference::default();
        self.moves = false;
    }

    /// A new setpoint; one that is not finite is ignored.
    pub fn aim(&mut self, setpoint: Reference<f32>) {
        let parts = [setpoint.angle, setpoint.rate, setpoint.accel];
        if parts.iter().all(|part| part.pitch.is_finite() && part.yaw.is_finite()) {
            self.setpoint = setpoint;
            self.moves = setpoint != Reference::at_rest(setpoint.angle);
        }
    }

    /// The setpoint, at rest: what the reference is while nothing follows it.
    #[must_use]
    pub fn idle(&self) -> Reference<f32> {
        Reference::at_rest(self.setpoint.angle)
    }

    /// The reference of this tick.
    #[inline(always)]
    pub fn step(&mut self) -> Reference<f32> {
        let closing = if self.offset == PerAxis::zero() { PerAxis::zero() } else { self.close_in() };
        let now = self.setpoint;
        if self.moves {
            self.move_on();
        }
        Reference { angle: now.angle.plus(self.offset), rate: now.rate.plus(closing), accel: now.accel }
    }

    /// The setpoint of the next tick.
    fn move_on(&mut self) {
        let (now, t) = (self.setpoint, self.sample_time);
        self.setpoint.angle = now.angle.plus(now.rate.plus(now.accel.scaled(0.5 * t)).scaled(t));
        self.setpoint.rate = now.rate.plus(now.accel.scaled(t));
    }

    /// Shortens the way by one tick's; gives the rate \[rad/s\] at which it goes on.
    fn close_in(&mut self) -> PerAxis<f32> {
        let reach = self.rate * self.sample_time;
        let left = self.offset.map(|offset| offset - Real::clamp(offset, -reach, reach));
        self.offset = left;
        // Where the way has ended, or is so short that it is a jump, the reference rests.
        left.map(|left| match left {
            left if left > 0.0 => -self.rate,
            left if left < 0.0 => self.rate,
            _ => 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_starts_where_the_rig_is_and_ends_at_the_setpoint_at_the_stated_rate() {
        let mut approach = Approach::new(0.5, 1e-3);
        approach.aim(Reference::at_rest(PerAxis::new(0.2, 0.7)));
        approach.begin(PerAxis::new(-0.7, 0.7));
        let first = approach.step();
        assert!((first.angle.pitch + 0.7).abs() < 1e-3);
        assert_eq!(first.angle.yaw, 0.7);
        let mut last = first;
        for tick in 1..1800 {
            let now = approach.step();
            let slope = (now.angle.pitch - last.angle.pitch) / 1e-3;
            let arrives = now.rate.pitch == 0.0 && last.rate.pitch != 0.0;
            assert!(arrives || (slope - last.rate.pitch).abs() < 1e-3, "rate is the slope at tick {tick}");
            assert!((-1e-3..0.501).contains(&slope));
            last = now;
        }
        assert_eq!(approach.step(), Reference::at_rest(PerAxis::new(0.2, 0.7)));
    }

    #[test]
    fn a_setpoint_in_motion_moves_on() {
        let mut approach = Approach::new(0.5, 1e-3);
        approach.aim(Reference {
            angle: PerAxis::both(0.1),
            rate: PerAxis::both(1.0),
            accel: PerAxis::both(-2.0),
        });
        for _ in 0..100 {
            approach.step();
        }
        let now = approach.step();
        // x = x0 + v t + a t²/2 at t = .1 s.
        assert!((now.angle.pitch - (0.1 + 0.1 - 0.01)).abs() < 1e-5);
        assert!((now.rate.pitch - 0.8).abs() < 1e-5);
    }

    #[test]
    fn a_setpoint_that_is_not_finite_changes_nothing() {
        let mut approach = Approach::new(0.5, 1e-3);
        approach.aim(Reference::at_rest(PerAxis::new(f32::NAN, 0.0)));
        assert_eq!(approach.step(), Reference::default());
    }
}
