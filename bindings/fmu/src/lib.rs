//! A functional mock-up unit of FMI 2.0 for co-simulation: a rig, its board, or both, with the bits that fly.
//!
//! [`Model`] is what a unit holds, [`description`] its XML, [`interface`] the standard's C functions around
//! it. A unit's rig and gains are files in its `resources`, so that one library serves every unit.

mod description;
mod design;
mod history;
pub mod interface;
mod model;
mod tuning;
mod variables;

pub use description::description;
pub use design::{Design, What};
pub use model::Model;
pub use variables::{Causality, Variable, variables};
