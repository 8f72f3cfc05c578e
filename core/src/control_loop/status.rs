//! What the conversation must know of the loop, in one word: a tick that interrupts the reader never leaves
//! it half of one tick and half of another.

use crate::sequence::Sequence;
use crate::telemetry::TrialPhase;

/// The loop after a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Status {
    /// The law may turn the motors.
    pub armed: bool,
    /// Parameters may be written: [`crate::supervisor::ArmState::lets_flash_be_written`].
    pub flash_may_be_written: bool,
    /// What a trial is doing.
    pub trial: TrialPhase,
    /// Number of the message that asked for the controller to go back to; none if it is the record's.
    pub accepted: Option<Sequence>,
}

const ARMED: u32 = 1 << 16;
const FLASH: u32 = 1 << 17;
const ACCEPTED: u32 = 1 << 18;
/// Where the phase's number begins.
const PHASE: u32 = 19;
const PHASES: [TrialPhase; 5] =
    [TrialPhase::None, TrialPhase::Shadow, TrialPhase::FadingIn, TrialPhase::Flying, TrialPhase::FadingOut];

impl Status {
    /// As a word; [`Status::default`] is 0.
    #[must_use]
    pub fn to_word(self) -> u32 {
        let bit = |set, bit| if set { bit } else { 0 };
        let accepted = self.accepted.map_or(0, |Sequence(number)| ACCEPTED | u32::from(number));
        bit(self.armed, ARMED)
            | bit(self.flash_may_be_written, FLASH)
            | (self.trial as u32) << PHASE
            | accepted
    }

    /// What [`Status::to_word`] gave.
    #[must_use]
    pub fn from_word(word: u32) -> Self {
        let phase = usize::try_from(word >> PHASE).unwrap_or(0);
        #[expect(clippy::cast_possible_truncation, reason = "the low half is the number")]
        let number = word as u16;
        Self {
            armed: word & ARMED != 0,
            flash_may_be_written: word & FLASH != 0,
            trial: PHASES.get(phase).copied().unwrap_or_default(),
            accepted: (word & ACCEPTED != 0).then_some(Sequence(number)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_the_status_it_was_made_of() {
        assert_eq!(Status::default().to_word(), 0);
        for trial in PHASES {
            for accepted in [None, Some(0), Some(1), Some(0x8000), Some(u16::MAX)] {
                for (armed, flash_may_be_written) in
                    [(false, false), (false, true), (true, false), (true, true)]
                {
                    let accepted = accepted.map(Sequence);
                    let status = Status { armed, flash_may_be_written, trial, accepted };
                    assert_eq!(Status::from_word(status.to_word()), status);
                }
            }
        }
    }
}
