//! Step 4 of the tick on a board: the operator's setpoint, reached from where the rig is.

use crate::axes::PerAxis;
use crate::real::Real;
use crate::reference::Reference;

/// The setpoint in force, and what is left of the way to it after arming.
///
/// At arming the reference begins where the rig is and runs to the setpoint at a limited rate, each axis on its own; from
/// then on a new setpoint counts as it is. A setpoint with a rate or an acceleration moves on by itself, so that a host that
/// sends a hundred a second gives a smooth reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    setpoint: Reference<f32>,
    /// \[rad\] Reference minus setpoint.
    offset: PerAxis<f32>,
    /// \[rad/s\]
    rate: f32,
    /// \[s\]
    sample_time: f32,
}

impl Approach {
    /// Level, and nothing left of the way; `rate` [rad/s] is that of the way, `sample_time` in s.
    #[must_use]
    pub fn new(rate: f32, sample_time: f32) -> Self {
        Self { setpoint: Reference::default(), offset: PerAxis::zero(), rate, sample_time }
    }

    /// The way begins at `angle` [rad].
    pub fn begin(&mut self, angle: PerAxis<f32>) {
        self.setpoint = Reference::at_rest(self.setpoint.angle);
        self.offset = angle.minus(self.setpoint.angle);
    }

    /// Forgets the setpoint: level, at rest.
    pub fn level(&mut self) {
        self.setpoint = Reference::default();
    }

    /// A new setpoint; one that is not finite is ignored.
    pub fn aim(&mut self, setpoint: Reference<f32>) {
        let parts = [setpoint.angle, setpoint.rate, setpoint.accel];
        if parts.iter().all(|part| part.pitch.is_finite() && part.yaw.is_finite()) {
            self.setpoint = setpoint;
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
        let reach = self.rate * self.sample_time;
        let left = self.offset.map(|offset| offset - Real::clamp(offset, -reach, reach));
        // Where the way has ended, or is so short that it is a jump, the reference rests.
        let closing = left.map(|left| match left {
            left if left > 0.0 => -self.rate,
            left if left < 0.0 => self.rate,
            _ => 0.0,
        });
        self.offset = left;
        let now = self.setpoint;
        let (t, half) = (self.sample_time, 0.5 * self.sample_time);
        self.setpoint.angle = now.angle.plus(now.rate.plus(now.accel.scaled(half)).scaled(t));
        self.setpoint.rate = now.rate.plus(now.accel.scaled(t));
        Reference { angle: now.angle.plus(left), rate: now.rate.plus(closing), accel: now.accel }
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
