//! The parameter pages of an STM32F4 in RAM, or of an STM32G4, which is programmed by double words; power
//! cuts included: what the host makes images with and what proves [`super::store`].

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

use super::store::PAGES;

/// \[byte\] A page: one 16 KiB sector.
pub const PAGE_SIZE: usize = 16 * 1024;
/// \[byte\] The whole area.
pub const AREA_SIZE: usize = PAGE_SIZE * PAGES as usize;

/// When the supply fails: in the middle of one flash operation.
#[derive(Clone, Copy, Debug)]
pub struct PowerCut {
    /// Which operation from now on, a word program or a page erase, counted from 0.
    pub operation: u32,
    /// How far that operation had come: each bit it would change has changed with this chance, of 256.
    pub progress: u16,
    /// Seed of those chances.
    pub seed: u32,
}

/// What the flash says when it cannot do as asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RamFlashError {
    /// An address or a length that flash cannot take.
    Access(NorFlashErrorKind),
    /// A word was programmed that is not erased.
    NotErased,
    /// The supply is off: see [`PowerCut`].
    PowerOff,
}

impl NorFlashError for RamFlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Access(kind) => *kind,
            Self::NotErased | Self::PowerOff => NorFlashErrorKind::Other,
        }
    }
}

impl From<NorFlashErrorKind> for RamFlashError {
    fn from(kind: NorFlashErrorKind) -> Self {
        Self::Access(kind)
    }
}

/// [`PAGES`] pages of flash in RAM, erased at first, programmed by `WORD` bytes at once.
#[derive(Clone, Debug)]
pub struct RamFlash<const WORD: usize = 4> {
    bytes: [u8; AREA_SIZE],
    /// Flash operations so far: word programs and page erases.
    pub operations: u32,
    /// The cut to come; the supply is off from then on, until [`RamFlash::power_on`].
    pub cut: Option<PowerCut>,
    off: bool,
}

impl Default for RamFlash {
    fn default() -> Self {
        Self::erased()
    }
}

impl<const WORD: usize> RamFlash<WORD> {
    /// As it is delivered.
    #[must_use]
    pub const fn erased() -> Self {
        Self { bytes: [0xFF; AREA_SIZE], operations: 0, cut: None, off: false }
    }

    /// All bytes: the image of the area.
    #[must_use]
    pub const fn bytes(&self) -> &[u8; AREA_SIZE] {
        &self.bytes
    }

    /// The supply returns.
    pub fn power_on(&mut self) {
        self.off = false;
        self.cut = None;
    }

    /// Counts one operation; `Some` when the supply fails in it.
    fn begin(&mut self) -> Result<Option<PowerCut>, RamFlashError> {
        if self.off {
            return Err(RamFlashError::PowerOff);
        }
        self.operations = self.operations.wrapping_add(1);
        match &mut self.cut {
            Some(cut) if cut.operation == 0 => {
                self.off = true;
                Ok(self.cut.take())
            }
            Some(cut) => {
                cut.operation -= 1;
                Ok(None)
            }
            None => Ok(None),
        }
    }
}

impl<const WORD: usize> ErrorType for RamFlash<WORD> {
    type Error = RamFlashError;
}

impl<const WORD: usize> ReadNorFlash for RamFlash<WORD> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        check_read(self, offset, bytes.len())?;
        let from = self.bytes.iter().skip(offset as usize);
        bytes.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
        Ok(())
    }

    fn capacity(&self) -> usize {
        AREA_SIZE
    }
}

impl<const WORD: usize> NorFlash for RamFlash<WORD> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        for start in (from as usize..to as usize).step_by(PAGE_SIZE) {
            let cut = self.begin()?;
            let Some(page) = self.bytes.get_mut(start..start + PAGE_SIZE) else { break };
            match cut {
                None => page.fill(0xFF),
                Some(cut) => {
                    let mut chance = Chance::new(cut);
                    page.iter_mut().for_each(|byte| *byte |= chance.byte());
                    return Err(RamFlashError::PowerOff);
                }
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        check_write(self, offset, bytes.len())?;
        for (at, word) in (offset as usize..).step_by(Self::WRITE_SIZE).zip(bytes.chunks(Self::WRITE_SIZE)) {
            let cut = self.begin()?;
            let Some(place) = self.bytes.get_mut(at..at + Self::WRITE_SIZE) else { break };
            if place.iter().any(|&byte| byte != 0xFF) {
                return Err(RamFlashError::NotErased);
            }
            match cut {
                None => place.copy_from_slice(word),
                Some(cut) => {
                    let mut chance = Chance::new(cut);
                    place.iter_mut().zip(word).for_each(|(to, new)| *to &= new | !chance.byte());
                    return Err(RamFlashError::PowerOff);
                }
            }
        }
        Ok(())
    }
}

/// Bits that are set with the chance that a cut operation had come so far (xorshift32).
struct Chance {
    state: u32,
    progress: u16,
}

impl Chance {
    fn new(cut: PowerCut) -> Self {
        Self { state: cut.seed.wrapping_mul(0x9E37_79B9) | 1, progress: cut.progress }
    }

    fn byte(&mut self) -> u8 {
        (0..8).fold(0, |byte, bit| {
            self.state ^= self.state << 13;
            self.state ^= self.state >> 17;
            self.state ^= self.state << 5;
            byte | u8::from((self.state >> 24) < u32::from(self.progress)) << bit
        })
    }
}
