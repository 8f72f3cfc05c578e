//! What host and board say to each other: messages as data, no transport.
//!
//! On the wire a message is `COBS([version][postcard][CRC-32 of both, little endian])` and a zero byte. A
//! zero byte never occurs inside, so a receiver that comes late, or loses bytes, is in step again after the
//! next one; what is damaged fails its CRC and is dropped. The bytes of every message are literals in
//! `core/tests/wire/frames.txt`: what changes them changes [`VERSION`].
//!
//! A message to the board travels as [`Numbered`]: one whose number is not newer than what the board has
//! dealt with is dropped and counted, since a line may hand out old bytes again. [`ToBoard::Identify`] is
//! answered and [`ToBoard::Disarm`] obeyed whatever its number. What can turn a motor, clear a fault or
//! change what flies carries the [`Nonce`] of this boot: a host that has not asked who is there cannot do
//! that.
//!
//! ```
//! use twinrotor::link::{Decoder, MAX_FRAME, Nonce, ToBoard, encode};
//! use twinrotor::sequence::{Numbered, Sequence};
//!
//! let arm = ToBoard::Arm(Nonce(7)).numbered(Sequence(1));
//! let mut buffer = [0; MAX_FRAME];
//! let frame = encode(&arm, &mut buffer).expect("every message fits its frame");
//! assert_eq!(frame.last(), Some(&0), "a zero byte ends a frame, and none is in it");
//!
//! // The other side takes bytes as they come; the last of a frame completes the message.
//! let mut decoder = Decoder::new();
//! let received: Vec<Numbered<ToBoard>> =
//!     frame.iter().filter_map(|&byte| decoder.push(byte)).map(|got| got.expect("undamaged")).collect();
//! assert_eq!(received, [arm]);
//! ```

#[cfg(test)]
mod tests;
mod wire;

pub use wire::{Decoder, LinkError, MAX_FRAME, MAX_MESSAGE, encode};

use crate::bench::Injection;
use crate::first_power::Verdict;
use crate::parameters::{ParameterError, Parameters, Provenance};
use crate::reference::Reference;
use crate::replay::{Replayed, Sample};
use crate::rig_port::RigPort;
use crate::sequence::{Numbered, Sequence};
use crate::supervisor::Condition;
use crate::telemetry::Frame;
use crate::trial::Attempt;
use heapless::String;
use serde::{Deserialize, Serialize};

/// \[baud\] Of the serial line between host and board: 8 data bits, no parity, 1 stop bit.
pub const BAUD: u32 = 1_000_000;
/// Version of the messages, the first byte of each.
pub const VERSION: u8 = 6;
/// \[byte\] The most that a frame of telemetry takes on the wire.
pub const MAX_TELEMETRY: u32 = 90;

/// \[1/s\] Frames of telemetry that a line of `baud` carries: 10 bits a byte, with start and stop bit.
#[must_use]
pub const fn frames_per_second(baud: u32) -> u32 {
    baud / (10 * MAX_TELEMETRY)
}

/// \[ticks\] From frame to frame, of 1,000 ticks a second, as close as a line of `baud` carries them; for
/// [`ToBoard::Telemetry`].
#[must_use]
pub fn ticks_per_frame(baud: u32) -> u16 {
    let ticks = 1_000_u32.div_ceil(frames_per_second(baud).max(1));
    u16::try_from(ticks).unwrap_or(u16::MAX)
}

/// What a boot of a board is known by: another one each time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Nonce(pub u32);

