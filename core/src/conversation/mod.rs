//! What a board answers to each message: a state machine without transport, flash or clock.
//!
//! A host of it (the firmware, or a board that is simulated) gives it what came over the link
//! ([`Conversation::receive`]) and does the [`Action`] that comes out: it hands commands to the tick, keeps a
//! record, sends an answer. What is to be sent first is decided in [`outgoing`], how the tick takes commands
//! in [`commands`].

pub mod commands;
pub mod goal;
pub mod outgoing;
#[cfg(test)]
mod tests;

use crate::control_loop::{OperatorCommand, Status};
use crate::link::{self, ChipSerial, Identity, LinkError, Nonce, Refusal, ResetReport, ToBoard, ToHost};
use crate::parameters::{self, Parameters, Provenance};
use crate::replay::{Replay, Replayed, Sample};
use crate::rig_port::RigPort;
use crate::sequence::{Numbered, Order, Sequence};
use crate::supervisor::{Conditions, Request};
use crate::telemetry::TrialPhase;
use crate::trial::{Attempt, Candidate};

/// \[ticks\] Fewest and most from one frame of telemetry to the next.
pub const FRAME_EVERY: core::ops::RangeInclusive<u16> = 1..=1000;

/// What a board knows of itself when it boots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Board {
    /// Version of its firmware, such as `0.1.0`.
    pub firmware: &'static str,
    /// Its chip, such as `stm32f405rg`.
    pub chip: &'static str,
    /// What its rig is.
    pub port: RigPort,
    /// Its chip's own number; zeros where there is no chip.
    pub serial: ChipSerial,
    /// What this boot is known by: another one than the last boot's.
    pub nonce: Nonce,
    /// What ended the firmware before this boot, if it was no ordinary reset.
    pub reset: Option<ResetReport>,
    /// \[baud\] Of its line.
    pub baud: u32,
}

/// What the loop can take, and where it stands, when a message comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Loop {
    /// There is room for a command.
    pub takes_command: bool,
    /// There is room for a candidate: the last one has been taken, or forgotten. Looked at before `status`,
    /// where the tick may come between.
    pub takes_candidate: bool,
    /// After the last tick.
    pub status: Status,
}

/// What came of a message.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// A host is there: for [`crate::control_loop::Inputs::heard`].
    pub heard: bool,
    /// What is to be done.
    pub action: Action,
}

/// What is to be done about a message.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Nothing.
    Nothing,
    /// To send this.
    Answer(ToHost),
    /// To switch the motors off in the next tick: [`crate::control_loop::Inputs::disarm`].
    Disarm,
    /// To hand this to the tick.
    Command(Numbered<OperatorCommand>),
    /// To make [`Conversation::candidate`] ready for the tick, then to hand it this command, an
    /// [`OperatorCommand::Try`].
    Try(Numbered<OperatorCommand>),
    /// To send a frame every so many ticks.
    FrameEvery(u16),
    /// To keep this record, if the motors cannot turn: the tick stands aside, the record goes to flash, the
    /// tick adopts it; then [`Conversation::kept`].
    Keep(Parameters),
}

/// A board's side of the conversation.
#[derive(Debug, Clone)]
pub struct Conversation {
    board: Board,
    parameters: Parameters,
    provenance: Provenance,
    order: Order,
    replay: Option<Replay>,
    /// What was handed to the tick to be tried, until that has ended or is accepted.
    tried: Option<(Sequence, Attempt)>,
    rejected: u32,
    stale: u32,
}

impl Conversation {
    /// At boot, with the parameters in force.
    #[must_use]
    pub const fn new(board: Board, parameters: Parameters, provenance: Provenance) -> Self {
        let order = Order::new();
        Self { board, parameters, provenance, order, replay: None, tried: None, rejected: 0, stale: 0 }
    }

    /// The parameters in force, with the accepted controller.
    #[must_use]
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// What the parameters' provenance says against arming.
    #[must_use]
    pub const fn standing(&self) -> Conditions {
        self.provenance.conditions()
    }

