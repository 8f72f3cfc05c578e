//! [`Real`] for the plain numbers `f32` and `f64`.

use super::{Mask, ROUND_F32, Real};

impl Mask for bool {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        value
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn lane(self, _index: usize) -> bool {
        self
    }
}

macro_rules! scalar {
    ($float:ty, $round:expr, $sqrt:path, $sin_cos:path, $from_f64:expr, $from_i32:expr) => {
        impl Real for $float {
            type Mask = bool;
            type Count = i32;
            type Scalar = Self;
            const LANES: usize = 1;

            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                $from_f64(value)
            }
            #[inline(always)]
            fn from_i32(value: i32) -> Self {
                $from_i32(value)
            }
            #[inline(always)]
            fn splat(value: Self) -> Self {
                value
            }
            #[inline(always)]
            fn from_fn(mut f: impl FnMut(usize) -> Self) -> Self {
                f(0)
            }
            #[inline(always)]
            fn lane(self, _index: usize) -> Self {
                self
            }
            #[inline(always)]
            #[expect(clippy::cast_possible_truncation, reason = "a whole number, far below 2^31")]
            fn to_count(self) -> i32 {
                self as i32
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$float>::abs(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                $sin_cos(self)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                <$float>::is_finite(self)
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
            #[inline(always)]
            fn round_small(self) -> Self {
                const SHIFT: $float = $round;
                (self + SHIFT) - SHIFT
            }
        }
    };
}

#[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is what it is for")]
const fn f32_from_f64(value: f64) -> f32 {
    value as f32
}

#[expect(clippy::cast_precision_loss, reason = "rounding to the nearest f32 is what it is for")]
const fn f32_from_i32(value: i32) -> f32 {
    value as f32
}

scalar!(f32, ROUND_F32, twinrotor_root::sqrt, super::trig::sin_cos, f32_from_f64, f32_from_i32);
scalar!(f64, 6_755_399_441_055_744.0, libm::sqrt, libm::sincos, f64::from, f64::from);
