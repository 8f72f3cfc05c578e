//! Conditions that count only once they have held for a while.

use crate::real::{Count, Real};
use core::hint::cold_path;

/// How long something has been so without a break.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Persistence<R: Real> {
    ticks: R::Count,
}

impl<R: Real> Default for Persistence<R> {
    fn default() -> Self {
        Self::of(0)
    }
}

impl<R: Real> Persistence<R> {
    /// That it has been so for `ticks` ticks.
    pub(super) fn of(ticks: i32) -> Self {
        Self { ticks: R::Count::whole(ticks) }
    }

    /// Takes this tick's `now`; true from the `limit`th in a row on.
    #[inline(always)]
    pub(super) fn over(&mut self, now: R::Mask, limit: i32) -> R::Mask {
        self.ticks = R::Count::pick(now, self.ticks.one_more(), R::Count::whole(0));
        self.ticks.reaches(limit)
    }
}

impl Persistence<f32> {
    /// The same, but that one good tick undoes one bad one: true once there were `limit` more bad ones.
    #[inline(always)]
    pub(super) fn over_more_often(&mut self, now: bool, limit: i32) -> bool {
        if !now && self.ticks == 0 {
            return false;
        }
        cold_path();
        self.ticks = if now { Ord::min(self.ticks.one_more(), limit) } else { Ord::max(self.ticks - 1, 0) };
        self.ticks >= limit
    }
}
