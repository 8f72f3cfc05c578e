//! One record on flash, safe against a power cut at any moment: afterwards the old or the new one
//! is there, whole, and the next save holds.
//!
//! ```text
//! page   [slot 0][slot 1] ... [slot 15]          three pages of 16 KiB, slots of 1 KiB
//! slot   [sequence][length][payload, padded with 0xFF to words][CRC-32 of all before it]
//! ```
//! The record in force is the one with the highest sequence whose CRC holds. Words, or the double words of a
//! flash that is programmed by these, are programmed in ascending order, each once, so the CRC comes last and
//! is what commits a save.
//!
//! Two rules make it safe, and no state outside the flash is needed:
//! 1. A save goes to a slot that reads erased in the page that holds the record in force, behind it.
//!    Such a page was erased to the end before that record could be written, so no slot of it can be
//!    half erased.
//! 2. When that page has no such slot left, the save erases the next page, whatever is in it, and
//!    takes its first slot. The erased page never holds the record in force, and what a cut leaves
//!    there is erased again by the next save, because the record in force is still elsewhere.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};
use embedded_storage::nor_flash::NorFlash;

/// Pages in the parameter area: sectors 1 to 3 of an STM32F4.
pub const PAGES: u32 = 3;
/// \[byte\] Where they begin, from the beginning of flash; `memory.x` keeps the program out of them.
pub const AREA_OFFSET: u32 = 0x4000;
/// Where they begin in an STM32's address space, whose flash begins at 0x0800_0000.
pub const AREA_ADDRESS: u32 = 0x0800_0000 + AREA_OFFSET;
/// Bytes of a slot, and so of a record with its frame.
pub const SLOT_SIZE: usize = 1024;
/// The longest payload, in bytes.
pub const MAX_PAYLOAD: usize = SLOT_SIZE - HEADER - CRC_SIZE;

const SLOT_BYTES: u32 = bytes(SLOT_SIZE);
const HEADER: usize = 8;
const CRC_SIZE: usize = 4;
const WORD: usize = 4;
const ERASED: u8 = 0xFF;
const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Why a record could not be saved or read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreError<E> {
    /// The flash driver refused.
    Flash(E),
    /// The payload is longer than [`MAX_PAYLOAD`].
    TooLong,
    /// What was written does not read back: the flash is worn out.
    Verify,
}

impl<E> From<E> for StoreError<E> {
    fn from(error: E) -> Self {
        Self::Flash(error)
    }
}

/// The parameter area of a NOR flash: [`PAGES`] pages that begin at `base`.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
    base: u32,
}

/// Where the record in force lies.
#[derive(Clone, Copy)]
struct Found {
    sequence: u32,
    page: u32,
    slot: u32,
}

impl<F: NorFlash> Store<F> {
    const PAGE_BYTES: u32 = bytes(F::ERASE_SIZE);
    const SLOTS: u32 = Self::PAGE_BYTES / SLOT_BYTES;
    const FITS: () =
        assert!(F::ERASE_SIZE.is_multiple_of(SLOT_SIZE) && (2 * WORD).is_multiple_of(F::WRITE_SIZE));

    /// The area of [`PAGES`] erase pages of `flash` from the byte offset `base` on.
    pub const fn new(flash: F, base: u32) -> Self {
        let () = Self::FITS;
        Self { flash, base }
    }

    /// The flash, given back.
    pub fn into_flash(self) -> F {
        self.flash
    }

