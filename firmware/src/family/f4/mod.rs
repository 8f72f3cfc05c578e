//! STM32F4: F405, F407, F411 and F446, as far as this firmware goes by one reference manual, RM0090.

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

/// The break input has no filter.
#[cfg(not(feature = "simulated"))]
pub(crate) fn filter_break(_: &mut embassy_stm32::pac::timer::regs::BdtrAdv) {}
