//! Step 4 of the tick on a board: the operator's setpoint, reached from where the rig is.

use crate::axes::PerAxis;
use crate::parameters::{LostLink, Parameters};
use crate::real::Real;
use crate::reference::Reference;

/// \[ticks\] How long a setpoint that moves does so by itself. A host that is there sends many in that time.
pub const HOLD_TICKS: u32 = 500;

/// The setpoint in force, and what is left of the way to it after arming.
///
/// At arming the reference begins where the rig is and runs to the setpoint at a limited rate, each axis on
/// its own; from then on a new setpoint counts as it is. A setpoint with a rate or an acceleration moves on
/// by itself, so that a host that sends a hundred a second gives a smooth reference; it comes to rest where
/// it is when no new one has come for [`HOLD_TICKS`], or where it would leave the pitch envelope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    setpoint: Reference<f32>,
    /// \[ticks\] For how long it moves.
    moves: u32,
    /// \[rad\] Reference minus setpoint.
    offset: PerAxis<f32>,
    /// It is on the way to the rest pose, since the link is lost.
    landing: bool,
    /// \[rad/s\]
    rate: f32,
    /// \[s\]
    sample_time: f32,
    /// \[rad\] Largest pitch of a setpoint that moves.
    pitch: f32,
    /// \[rad\] Pitch of the rest pose.
    rest: f32,
    lost_link: LostLink,
}