    /// Messages since boot that came damaged, in another version, or too long.
    #[must_use]
    pub const fn rejected(&self) -> u32 {
        self.rejected
    }

    /// Messages since boot that were not newer than what came before.
    #[must_use]
    pub const fn stale(&self) -> u32 {
        self.stale
    }

    /// Deals with what came over the link, where the loop is as in `now`.
    pub fn receive(&mut self, received: Result<Numbered<ToBoard>, LinkError>, now: &Loop) -> Response {
        self.follow(now);
        let Ok(Numbered { sequence, message }) = received else {
            self.rejected = self.rejected.wrapping_add(1);
            return Response { heard: false, action: Action::Nothing };
        };
        let heard = self.order.admit(sequence);
        // Motors off does no harm twice, and a host that does not know the number must be told it.
        let always = matches!(message, ToBoard::Disarm | ToBoard::Identify);
        let action = if !(heard || always) {
            self.stale = self.stale.wrapping_add(1);
            Action::Nothing
        } else if message.nonce().is_some_and(|nonce| nonce != self.board.nonce) {
            refused(Refusal::Nonce)
        } else {
            self.deal_with(sequence, message, now)
        };
        Response { heard, action }
    }

    /// A message that counts: new, or one that always does, and meant for this boot.
    fn deal_with(&mut self, sequence: Sequence, message: ToBoard, now: &Loop) -> Action {
        let command = match message {
            ToBoard::Alive => return Action::Nothing,
            ToBoard::Disarm => return Action::Disarm,
            ToBoard::Identify => return Action::Answer(self.identity()),
            ToBoard::ReadParameters => return Action::Answer(ToHost::Parameters(self.in_force(&now.status))),
            ToBoard::Telemetry { every } => return self.frame_every(every),
            ToBoard::Replay(sample) => {
                return self.replayed(&sample).map_or(refused(Refusal::NoReplay), |replayed| {
                    Action::Answer(ToHost::Replayed(replayed))
                });
            }
            ToBoard::WriteParameters(_, parameters) => {
                return match parameters.validate() {
                    Ok(()) => Action::Keep(parameters.at_port(self.board.port)),
                    Err(error) => refused(error.into()),
                };
            }
            ToBoard::Check(_) if !self.standing().is_empty() => return refused(Refusal::NoParameters),
            ToBoard::Setpoint(setpoint) => match goal::outside(&self.parameters.limits, &setpoint) {
                None => OperatorCommand::Setpoint(setpoint),
                Some(refusal) => return refused(refusal),
            },
            ToBoard::Zero => OperatorCommand::Zero,
            ToBoard::Arm(_) => OperatorCommand::Request(Request::Arm),
            ToBoard::ClearFault(_) => OperatorCommand::Request(Request::ClearFault),
            ToBoard::Check(_) => OperatorCommand::Request(Request::Check),
            ToBoard::Trial(_, attempt) => return self.handed_over(sequence, &attempt, now),
            ToBoard::Accept(_) if now.status.trial != TrialPhase::Flying => {
                return refused(Refusal::NothingToAccept);
            }
            ToBoard::Accept(_) => OperatorCommand::Accept,
            ToBoard::Revert => OperatorCommand::Revert,
            ToBoard::Save(_) => return self.saved(&now.status),
            ToBoard::Inject(..) if self.board.port != RigPort::Simulated => {
                return refused(Refusal::NotSimulated);
            }
            ToBoard::Inject(_, injection) => match injection.validate() {
                Ok(()) => OperatorCommand::Inject(injection),
                Err(invalid) => return refused(Refusal::range(invalid.field, invalid.allowed)),
            },
        };
        if now.takes_command {
            Action::Command(Numbered { sequence, message: command })
        } else {
            refused(Refusal::Busy)
        }
    }

