//! Twinrotor's tuner: methods of search, what they minimise, which of a controller's numbers they may move,
//! and the designs that they start from. No files, no terminal; threads by the feature `threads`, without
//! which the same bytes come out one after the other.

#![cfg_attr(
    test,
    allow(
        clippy::float_cmp,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "tests compare bits and make samples"
    )
)]

pub mod checkpoint;
pub mod contest;
pub mod design;
pub mod integral;
pub mod optimise;
pub mod parallel;
pub mod robust;
pub mod search;
pub mod tunable;
