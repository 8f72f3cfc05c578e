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

use crate::control_loop::OperatorCommand;
use crate::link::{self, Identity, LinkError, Nonce, Refusal, ResetReport, ToBoard, ToHost};
use crate::parameters::{self, Parameters, Provenance};
use crate::replay::{Replay, Replayed, Sample};
use crate::sequence::{Numbered, Order, Sequence};
use crate::supervisor::{Conditions, Request};

/// \[ticks\] Fewest and most from one frame of telemetry to the next.
pub const FRAME_EVERY: core::ops::RangeInclusive<u16> = 1..=1000;

/// What a board knows of itself when it boots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Board {
    /// Version of its firmware, such as `0.1.0`.
    pub firmware: &'static str,
    /// Its chip, such as `stm32f405rg`.
    pub chip: &'static str,
    /// What this boot is known by: another one than the last boot's.
    pub nonce: Nonce,
    /// What ended the firmware before this boot, if it was no ordinary reset.
    pub reset: Option<ResetReport>,
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
    rejected: u32,
    stale: u32,
}

impl Conversation {
    /// At boot, with the parameters in force.
    #[must_use]
    pub const fn new(board: Board, parameters: Parameters, provenance: Provenance) -> Self {
        let order = Order::new();
        Self { board, parameters, provenance, order, replay: None, rejected: 0, stale: 0 }
    }

    /// The parameters in force.
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

    /// Deals with what came over the link. `room`: whether the tick has room for a command.
    pub fn receive(&mut self, received: Result<Numbered<ToBoard>, LinkError>, room: bool) -> Response {
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
            self.deal_with(sequence, message, room)
        };
        Response { heard, action }
    }

    /// A message that counts: new, or one that always does, and meant for this boot.
    fn deal_with(&mut self, sequence: Sequence, message: ToBoard, room: bool) -> Action {
        let command = match message {
            ToBoard::Alive => return Action::Nothing,
            ToBoard::Disarm => return Action::Disarm,
            ToBoard::Identify => return Action::Answer(self.identity()),
            ToBoard::ReadParameters => return Action::Answer(ToHost::Parameters(self.parameters)),
            ToBoard::Telemetry { every } if FRAME_EVERY.contains(&every) => return Action::FrameEvery(every),
            ToBoard::Telemetry { .. } => {
                return refused(Refusal::range("telemetry.every", "1 to 1000 ticks"));
            }
            ToBoard::Replay(sample) => {
                return self.replayed(&sample).map_or(refused(Refusal::NoReplay), |replayed| {
                    Action::Answer(ToHost::Replayed(replayed))
                });
            }
            ToBoard::WriteParameters(_, parameters) => {
                return match parameters.validate() {
                    Ok(()) => Action::Keep(parameters),
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
        };
        if room { Action::Command(Numbered { sequence, message: command }) } else { refused(Refusal::Busy) }
    }

    /// What came of [`Action::Keep`]; gives the answer. From then on `parameters` are those in force, if they
    /// were kept.
    pub fn kept(&mut self, parameters: &Parameters, outcome: Result<(), Refusal>) -> ToHost {
        if let Err(refusal) = outcome {
            return ToHost::Refused(refusal);
        }
        self.parameters = *parameters;
        self.provenance = Provenance::Stored;
        // Half a record with one controller and half with another would be neither's.
        self.replay = None;
        ToHost::Saved
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
