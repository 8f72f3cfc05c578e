//! The arithmetic that the core needs, and nothing more.
//!
//! Every equation of the core is written once over [`Real`] and runs as `f32` on the board, as `f64` in
//! verification, and in lanes of `f32` in the tuner. Every `Real` that is `f32` inside must give the same
//! bits on every machine, so:
//!
//! - only IEEE 754 basic operations are required of an implementation (`+ - * /`, square root, comparison):
//!   they are exactly rounded everywhere; there is no fused multiply-add;
//! - `min`, `max`, `clamp` and `round` are *defined* here from comparison and selection, because the built-in
//!   ones differ between scalar and vector types in what they do with NaN and signed zero;
//! - sine and cosine are the one routine in [`trig`].

mod count;
mod scalar;
pub mod trig;

pub use count::Count;

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// 1.5 x 2^23: an `f32` below 2^22 that this is added to and taken from again is rounded to a whole number, a
/// tie to the even one, by the rounding of IEEE 754 itself.
pub const ROUND_F32: f32 = 12_582_912.0;

/// The outcome of a comparison: one truth value, or one for each lane.
pub trait Mask:
    Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> + Send + Sync + 'static
{
    /// The same truth value in every lane.
    fn splat(value: bool) -> Self;
    /// Is it true in at least one lane?
    fn any(self) -> bool;
    /// Is it true in every lane?
    fn all(self) -> bool;
    /// Is it true in lane `index`, which is below [`Real::LANES`]? A plain truth value has but one lane,
    /// whatever the index.
    fn lane(self, index: usize) -> bool;

    /// Both. The other one is only asked for where this one is true in at least one lane.
    #[inline(always)]
    fn and(self, other: impl FnOnce() -> Self) -> Self {
        if self.any() { self & other() } else { self }
    }
}

/// A real number, or a group of independent ones that are computed side by side.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// What a comparison gives.
    type Mask: Mask;
    /// Whole numbers that are counted beside it.
    type Count: Count<Self::Mask>;
    /// The number in one lane; `Self` for a plain number.
    type Scalar: Real<Scalar = Self::Scalar, Mask = bool> + Into<f64>;
    /// How many numbers are computed side by side.
    const LANES: usize;

    /// The nearest representable number. Constants and gains enter this way and never by way of `f32`,
    /// which alone would cost 1e-8 rad in an `f64` run.
    fn from_f64(value: f64) -> Self;
    /// The nearest representable number to an integer, such as an encoder's count.
    fn from_i32(value: i32) -> Self;
    /// The same number in every lane.
    fn splat(value: Self::Scalar) -> Self;
    /// Lane k holds what `f` gives for k.
    fn from_fn(f: impl FnMut(usize) -> Self::Scalar) -> Self;
    /// The number in lane `index`, which is below [`Real::LANES`]. A plain number has but one lane, whatever
    /// the index.
    fn lane(self, index: usize) -> Self::Scalar;

    /// A whole number of this kind, far below 2^31, as a count.
    fn to_count(self) -> Self::Count;

    /// Magnitude.
    fn abs(self) -> Self;
    /// Square root, exactly rounded; NaN below zero.
    fn sqrt(self) -> Self;
    /// Sine and cosine of an angle in rad.
    fn sin_cos(self) -> (Self, Self);

    /// Is `self < other`? False with a NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// Is `self <= other`? False with a NaN.
    fn le(self, other: Self) -> Self::Mask;
    /// Neither infinite nor NaN?
    fn is_finite(self) -> Self::Mask;
    /// `yes` where the mask is true, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }

    /// One.
    #[inline(always)]
    fn one() -> Self {
        Self::from_f64(1.0)
    }

    /// The smaller of two; `other` if either is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }

    /// The larger of two; `other` if either is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }

    /// Limited to `low..=high`. A NaN comes out as a bound: this is no guard against one.
    #[inline(always)]
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }

    /// The nearest integer, ties to even, for magnitudes below 2^22; larger ones come back as they are.
    #[inline(always)]
    fn round(self) -> Self {
        let limit = Self::from_f64(4_194_304.0);
        Self::select(self.abs().lt(limit), self.round_small(), self)
    }

    /// [`Real::round`] without the guard: garbage from magnitude 2^22 on.
    ///
    /// Adding 1.5 x 2^(significand bits - 1) pushes every fraction bit out of the significand, and the
    /// addition itself rounds.
    #[doc(hidden)]
    fn round_small(self) -> Self;
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn round_is_to_nearest_even(x in -4_000_000.0_f32..4_000_000.0) {
            prop_assert_eq!(Real::round(x), x.round_ties_even());
        }

        #[test]
        fn min_max_clamp_are_ordered(a in any::<f64>(), b in -1e3..0.0, c in 0.0..1e3) {
            prop_assume!(!a.is_nan());
            let x = Real::clamp(a, b, c);
            prop_assert!(b <= x && x <= c && (x == a || x == b || x == c));
        }
    }

    #[test]
    fn large_magnitudes_and_non_finite_pass_round_unchanged() {
        for x in [4_194_304.5_f32, -1e30, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(Real::round(x), x);
        }
        assert!(Real::round(f32::NAN).is_nan());
    }

    #[test]
    fn a_nan_gives_the_second_operand() {
        assert_eq!(Real::min(f32::NAN, 1.0), 1.0);
        assert_eq!(Real::max(f32::NAN, 1.0), 1.0);
        assert_eq!(Real::clamp(f32::NAN, -24.0, 24.0), -24.0);
    }
}
