//! Twinrotor on a PC: the command line, the files, figures and reports around the crates that compute.

// They panic where nobody listens; `cli` has what does not.
#![deny(clippy::print_stdout, clippy::print_stderr)]
#![cfg_attr(
    test,
    allow(
        clippy::float_cmp,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "tests compare bits and make samples"
    )
)]

pub mod cli;
pub mod device;
pub mod error;
pub mod figures;
pub mod files;
pub mod line;
#[cfg(feature = "monitor")]
pub mod monitor;
pub mod page;
pub mod report;
pub mod stop;
pub mod threads;
