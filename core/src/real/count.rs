//! Whole numbers beside a [`Real`](super::Real): encoders' counts, and ticks in a row.

use super::Mask;
use core::fmt::Debug;

/// A whole number, or one for each lane, that comparisons of kind `M` choose between: an `i32` beside a plain
/// number; in lanes at most 2^24, which no flight reaches.
pub trait Count<M: Mask>: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// The same number in every lane.
    fn whole(number: i32) -> Self;
    /// The sum; an `i32` wraps around.
    #[must_use]
    fn plus(self, other: Self) -> Self;
    /// One more; the largest stays.
    #[must_use]
    fn one_more(self) -> Self;
    /// Is it `least` or more?
    fn reaches(self, least: i32) -> M;
    /// Is its magnitude above `most`, which is 0 or more?
    fn exceeds(self, most: Self) -> M;
    /// `yes` where the mask is true, else `no`.
    #[must_use]
    fn pick(mask: M, yes: Self, no: Self) -> Self;
}

impl Count<bool> for i32 {
    #[inline(always)]
    fn whole(number: i32) -> Self {
        number
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.wrapping_add(other)
    }
    #[inline(always)]
    fn one_more(self) -> Self {
        // Saturates, as the board's compiler does it in the fewest instructions.
        if self == i32::MAX { self } else { self.wrapping_add(1) }
    }
    #[inline(always)]
    fn reaches(self, least: i32) -> bool {
        self >= least
    }
    #[inline(always)]
    fn exceeds(self, most: Self) -> bool {
        self.unsigned_abs() > most.cast_unsigned()
    }
    #[inline(always)]
    fn pick(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}
