//! Controllers designed for a rig by rules: what tuning starts from and what it is compared with.

mod catalogue;
mod riccati;

pub use catalogue::{CATALOGUE, Design, uses};
pub use riccati::{kalman, lqr};
