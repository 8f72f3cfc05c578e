//! The parameters' place in flash: 48 KiB of bank 1, pages of 2 KiB in double words of 64 bits with 8 more
//! that correct one wrong bit of them and detect two (reference manual RM0440, 3.3 and 5.3).
//!
//! A supply that goes while a double word is programmed or erased leaves one that reads as nothing in
//! particular, and interrupts the core each time (an NMI). So a double word whose bits do not agree reads as
//! zeros here: no record is whole that has one, and no place with one is taken for erased, where it could not
//! be programmed. The data cache, which would hide that from a second reading, is off while a save looks
//! ([`crate::flash_cache`]).

use core::sync::atomic::{AtomicBool, Ordering};
use embassy_stm32::Peri;
use embassy_stm32::flash::{Bank1Region, Blocking, Error, Flash};
use embassy_stm32::pac::{FLASH as REGISTERS, RCC};
use embassy_stm32::peripherals::FLASH;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// \[byte\] Of a double word.
const DOUBLE_WORD: usize = 8;
/// \[byte\] What is erased at once: as much as a sector of an STM32F4, so that an image is the same for both.
const ERASED_AT_ONCE: usize = 16 * 1024;

/// A double word is being read that need not be whole.
static READS: AtomicBool = AtomicBool::new(false);
/// It was not.
static BROKEN: AtomicBool = AtomicBool::new(false);

/// What is written there.
pub(crate) struct ParameterFlash(Bank1Region<'static, Blocking>);

/// Of bank 1, which has both.
pub(crate) fn parameters(flash: Peri<'static, FLASH>) -> ParameterFlash {
    ParameterFlash(Flash::new_blocking(flash).into_blocking_regions().bank1_region)
}

/// Was it the flash that interrupted the core, over what may lie there?
pub(crate) fn tolerates() -> bool {
    if !REGISTERS.eccr().read().eccd() {
        // Its flag has been taken back since; if it was the clock security, that says so.
        return !RCC.cifr().read().cssf();
    }
    let tolerated = READS.load(Ordering::Relaxed);
    if tolerated {
        BROKEN.store(true, Ordering::Relaxed);
        forget();
    }
    tolerated
}

/// What was said of errors: two flags that a one clears.
fn forget() {
    REGISTERS.eccr().modify(|w| {
        w.set_eccc(true);
        w.set_eccd(true);
    });
}

impl ParameterFlash {
    /// Reads one double word.
    fn read_one(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        forget();
        BROKEN.store(false, Ordering::Relaxed);
        READS.store(true, Ordering::SeqCst);
        let read = self.0.blocking_read(offset, bytes);
        cortex_m::asm::dsb();
        let flags = REGISTERS.eccr().read();
        forget();
        READS.store(false, Ordering::SeqCst);
        // One that reads as erased and was corrected is not.
        let looks_erased = bytes.iter().all(|&byte| byte == 0xFF);
        let broken = flags.eccd() || BROKEN.load(Ordering::Relaxed);
        if broken || flags.eccc() && looks_erased {
            bytes.fill(0);
        }
        read
    }
}

impl ErrorType for ParameterFlash {
    type Error = Error;
}

impl ReadNorFlash for ParameterFlash {
    const READ_SIZE: usize = DOUBLE_WORD;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        let (addresses, double_words) = ((offset..).step_by(DOUBLE_WORD), bytes.chunks_mut(DOUBLE_WORD));
        addresses.zip(double_words).try_for_each(|(at, bytes)| self.read_one(at, bytes))
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl NorFlash for ParameterFlash {
    const WRITE_SIZE: usize = DOUBLE_WORD;
    const ERASE_SIZE: usize = ERASED_AT_ONCE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        self.0.blocking_erase(from, to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        self.0.blocking_write(offset, bytes)
    }
}
