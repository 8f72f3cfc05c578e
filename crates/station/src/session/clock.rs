//! Time as a session counts it.

use std::time::Duration;

/// A host's clock that is never behind the board's ticks: a board that runs faster than a clock, as a
/// simulated one may, finds its operator awake.
#[derive(Debug, Default)]
pub(super) struct Clock {
    now: Duration,
    ahead: Duration,
    /// The last tick that was heard of, and the time then.
    last: Option<(u32, Duration)>,
}

impl Clock {
    /// The host's clock says `host`; what it is here.
    pub(super) fn tell(&mut self, host: Duration) -> Duration {
        self.now = self.now.max(host + self.ahead);
        self.now
    }

    /// The board says that it is at `tick`.
    pub(super) fn board(&mut self, tick: u32) -> Duration {
        if let Some((last, at)) = self.last
            && let passed = tick.wrapping_sub(last)
            && passed < 1 << 31
        {
            let board = at + Duration::from_millis(passed.into());
            self.ahead += board.saturating_sub(self.now);
            self.now = self.now.max(board);
            self.last = Some((tick, board));
        } else {
            self.last = Some((tick, self.now));
        }
        self.now
    }

    pub(super) const fn now(&self) -> Duration {
        self.now
    }

    /// What the host's clock will say when it is `time` here, if the board does not run ahead.
    pub(super) fn host(&self, time: Duration) -> Duration {
        time.saturating_sub(self.ahead)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn a_board_that_runs_ahead_takes_the_time_with_it_and_a_slow_one_does_not() {
        let mut clock = Clock::default();
        assert_eq!(clock.tell(ms(100)), ms(100));
        assert_eq!(clock.board(5_000), ms(100));
        assert_eq!(clock.board(5_030), ms(130), "the host's clock stands still");
        assert_eq!(clock.tell(ms(101)), ms(131));
        assert_eq!(clock.host(ms(131)), ms(101));
        assert_eq!(clock.board(5_031), ms(131));
        assert_eq!(clock.tell(ms(400)), ms(430));
        assert_eq!(clock.board(5_040), ms(430), "the board is behind");
    }

    #[test]
    fn a_board_that_begins_anew_turns_no_time_back() {
        let mut clock = Clock::default();
        clock.tell(ms(100));
        clock.board(70_000);
        assert_eq!(clock.board(3), ms(100));
        assert_eq!(clock.board(13), ms(110));
    }
}
