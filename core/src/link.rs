//! What host and board say to each other: messages as data, no transport.
//!
//! On the wire a message is `COBS([version][postcard][CRC-32 of both, little endian])` and a zero byte. A
//! zero byte never occurs inside, so a receiver that comes late, or loses bytes, is in step again after the
//! next one; what is damaged fails its CRC and is dropped. The bytes of every message are literals in
//! `core/tests/wire/frames.txt`: what changes them changes [`VERSION`].
//!
//! ```
//! use twinrotor::control_loop::OperatorCommand;
//! use twinrotor::link::{Decoder, MAX_FRAME, ToBoard, encode};
//! use twinrotor::supervisor::Request;
//!
//! let arm = ToBoard::Control(OperatorCommand::Request(Request::Arm));
//! let mut buffer = [0; MAX_FRAME];
//! let frame = encode(&arm, &mut buffer).expect("every message fits its frame");
//! assert_eq!(frame.last(), Some(&0), "a zero byte ends a frame, and none is in it");
//!
//! // The other side takes bytes as they come; the last of a frame completes the message.
//! let mut decoder = Decoder::new();
//! let received: Vec<ToBoard> =
//!     frame.iter().filter_map(|&byte| decoder.push(byte)).map(|got| got.expect("undamaged")).collect();
//! assert_eq!(received, [arm]);
//! ```

use crate::control_loop::OperatorCommand;
use crate::first_power::Verdict;
use crate::parameters::{ParameterError, Parameters};
use crate::replay::{Replayed, Sample};
use crate::supervisor::Condition;
use crate::telemetry::Frame;
use crc::{CRC_32_ISO_HDLC, Crc, Table};
use heapless::String;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// \[baud\] Of the serial line between host and board: 8 data bits, no parity, 1 stop bit.
pub const BAUD: u32 = 1_000_000;
/// Version of the messages, the first byte of each.
pub const VERSION: u8 = 2;
/// \[byte\] The longest message, unframed.
pub const MAX_MESSAGE: usize = 1024;
/// \[byte\] The longest frame: COBS adds a byte in 254 and one more, then the zero.
pub const MAX_FRAME: usize = MAX_MESSAGE + MAX_MESSAGE / 254 + 3;

const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);
const CRC_SIZE: usize = 4;

/// From the host.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::large_enum_variant,
    reason = "a message lives for one exchange; there is no heap to put the record on"
)]
pub enum ToBoard {
    /// The host is there. Any message says so; this one says nothing else.
    Alive,
    /// Who are you? Answered by [`ToHost::Identity`].
    Identify,
    /// Something for the control loop; what came of it is in the telemetry.
    Control(OperatorCommand),
    /// A frame every so many ticks from now on, 1 to 1000.
    Telemetry {
        /// \[ticks\]
        every: u16,
    },
    /// Answered by [`ToHost::Parameters`].
    ReadParameters,
    /// To be kept in flash and used from now on; only while disarmed. Answered by [`ToHost::Saved`] or
    /// [`ToHost::Refused`].
    WriteParameters(Parameters),
    /// A tick of a record through the controller in force. Answered by [`ToHost::Replayed`].
    Replay(Sample),
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
    /// The parameters in force.
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
    /// \[cycles\] Longest tick since boot.
    pub tick_cycles_max: u32,
    /// \[byte\] Most of the stack that was ever in use.
    pub stack_used: u32,
    /// \[byte\] All of the stack.
    pub stack_size: u32,
}

/// Who the board is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Version of the firmware, such as `0.1.0`.
    pub firmware: String<16>,
    /// Its chip, such as `stm32f405rg`.
    pub chip: String<16>,
    /// Version of the parameter record.
    pub parameters: u16,
    /// What ended the firmware before this boot, if it was no ordinary reset.
    pub reset: Option<ResetReport>,
}

/// The circumstances of a reset that should not have been.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ResetReport {
    /// Why.
    pub cause: Condition,
    /// Program counter where it happened, or 0: `addr2line` on the unstripped ELF tells the line.
    pub program_counter: u32,
    /// How many ticks the firmware had run, or 0 if that is not known.
    pub ticks: u32,
}

