//! The rules by which an axis disagrees with its motors, names as in `motion.rs`:
//!
//! ```text
//! contradicts: |expected| > least  and  observed sign(expected) < MOTION_SHARE |expected|
//!              and |expected - observed| > what a disturbance explains,
//!              MOTION_TICKS in a row                          a swapped sign, a stuck encoder
//! stuck:       still, and due > most, where                   a stuck encoder as the reference moves on
//!              change = min(|push - push when it became still|, |expected|)
//!              due   <- due + T change    if change > least and the axis is wanted over most away;
//!              due   <- 0                 if not still
//! ```

use super::motion::{MOTION_EVERY, MOTION_SHARE, MOTION_TICKS, STILL_TICKS};
use super::persistence::Persistence;
use crate::real::Real;

/// \[rad/s\] By how much a disturbance may part what is observed from what is expected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Parted {
    /// While hardly anything moves.
    pub(super) at_rest: f32,
    /// While the axis moves against what is expected.
    pub(super) against: f32,
}

/// The two rules of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Watch {
    /// \[rad/s\] From where on an expected rate counts.
    least: f32,
    parted: Parted,
    disagreement: Persistence,
    pub(super) stillness: Stillness,
}

impl Watch {
    pub(super) fn new(least: f32, parted: Parted, least_change: f32, most: f32) -> Self {
        let stillness = Stillness {
            away: 0,
            still: Persistence::default(),
            push: 0.0,
            least: least_change,
            due: 0.0,
            most,
        };
        Self { least, parted, disagreement: Persistence::default(), stillness }
    }

    pub(super) fn restart(self) -> Self {
        let stillness = Stillness { away: 0, still: Persistence::default(), due: 0.0, ..self.stillness };
        Self { disagreement: Persistence::default(), stillness, ..self }
    }

    /// Less than its share of the expected motion, in its direction, and no disturbance explains that.
    #[inline(always)]
    pub(super) fn contradicts(&mut self, expected: f32, observed: f32) -> bool {
        let (size, along) = if expected < 0.0 { (-expected, -observed) } else { (expected, observed) };
        let share = MOTION_SHARE * size;
        let contradicts = size > self.least
            && along < share
            && size - along > if along < -share { self.parted.against } else { self.parted.at_rest };
        self.disagreement.over(contradicts, MOTION_TICKS / MOTION_EVERY)
    }
}

/// An encoder that does not move, and what it should have moved by.
///
/// A load that the model does not know (a weight, a hand, a disturbance) does not change with the push; so a
/// change of the push moves even a loaded axis, and less of it is enough than for a comparison of rates. A
/// disturbance that changes while the loop holds against it changes the push too, and an axis that is held
/// well stands still: there only a push towards somewhere else counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stillness {
    /// \[counts\] How far the encoder is from where it has been still.
    pub(super) away: i32,
    still: Persistence,
    /// \[rad/s\] The push when it became still.
    push: f32,
    /// \[rad/s\] From where on a change of the push counts.
    least: f32,
    /// \[rad\] How far that should have moved the axis.
    due: f32,
    /// \[rad\] When that is too far; and the least that the axis must be away from where it is wanted.
    most: f32,
}

impl Stillness {
    /// True once the axis should have moved too far. `wanted`: where it is to be, and where it seems to be
    /// \[rad\]. `lies`: on its stop, where being still is no wonder.
    #[inline(always)]
    pub(super) fn is_stuck(
        &mut self,
        push: f32,
        expected: f32,
        wanted: (f32, f32),
        lies: bool,
        step: f32,
    ) -> bool {
        let near = self.away.unsigned_abs() <= 1;
        if !near {
            self.away = 0;
        }
        if !self.still.over(near && !lies, STILL_TICKS / MOTION_EVERY) {
            self.push = push;
            self.due = 0.0;
        }
        let change = Real::min((push - self.push).abs(), expected.abs());
        if change > self.least && (wanted.0 - wanted.1).abs() > self.most {
            self.due += change * step;
        }
        self.due > self.most
    }
}