/// From the host; on the wire with its number, as [`Numbered`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::large_enum_variant,
    reason = "a message lives for one exchange; there is no heap to put the record on"
)]
pub enum ToBoard {
    /// The host is there. Any message says so; this one says nothing else.
    Alive,
    /// Who are you? Answered by [`ToHost::Identity`], whatever the message's number.
    Identify,
    /// Motors off, in the next tick and whatever the message's number.
    Disarm,
    /// To be there, and to move on at that rate and acceleration until the next setpoint; see
    /// [`crate::approach`]. Outside the limits: [`ToHost::Refused`].
    Setpoint(Reference<f32>),
    /// To take where the rig lies now, motors off and still, for its rest pose.
    Zero,
    /// Let the law turn the motors. What came of it is in the telemetry.
    Arm(Nonce),
    /// Forget the latched fault.
    ClearFault(Nonce),
    /// Start the first-power check, which turns the motors. Ends with [`ToHost::Verdict`].
    Check(Nonce),
    /// A frame every so many ticks from now on, 1 to 1000, and no more often than the line carries them.
    Telemetry {
        /// \[ticks\]
        every: u16,
    },
    /// Answered by [`ToHost::Parameters`].
    ReadParameters,
    /// To be kept in flash and used from now on; only while disarmed. Answered by [`ToHost::Saved`] or
    /// [`ToHost::Refused`].
    WriteParameters(Nonce, Parameters),
    /// A tick of a record through the accepted controller. Answered by [`ToHost::Replayed`].
    Replay(Sample),
    /// Another controller in flight, as [`crate::trial`] says; only while armed, one at a time. What comes of
    /// it is in the telemetry.
    Trial(Nonce, Attempt),
    /// The controller that is being tried, and flies alone, is the one to go back to from now on.
    Accept(Nonce),
    /// Back to the accepted controller.
    Revert,
    /// The accepted controller to flash, with the parameters it was tried with; only while disarmed. Answered
    /// by [`ToHost::Saved`] or [`ToHost::Refused`].
    Save(Nonce),
    /// To let this befall the rig, where the board simulates it; refused by any other.
    Inject(Nonce, Injection),
}

impl ToBoard {
    /// The boot that this message is meant for, where it matters.
    #[must_use]
    pub const fn nonce(&self) -> Option<Nonce> {
        match self {
            Self::Arm(nonce)
            | Self::ClearFault(nonce)
            | Self::Check(nonce)
            | Self::Accept(nonce)
            | Self::Save(nonce)
            | Self::Trial(nonce, _)
            | Self::Inject(nonce, _)
            | Self::WriteParameters(nonce, _) => Some(*nonce),
            _ => None,
        }
    }

    /// The same, meant for the boot `now`, where it matters.
    #[must_use]
    pub fn meant_for(mut self, now: Nonce) -> Self {
        match &mut self {
            Self::Arm(nonce)
            | Self::ClearFault(nonce)
            | Self::Check(nonce)
            | Self::Accept(nonce)
            | Self::Save(nonce)
            | Self::Trial(nonce, _)
            | Self::Inject(nonce, _)
            | Self::WriteParameters(nonce, _) => *nonce = now,
            _ => {}
        }
        self
    }

    /// With the number `sequence`, ready to be encoded.
    pub const fn numbered(self, sequence: Sequence) -> Numbered<Self> {
        Numbered { sequence, message: self }
    }
}

/// From the board.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::large_enum_variant,
    reason = "a message lives for one exchange; there is no heap to put the record on"
)]
pub enum ToHost {
    /// One tick.
    Frame(Frame),
    /// Once a second.
    Health(Health),
    /// At boot and when asked.
    Identity(Identity),
    /// The parameters in force: with the controller that is being tried, while it flies alone.
    Parameters(Parameters),
    /// The parameters are in flash and in force.
    Saved,
    /// What the first-power check found.
    Verdict(Verdict),
    /// What a tick of a record came to.
    Replayed(Replayed),
    /// The board will not do as asked.
    Refused(Refusal),
}

