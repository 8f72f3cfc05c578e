//! A trial's part of the tick (`core/src/trial.rs` has the rules), and what is told of it.

use super::{ControlLoop, OperatorCommand, Status};
use crate::axes::PerAxis;
use crate::estimator::Belief;
use crate::reference::Reference;
use crate::sequence::Numbered;
use crate::telemetry::{InForce, Kept, TrialPhase};
use crate::trial::{Candidate, Trial};

impl ControlLoop {
    /// Which controller decides, for telemetry.
    pub(super) fn in_force(&self) -> InForce {
        let (trial, blend) = self.trial.as_ref().map_or((TrialPhase::None, 0), |t| (t.phase(), t.percent()));
        InForce { accepted: self.kept, trial, blend }
    }

    /// A controller is being tried.
    #[inline(always)]
    pub fn is_trying(&self) -> bool {
        self.trial.is_some()
    }

    /// What the conversation must know.
    pub fn status(&self) -> Status {
        Status {
            armed: self.is_armed(),
            flash_may_be_written: self.state().lets_flash_be_written(),
            trial: self.trial.as_ref().map_or(TrialPhase::None, Trial::phase),
            accepted: self.accepted_by,
        }
    }

    /// Begins to try `candidate`, if `command` asks for it.
    #[inline(never)]
    pub(super) fn begin_trying(
        &mut self,
        candidate: &Candidate,
        command: Option<&Numbered<OperatorCommand>>,
        measured: PerAxis<f32>,
    ) {
        let asked = command.is_some_and(|command| candidate.is_asked_for_by(command));
        if asked && self.trial.is_none() && self.is_armed() {
            Trial::begin(&mut self.trial, candidate, &self.accepted, measured);
        }
    }

    /// A trial's part of the tick.
    #[inline(never)]
    pub(super) fn go_on_trying(
        &mut self,
        belief: Belief<f32>,
        reference: &Reference<f32>,
        command: Option<&OperatorCommand>,
    ) {
        let Some(trial) = &mut self.trial else { return };
        if command == Some(&OperatorCommand::Revert) {
            trial.take_back();
        }
        let decision = trial.decide(&self.decision, belief, reference);
        let over = decision.is_none() || trial.is_over();
        if let Some(decision) = decision {
            self.decision = decision;
        }
        if over {
            self.trial = None;
        } else if command == Some(&OperatorCommand::Accept)
            && let Some(sequence) = trial.accept(&mut self.accepted)
        {
            self.kept = Kept::Unsaved;
            self.accepted_by = Some(sequence);
            self.trial = None;
        }
    }
}
