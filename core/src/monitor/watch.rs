//! The rules by which an axis disagrees with its motors, names as in `motion.rs`:
//!
//! ```text
//! contradicts: |expected| > least  and  observed sign(expected) < MOTION_SHARE |expected|
//!              and |expected - observed| > what a disturbance or what `against.rs` has explains,
//!              MOTION_TICKS in a row, AGAINST_TICKS while     a swapped sign, a stuck encoder
//!              the rate is against expected
//! stuck:       still, and due > most, where                   a stuck encoder as the reference moves on
//!              change = min(|push - push when it became still|, |expected|)
//!              due   <- due + T change    if change > least and the axis is wanted over most away;
//!              due   <- 0                 if not still
//! ```

use super::motion::{AGAINST_TICKS, MOTION_EVERY, MOTION_SHARE, MOTION_TICKS, STILL_TICKS};
use super::persistence::Persistence;
use crate::real::{Count, Mask, Real};

/// The two rules of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Watch<R: Real> {
    /// \[rad/s\] From where on an expected rate counts.
    least: R,
    /// \[rad/s\] By how much a disturbance by volts may part what is observed from what is expected.
    disturbed: R,
    disagreement: Persistence<R>,
    pub(super) stillness: Stillness<R>,
}

impl<R: Real<Scalar = f32>> Watch<R> {
    pub(super) fn new(least: R, disturbed: R, least_change: R, most: R) -> Self {
        let stillness = Stillness {
            away: R::Count::whole(0),
            still: Persistence::default(),
            push: R::zero(),
            least: least_change,
            due: R::zero(),
            most,
        };
        Self { least, disturbed, disagreement: Persistence::default(), stillness }
    }

    pub(super) fn restart(self) -> Self {
        let stillness = Stillness {
            away: R::Count::whole(0),
            still: Persistence::default(),
            due: R::zero(),
            ..self.stillness
        };
        Self { disagreement: Persistence::default(), stillness, ..self }
    }

    /// Less than its share of the expected motion is seen, and nothing sound explains what is missing.
    /// `late`: what late rotors push less by \[rad/s\]. `explained`: what else explains, from what a
    /// disturbance by volts does \[rad/s\], whether the push is negative, and whether the axis moves against
    /// it.
    #[inline(always)]
    pub(super) fn contradicts(
        &mut self,
        expected: R,
        observed: R,
        rate: R,
        late: R,
        explained: impl FnOnce(R, R::Mask, R::Mask) -> R,
    ) -> R::Mask {
        let size = expected.abs();
        let down = expected.lt(R::zero());
        let along = |x: R| R::select(down, -x, x);
        let against = || along(rate).lt(R::zero());
        let contradicts = self.least.lt(size).and(
            #[inline(always)]
            || {
                let seen = along(observed);
                let share = R::splat(MOTION_SHARE) * size;
                seen.lt(share).and(
                    #[inline(always)]
                    || {
                        let moves = against();
                        let late = R::select(moves, along(late).max(R::zero()), R::zero());
                        (explained(self.disturbed, down, moves) + late).lt(size - seen)
                    },
                )
            },
        );
        self.disagreement.over(contradicts, MOTION_TICKS / MOTION_EVERY).and(
            #[inline(always)]
            || !against() | self.disagreement.is_over(AGAINST_TICKS / MOTION_EVERY),
        )
    }
}

/// An encoder that does not move, and what it should have moved by.
///
/// A load that the model does not know (a weight, a hand, a disturbance) does not change with the push; so a
/// change of the push moves even a loaded axis, and less of it is enough than for a comparison of rates. A
/// disturbance that changes while the loop holds against it changes the push too, and an axis that is held
/// well stands still: there only a push towards somewhere else counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stillness<R: Real> {
    /// \[counts\] How far the encoder is from where it has been still.
    pub(super) away: R::Count,
    still: Persistence<R>,
    /// \[rad/s\] The push when it became still.
    push: R,
    /// \[rad/s\] From where on a change of the push counts.
    least: R,
    /// \[rad\] How far that should have moved the axis.
    due: R,
    /// \[rad\] When that is too far; and the least that the axis must be away from where it is wanted.
    most: R,
}

impl<R: Real> Stillness<R> {
    /// True once the axis should have moved too far. `wanted`: where it is to be, and where it seems to be
    /// \[rad\]. `lies`: on its stop, where being still is no wonder.
    #[inline(always)]
    pub(super) fn is_stuck(
        &mut self,
        push: R,
        expected: R,
        wanted: (R, R),
        lies: R::Mask,
        step: R,
    ) -> R::Mask {
        let gone = self.away.exceeds(R::Count::whole(1));
        self.away = R::Count::pick(gone, R::Count::whole(0), self.away);
        let still = self.still.over(!(gone | lies), STILL_TICKS / MOTION_EVERY);
        self.push = R::select(still, self.push, push);
        let due = R::select(still, self.due, R::zero());
        let change = (push - self.push).abs().min(expected.abs());
        let counts = self.least.lt(change).and(
            #[inline(always)]
            || self.most.lt((wanted.0 - wanted.1).abs()),
        );
        self.due = if counts.any() { R::select(counts, due + change * step, due) } else { due };
        self.most.lt(self.due)
    }
}
