//! The chip's own supply, and what a reset was for.

use embassy_stm32::pac;
use twinrotor::supervisor::Condition;

/// The voltage detector at 2.84 V (2.75 to 2.92, datasheet DS8626, table 19): a board of 3.0 V keeps clear of
/// that, and the flash is written from 2.7 V on.
pub(crate) fn detect_low_supply() {
    const LEVEL: u8 = 5;
    pac::PWR.cr1().modify(|w| {
        w.set_pls(LEVEL);
        w.set_pvde(true);
    });
}

/// Is it below?
pub(crate) fn supply_is_low() -> bool {
    pac::PWR.csr1().read().pvdo()
}

/// What the hardware alone ended the last boot for, if it should not have; forgets it.
pub(crate) fn reset_cause() -> Option<Condition> {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    match flags {
        // At power-on, this one is set together with the brown-out's.
        _ if flags.porrstf() => None,
        _ if flags.wdgrstf() => Some(Condition::ResetByWatchdog),
        _ if flags.borrstf() => Some(Condition::ResetByBrownOut),
        _ => None,
    }
}
