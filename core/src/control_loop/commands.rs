//! The command that counts in a tick, and what it does to the reference and to where zero is.

use super::{ControlLoop, Inputs, OperatorCommand};
use crate::bench::Injection;
use crate::first_power::REST_TICKS;
use crate::sequence::Numbered;
use crate::telemetry::Taken;
use core::hint::cold_path;

impl ControlLoop {
    /// The command that counts in this tick: none where the operator disarms.
    #[inline(always)]
    pub(super) fn take<'a>(&mut self, inputs: &Inputs<'a>) -> Option<&'a OperatorCommand> {
        self.taken.ago = self.taken.ago.saturating_add(1);
        let Numbered { sequence, message } = inputs.command.filter(|_| !inputs.disarm)?;
        cold_path();
        self.taken = Taken { sequence: *sequence, ago: 0 };
        Some(message)
    }

    #[inline(never)]
    pub(super) fn follow_command(&mut self, command: &OperatorCommand) {
        match command {
            OperatorCommand::Setpoint(setpoint) => self.approach.aim(*setpoint),
            OperatorCommand::Zero
                if self.still >= REST_TICKS && !self.supervisor.state().motors_may_turn() =>
            {
                self.zero();
            }
            // A rig that is laid down anew: what the motors did before has no part in it.
            OperatorCommand::Inject(Injection::Rest) if !self.supervisor.state().motors_may_turn() => {
                self.accepted.pipeline.forget_motion();
            }
            _ => {}
        }
    }

    /// Takes where the rig lies for its rest pose.
    fn zero(&mut self) {
        self.encoders.pitch.set_position(self.rest_counts.pitch);
        self.encoders.yaw.set_position(self.rest_counts.yaw);
        self.accepted.pipeline.restart(self.encoders.map(|e| e.angle()));
        self.zeroed = true;
    }
}
