//! How any structure of numbers is gone through: by position, in the order of its declaration.

use crate::axes::{PerAxis, PerMotor};
use crate::real::Real;

/// A structure whose leaves are numbers, or switches that count as 0 or 1.
pub trait Leaves<R>: Copy {
    /// The same structure of other numbers.
    type Of<U>;

    /// Each number through `f`. Switches stay as they are.
    fn map_each<U, F: FnMut(R) -> U>(self, f: &mut F) -> Self::Of<U>;

    /// Replaces each leaf by what `f` makes of it and its position, of which the first is `first`. Gives the
    /// position after the last. What is left out keeps its positions.
    fn change<F: FnMut(usize, R) -> R>(&mut self, first: usize, f: &mut F) -> usize;
}

/// A structure that is made of its leaves alone.
pub trait Build<R>: Leaves<R> {
    /// Made of what `f` gives for each position, and the position after the last. What can be left out is.
    fn build<F: FnMut(usize) -> R>(first: usize, f: &mut F) -> (Self, usize);
}

/// A structure that always has the same number of leaves.
pub trait Fixed {
    /// How many.
    const COUNT: usize;
}

impl<R: Real> Fixed for R {
    const COUNT: usize = 1;
}

impl<R: Real> Leaves<R> for R {
    type Of<U> = U;

    fn map_each<U, F: FnMut(R) -> U>(self, f: &mut F) -> U {
        f(self)
    }

    fn change<F: FnMut(usize, R) -> R>(&mut self, first: usize, f: &mut F) -> usize {
        *self = f(first, *self);
        first + 1
    }
}

impl<R: Real> Build<R> for R {
    fn build<F: FnMut(usize) -> R>(first: usize, f: &mut F) -> (Self, usize) {
        (f(first), first + 1)
    }
}

impl<R: Real> Leaves<R> for bool {
    type Of<U> = bool;

    fn map_each<U, F: FnMut(R) -> U>(self, _f: &mut F) -> bool {
        self
    }

    fn change<F: FnMut(usize, R) -> R>(&mut self, first: usize, f: &mut F) -> usize {
        *self = f(first, if *self { R::one() } else { R::zero() }) != R::zero();
        first + 1
    }
}

impl<R: Real> Build<R> for bool {
    fn build<F: FnMut(usize) -> R>(first: usize, f: &mut F) -> (Self, usize) {
        (f(first) != R::zero(), first + 1)
    }
}

macro_rules! pair {
    ($name:ident, $first:ident, $second:ident) => {
        impl<T: Fixed> Fixed for $name<T> {
            const COUNT: usize = 2 * T::COUNT;
        }

        impl<R: Real, T: Leaves<R>> Leaves<R> for $name<T> {
            type Of<U> = $name<T::Of<U>>;

            fn map_each<U, F: FnMut(R) -> U>(self, f: &mut F) -> Self::Of<U> {
                $name { $first: self.$first.map_each(f), $second: self.$second.map_each(f) }
            }

            fn change<F: FnMut(usize, R) -> R>(&mut self, first: usize, f: &mut F) -> usize {
                let second = self.$first.change(first, f);
                self.$second.change(second, f)
            }
        }

        impl<R: Real, T: Build<R>> Build<R> for $name<T> {
            fn build<F: FnMut(usize) -> R>(first: usize, f: &mut F) -> (Self, usize) {
                let ($first, second) = T::build(first, f);
                let ($second, end) = T::build(second, f);
                ($name { $first, $second }, end)
            }
        }
    };
}

pair!(PerAxis, pitch, yaw);
pair!(PerMotor, main, tail);

impl<R: Real, T: Leaves<R> + Fixed> Leaves<R> for Option<T> {
    type Of<U> = Option<T::Of<U>>;

    fn map_each<U, F: FnMut(R) -> U>(self, f: &mut F) -> Self::Of<U> {
        self.map(|values| values.map_each(f))
    }

    fn change<F: FnMut(usize, R) -> R>(&mut self, first: usize, f: &mut F) -> usize {
        if let Some(values) = self {
            values.change(first, f);
        }
        first + T::COUNT
    }
}

impl<R: Real, T: Build<R> + Fixed> Build<R> for Option<T> {
    fn build<F: FnMut(usize) -> R>(first: usize, _f: &mut F) -> (Self, usize) {
        (None, first + T::COUNT)
    }
}
