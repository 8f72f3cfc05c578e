//! What a board has said so far.

use crate::client::Event;
use twinrotor::first_power::Verdict;
use twinrotor::link::{Health, Identity, Refusal, ToHost};
use twinrotor::parameters::Parameters;
use twinrotor::replay::Replayed;
use twinrotor::supervisor::{ArmState, Condition};
use twinrotor::telemetry::Frame;

/// What a board has said.
#[derive(Debug, Default)]
pub struct Heard {
    /// Every frame of telemetry.
    pub frames: Vec<Frame>,
    /// Every report of its health.
    pub health: Vec<Health>,
    /// Who it is, for each time it said so.
    pub identities: Vec<Identity>,
    /// Its parameters, for each time it said them.
    pub parameters: Vec<Parameters>,
    /// How often it said that it had saved its parameters.
    pub saved: usize,
    /// What its first-power checks found.
    pub verdicts: Vec<Verdict>,
    /// What it made of the ticks of a record.
    pub replayed: Vec<Replayed>,
    /// What it would not do.
    pub refusals: Vec<Refusal>,
    /// Messages that came damaged.
    pub damaged: usize,
}

impl Heard {
    /// Keeps what came over the line.
    pub fn note(&mut self, event: Event) {
        match event {
            Event::Message(message) => self.note_message(message),
            Event::Damaged => self.damaged += 1,
            Event::Answered(_) => {}
        }
    }

    fn note_message(&mut self, message: ToHost) {
        match message {
            ToHost::Frame(frame) => self.frames.push(frame),
            ToHost::Health(health) => self.health.push(health),
            ToHost::Identity(identity) => self.identities.push(identity),
            ToHost::Parameters(parameters) => self.parameters.push(parameters),
            ToHost::Saved => self.saved += 1,
            ToHost::Verdict(verdict) => self.verdicts.push(verdict),
            ToHost::Replayed(replayed) => self.replayed.push(replayed),
            ToHost::Refused(refusal) => self.refusals.push(refusal),
        }
    }

    /// The state in the last frame.
    pub fn state(&self) -> Option<ArmState> {
        self.frames.last().map(|frame| frame.state)
    }

    /// What is wrong by the last frame.
    pub fn conditions(&self) -> Vec<Condition> {
        self.frames.last().map(|frame| frame.conditions.iter().collect()).unwrap_or_default()
    }

    /// Where the board stands, in a line.
    pub fn summary(&self) -> String {
        format!(
            "{:?} with {:?}, {} frames, verdicts {:?}, refusals {:?}, {} damaged",
            self.state(),
            self.conditions(),
            self.frames.len(),
            self.verdicts,
            self.refusals,
            self.damaged
        )
    }
}
