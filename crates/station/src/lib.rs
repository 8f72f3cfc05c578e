//! The operator's end of Twinrotor's link, without a line of its own: a client that takes bytes and the time
//! and gives events and bytes ([`client`]), what a board has said so far ([`heard`]), parameters as an
//! image of a board's flash ([`image`]), and a board that is simulated with its rig ([`simulated`]).

#![cfg_attr(test, allow(clippy::float_cmp, reason = "tests compare bits"))]

pub mod client;
pub mod heard;
pub mod image;
pub mod simulated;

pub use client::{Answer, Client, Event, Question};
pub use heard::Heard;
pub use simulated::SimulatedBoard;