/// Why the board will not.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// Only while disarmed.
    MotorsMayTurn,
    /// A record begins with its sample 0.
    NoReplay,
    /// The loop has too many commands to deal with.
    Busy,
    /// The flash does not hold what is written.
    Flash,
    /// A value out of its range.
    Range {
        /// Name of the field.
        field: String<40>,
        /// What is allowed.
        allowed: String<48>,
    },
}

impl From<ParameterError> for Refusal {
    fn from(error: ParameterError) -> Self {
        match error {
            ParameterError::Range { field, allowed } => {
                Self::Range { field: text(field), allowed: text(allowed) }
            }
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

/// Why bytes are no message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinkError {
    /// Longer than [`MAX_FRAME`] or [`MAX_MESSAGE`].
    TooLong,
    /// Not whole: COBS, CRC or contents are wrong.
    Damaged,
    /// In another version of the messages.
    Version {
        /// The version found.
        found: u8,
    },
}

/// `message` as a frame, its zero byte included, in `buffer`.
///
/// # Errors
/// [`LinkError::TooLong`].
pub fn encode<'b, M: Serialize>(message: &M, buffer: &'b mut [u8; MAX_FRAME]) -> Result<&'b [u8], LinkError> {
    let mut plain = [0; MAX_MESSAGE];
    let (version, rest) = plain.split_first_mut().ok_or(LinkError::TooLong)?;
    *version = VERSION;
    let length = 1 + postcard::to_slice(message, rest).map_err(|_| LinkError::TooLong)?.len();
    let crc = CRC.checksum(plain.get(..length).ok_or(LinkError::TooLong)?).to_le_bytes();
    plain.get_mut(length..length + CRC_SIZE).ok_or(LinkError::TooLong)?.copy_from_slice(&crc);
    let body = plain.get(..length + CRC_SIZE).ok_or(LinkError::TooLong)?;
    let end = cobs::try_encode(body, buffer).map_err(|_| LinkError::TooLong)?;
    *buffer.get_mut(end).ok_or(LinkError::TooLong)? = 0;
    buffer.get(..=end).ok_or(LinkError::TooLong)
}

/// Puts frames together from bytes as they come.
#[derive(Debug, Clone)]
pub struct Decoder {
    buffer: [u8; MAX_FRAME],
    length: usize,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// Waits for the beginning of a frame.
    #[must_use]
    pub const fn new() -> Self {
        Self { buffer: [0; MAX_FRAME], length: 0 }
    }

    /// Takes a byte; at the end of a frame, what it says or why it says nothing.
    pub fn push<M: DeserializeOwned>(&mut self, byte: u8) -> Option<Result<M, LinkError>> {
        if byte != 0 {
            if let Some(place) = self.buffer.get_mut(self.length) {
                *place = byte;
            }
            self.length = self.length.saturating_add(1);
            return None;
        }
        let length = core::mem::take(&mut self.length);
        if length == 0 {
            return None;
        }
        Some(self.buffer.get_mut(..length).ok_or(LinkError::TooLong).and_then(decode))
    }
}

