//! The operator's end of Twinrotor's link, without a line of its own: a client that takes bytes and the time
//! and gives events and bytes ([`client`]), what a board has said so far ([`heard`]) and what that means
//! ([`words`]), a whole session from connecting to disarmed ([`session`]) that ends with the motors seen off
//! ([`switch_off`]), in what two records differ ([`differences`]), a flight as telemetry told it ([`flown`])
//! and computed once more ([`mod@again`]), parameters as an image of a board's flash ([`image`]), and a board
//! that is simulated with its rig ([`simulated`]), as fast as whoever talks to it bears ([`pace`]).

#![cfg_attr(
    test,
    allow(
        clippy::float_cmp,
        clippy::cast_possible_truncation,
        reason = "tests compare bits and make samples"
    )
)]

pub mod again;
pub mod client;
pub mod differences;
pub mod flown;
pub mod heard;
pub mod image;
pub mod pace;
pub mod recording;
pub mod session;
pub mod simulated;
pub mod switch_off;
pub mod words;

pub use client::{Answer, Client, Event, Question};
pub use heard::Heard;
pub use session::Session;
pub use simulated::SimulatedBoard;
