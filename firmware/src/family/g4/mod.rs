//! STM32G4: the G474, by reference manual RM0440. It has been compiled, and has run nowhere.

mod clocks;
#[cfg(not(feature = "simulated"))]
pub(crate) mod converter;
pub(crate) mod flash;
pub(crate) mod interrupts;
pub(crate) mod oscillator;
pub(crate) mod stream;
mod supply;

pub(crate) use clocks::{configuration, stand_still_at_breakpoints};
pub(crate) use supply::{detect_low_supply, reset_cause, supply_is_low};

/// The longest filter, 8 samples at a 32nd of the timer's clock: the stop acts after 1.5 µs (28.6.20).
#[cfg(not(feature = "simulated"))]
pub(crate) fn filter_break(w: &mut embassy_stm32::pac::timer::regs::BdtrAdv) {
    w.set_bkf(0, embassy_stm32::pac::timer::vals::FilterValue::FDTS_DIV32_N8);
}