    /// The payload in force, read into `buffer`; `None` when no valid record is there.
    ///
    /// # Errors
    /// The flash driver's own.
    pub fn load<'b>(
        &mut self,
        buffer: &'b mut [u8; SLOT_SIZE],
    ) -> Result<Option<&'b [u8]>, StoreError<F::Error>> {
        let Some(found) = self.newest(buffer)? else { return Ok(None) };
        self.flash.read(self.address(found.page, found.slot), buffer)?;
        Ok(payload(buffer).map(|(_, payload)| payload))
    }

    /// Replaces the payload in force. `buffer` is room to work in.
    ///
    /// # Errors
    /// [`StoreError::TooLong`], [`StoreError::Verify`], or the flash driver's own; the old record
    /// stays in force.
    pub fn save(&mut self, new: &[u8], buffer: &mut [u8; SLOT_SIZE]) -> Result<(), StoreError<F::Error>> {
        if new.len() > MAX_PAYLOAD {
            return Err(StoreError::TooLong);
        }
        let newest = self.newest(buffer)?;
        let (page, slot) = self.free_slot(newest, buffer)?;
        let sequence = newest.map_or(0, |found| found.sequence.wrapping_add(1));
        let address = self.address(page, slot);
        self.flash.write(address, frame(sequence, new, F::WRITE_SIZE, buffer))?;
        self.flash.read(address, buffer)?;
        match payload(buffer) {
            Some((read, payload)) if read == sequence && payload == new => Ok(()),
            _ => Err(StoreError::Verify),
        }
    }

    fn address(&self, page: u32, slot: u32) -> u32 {
        self.base + page * Self::PAGE_BYTES + slot * SLOT_BYTES
    }

    fn newest(&mut self, buffer: &mut [u8; SLOT_SIZE]) -> Result<Option<Found>, StoreError<F::Error>> {
        let mut newest: Option<Found> = None;
        for page in 0..PAGES {
            for slot in 0..Self::SLOTS {
                self.flash.read(self.address(page, slot), buffer)?;
                if let Some((sequence, _)) = payload(buffer)
                    && newest.is_none_or(|found| sequence > found.sequence)
                {
                    newest = Some(Found { sequence, page, slot });
                }
            }
        }
        Ok(newest)
    }

    /// The slot for the next record, erased: rule 1, else rule 2.
    fn free_slot(
        &mut self,
        newest: Option<Found>,
        buffer: &mut [u8; SLOT_SIZE],
    ) -> Result<(u32, u32), StoreError<F::Error>> {
        if let Some(found) = newest {
            for slot in found.slot + 1..Self::SLOTS {
                self.flash.read(self.address(found.page, slot), buffer)?;
                if buffer.iter().all(|&byte| byte == ERASED) {
                    return Ok((found.page, slot));
                }
            }
        }
        let page = newest.map_or(0, |found| (found.page + 1) % PAGES);
        self.flash.erase(self.address(page, 0), self.address(page + 1, 0))?;
        Ok((page, 0))
    }
}

/// The bytes of a slot that holds `payload`, built in `buffer`, as far as they are written: to a multiple of
/// `write_size`.
fn frame<'b>(sequence: u32, payload: &[u8], write_size: usize, buffer: &'b mut [u8; SLOT_SIZE]) -> &'b [u8] {
    let padded = payload.len().next_multiple_of(WORD);
    buffer.fill(ERASED);
    let (header, body) = buffer.split_at_mut(HEADER);
    let (sequence_bytes, length_bytes) = header.split_at_mut(WORD);
    sequence_bytes.copy_from_slice(&sequence.to_le_bytes());
    length_bytes.copy_from_slice(&bytes(payload.len()).to_le_bytes());
    for (to, from) in body.iter_mut().zip(payload) {
        *to = *from;
    }
    let end = HEADER + padded;
    let crc = checksum(buffer.get(..end).unwrap_or_default());
    if let Some(place) = buffer.get_mut(end..end + CRC_SIZE) {
        place.copy_from_slice(&crc.to_le_bytes());
    }
    buffer.get(..(end + CRC_SIZE).next_multiple_of(write_size)).unwrap_or_default()
}

/// Sequence and payload of a slot, if it holds a whole record.
fn payload(slot: &[u8; SLOT_SIZE]) -> Option<(u32, &[u8])> {
    let (sequence, rest) = slot.split_first_chunk::<WORD>()?;
    let (length, body) = rest.split_first_chunk::<WORD>()?;
    let length = usize::try_from(u32::from_le_bytes(*length)).ok().filter(|&length| length <= MAX_PAYLOAD)?;
    let end = HEADER + length.next_multiple_of(WORD);
    let (stored, _) = slot.get(end..)?.split_first_chunk::<CRC_SIZE>()?;
    let whole = checksum(slot.get(..end)?) == u32::from_le_bytes(*stored);
    whole.then_some((u32::from_le_bytes(*sequence), body.get(..length)?))
}

/// A length on flash.
#[expect(clippy::cast_possible_truncation, reason = "pages, slots and payloads are far below 4 GiB")]
const fn bytes(length: usize) -> u32 {
    length as u32
}

fn checksum(bytes: &[u8]) -> u32 {
    let mut digest: Digest<'_, u32, Table<1>> = CRC.digest();
    digest.update(bytes);
    digest.finalize()
}
