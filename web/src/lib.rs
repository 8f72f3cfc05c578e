//! Twinrotor in a browser: a simulated board and its rig, the operator's end of the link, the settings table
//! and the tuner, as a WebAssembly module without imports.
//!
//! What a page can ask is [`request::Request`], JSON in and JSON out. What comes hundreds of times a second
//! does not go by JSON: rows of `f32` ([`desk::samples`]). A browser's module is asked by its exports
//! (`web/src/exports.rs`); `host-sim monitor` asks the same of the same code, with a board at the other end
//! of a line or simulated there ([`desk::Desk`]).

#![cfg_attr(
    test,
    allow(
        clippy::float_cmp,
        clippy::cast_possible_truncation,
        reason = "tests compare bits and make samples"
    )
)]

pub mod desk;
#[cfg(target_arch = "wasm32")]
pub mod exports;
pub mod lessons;
pub mod page;
pub mod recorded;
pub mod request;
pub mod same_bits;
pub mod tuner;
