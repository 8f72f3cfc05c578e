//! Messages as bytes, and bytes as messages.

use super::VERSION;
use core::fmt;
use core::ops::Range;
use crc::{CRC_32_ISO_HDLC, Crc, Table};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// \[byte\] The longest message, unframed.
pub const MAX_MESSAGE: usize = 1024;
/// \[byte\] The longest frame: COBS adds a byte in 254 and one more, then the zero.
pub const MAX_FRAME: usize = MAX_MESSAGE + MAX_MESSAGE / 254 + 3;

const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);
const CRC_SIZE: usize = 4;

/// Why bytes are no message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

/// As a host tells it: a board's messages are the only ones that it reads.
impl fmt::Display for LinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found = match self {
            Self::TooLong => return f.write_str("a message is longer than any"),
            Self::Damaged => return f.write_str("a message came damaged"),
            Self::Version { found } => found,
        };
        let older = if *found < VERSION { "the board's firmware" } else { "this program" };
        write!(
            f,
            "the board speaks version {found} of the link, this program version {VERSION}: update {older}"
        )
    }
}

/// `message` as a frame, its zero byte included, in `buffer`.
///
/// # Errors
/// [`LinkError::TooLong`].
pub fn encode<'b, M: Serialize>(message: &M, buffer: &'b mut [u8; MAX_FRAME]) -> Result<&'b [u8], LinkError> {
    let (_, plain) = buffer.split_at_mut(AHEAD);
    let (version, rest) = plain.split_first_mut().ok_or(LinkError::TooLong)?;
    *version = VERSION;
    let length = 1 + postcard::to_slice(message, rest).map_err(|_| LinkError::TooLong)?.len();
    let crc = CRC.checksum(plain.get(..length).ok_or(LinkError::TooLong)?).to_le_bytes();
    plain.get_mut(length..length + CRC_SIZE).ok_or(LinkError::TooLong)?.copy_from_slice(&crc);
    let end = stuff(buffer, AHEAD..AHEAD + length + CRC_SIZE);
    buffer.get(..=end).ok_or(LinkError::TooLong)
}

/// \[byte\] How far a message lies before its frame, in the same buffer: as much as COBS adds, and more.
const AHEAD: usize = MAX_FRAME - MAX_MESSAGE;

/// The bytes at `plain`, [`AHEAD`] or later, by COBS at the buffer's beginning, where they never catch up
/// with what is still to be read: in place of each zero, and after each run of 254 bytes that are none,
/// stands a byte that says how far the next one is. Gives the place of the zero behind them.
fn stuff(buffer: &mut [u8; MAX_FRAME], plain: Range<usize>) -> usize {
    let (mut mark, mut end, mut distance) = (0, 1, 1_u8);
    let (last, empty) = (plain.end.saturating_sub(1), plain.is_empty());
    for at in plain {
        let byte = buffer.get(at).copied().unwrap_or(0);
        if byte != 0 {
            put(buffer, end, byte);
            (end, distance) = (end.saturating_add(1), distance.saturating_add(1));
        }
        if byte == 0 || distance == u8::MAX {
            put(buffer, mark, distance);
            (mark, end, distance) = (end, end.saturating_add(1), 1);
        }
    }
    // Behind a run of 254 that ends the message there is nothing to tell.
    let full = distance == 1 && !empty && buffer.get(last).is_some_and(|byte| *byte != 0);
    if !full {
        put(buffer, mark, distance);
    }
    let end = if full { mark } else { end };
    put(buffer, end, 0);
    end
}

/// Within the buffer, as all of a message is.
fn put(buffer: &mut [u8; MAX_FRAME], at: usize, byte: u8) {
    if let Some(place) = buffer.get_mut(at) {
        *place = byte;
    }
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
    use proptest::prelude::*;

    #[test]
    fn a_run_that_ends_the_message_is_followed_by_nothing() {
        for length in [253, 254, 255, 507, 508, 509] {
            let mut buffer = [0xAA; MAX_FRAME];
            buffer[AHEAD..AHEAD + length].fill(7);
            let end = stuff(&mut buffer, AHEAD..AHEAD + length);
            assert_eq!(end, length + length.div_ceil(254), "{length}");
            assert!(buffer[..end].iter().all(|byte| *byte != 0) && buffer[end] == 0);
            let mut frame = buffer[..end].to_vec();
            assert_eq!(cobs::decode_in_place(&mut frame).unwrap(), length);
            assert!(frame[..length].iter().all(|byte| *byte == 7));
        }
    }

    proptest! {
        /// What another implementation of COBS makes of the same bytes; none of them zero, many, all.
        #[test]
        fn a_frame_is_what_cobs_makes_of_a_message(
            mut bytes in prop::collection::vec(any::<u8>(), 0..=MAX_MESSAGE),
            zeros in 0_u8..=3,
        ) {
            for byte in &mut bytes {
                *byte = match zeros {
                    0 => *byte | 1,
                    1 => *byte,
                    2 => *byte & 1,
                    _ => 0,
                };
            }
            let mut buffer = [0xAA; MAX_FRAME];
            buffer[AHEAD..AHEAD + bytes.len()].copy_from_slice(&bytes);
            let end = stuff(&mut buffer, AHEAD..AHEAD + bytes.len());
            let mut expected = [0; MAX_FRAME];
            let length = cobs::try_encode(&bytes, &mut expected).unwrap();
            // It leaves what it thought better of.
            expected[length] = 0;
            prop_assert_eq!(&buffer[..=end], &expected[..=length]);
        }
    }
}
