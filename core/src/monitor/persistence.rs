//! Conditions that count only once they have held for a while.

use core::hint::cold_path;

/// How long something has been so without a break.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Persistence {
    ticks: u32,
}

impl Persistence {
    /// That it has been so for `ticks` ticks.
    pub(super) fn of(ticks: u32) -> Self {
        Self { ticks }
    }

    /// Takes this tick's `now`; true from the `limit`th in a row on.
    #[inline(always)]
    pub(super) fn over(&mut self, now: bool, limit: u32) -> bool {
        self.ticks = if now { self.ticks.saturating_add(1) } else { 0 };
        self.ticks >= limit
    }

    /// The same, but that one good tick undoes one bad one: true once there were `limit` more bad ones.
    #[inline(always)]
    pub(super) fn over_more_often(&mut self, now: bool, limit: u32) -> bool {
        if !now && self.ticks == 0 {
            return false;
        }
        cold_path();
        self.ticks =
            if now { Ord::min(self.ticks.saturating_add(1), limit) } else { self.ticks.saturating_sub(1) };
        self.ticks >= limit
    }
}
