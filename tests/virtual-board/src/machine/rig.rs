//! What a board is connected to.

use std::any::Any;

use crate::board::{Inputs, Outputs};

/// What the board is connected to.
pub trait Rig: Any + Send {
    /// A millisecond passes with the board's `outputs` in effect: what the rig's sensors say at its end.
    fn step(&mut self, outputs: &Outputs) -> Inputs;
}

/// A rig at rest: nothing moves, the supply is on.
#[derive(Debug, Default)]
pub struct AtRest(pub Inputs);

impl Rig for AtRest {
    fn step(&mut self, _outputs: &Outputs) -> Inputs {
        self.0
    }
}
