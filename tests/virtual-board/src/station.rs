//! An operator's end of the link: sends commands to a board that runs, and keeps what it says.

use host_sim::board::AT_ONCE;
use twinrotor::axes::PerAxis;
use twinrotor::control_loop::OperatorCommand;
use twinrotor::first_power::Verdict;
use twinrotor::link::{self, Decoder, Health, Identity, MAX_FRAME, Refusal, ToBoard, ToHost};
use twinrotor::parameters::Parameters;
use twinrotor::reference::Reference;
use twinrotor::replay::{Replayed, Sample};
use twinrotor::supervisor::{ArmState, Condition, Request};
use twinrotor::telemetry::Frame;

use crate::machine::{Failure, Machine};

/// What the board has said.
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

/// An operator with a board.
#[derive(Debug)]
pub struct Station {
    /// The board.
    pub machine: Machine,
    /// What it said so far.
    pub heard: Heard,
    decoder: Decoder,
    /// \[ms\] Since it last did.
    silent: u64,
    /// Whether to tell the board ten times a second that somebody is there.
    pub attentive: bool,
}

/// \[ms\] How often an attentive operator's program says that it is there.
const ALIVE_EVERY: u64 = 100;

impl Station {
    /// At `machine`, attentive.
    pub fn new(machine: Machine) -> Self {
        Self { machine, heard: Heard::default(), decoder: Decoder::new(), silent: 0, attentive: true }
    }

    /// Sends a message.
    pub fn send(&mut self, message: &ToBoard) {
        let mut buffer = [0; MAX_FRAME];
        let frame = link::encode(message, &mut buffer).expect("every message has room");
        self.machine.say(frame);
    }

    /// Asks something of the supervisor.
    pub fn request(&mut self, request: Request) {
        self.send(&ToBoard::Control(OperatorCommand::Request(request)));
    }

    /// Puts a record through the board's own estimator and law.
    ///
    /// # Errors
    ///
    /// If the firmware reached something that is not modelled, or does not answer.
    pub fn replay(&mut self, samples: &[Sample]) -> Result<Vec<Replayed>, Failure> {
        self.heard.replayed.clear();
        for chunk in samples.chunks(AT_ONCE) {
            chunk.iter().for_each(|sample| self.send(&ToBoard::Replay(*sample)));
            let wanted = self.heard.replayed.len() + chunk.len();
            for _ in 0..100 {
                self.try_run(2)?;
                if self.heard.replayed.len() >= wanted {
                    break;
                }
            }
            if self.heard.replayed.len() < wanted {
                let heard = self.heard.replayed.len();
                return Err(Failure(format!("after {heard} ticks of the record: {}", self.heard.summary())));
            }
        }
        Ok(std::mem::take(&mut self.heard.replayed))
    }

    /// Wants the helicopter at rest there, angles in rad.
    pub fn aim(&mut self, angle: PerAxis<f32>) {
        self.send(&ToBoard::Control(OperatorCommand::Setpoint(Reference::at_rest(angle))));
    }

    /// Lets the board run and listens.
    ///
    /// # Panics
    ///
    /// If the firmware reached something that is not modelled.
    #[track_caller]
    pub fn run(&mut self, milliseconds: u64) {
        self.try_run(milliseconds).unwrap_or_else(|failure| panic!("{failure}"));
    }

    /// Lets the board run and listens.
    ///
    /// # Errors
    ///
    /// If the firmware reached something that is not modelled.
    pub fn try_run(&mut self, milliseconds: u64) -> Result<(), Failure> {
        let mut left = milliseconds;
        while left > 0 {
            let stretch = left.min(ALIVE_EVERY - self.silent);
            if self.attentive && self.silent == 0 {
                self.send(&ToBoard::Alive);
            }
            self.silent = (self.silent + stretch) % ALIVE_EVERY;
            self.machine.try_run(stretch)?;
            self.listen();
            left -= stretch;
        }
        Ok(())
    }

    /// Lets the board run until what it said so far is what was waited for, at most so long. Answers whether
    /// it came.
    ///
    /// # Panics
    ///
    /// If the firmware reached something that is not modelled.
    #[track_caller]
    pub fn run_until(&mut self, milliseconds: u64, mut came: impl FnMut(&Heard) -> bool) -> bool {
        const LOOK_EVERY: u64 = 2;
        for _ in 0..milliseconds.div_ceil(LOOK_EVERY) {
            self.run(LOOK_EVERY);
            if came(&self.heard) {
                return true;
            }
        }
        false
    }

    /// Lets the board run until its telemetry says it is in `state`.
    ///
    /// # Panics
    ///
    /// If it is not within `milliseconds`: with the state it is in instead, and what keeps it there.
    #[track_caller]
    pub fn await_state(&mut self, milliseconds: u64, state: ArmState) {
        let came = self.run_until(milliseconds, |heard| heard.state() == Some(state));
        assert!(came, "not {state:?} after {milliseconds} ms but {}", self.heard.summary());
    }

    /// Takes what came over the line.
    fn listen(&mut self) {
        for byte in self.machine.heard() {
            match self.decoder.push(byte) {
                Some(Ok(message)) => self.heard.note(message),
                Some(Err(_)) => self.heard.damaged += 1,
                None => {}
            }
        }
    }
}

impl Heard {
    fn note(&mut self, message: ToHost) {
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