fn decode<M: DeserializeOwned>(frame: &mut [u8]) -> Result<M, LinkError> {
    let length = cobs::decode_in_place(frame).map_err(|_| LinkError::Damaged)?;
    let (body, crc) =
        frame.get(..length).and_then(<[u8]>::split_last_chunk::<CRC_SIZE>).ok_or(LinkError::Damaged)?;
    if CRC.checksum(body) != u32::from_le_bytes(*crc) {
        return Err(LinkError::Damaged);
    }
    match body.split_first() {
        Some((&VERSION, message)) => match postcard::take_from_bytes(message) {
            Ok((message, [])) => Ok(message),
            _ => Err(LinkError::Damaged),
        },
        Some((&found, _)) => Err(LinkError::Version { found }),
        None => Err(LinkError::Damaged),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SAMPLE_TIME;
    use crate::axes::{PerAxis, PerMotor};
    use crate::gains;
    use crate::pipeline::Settings;
    use crate::plant::presets;
    use crate::reference::Reference;
    use crate::supervisor::Request;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn parameters() -> Parameters {
        Parameters::new(&presets::AERO, &Settings::paper(&presets::AERO, gains::PAPER, SAMPLE_TIME))
    }

    fn to_board() -> impl Strategy<Value = ToBoard> {
        let number = || prop::num::f32::NORMAL | prop::num::f32::ZERO;
        let pair = move || (number(), number()).prop_map(|(p, y)| PerAxis::new(p, y));
        prop_oneof![
            Just(ToBoard::Alive),
            Just(ToBoard::Identify),
            Just(ToBoard::ReadParameters),
            Just(ToBoard::Control(OperatorCommand::Zero)),
            Just(ToBoard::Control(OperatorCommand::Request(Request::Arm))),
            any::<u16>().prop_map(|every| ToBoard::Telemetry { every }),
            (pair(), pair(), pair()).prop_map(|(angle, rate, accel)| {
                ToBoard::Control(OperatorCommand::Setpoint(Reference { angle, rate, accel }))
            }),
            (any::<u32>(), any::<[i32; 2]>(), pair(), prop::option::of(pair())).prop_map(
                |(number, [pitch, yaw], volts, wanted)| {
                    ToBoard::Replay(Sample {
                        number,
                        counts: PerAxis::new(pitch, yaw),
                        volts: PerMotor::new(volts.pitch, volts.yaw),
                        wanted: wanted.map(Reference::at_rest),
                    })
                }
            ),
            number().prop_map(|gain| {
                let mut parameters = parameters();
                parameters.settings.model.damping.yaw = gain;
                ToBoard::WriteParameters(parameters)
            }),
        ]
    }

    fn framed<M: Serialize>(message: &M) -> Vec<u8> {
        encode(message, &mut [0; MAX_FRAME]).unwrap().to_vec()
    }

    fn feed<M: DeserializeOwned>(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Result<M, LinkError>> {
        bytes.iter().filter_map(|&byte| decoder.push(byte)).collect()
    }

    proptest! {
        #[test]
        fn what_is_sent_arrives(messages in prop::collection::vec(to_board(), 1..8)) {
            let bytes: Vec<u8> = messages.iter().flat_map(framed).collect();
            let got = feed::<ToBoard>(&mut Decoder::new(), &bytes);
            prop_assert_eq!(got, messages.into_iter().map(Ok).collect::<Vec<_>>());
        }

        /// Nothing that a broken line can do panics, and the message after the next zero byte arrives.
        #[test]
        fn noise_is_dropped_and_the_next_message_arrives(
            noise in prop::collection::vec(any::<u8>(), 0..3000), message in to_board(),
        ) {
            let mut decoder = Decoder::new();
            for got in feed::<ToBoard>(&mut decoder, &noise) {
                prop_assert!(got.is_err());
            }
            decoder.push::<ToBoard>(0);
            prop_assert_eq!(feed::<ToBoard>(&mut decoder, &framed(&message)), [Ok(message)]);
        }

        /// A flipped bit, a lost byte, a cut: never another message.
        #[test]
        fn damage_is_noticed(
            message in to_board(), at in any::<prop::sample::Index>(), flip in 1_u8.., cut in any::<bool>(),
        ) {
            let mut bytes = framed(&message);
            let at = at.index(bytes.len() - 1);
            if cut { bytes.remove(at); } else { bytes[at] ^= flip; }
            for got in feed::<ToBoard>(&mut Decoder::new(), &bytes) {
                prop_assert!(got.is_err(), "{:?}", got);
            }
        }
    }

    #[test]
    fn another_version_is_named() {
        let mut plain = [VERSION + 1, 0, 0, 0, 0, 0];
        let crc = CRC.checksum(&plain[..2]).to_le_bytes();
        plain[2..].copy_from_slice(&crc);
        let mut frame = [0; 16];
        let length = cobs::try_encode(&plain, &mut frame).unwrap();
        let got = feed::<ToBoard>(&mut Decoder::new(), &frame[..=length]);
        assert_eq!(got, [Err(LinkError::Version { found: VERSION + 1 })]);
    }

    #[test]
    fn every_answer_fits() {
        let refusal = ToHost::Refused(Refusal::from(ParameterError::Range { field: "f", allowed: "a" }));
        for message in [ToHost::Parameters(parameters()), ToHost::Frame(Frame::default()), refusal] {
            assert_eq!(feed::<ToHost>(&mut Decoder::new(), &framed(&message)), [Ok(message)]);
        }
    }
}
