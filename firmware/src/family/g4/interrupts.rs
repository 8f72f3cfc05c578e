//! The interrupts that have other names in other families.

use embassy_stm32::interrupt;
use embassy_stm32::interrupt::Interrupt;

/// The supply's voltage detector.
pub(crate) const SUPPLY: Interrupt = Interrupt::PVD_PVM;
/// Word from the tick to the thread: the chip has no other use for this one.
pub(crate) const WORD: Interrupt = Interrupt::UCPD1;

#[interrupt]
fn PVD_PVM() {
    crate::reset_record::end_for_supply();
}

#[interrupt]
fn UCPD1() {
    crate::wake::hand_on();
}
