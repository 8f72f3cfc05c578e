//! The instruction and the data cache before the flash, RM0090 3.5.2 and 3.9.1, as far as their registers go,
//! and as far as saying whether they may hold lines from before an erase or a program. What the core reads is
//! always the array: a firmware that reads a stale line reads the right bytes here, so it is for a test to
//! ask.

/// One cache.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Cache {
    on: bool,
    /// It was on since it was last emptied.
    filled: bool,
    stale: bool,
}

impl Cache {
    /// `ACR` was written: its enable, and its reset, which empties the cache only while it is off.
    pub(super) fn write(&mut self, on: bool, reset: bool) {
        if reset && !self.on {
            (self.filled, self.stale) = (false, false);
        }
        self.on = on;
        self.filled |= on;
    }

    /// The array changes.
    pub(super) fn array_changes(&mut self) {
        self.stale |= self.filled;
    }

    /// Whether the core may be given a line from before the array changed.
    pub(super) fn serves_stale_lines(&self) -> bool {
        self.on && self.stale
    }
}
