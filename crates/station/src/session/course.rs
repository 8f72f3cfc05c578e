//! Setpoints over time.

use twinrotor::axes::PerAxis;
use twinrotor::reference::Reference;

/// \[ticks\] From one setpoint of a course that moves to the next: a board moves it on by itself in between.
const EVERY: u32 = 10;
/// \[ticks\] After which a setpoint is said again, lest the line has lost it.
const AGAIN: u32 = 200;

/// References, a tick each, handed out as setpoints when they are due.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    references: Vec<Reference<f32>>,
    last: Option<(u32, Reference<f32>)>,
}

impl Course {
    /// Of these references.
    #[must_use]
    pub const fn new(references: Vec<Reference<f32>>) -> Self {
        Self { references, last: None }
    }

    /// From `from` \[rad\] to `to` at `rate` \[rad/s\], each axis on its own, and a moment's rest there.
    pub(super) fn ramp(from: PerAxis<f32>, to: PerAxis<f32>, rate: f32, sample_time: f32) -> Self {
        let way = to.minus(from);
        let longest = way.pitch.abs().max(way.yaw.abs());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few seconds of ticks")]
        let ticks = (longest / (rate * sample_time)).ceil() as u32;
        #[expect(clippy::cast_precision_loss, reason = "a few seconds of ticks")]
        let on_the_way = |tick: u32| {
            let gone = rate * sample_time * tick as f32;
            let angle = way.map(|way| way.signum() * gone.min(way.abs()));
            let moving = way.map(|way| if gone < way.abs() { way.signum() * rate } else { 0.0 });
            Reference { angle: from.plus(angle), rate: moving, accel: PerAxis::zero() }
        };
        const REST: usize = 500;
        let rest = std::iter::repeat_n(Reference::at_rest(to), REST);
        Self::new((0..ticks).map(on_the_way).chain(rest).collect())
    }

    /// \[ticks\] How long it is.
    #[must_use]
    pub fn ticks(&self) -> u32 {
        u32::try_from(self.references.len()).unwrap_or(u32::MAX)
    }

    /// Where it ends.
    pub(super) fn end(&self) -> PerAxis<f32> {
        self.references.last().map_or(PerAxis::zero(), |reference| reference.angle)
    }

    /// The setpoint to be said for `tick` of the course, if one is.
    pub fn due(&mut self, tick: u32) -> Option<Reference<f32>> {
        let reference = *self.references.get(tick as usize).or(self.references.last())?;
        let due = self.last.is_none_or(|(at, last)| {
            let rests = |reference: &Reference<f32>| *reference == Reference::at_rest(reference.angle);
            let jumps = rests(&reference) || rests(&last);
            let passed = tick.saturating_sub(at);
            passed >= AGAIN || reference != last && (jumps || passed >= EVERY)
        });
        if due {
            self.last = Some((tick, reference));
        }
        due.then_some(reference)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_is_said_in_its_tick_and_again_now_and_then() {
        let at = |pitch| Reference::at_rest(PerAxis::new(pitch, 0.0));
        let mut course = Course::new([vec![at(0.0); 300], vec![at(0.1); 300]].concat());
        let said: Vec<u32> = (0..600).filter(|&tick| course.due(tick).is_some()).collect();
        assert_eq!(said, [0, 200, 300, 500]);
    }

    #[test]
    fn what_moves_is_said_a_hundred_times_a_second() {
        let mut course = Course::ramp(PerAxis::new(0.2, 1.0), PerAxis::new(-0.3, 1.0), 0.5, 1e-3);
        let said: Vec<(u32, Reference<f32>)> =
            (0..course.ticks()).filter_map(|tick| course.due(tick).map(|r| (tick, r))).collect();
        assert!(said[..100].iter().enumerate().all(|(k, (tick, _))| *tick == 10 * k as u32));
        let (_, half) = said[50];
        assert!((half.angle.pitch + 0.05).abs() < 1e-4 && half.rate.pitch == -0.5 && half.rate.yaw == 0.0);
        assert_eq!(said.last().unwrap().1, Reference::at_rest(PerAxis::new(-0.3, 1.0)));
        assert!(course.ticks() >= 1_500);
    }
}
