//! The chip's own supply, and what a reset was for.

use embassy_stm32::pac;
use twinrotor::supervisor::Condition;

/// The voltage detector at 2.8 V (datasheet DS12288, table 17).
pub(crate) fn detect_low_supply() {
    const LEVEL: u8 = 5;
    pac::PWR.cr2().modify(|w| {
        w.set_pls(LEVEL);
        w.set_pvde(true);
    });
}

/// Is it below?
pub(crate) fn supply_is_low() -> bool {
    pac::PWR.sr2().read().pvdo()
}

/// What the hardware alone ended the last boot for, if it should not have; forgets it. One flag says power-on
/// and brown-out: the latter is known by the note that the detector's interrupt has left (RM0440, 7.4.28).
pub(crate) fn reset_cause() -> Option<Condition> {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    (flags.iwdgrstf() && !flags.borrstf()).then_some(Condition::ResetByWatchdog)
}
