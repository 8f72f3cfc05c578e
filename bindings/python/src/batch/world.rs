//! What sixteen plants do with what is asked.

use super::boards::Boards;
use super::task::{Kind, Seen, Task};
use super::volts::Volts;
use twinrotor::axes::PerAxis;
use twinrotor_sim::lanes::LANES;
use twinrotor_tune::robust::Draw;

/// Sixteen plants, each on its own.
pub(super) trait World: Send {
    /// Those for which something is drawn begin at rest at zero; the others go on.
    fn begin(&mut self, drawn: &[Option<Draw>; LANES]);

    /// All fly on for the ticks of one action.
    fn advance(&mut self, asked: &[[f32; 2]; LANES], goals: &[PerAxis<f32>; LANES]) -> [Seen; LANES];
}

/// Of this kind of action.
pub(super) fn world(task: &Task) -> Box<dyn World> {
    match task.kind {
        Kind::Volts => Box::new(Volts::new(task)),
        Kind::Setpoint { believed, settings, supervised } => {
            Box::new(Boards::new(&task.rig, &believed, &settings, supervised))
        }
    }
}
