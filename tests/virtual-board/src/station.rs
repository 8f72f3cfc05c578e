//! An operator with an emulated board: the station's client, whose bytes and time are the emulator's.

use std::time::Duration;

use twinrotor::axes::PerAxis;
use twinrotor::link::{Decoder, ToBoard};
use twinrotor::replay::{Replayed, Sample};
use twinrotor::sequence::Numbered;
use twinrotor::supervisor::{ArmState, Request};
use twinrotor_station::{Answer, Client, Event, Heard, Question};

use crate::machine::{Failure, Machine};
use crate::serial::Flaw;

/// An operator with a board.
#[derive(Debug)]
pub struct Station {
    /// The board.
    pub machine: Machine,
    /// What it said so far.
    pub heard: Heard,
    /// Whether to tell the board ten times a second that somebody is there.
    pub attentive: bool,
    /// What was said to it so far, each with the tick of the last frame that had come by then.
    pub said: Vec<(u32, Numbered<ToBoard>)>,
    decoder: Decoder,
    client: Client,
    /// \[ms\] That the board has run.
    now: u64,
    answer: Option<Result<Answer, String>>,
}

impl Station {
    /// At `machine`, attentive.
    pub fn new(machine: Machine) -> Self {
        Self {
            machine,
            heard: Heard::default(),
            attentive: true,
            said: Vec::new(),
            decoder: Decoder::new(),
            client: Client::new(),
            now: 0,
            answer: None,
        }
    }

    /// Sends a message.
    pub fn send(&mut self, message: &ToBoard) {
        self.client.send(message);
        self.say();
    }

    /// Sends a message whose `at`th word arrives with `flaw`, or, past its end, a word more that does.
    pub fn send_flawed(&mut self, message: &ToBoard, at: usize, flaw: Flaw) {
        self.client.send(message);
        let bytes = self.client.take_outgoing();
        let (before, rest) = bytes.split_at(at.min(bytes.len()));
        self.machine.say(before);
        match rest {
            [] => self.machine.say_flawed(0x55, flaw),
            [word, after @ ..] => {
                self.machine.say_flawed(*word, flaw);
                self.machine.say(after);
            }
        }
    }

    /// Asks something of the supervisor.
    pub fn request(&mut self, request: Request) {
        self.client.request(request);
        self.say();
    }

    /// Wants the helicopter at rest there, angles in rad.
    pub fn aim(&mut self, angle: PerAxis<f32>) {
        self.client.aim(angle);
        self.say();
    }

    fn say(&mut self) {
        let bytes = self.client.take_outgoing();
        let tick = self.heard.frames.last().map_or(0, |frame| frame.tick);
        let said = bytes.iter().filter_map(|&byte| self.decoder.push(byte)?.ok());
        self.said.extend(said.map(|message| (tick, message)));
        if !bytes.is_empty() {
            self.machine.say(&bytes);
        }
    }

    /// Puts a record through the board's own estimator and law.
    ///
    /// # Errors
    ///
    /// If the firmware reached something that is not modelled, or does not answer.
    pub fn replay(&mut self, samples: &[Sample]) -> Result<Vec<Replayed>, Failure> {
        self.answer = None;
        self.client.ask(Question::Replay(samples.to_vec()), Duration::from_millis(self.now));
        self.say();
        loop {
            self.try_run(2)?;
            match self.answer.take() {
                Some(Ok(Answer::Replayed(replayed))) => return Ok(replayed),
                Some(other) => return Err(Failure(format!("{other:?}: {}", self.heard.summary()))),
                None => {}
            }
        }
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
        let end = self.now + milliseconds;
        while self.now < end {
            let now = Duration::from_millis(self.now);
            self.client.set_attentive(self.attentive);
            let due = self.client.poll(now);
            self.note(due);
            self.say();
            let due = u64::try_from(self.client.due().as_millis()).unwrap_or(u64::MAX);
            let stretch = due.clamp(self.now + 1, end) - self.now;
            self.machine.try_run(stretch)?;
            self.now += stretch;
            let bytes = self.machine.heard();
            let events = self.client.push(&bytes, Duration::from_millis(self.now));
            self.note(events);
            self.say();
        }
        Ok(())
    }

    fn note(&mut self, events: impl IntoIterator<Item = Event>) {
        for event in events {
            match event {
                Event::Answered(outcome) => self.answer = Some(outcome.map_err(|e| e.to_string())),
                heard => self.heard.note(heard),
            }
        }
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
}
