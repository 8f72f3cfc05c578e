//! What differs between families of chips, a folder each with the same names in it: where clocks, flash,
//! converter, DMA, supply detector and reset flags lie, and what their interrupts are called. Nothing else in
//! the firmware asks which family it is.

#[cfg(not(feature = "g4"))]
mod f4;
#[cfg(feature = "g4")]
mod g4;

#[cfg(not(feature = "g4"))]
pub(crate) use f4::*;
#[cfg(feature = "g4")]
pub(crate) use g4::*;
