//! A board that is simulated with its rig: the core's loop, conversation and record store on a bench, tick by
//! tick. What the firmware does beside that, transport and flash, is here bytes in a vector and flash in RAM.
//!
//! [`SimulatedBoard::new`] is a board with any rig at its port, as the firmware for real rigs is one;
//! [`SimulatedBoard::alone`] one that computes the rig of its own record, as the firmware with the feature
//! `simulated` does.

use twinrotor::bench::SimulatedRig;
use twinrotor::board;
use twinrotor::control_loop::{ControlLoop, Inputs, OperatorCommand};
use twinrotor::conversation::commands::{self, Commands};
use twinrotor::conversation::outgoing::{Outgoing, Waiting};
use twinrotor::conversation::{Action, Board, Conversation, Loop};
use twinrotor::drive::Drive;
use twinrotor::encoder::CounterWidth;
use twinrotor::first_power::Verdict;
use twinrotor::link::{BAUD, ChipSerial, Decoder, Health, MAX_FRAME, Nonce, Refusal, ToHost, encode};
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{SLOT_SIZE, Store};
use twinrotor::parameters::{self, Parameters, Provenance};
use twinrotor::plant::presets::Rig;
use twinrotor::rig_port::RigPort;
use twinrotor::sequence::Numbered;
use twinrotor::supervisor::{Condition, Conditions};
use twinrotor::telemetry::Frame;
use twinrotor::trial::Candidate;

/// \[ticks\] From frame to frame, until the host says otherwise; the firmware's.
const FRAME_EVERY: u16 = 5;

/// A board and its rig.
pub struct SimulatedBoard {
    /// The rig: faults, supply and disturbances may be set at any time.
    pub rig: SimulatedRig,
    /// What else is wrong, as only a board can see: the emergency stop, for example.
    pub senses: Conditions,
    /// The last tick took too long.
    overrun: bool,
    port: RigPort,
    control: ControlLoop,
    conversation: Conversation,
    flash: Store<RamFlash>,
    built_in: Parameters,
    hardware: board::Board,
    commands: Commands,
    /// To be tried, until the loop has taken it.
    candidate: Option<Candidate>,
    disarm: bool,
    heard: bool,
    frame_every: u16,
    until_frame: u16,
    decoder: Decoder,
    reports: Reports,
    outgoing: Outgoing,
    sent: Vec<u8>,
    boots: u32,
}

/// What waits to be said.
#[derive(Debug, Default)]
struct Reports {
    answers: Vec<ToHost>,
    verdict: Option<Verdict>,
    frame: Option<Frame>,
    messages_rejected: u32,
    messages_stale: u32,
}

impl Waiting for Reports {
    fn answer(&mut self) -> Option<ToHost> {
        (!self.answers.is_empty()).then(|| self.answers.remove(0))
    }

    fn verdict(&mut self) -> Option<Verdict> {
        self.verdict.take()
    }

    fn frame(&mut self) -> Option<Frame> {
        self.frame.take()
    }

    fn health(&mut self) -> Health {
        let Self { messages_rejected, messages_stale, .. } = *self;
        Health { messages_rejected, messages_stale, ..Health::default() }
    }
}

impl SimulatedBoard {
    /// `rig` in its rest pose; a board that has just booted with what is in `flash`, or else with the
    /// parameters `built_in`.
    pub fn new(rig: &Rig, built_in: Parameters, flash: RamFlash) -> Self {
        let mut flash = Store::new(flash, 0);
        let loaded = load(&mut flash, RigPort::Pwm, built_in);
        Self::with(SimulatedRig::new(rig), RigPort::Pwm, rig.board, flash, built_in, loaded, 0)
    }

    /// The same of a board of that kind that computes the rig of its own record, in its rest pose.
    pub fn alone(hardware: board::Board, built_in: Parameters, flash: RamFlash) -> Self {
        let mut flash = Store::new(flash, 0);
        let loaded = load(&mut flash, RigPort::Simulated, built_in);
        let rig = SimulatedRig::of(&loaded.0, hardware);
        Self::with(rig, RigPort::Simulated, hardware, flash, built_in, loaded, 0)
    }

    fn with(
        rig: SimulatedRig,
        port: RigPort,
        hardware: board::Board,
        flash: Store<RamFlash>,
        built_in: Parameters,
        (parameters, provenance): (Parameters, Provenance),
        boots: u32,
    ) -> Self {
        let board = Board {
            firmware: env!("CARGO_PKG_VERSION"),
            chip: "simulated",
            port,
            serial: ChipSerial::default(),
            nonce: Nonce(boots),
            reset: None,
            baud: BAUD,
        };
        let conversation = Conversation::new(board, parameters, provenance);
        let drive = Drive::new(hardware.pwm_steps());
        let control = ControlLoop::new(&parameters, CounterWidth::Bits16, rig.counters(), drive, None);
        Self {
            rig,
            senses: Conditions::NONE,
            overrun: false,
            port,
            reports: Reports { answers: vec![conversation.identity()], ..Reports::default() },
            control,
            conversation,
            flash,
            built_in,
            hardware,
            commands: Commands::new(),
            candidate: None,
            disarm: false,
            heard: false,
            frame_every: FRAME_EVERY,
            until_frame: 0,
            decoder: Decoder::new(),
            outgoing: Outgoing::new(),
            sent: Vec::new(),
            boots,
        }
    }

