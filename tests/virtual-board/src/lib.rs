//! The virtual board: an emulated STM32F405 that runs the firmware's released ELF, unmodified, in
//! lock-step with a simulated rig.

pub mod board;
pub mod chip;
pub mod figures;
pub mod firmware;
pub mod flight;
pub mod helicopter;
pub mod in_c;
pub mod listen;
pub mod machine;
pub mod profile;
pub mod record;
pub mod serial;
pub mod station;
mod warm_core;
pub mod wiring;