    /// What came of [`Action::Keep`]; gives the answer. From then on `parameters` are those in force, if they
    /// were kept.
    pub fn kept(&mut self, parameters: &Parameters, outcome: Result<(), Refusal>) -> ToHost {
        if let Err(refusal) = outcome {
            return ToHost::Refused(refusal);
        }
        self.parameters = *parameters;
        self.provenance = Provenance::Stored;
        self.tried = None;
        // Half a record with one controller and half with another would be neither's.
        self.replay = None;
        ToHost::Saved
    }

    fn frame_every(&self, ticks: u16) -> Action {
        let least = link::ticks_per_frame(self.board.baud);
        if !FRAME_EVERY.contains(&ticks) {
            refused(Refusal::range("telemetry.every", "1 to 1000 ticks"))
        } else if ticks < least {
            refused(Refusal::TooOften { least })
        } else {
            Action::FrameEvery(ticks)
        }
    }

    /// What became of what is tried.
    fn follow(&mut self, now: &Loop) {
        let Some((sequence, attempt)) = &self.tried else { return };
        if now.status.accepted == Some(*sequence) {
            self.parameters.settings.controller = attempt.controller;
            self.replay = None;
            self.tried = None;
        } else if now.takes_candidate && now.status.trial == TrialPhase::None {
            self.tried = None;
        }
    }

    /// The parameters in force, with the controller that flies.
    fn in_force(&self, status: &Status) -> Parameters {
        let mut parameters = self.parameters;
        if let (Some((_, attempt)), TrialPhase::Flying) = (&self.tried, status.trial) {
            parameters.settings.controller = attempt.controller;
        }
        parameters
    }

    /// A controller to be tried, on its way to the tick.
    fn handed_over(&mut self, sequence: Sequence, attempt: &Attempt, now: &Loop) -> Action {
        if !now.status.armed {
            return refused(Refusal::NotArmed);
        }
        if self.tried.is_some() {
            return refused(Refusal::TrialUnderWay);
        }
        // A number that was accepted half a day ago would be taken for accepted again.
        if !(now.takes_command && now.takes_candidate) || now.status.accepted == Some(sequence) {
            return refused(Refusal::Busy);
        }
        if let Err(invalid) = attempt.validate() {
            return refused(Refusal::range(invalid.field, invalid.allowed));
        }
        self.tried = Some((sequence, *attempt));
        Action::Try(Numbered { sequence, message: OperatorCommand::Try })
    }

    /// What is to be tried, ready for the tick; none where nothing is.
    #[must_use]
    pub fn candidate(&self) -> Option<Candidate> {
        let (sequence, attempt) = self.tried.as_ref()?;
        Candidate::new(&self.parameters, attempt, *sequence).ok()
    }

    /// The accepted controller to flash, if it is not there yet.
    fn saved(&self, status: &Status) -> Action {
        if !status.flash_may_be_written {
            refused(Refusal::MotorsMayTurn)
        } else if !self.standing().is_empty() {
            refused(Refusal::NoParameters)
        } else if status.accepted.is_some() {
            Action::Keep(self.parameters)
        } else {
            Action::Answer(ToHost::Saved)
        }
    }

    /// One tick of a record; nothing of the control loop's. What it puts on the stack is not always there.
    #[inline(never)]
    fn replayed(&mut self, sample: &Sample) -> Option<Replayed> {
        if sample.number == 0 {
            self.replay = Some(Replay::new(&self.parameters, sample));
        }
        self.replay.as_mut().map(|replay| replay.step(sample))
    }

    /// Who the board is: to be sent at boot.
    #[must_use]
    pub fn identity(&self) -> ToHost {
        ToHost::Identity(Identity {
            firmware: link::text(self.board.firmware),
            chip: link::text(self.board.chip),
            serial: self.board.serial,
            port: self.board.port,
            parameters: parameters::VERSION,
            provenance: self.provenance,
            nonce: self.board.nonce,
            expected: self.order.expected(),
            reset: self.board.reset,
        })
    }
}

fn refused(refusal: Refusal) -> Action {
    Action::Answer(ToHost::Refused(refusal))
}
