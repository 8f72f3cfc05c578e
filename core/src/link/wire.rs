//! Messages as bytes, and bytes as messages.

use super::VERSION;
use core::fmt;
use crc::{CRC_32_ISO_HDLC, Crc, Table};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// \[byte\] The longest message, unframed.
pub const MAX_MESSAGE: usize = 512;
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
