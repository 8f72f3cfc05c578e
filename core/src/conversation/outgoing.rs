//! What a board says first when it has several things to say.

use crate::first_power::Verdict;
use crate::link::{Health, ToHost};
use crate::telemetry::Frame;

/// \[ticks\] From one report of the board's health to the next.
pub const HEALTH_EVERY: u32 = 1000;

/// What waits to be said.
pub trait Waiting {
    /// The next answer to a message.
    fn answer(&mut self) -> Option<ToHost>;
    /// What a first-power check has found.
    fn verdict(&mut self) -> Option<Verdict>;
    /// The oldest frame of telemetry.
    fn frame(&mut self) -> Option<Frame>;
    /// How the board is.
    fn health(&mut self) -> Health;
}

/// When what was said last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outgoing {
    next_health: u32,
}

impl Outgoing {
    /// Nothing has been said.
    #[must_use]
    pub const fn new() -> Self {
        Self { next_health: 0 }
    }

    /// What to say in `tick`: answers first, then what the tick reports, once a second how the board is.
    pub fn next(&mut self, tick: u32, waiting: &mut impl Waiting) -> Option<ToHost> {
        if let Some(answer) = waiting.answer() {
            return Some(answer);
        }
        if let Some(verdict) = waiting.verdict() {
            return Some(ToHost::Verdict(verdict));
        }
        // Due: not half of all ticks or more ahead.
        if tick.wrapping_sub(self.next_health) < 1 << 31 {
            self.next_health = tick.wrapping_add(HEALTH_EVERY);
            return Some(ToHost::Health(waiting.health()));
        }
        waiting.frame().map(ToHost::Frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Something of everything.
    struct Everything {
        answers: u32,
        verdicts: u32,
        frames: u32,
    }

    impl Waiting for Everything {
        fn answer(&mut self) -> Option<ToHost> {
            self.answers.checked_sub(1).map(|left| {
                self.answers = left;
                ToHost::Saved
            })
        }
        fn verdict(&mut self) -> Option<Verdict> {
            self.verdicts.checked_sub(1).map(|left| {
                self.verdicts = left;
                Verdict::Passed
            })
        }
        fn frame(&mut self) -> Option<Frame> {
            self.frames.checked_sub(1).map(|left| {
                self.frames = left;
                Frame::default()
            })
        }
        fn health(&mut self) -> Health {
            Health::default()
        }
    }

    #[test]
    fn answers_go_before_verdicts_health_and_frames() {
        let mut waiting = Everything { answers: 2, verdicts: 1, frames: 2 };
        let mut outgoing = Outgoing::new();
        let said: Vec<ToHost> = core::iter::from_fn(|| outgoing.next(0, &mut waiting)).collect();
        let frame = || ToHost::Frame(Frame::default());
        let health = ToHost::Health(Health::default());
        assert_eq!(
            said,
            [ToHost::Saved, ToHost::Saved, ToHost::Verdict(Verdict::Passed), health, frame(), frame()]
        );
    }

    /// The count of ticks wraps after 50 days.
    #[test]
    fn health_comes_once_a_second_through_the_wrap_of_the_ticks() {
        let mut outgoing = Outgoing { next_health: u32::MAX - 2_500 };
        let mut silent = Everything { answers: 0, verdicts: 0, frames: 0 };
        let said: Vec<u32> = (0..6_000)
            .filter(|after| outgoing.next((u32::MAX - 2_500).wrapping_add(*after), &mut silent).is_some())
            .collect();
        assert_eq!(said, [0, 1_000, 2_000, 3_000, 4_000, 5_000]);
    }
}
