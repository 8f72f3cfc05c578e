//! The caches before the flash, without which the core waits for most instructions.

use embassy_stm32::pac::{DBGMCU, FLASH};

/// Caches and prefetching on.
pub(crate) fn start() {
    // Errata sheet ES0182, 2.1.3: prefetching does not work on revision A of the F405 and F407.
    let chip = DBGMCU.idcode().read();
    let prefetches = chip.dev_id() != 0x413 || chip.rev_id() != 0x1000;
    empty();
    FLASH.acr().modify(|w| {
        w.set_icen(true);
        w.set_dcen(true);
        w.set_prften(prefetches);
    });
}

/// Runs `work`, which erases or programs, without caches that would still hold what was there before
/// (reference manual RM0090, 3.9.2): what it reads back is the flash.
pub(crate) fn without<T>(work: impl FnOnce() -> T) -> T {
    let before = FLASH.acr().read();
    FLASH.acr().modify(|w| {
        w.set_icen(false);
        w.set_dcen(false);
    });
    let done = work();
    empty();
    FLASH.acr().write_value(before);
    done
}

/// Forgets what the caches hold; they are off.
fn empty() {
    for reset in [true, false] {
        FLASH.acr().modify(|w| {
            w.set_icrst(reset);
            w.set_dcrst(reset);
        });
    }
}
