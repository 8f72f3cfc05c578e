//! Twinrotor on a PC: the core that flies on the board, closed around a simulated helicopter, once or
//! thousands of times.

#![cfg_attr(
    test,
    allow(
        clippy::float_cmp,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "tests compare bits and make samples"
    )
)]

pub mod board;
pub mod checkpoint;
pub mod cli;
pub mod closed_loop;
pub mod error;
pub mod export;
pub mod figures;
pub mod flash;
pub mod flight;
pub mod gains_file;
pub mod identify;
pub mod lanes;
pub mod log;
pub mod metrics;
pub mod objective;
pub mod operation_count;
pub mod optimise;
pub mod output;
pub mod peers;
pub mod plot;
pub mod replay;
pub mod report;
pub mod rig;
pub mod robust;
pub mod scenario;
pub mod tunable;
pub mod tuner;
