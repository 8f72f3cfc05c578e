//! Twinrotor's simulator: the core that flies on the board, closed around a simulated helicopter, once or
//! in sixteen lanes at a time. It takes text and gives values: no files, no terminal, no threads.
//!
//! Without the feature `std` there are the closed loops and what is summed up of a flight, for a GPU.

#![cfg_attr(not(feature = "std"), no_std)]
#![cfg_attr(
    test,
    allow(
        clippy::float_cmp,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "tests compare bits and make samples"
    )
)]

pub mod closed_loop;
#[cfg(feature = "std")]
pub mod device;
#[cfg(feature = "std")]
pub mod error;
pub mod fittings;
#[cfg(feature = "std")]
pub mod flight;
#[cfg(feature = "std")]
pub mod gains_file;
pub mod guard;
pub mod integrated;
pub mod judged;
#[cfg(feature = "std")]
pub mod lanes;
#[cfg(feature = "std")]
pub mod linear;
#[cfg(feature = "std")]
mod located;
#[cfg(feature = "std")]
pub mod margins;
pub mod metrics;
#[cfg(feature = "std")]
pub mod operation_count;
#[cfg(feature = "std")]
pub mod rig;
#[cfg(feature = "std")]
pub mod scenario;
#[cfg(feature = "std")]
pub mod state_space;
#[cfg(feature = "std")]
pub mod table;
#[cfg(feature = "std")]
pub mod toml;

#[cfg(feature = "std")]
pub use error::{Error, Outcome};

/// How a text that is named comes in: from a file, an upload, a table of what is built in.
#[cfg(feature = "std")]
pub type Read<'a> = &'a dyn Fn(&str) -> Outcome<String>;

/// Does `name` stand for a text, and not for something known by name? It does if it ends in `.toml` or is a
/// path of more than one part, such as what a shell makes of a command's output.
#[cfg(feature = "std")]
pub fn is_text(name: &str) -> bool {
    let toml = |ending: &std::ffi::OsStr| ending.eq_ignore_ascii_case("toml");
    name.contains('/') || std::path::Path::new(name).extension().is_some_and(toml)
}
