//! Motors off, said until it is seen.

use std::time::Duration;
use twinrotor::telemetry::Frame;

/// From one `Disarm` to the next.
const EVERY: Duration = Duration::from_millis(20);
/// How long the board's word for it is waited for.
const PATIENCE: Duration = Duration::from_secs(3);

/// Says `Disarm` again and again until a frame says that the motors are off.
#[derive(Debug, Clone, Copy)]
pub struct SwitchOff {
    next: Duration,
    end: Duration,
    said: bool,
    seen: bool,
}

impl SwitchOff {
    /// From `now` on.
    #[must_use]
    pub fn new(now: Duration) -> Self {
        Self { next: now, end: now + PATIENCE, said: false, seen: false }
    }

    /// Is `Disarm` to be said now?
    pub fn say(&mut self, now: Duration) -> bool {
        let due = !self.is_over(now) && now >= self.next;
        if due {
            self.next = now + EVERY;
            self.said = true;
        }
        due
    }

    /// Takes a frame that came after it began.
    pub fn hear(&mut self, frame: &Frame) {
        self.seen |= self.said && !frame.state.motors_may_turn();
    }

    /// The board has said that its motors are off.
    #[must_use]
    pub const fn is_seen(&self) -> bool {
        self.seen
    }

    /// Seen, or waited for long enough.
    #[must_use]
    pub fn is_over(&self, now: Duration) -> bool {
        self.seen || now >= self.end
    }

    /// When there is something to do next.
    #[must_use]
    pub fn due(&self) -> Duration {
        self.next.min(self.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::supervisor::ArmState;

    const fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn it_is_said_until_it_is_seen_and_what_was_seen_before_does_not_count() {
        let frame = |state| Frame { state, ..Frame::default() };
        let mut off = SwitchOff::new(ms(1_000));
        off.hear(&frame(ArmState::Ready));
        assert!(!off.is_seen() && off.say(ms(1_000)) && !off.say(ms(1_019)) && off.say(ms(1_020)));
        off.hear(&frame(ArmState::Armed));
        assert!(!off.is_over(ms(1_030)) && off.say(ms(1_040)));
        off.hear(&frame(ArmState::Ready));
        assert!(off.is_seen() && off.is_over(ms(1_041)) && !off.say(ms(1_060)));
    }

    #[test]
    fn a_board_that_never_says_so_is_given_up() {
        let mut off = SwitchOff::new(ms(0));
        let said = (0..60_000).filter(|&at| off.say(ms(at))).count();
        assert_eq!(said, 150);
        assert!(off.is_over(ms(3_000)) && !off.is_seen());
    }
}
