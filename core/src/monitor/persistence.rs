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
        Self { ticks: R::Count::whole(0) }
    }
}

impl<R: Real> Persistence<R> {
    /// Takes this tick's `now`; true from the `limit`th in a row on.
    #[inline(always)]
    pub(super) fn over(&mut self, now: R::Mask, limit: u32) -> R::Mask {
        self.ticks = R::Count::pick(now, self.ticks.one_more(), R::Count::whole(0));
        self.ticks.reaches(limit.cast_signed())
    }

    /// True from the `limit`th in a row on, this tick's counted.
    #[inline(always)]
    pub(super) fn is_over(&self, limit: u32) -> R::Mask {
        self.ticks.reaches(limit.cast_signed())
    }
}

/// How often what is the exception has been so, on a board.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Exception {
    ticks: u32,
}

impl Exception {
    /// That it has been so for `ticks` ticks.
    pub(super) fn of(ticks: u32) -> Self {
        Self { ticks }
    }

    /// Takes this tick's `now`; true from the `limit`th in a row on.
    #[inline(always)]
    pub(super) fn in_a_row(&mut self, now: bool, limit: u32) -> bool {
        if !now {
            self.ticks = 0;
            return false;
        }
        cold_path();
        self.ticks = self.ticks.saturating_add(1);
        self.ticks >= limit
    }

    /// Takes this tick's `now`; one good tick undoes one bad one: true once there were `limit` more bad ones.
    #[inline(always)]
    pub(super) fn more_often(&mut self, now: bool, limit: u32) -> bool {
        if !now && self.ticks == 0 {
            return false;
        }
        cold_path();
        self.ticks =
            if now { Ord::min(self.ticks.saturating_add(1), limit) } else { self.ticks.saturating_sub(1) };
        self.ticks >= limit
    }
}
