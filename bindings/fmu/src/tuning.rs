//! Parameters that are set in flight: a trial, as an operator makes one (`core/src/trial.rs` has the rules).

use twinrotor::control_loop::{ControlLoop, OperatorCommand};
use twinrotor::controller::ControllerSettings;
use twinrotor::parameters::Parameters;
use twinrotor::real::Real;
use twinrotor::sequence::{Numbered, Sequence};
use twinrotor::telemetry::TrialPhase;
use twinrotor::trial::{Attempt, Candidate};

/// \[ticks\] That a controller flies alone before it is accepted.
const ALONE: u32 = 1_000;

/// What is asked of a board beside flying on.
pub(crate) type Asked = (Numbered<OperatorCommand>, Option<Candidate>);

/// Which controller flies, which is tried, and which is to be tried next.
#[derive(Debug, Clone)]
pub(crate) struct Tuning {
    accepted: ControllerSettings<f64>,
    tried: Option<ControllerSettings<f64>>,
    wanted: Option<ControllerSettings<f64>>,
    said: Sequence,
    /// Of the message that asked for what is tried.
    asked: Sequence,
    /// \[ticks\] That it has flown alone.
    alone: u32,
}

impl Tuning {
    pub(crate) fn new(accepted: ControllerSettings<f64>) -> Self {
        let said = Sequence::default();
        Self { accepted, tried: None, wanted: None, said, asked: said, alone: 0 }
    }

    /// What was asked for last, unless it was taken back.
    pub(crate) fn controller(&self) -> &ControllerSettings<f64> {
        self.wanted.as_ref().or(self.tried.as_ref()).unwrap_or(&self.accepted)
    }

    /// To be tried as soon as the motors turn and nothing else is tried.
    pub(crate) fn want(&mut self, controller: ControllerSettings<f64>) {
        self.wanted = Some(controller);
    }

    /// What is to be asked of `control` in the tick that comes, whose parameters are these.
    pub(crate) fn ask(&mut self, control: &ControlLoop, parameters: &Parameters) -> Option<Asked> {
        let status = control.status();
        if let Some(tried) = self.tried {
            match status.trial {
                TrialPhase::Flying => {
                    self.alone += 1;
                    return (self.alone > ALONE).then(|| (self.number(OperatorCommand::Accept), None));
                }
                TrialPhase::None => {
                    if status.accepted == Some(self.asked) {
                        self.accepted = tried;
                    }
                    self.tried = None;
                }
                TrialPhase::Shadow | TrialPhase::FadingIn | TrialPhase::FadingOut => return None,
            }
        }
        if !status.armed {
            return None;
        }
        let wanted = self.wanted.take()?;
        let command = self.number(OperatorCommand::Try);
        let attempt = Attempt::new(wanted.map(f32::from_f64));
        // What no board would take was refused when it was set.
        let candidate = Candidate::new(parameters, &attempt, command.sequence).ok()?;
        (self.tried, self.asked, self.alone) = (Some(wanted), command.sequence, 0);
        Some((command, Some(candidate)))
    }

    fn number(&mut self, message: OperatorCommand) -> Numbered<OperatorCommand> {
        self.said = self.said.next();
        Numbered { sequence: self.said, message }
    }
}