impl Approach {
    /// Level, and nothing left of the way.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let Parameters { limits, encoders, .. } = parameters;
        Self {
            setpoint: Reference::default(),
            moves: 0,
            offset: PerAxis::zero(),
            landing: false,
            rate: limits.approach_rate,
            sample_time: parameters.settings.sample_time,
            pitch: limits.pitch,
            rest: f32::from_i32(encoders.pitch.rest_counts) * encoders.pitch.angle_per_count,
            lost_link: limits.lost_link,
        }
    }

    /// The way begins at `angle` \[rad\], and a setpoint that moves begins to.
    pub fn begin(&mut self, angle: PerAxis<f32>) {
        self.offset = angle.minus(self.setpoint.angle);
        self.landing = false;
    }

    /// Forgets the setpoint: level, at rest.
    pub fn level(&mut self) {
        self.rest_at(PerAxis::zero());
    }

    /// A new setpoint; one that is not finite is ignored.
    pub fn aim(&mut self, setpoint: Reference<f32>) {
        let parts = [setpoint.angle, setpoint.rate, setpoint.accel];
        if parts.iter().all(|part| part.pitch.is_finite() && part.yaw.is_finite()) {
            let moves = setpoint != Reference::at_rest(setpoint.angle);
            self.setpoint = setpoint;
            self.moves = if moves { HOLD_TICKS } else { 0 };
            self.landing = false;
        }
    }

    /// The link is lost: the reference stays where it is, or goes to the rest pose's pitch at the rate of the
    /// way; until a new setpoint comes.
    #[cold]
    pub fn lose_link(&mut self) {
        let now = self.setpoint.angle.plus(self.offset);
        self.offset = PerAxis::zero();
        self.rest_at(now);
        if self.lost_link == LostLink::Land {
            self.landing = true;
            self.setpoint.angle.pitch = self.rest;
            self.offset.pitch = now.pitch - self.rest;
        }
    }

    /// The link was lost, and the reference has come to the rest pose.
    #[inline(always)]
    #[must_use]
    pub fn has_landed(&self) -> bool {
        self.landing && self.offset == PerAxis::zero()
    }

    /// The way is done and the setpoint does not move: the reference is [`Self::idle`], and need not be stepped.
    #[inline(always)]
    #[must_use]
    pub fn rests(&self) -> bool {
        self.moves == 0 && self.offset == PerAxis::zero()
    }

    /// The setpoint, at rest: what the reference is while nothing follows it.
    #[inline(always)]
    #[must_use]
    pub fn idle(&self) -> Reference<f32> {
        Reference::at_rest(self.setpoint.angle)
    }

    /// The reference of this tick.
    #[inline(never)]
    pub fn step(&mut self) -> Reference<f32> {
        let closing = if self.offset == PerAxis::zero() { PerAxis::zero() } else { self.close_in() };
        let now = self.setpoint;
        if self.moves > 0 {
            self.move_on();
        }
        Reference { angle: now.angle.plus(self.offset), rate: now.rate.plus(closing), accel: now.accel }
    }

    /// The setpoint of the next tick.
    fn move_on(&mut self) {
        let (now, t) = (self.setpoint, self.sample_time);
        self.setpoint.angle = now.angle.plus(now.rate.plus(now.accel.scaled(0.5 * t)).scaled(t));
        self.setpoint.rate = now.rate.plus(now.accel.scaled(t));
        self.moves = self.moves.saturating_sub(1);
        let angle = self.setpoint.angle;
        if self.moves == 0 || angle.pitch.abs() > self.pitch {
            self.rest_at(PerAxis { pitch: Real::clamp(angle.pitch, -self.pitch, self.pitch), ..angle });
        }
    }

    fn rest_at(&mut self, angle: PerAxis<f32>) {
        self.setpoint = Reference::at_rest(angle);
        self.moves = 0;
        self.landing = false;
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
    use crate::SAMPLE_TIME;
    use crate::gains;
    use crate::pipeline::Settings;
    use crate::plant::presets::HELI;

    fn parameters() -> Parameters {
        Parameters::new(&HELI, &Settings::paper(&HELI, gains::PAPER, SAMPLE_TIME))
    }

    fn approach() -> Approach {
        Approach::new(&parameters())
    }

    fn moving(angle: f32, rate: f32) -> Reference<f32> {
        Reference { angle: PerAxis::both(angle), rate: PerAxis::both(rate), accel: PerAxis::zero() }
    }

    /// Without a new one; with a new one in time it goes on for ever.
    #[test]
    fn a_setpoint_that_moves_comes_to_rest_after_half_a_second() {
        let mut alone = approach();
        alone.aim(moving(0.0, 1.0));
        let ends: std::vec::Vec<_> = (0..30_000).map(|_| alone.step()).collect();
        assert!((ends[499].angle.yaw - 0.499).abs() < 1e-4 && ends[499].rate.yaw == 1.0);
        for end in &ends[500..] {
            assert_eq!(*end, Reference::at_rest(end.angle));
            assert!((end.angle.yaw - 0.5).abs() < 1e-4, "{end:?}");
        }
        let mut followed = approach();
        for tick in 0..5_000_u16 {
            if tick % 499 == 0 {
                followed.aim(Reference {
                    rate: PerAxis::new(0.0, 1.0),
                    ..Reference::at_rest(PerAxis::new(0.0, f32::from(tick) * 1e-3))
                });
            }
            assert_eq!(followed.step().rate.yaw, 1.0);
        }
    }

    #[test]
    fn a_setpoint_that_moves_stops_at_the_envelope() {
        let limit = parameters().limits.pitch;
        for way in [1.0, -1.0] {
            let mut approach = approach();
            approach.aim(moving(way * (limit - 0.1), way * 2.0));
            for _ in 0..1_000 {
                assert!(approach.step().angle.pitch.abs() <= limit);
            }
            assert_eq!(approach.step(), Reference::at_rest(approach.idle().angle));
            assert_eq!(approach.idle().angle.pitch, way * limit);
        }
    }

    #[test]
    fn a_lost_link_lands_at_the_stated_rate_and_yaw_stays() {
        let mut parameters = parameters();
        parameters.limits.lost_link = LostLink::Land;
        let mut approach = Approach::new(&parameters);
        approach.aim(moving(0.1, 0.5));
        approach.step();
        let before = approach.step();
        approach.lose_link();
        assert!(!approach.has_landed());
        let mut ticks = 0_u16;
        while !approach.has_landed() {
            let now = approach.step();
            assert!((now.angle.yaw - before.angle.yaw).abs() < 1e-3);
            assert!((now.angle.pitch - (before.angle.pitch - 0.5e-3 * f32::from(ticks))).abs() < 2e-3);
            ticks += 1;
        }
        // From .1 rad to 40.5 degrees below level at .5 rad/s.
        let seconds = (0.1 + f32::from_f64(-HELI.rest_angle.pitch)) / 0.5;
        assert!((f32::from(ticks) * 1e-3 - seconds).abs() < 0.01, "{ticks}");
        assert!((approach.idle().angle.pitch - f32::from_f64(HELI.rest_angle.pitch)).abs() < 2e-3);
        approach.aim(moving(0.0, 0.0));
        assert!(!approach.has_landed(), "a setpoint means that the host is back");
    }

    #[test]
    fn it_starts_where_the_rig_is_and_ends_at_the_setpoint_at_the_stated_rate() {
        let mut approach = approach();
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
        let mut approach = approach();
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
        let mut approach = approach();
        approach.aim(Reference::at_rest(PerAxis::new(f32::NAN, 0.0)));
        assert_eq!(approach.step(), Reference::default());
    }
}
