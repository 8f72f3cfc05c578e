//! Twinrotor's simulator: the core that flies on the board, closed around a simulated helicopter, once or
//! in sixteen lanes at a time. It takes text and gives values: no files, no terminal, no threads.

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
pub mod error;
pub mod flight;
pub mod gains_file;
pub mod lanes;
pub mod margins;
pub mod metrics;
pub mod operation_count;
pub mod rig;
pub mod scenario;
pub mod table;
pub mod toml;

pub use error::{Error, Outcome};

/// How a text that is named comes in: from a file, an upload, a table of what is built in.
pub type Read<'a> = &'a dyn Fn(&str) -> Outcome<String>;

/// Does `name` stand for a text, and not for something known by name? It does if it ends in `.toml` or is a
/// path of more than one part, such as what a shell makes of a command's output.
pub fn is_text(name: &str) -> bool {
    let toml = |ending: &std::ffi::OsStr| ending.eq_ignore_ascii_case("toml");
    name.contains('/') || std::path::Path::new(name).extension().is_some_and(toml)
}