/// How the board is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Health {
    /// Frames that found no room since boot: the link is too slow for the rate asked for.
    pub frames_dropped: u32,
    /// Messages since boot that came damaged, in another version, or too long.
    pub messages_rejected: u32,
    /// Messages since boot that came whole and were dropped: not newer than what came before.
    pub messages_stale: u32,
    /// \[cycles\] Longest tick since boot.
    pub tick_cycles_max: u32,
    /// \[byte\] Most of the stack that was ever in use.
    pub stack_used: u32,
    /// \[byte\] All of the stack.
    pub stack_size: u32,
}

/// A chip's unique number, 96 bits as they lie in its memory (reference manuals RM0090, 39.1; RM0440, 48.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ChipSerial(pub [u8; 12]);

impl core::fmt::Display for ChipSerial {
    /// 24 digits, as its maker's tools have it: three words, most significant digit first.
    fn fmt(&self, to: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let (words, _) = self.0.as_chunks::<4>();
        words.iter().try_for_each(|word| write!(to, "{:08X}", u32::from_le_bytes(*word)))
    }
}

/// Who the board is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Version of the firmware, such as `0.1.0`.
    pub firmware: String<16>,
    /// Its chip, such as `stm32f405rg`.
    pub chip: String<16>,
    /// Which one of these, as its maker has numbered it; zeros for a board that is no chip.
    pub serial: ChipSerial,
    /// What its rig is.
    pub port: RigPort,
    /// Version of the parameter record.
    pub parameters: u16,
    /// Where the parameters in force come from.
    pub provenance: Provenance,
    /// What this boot is known by.
    pub nonce: Nonce,
    /// The number that the host's next message should have.
    pub expected: Sequence,
    /// What ended the firmware before this boot, if it was no ordinary reset.
    pub reset: Option<ResetReport>,
}

/// The circumstances of a reset that should not have been.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ResetReport {
    /// Why.
    pub cause: Condition,
    /// Program counter where it happened, or 0: `addr2line` on the unstripped ELF tells the line.
    pub program_counter: u32,
    /// How many ticks the firmware had run, or 0 if that is not known.
    pub ticks: u32,
}

/// Why the board will not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// Only while disarmed.
    MotorsMayTurn,
    /// A record begins with its sample 0.
    NoReplay,
    /// The loop has too many commands to deal with.
    Busy,
    /// Meant for another boot of the board: ask who is there first.
    Nonce,
    /// No first-power check with built-in parameters: write those of the rig first.
    NoParameters,
    /// A setpoint out of its range.
    Setpoint {
        /// Name of the field.
        field: String<40>,
        /// Least that is allowed, in the field's unit.
        low: f32,
        /// Most that is allowed.
        high: f32,
    },
    /// The flash does not hold what is written.
    Flash,
    /// A value out of its range.
    Range {
        /// Name of the field.
        field: String<40>,
        /// What is allowed.
        allowed: String<48>,
    },
    /// A controller is tried only while armed.
    NotArmed,
    /// One controller is tried at a time.
    TrialUnderWay,
    /// Only a controller that is being tried and flies alone can be accepted.
    NothingToAccept,
    /// The line does not carry frames so often.
    TooOften {
        /// \[ticks\] From frame to frame at least.
        least: u16,
    },
    /// Only a rig that the board simulates is told what befalls it.
    NotSimulated,
}

impl Refusal {
    /// Of a value out of its range.
    #[must_use]
    pub fn range(field: &str, allowed: &str) -> Self {
        Self::Range { field: text(field), allowed: text(allowed) }
    }
}

impl From<ParameterError> for Refusal {
    fn from(error: ParameterError) -> Self {
        match error {
            ParameterError::Range { field, allowed } => Self::range(field, allowed),
            ParameterError::Damaged | ParameterError::Version { .. } | ParameterError::TooLong => Self::Flash,
        }
    }
}

/// `from`, or as much of it as there is room for.
#[must_use]
pub fn text<const N: usize>(from: &str) -> String<N> {
    let mut text = String::new();
    for character in from.chars() {
        if text.push(character).is_err() {
            break;
        }
    }
    text
}