    /// The board's supply comes back: it boots with what is in flash. A rig at its port stays where it is.
    #[must_use]
    pub fn reset(self) -> Self {
        let Self { rig, port, mut flash, built_in, hardware, senses, boots, .. } = self;
        let loaded = load(&mut flash, port, built_in);
        let rig = if port == RigPort::Simulated { SimulatedRig::of(&loaded.0, hardware) } else { rig };
        let board = Self::with(rig, port, hardware, flash, built_in, loaded, boots.wrapping_add(1));
        Self { senses, ..board }
    }

    /// Takes what came over the line.
    pub fn push(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let Some(received) = self.decoder.push(byte) else { continue };
            let (mut sender, _) = self.commands.split();
            let now = Loop {
                takes_command: sender.ready(),
                takes_candidate: self.candidate.is_none(),
                status: self.control.status(),
            };
            let response = self.conversation.receive(received, &now);
            self.heard |= response.heard;
            match response.action {
                Action::Nothing => {}
                Action::Answer(message) => self.reports.answers.push(message),
                Action::Disarm => self.disarm = true,
                Action::Command(command) => {
                    // The conversation was told that there is room.
                    let _ = sender.enqueue(command);
                }
                Action::Try(command) => {
                    self.candidate = self.conversation.candidate();
                    let _ = sender.enqueue(command);
                }
                Action::FrameEvery(ticks) => self.frame_every = ticks,
                Action::Keep(parameters) => {
                    let outcome = self.keep(&parameters);
                    self.reports.answers.push(self.conversation.kept(&parameters, outcome));
                }
            }
        }
        self.reports.messages_rejected = self.conversation.rejected();
        self.reports.messages_stale = self.conversation.stale();
    }

    fn keep(&mut self, parameters: &Parameters) -> Result<(), Refusal> {
        if !self.control.state().lets_flash_be_written() {
            return Err(Refusal::MotorsMayTurn);
        }
        parameters::save(&mut self.flash, parameters, &mut [0; SLOT_SIZE])?;
        if self.port == RigPort::Simulated {
            self.rig = SimulatedRig::of(parameters, self.hardware);
        }
        self.control.adopt(parameters);
        Ok(())
    }

    /// A millisecond passes.
    pub fn tick(&mut self) {
        let disarm = std::mem::take(&mut self.disarm);
        let (_, mut receiver) = self.commands.split();
        let command = commands::next(&mut receiver, disarm);
        let outputs = self.control.tick(&Inputs {
            current_limit: self.rig.current_limit(),
            senses: self
                .senses
                .union(self.conversation.standing())
                .with(
                    Condition::EmergencyStop,
                    self.senses.contains(Condition::EmergencyStop) | self.rig.emergency_stop(),
                )
                .with(Condition::TickOverrun, std::mem::take(&mut self.overrun)),
            heard: std::mem::take(&mut self.heard),
            disarm,
            trial: self.candidate.as_ref(),
            command,
            ..Inputs::sound(self.rig.counters(), self.rig.supply())
        });
        if let Some(Numbered { message: OperatorCommand::Inject(injection), .. }) = command {
            self.rig.inject(injection);
        }
        self.candidate.take_if(|candidate| commands::is_done_with(candidate, command, disarm));
        if command.is_some() {
            commands::done(&mut receiver);
        }
        self.rig.tick(outputs.duty, self.control.state());
        self.overrun = self.rig.take_stall() > 0;
        self.reports.verdict = self.reports.verdict.or(outputs.verdict);
        self.until_frame = self.until_frame.saturating_sub(1);
        if self.until_frame == 0 {
            self.until_frame = self.frame_every;
            self.reports.frame = Some(self.control.frame());
        }
        self.say();
    }

    /// Everything that waits, on to the line.
    fn say(&mut self) {
        while let Some(message) = self.outgoing.next(self.control.next_tick(), &mut self.reports) {
            let mut buffer = [0; MAX_FRAME];
            self.sent.extend(encode(&message, &mut buffer).expect("every message fits its frame"));
        }
    }

    /// What has been sent; it is forgotten here.
    pub fn take_outgoing(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.sent)
    }

    /// The last tick, whether it was sent or not.
    pub fn frame(&self) -> Frame {
        self.control.frame()
    }

    /// What is stored.
    pub fn into_flash(self) -> RamFlash {
        self.flash.into_flash()
    }
}

/// What a board does first.
fn load(flash: &mut Store<RamFlash>, port: RigPort, built_in: Parameters) -> (Parameters, Provenance) {
    parameters::load(flash, &mut [0; SLOT_SIZE], port, || built_in)
}

#[cfg(test)]
mod tests;
