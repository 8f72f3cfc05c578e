//! The two axes and the two motors, kept apart by type.
//!
//! Torque, angle and gains belong to an axis, voltage to a motor. Only [`crate::allocation`] and
//! [`crate::plant::Effectiveness`] turn one into the other, so a wrong mixer order does not compile.

use crate::real::Real;
use serde::{Deserialize, Serialize};

/// One value for each axis of rotation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerAxis<T> {
    /// About the horizontal axis; nose up is positive (θ in the paper).
    pub pitch: T,
    /// About the vertical axis (ψ in the paper).
    pub yaw: T,
}

/// One value for each motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerMotor<T> {
    /// The main (front) rotor's motor (p in the paper); positive volts raise the nose.
    pub main: T,
    /// The tail (back) rotor's motor (y in the paper); positive volts turn yaw positive.
    pub tail: T,
}

macro_rules! pair {
    ($name:ident, $first:ident, $second:ident) => {
        impl<T> $name<T> {
            /// From the two values in order.
            #[inline(always)]
            pub const fn new($first: T, $second: T) -> Self {
                Self { $first, $second }
            }

            /// Applies `f` to both.
            #[inline(always)]
            pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> $name<U> {
                $name { $first: f(self.$first), $second: f(self.$second) }
            }

            /// Applies `f` to both, each with its partner in `other`.
            #[inline(always)]
            pub fn zip<U, V>(self, other: $name<U>, mut f: impl FnMut(T, U) -> V) -> $name<V> {
                $name { $first: f(self.$first, other.$first), $second: f(self.$second, other.$second) }
            }
        }

        impl<T: Copy> $name<T> {
            /// The same value twice.
            #[inline(always)]
            pub const fn both(value: T) -> Self {
                Self { $first: value, $second: value }
            }

            /// The two values in order.
            #[inline(always)]
            pub const fn to_array(self) -> [T; 2] {
                [self.$first, self.$second]
            }
        }

        impl<R: Real> $name<R> {
            /// Both zero.
            #[inline(always)]
            pub fn zero() -> Self {
                Self::both(R::zero())
            }

            /// Each sum.
            #[inline(always)]
            pub fn plus(self, other: Self) -> Self {
                self.zip(other, |a, b| a + b)
            }

            /// Each difference.
            #[inline(always)]
            pub fn minus(self, other: Self) -> Self {
                self.zip(other, |a, b| a - b)
            }

            /// Both multiplied by `factor`.
            #[inline(always)]
            pub fn scaled(self, factor: R) -> Self {
                self.map(|a| a * factor)
            }

            /// The same in every lane.
            #[inline(always)]
            pub fn splat(value: $name<R::Scalar>) -> Self {
                value.map(R::splat)
            }
        }

        impl $name<f64> {
            /// In the arithmetic `R`, each rounded once.
            #[inline(always)]
            pub fn cast<R: Real>(self) -> $name<R> {
                self.map(R::from_f64)
            }
        }
    };
}

pair!(PerAxis, pitch, yaw);
pair!(PerMotor, main, tail);
