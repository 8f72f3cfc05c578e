//! Many `f32` side by side, each bit for bit what a plain `f32` would be.
//!
//! An array and loops over it, and nothing else: the compiler turns them into the vector instructions of whatever processor the
//! calling function is compiled for, and into plain ones elsewhere. IEEE 754 makes both the same.

use crate::real::{Mask, Real};
use core::array::from_fn;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// `N` numbers that are computed side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes<const N: usize>([f32; N]);

/// `N` truth values, each all ones or all zeros.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(64))]
pub struct LaneMask<const N: usize>([u32; N]);

impl<const N: usize> Lanes<N> {
    /// Lane k holds what `f` gives for k.
    #[inline(always)]
    pub fn from_fn(f: impl FnMut(usize) -> f32) -> Self {
        Self(from_fn(f))
    }

    /// All lanes.
    #[inline(always)]
    pub fn to_array(self) -> [f32; N] {
        self.0
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }
}

impl<const N: usize> LaneMask<N> {
    /// Lane k is what `f` gives for k.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize) -> bool) -> Self {
        Self(from_fn(|k| if f(k) { u32::MAX } else { 0 }))
    }

    /// Is lane `index` true?
    #[inline(always)]
    pub fn lane(self, index: usize) -> bool {
        self.0.get(index).is_some_and(|m| *m != 0)
    }
}

impl<const N: usize> Default for Lanes<N> {
    fn default() -> Self {
        Self([0.0; N])
    }
}

/// Lane by lane through `$f`. The loop runs over two arrays in step: the form that vectorises.
macro_rules! lane_by_lane {
    ($a:expr, $b:expr, $f:expr) => {{
        let (a, b) = ($a, $b);
        let mut result = a;
        for (x, y) in result.iter_mut().zip(b) {
            *x = $f(*x, y);
        }
        result
    }};
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const N: usize> $trait for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(lane_by_lane!(self.0, other.0, |a, b| a $op b))
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

macro_rules! mask_operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const N: usize> $trait for LaneMask<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(lane_by_lane!(self.0, other.0, |a, b| a $op b))
            }
        }
    };
}
mask_operator!(BitAnd, bitand, &);
mask_operator!(BitOr, bitor, |);

impl<const N: usize> Not for LaneMask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(|m| !m))
    }
}

impl<const N: usize> Mask for LaneMask<N> {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self([if value { u32::MAX } else { 0 }; N])
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.iter().fold(0, |all, m| all | m) != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0.iter().fold(u32::MAX, |all, m| all & m) != 0
    }
}

impl<const N: usize> Real for Lanes<N> {
    type Mask = LaneMask<N>;
    type Scalar = f32;
    const LANES: usize = N;

    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self([f32::from_f64(value); N])
    }
    #[inline(always)]
    fn from_i32(value: i32) -> Self {
        Self([f32::from_i32(value); N])
    }
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn lane(self, index: usize) -> f32 {
        self.0.get(index % N).copied().unwrap_or_default()
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f32::abs)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(<f32 as Real>::sqrt)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        crate::trig::sin_cos(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> LaneMask<N> {
        compare(self, other, |a, b| a < b)
    }
    #[inline(always)]
    fn le(self, other: Self) -> LaneMask<N> {
        compare(self, other, |a, b| a <= b)
    }
    #[inline(always)]
    fn is_finite(self) -> LaneMask<N> {
        self.abs().lt(Self::splat(f32::INFINITY))
    }
    #[inline(always)]
    fn select(mask: LaneMask<N>, yes: Self, no: Self) -> Self {
        let mut result = no.0;
        for (r, (m, y)) in result.iter_mut().zip(mask.0.into_iter().zip(yes.0)) {
            *r = f32::from_bits((m & y.to_bits()) | (!m & r.to_bits()));
        }
        Self(result)
    }
    #[inline(always)]
    fn round_small(self) -> Self {
        self.map(|a| a.round_small())
    }
}

#[inline(always)]
fn compare<const N: usize>(a: Lanes<N>, b: Lanes<N>, holds: impl Fn(f32, f32) -> bool) -> LaneMask<N> {
    let mut result = [0; N];
    for (r, (a, b)) in result.iter_mut().zip(a.0.into_iter().zip(b.0)) {
        *r = if holds(a, b) { u32::MAX } else { 0 };
    }
    LaneMask(result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Any bit pattern: NaN, infinities, subnormals and signed zeros included.
    fn any_float() -> impl Strategy<Value = f32> {
        any::<u32>().prop_map(f32::from_bits)
    }

    fn same(lanes: Lanes<4>, scalar: impl Fn(usize) -> f32) -> Result<(), TestCaseError> {
        for k in 0..4 {
            let (a, b) = (lanes.lane(k), scalar(k));
            prop_assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()), "lane {k}: {a} {b}");
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn every_operation_is_the_scalar_one(
            x in prop::array::uniform4(any_float()),
            y in prop::array::uniform4(any_float()),
            small in prop::array::uniform4(-1e4_f32..1e4),
        ) {
            let (a, b) = (Lanes::from_fn(|k| x[k]), Lanes::from_fn(|k| y[k]));
            same(a + b, |k| x[k] + y[k])?;
            same(a - b, |k| x[k] - y[k])?;
            same(a * b, |k| x[k] * y[k])?;
            same(a / b, |k| x[k] / y[k])?;
            same(-a, |k| -x[k])?;
            same(a.abs(), |k| x[k].abs())?;
            same(a.sqrt(), |k| Real::sqrt(x[k]))?;
            same(a.min(b), |k| Real::min(x[k], y[k]))?;
            same(a.max(b), |k| Real::max(x[k], y[k]))?;
            same(a.round(), |k| Real::round(x[k]))?;
            let angle = Lanes::from_fn(|k| small[k]);
            same(angle.sin_cos().0, |k| Real::sin_cos(small[k]).0)?;
            same(angle.sin_cos().1, |k| Real::sin_cos(small[k]).1)?;
            let finite = a.is_finite();
            for k in 0..4 {
                prop_assert_eq!(finite.lane(k), x[k].is_finite());
                prop_assert_eq!(a.lt(b).lane(k), x[k] < y[k]);
                prop_assert_eq!(a.le(b).lane(k), x[k] <= y[k]);
            }
            prop_assert_eq!(finite.any(), x.iter().any(|v| v.is_finite()));
            prop_assert_eq!(finite.all(), x.iter().all(|v| v.is_finite()));
        }
    }
}
