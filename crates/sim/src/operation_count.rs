//! A number that counts what is done with it: how many floating-point operations a step of a closed loop
//! takes.

use std::cell::Cell;
use std::ops::{Add, Div, Mul, Neg, Sub};
use twinrotor::real::{ROUND_F32, Real};

thread_local! {
    static OPERATIONS: Cell<u64> = const { Cell::new(0) };
}

/// The floating-point operations that `work` does with [`Counted`] numbers on this thread: additions,
/// subtractions, multiplications, divisions, square roots and comparisons; signs and selections are bits and
/// not counted.
pub fn operations(work: impl FnOnce()) -> u64 {
    let before = OPERATIONS.get();
    work();
    OPERATIONS.get() - before
}

/// An `f32` that counts.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Counted(f32);

fn counted<T>(result: T) -> T {
    OPERATIONS.set(OPERATIONS.get() + 1);
    result
}

impl From<Counted> for f64 {
    fn from(number: Counted) -> Self {
        Self::from(number.0)
    }
}

macro_rules! operator {
    ($($trait:ident $method:ident),+) => {$(
        impl $trait for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                counted(Self(self.0.$method(other.0)))
            }
        }
    )+};
}
operator!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Real for Counted {
    type Mask = bool;
    type Count = i32;
    type Scalar = Self;
    const LANES: usize = 1;

    fn from_f64(value: f64) -> Self {
        Self(f32::from_f64(value))
    }
    fn from_i32(value: i32) -> Self {
        Self(f32::from_i32(value))
    }
    fn splat(value: Self) -> Self {
        value
    }
    fn from_fn(mut f: impl FnMut(usize) -> Self) -> Self {
        f(0)
    }
    fn lane(self, _index: usize) -> Self {
        self
    }
    fn to_count(self) -> i32 {
        self.0.to_count()
    }
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    fn sqrt(self) -> Self {
        counted(Self(Real::sqrt(self.0)))
    }
    fn sin_cos(self) -> (Self, Self) {
        twinrotor::real::trig::sin_cos(self)
    }
    fn lt(self, other: Self) -> bool {
        counted(self.0 < other.0)
    }
    fn le(self, other: Self) -> bool {
        counted(self.0 <= other.0)
    }
    fn is_finite(self) -> bool {
        counted(self.0.is_finite())
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    fn round_small(self) -> Self {
        let shift = Self(ROUND_F32);
        (self + shift) - shift
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_is_counted_by_hand() {
        let x = Counted::from_f64(0.5);
        assert_eq!(operations(|| _ = x * x + x / x - x.sqrt()), 5);
        assert_eq!(operations(|| _ = -x.abs()), 0);
    }
}
