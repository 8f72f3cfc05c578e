//! An operator's session with a board, from connecting to disarmed, without I/O: bytes and time go in, bytes,
//! events and wishes come out.
//!
//! The steps, in order: who is there, is it free, clear its fault, compare what it flies with, write that if
//! wanted, the first-power check if it is due, zero, arm, up to level, the legs of the plan, down to the rest
//! pose, motors off. Those on the ground are in `ground.rs`, those with the motors on in `air.rs`. Whatever
//! ends a session whose motors may turn, the last that it says is `Disarm`, until the board says that they
//! are off, or has not for three seconds ([`SwitchOff`]).

mod air;
mod clock;
mod course;
mod ground;
mod plan;
#[cfg(test)]
mod tests;

use crate::client::{self, Answer, Client, Question};
use crate::switch_off::SwitchOff;
use crate::words;
pub use plan::{End, Ending, Event, Leg, Motors, Plan, Wish, Write};

use air::Leave;
use clock::Clock;
pub use course::Course;
use std::collections::VecDeque;
use std::time::Duration;
use twinrotor::control_loop::OperatorCommand;
use twinrotor::link::{Identity, Nonce, ToBoard, ToHost};
use twinrotor::sequence::{Numbered, Sequence};
use twinrotor::supervisor::Request;
use twinrotor::telemetry::Frame;
use twinrotor::trial::Attempt;
use twinrotor_sim::{Error, Outcome};

/// How long a board may say nothing at all. It switches its motors off itself when it has not heard its host
/// for half a second; that it is not heard may be a busy computer's fault.
const SILENCE: Duration = Duration::from_secs(2);

/// Where a session stands.
#[derive(Debug)]
enum Phase {
    Finding,
    Looking,
    Clearing { again: Duration, until: Duration },
    Reading,
    Writing,
    Settling { until: Duration },
    Checking { begun: bool, over: Option<Duration> },
    Zeroing { first: Sequence, again: Duration, until: Duration },
    Waiting { until: Duration },
    Arming { until: Duration },
    Rising(Leave),
    Flying { leg: usize, course: Course, begin: Begin },
    Changing { leg: usize, begun: bool, until: Duration },
    Descending { course: Course, from: u32 },
    Off { off: SwitchOff, ending: Ending },
    Saving,
    Asking(Wish),
    Over,
}

/// When a leg's first setpoint came to bear.
#[derive(Debug, Clone, Copy)]
enum Begin {
    /// Its number, and in which tick it should.
    Said(Sequence, u32),
    In(u32),
}

/// A session. Time is any that does not run backwards.
#[derive(Debug)]
pub struct Session {
    client: Client,
    plan: Plan,
    phase: Phase,
    clock: Clock,
    events: VecDeque<Event>,
    identity: Option<Identity>,
    frame: Option<Frame>,
    heard: Duration,
    /// Something was said that may turn a motor.
    turns: bool,
    /// The operator has agreed to writing.
    may_write: bool,
    /// The first-power check has just been passed, which is to be kept.
    passed: bool,
    asked_to_arm: bool,
    said: Vec<Numbered<OperatorCommand>>,
    tried: Option<(Sequence, Attempt)>,
    /// What keeps the flight from having been all that was planned.
    flaw: Option<String>,
    accepted: bool,
    /// That came so far.
    bytes: usize,
    echo: client::Echo,
}

impl Session {
    /// Begins at once.
    pub fn new(plan: Plan, now: Duration) -> Self {
        let mut client = Client::new();
        client.resynchronise();
        client.ask(Question::Identify, now);
        let mut clock = Clock::default();
        clock.tell(now);
        Self {
            client,
            plan,
            phase: Phase::Finding,
            clock,
            events: VecDeque::new(),
            identity: None,
            frame: None,
            heard: now,
            turns: false,
            may_write: false,
            passed: false,
            asked_to_arm: false,
            said: Vec::new(),
            tried: None,
            flaw: None,
            accepted: false,
            bytes: 0,
            echo: client::Echo::default(),
        }
    }

    /// Takes what came over the line by `now`.
    pub fn push(&mut self, bytes: &[u8], now: Duration) {
        self.clock.tell(now);
        self.echo.hear(bytes);
        self.bytes += bytes.len();
        for event in self.client.push(bytes, self.clock.now()) {
            match event {
                _ if self.is_over() => {}
                client::Event::Damaged => {}
                client::Event::Answered(outcome) => self.answered(outcome),
                client::Event::Message(message) => self.take(message),
            }
        }
        self.go_on();
    }

    /// Does what is due by `now`.
    pub fn poll(&mut self, now: Duration) {
        let now = self.clock.tell(now);
        if let Some(client::Event::Answered(Err(silence))) = self.client.poll(now) {
            let why = self.unheard().unwrap_or_else(|| silence.to_string());
            self.answered(Err(Error::Failed(why)));
        }
        let waits_for_flash =
            matches!(self.phase, Phase::Finding | Phase::Writing | Phase::Off { .. } | Phase::Saving);
        if !waits_for_flash && !self.is_over() && now >= self.heard + SILENCE {
            self.end(Ending::Trouble("the board has fallen silent".to_owned()));
        }
        self.go_on();
    }

    /// What is to be sent; it is forgotten here.
    pub fn take_outgoing(&mut self) -> Vec<u8> {
        let bytes = self.client.take_outgoing();
        self.echo.say(&bytes);
        bytes
    }

    /// What there is to tell, in order.
    pub fn event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// When [`Session::poll`] has something to do next, for all that it knows now, by its host's clock.
    pub fn due(&self) -> Duration {
        let due = match &self.phase {
            Phase::Off { off, .. } => off.due().min(self.client.due()),
            _ => self.client.due(),
        };
        self.clock.host(due)
    }

    /// It has ended: nothing more is to be sent.
    pub const fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Over)
    }

    /// The operator's commands so far, with their numbers: what a flight can be computed once more from.
    pub fn said(&self) -> &[Numbered<OperatorCommand>] {
        &self.said
    }

    /// The board, once it has said who it is.
    pub const fn identity(&self) -> Option<&Identity> {
        self.identity.as_ref()
    }

    /// The controller that was tried, and the number of the message.
    pub const fn tried(&self) -> Option<&(Sequence, Attempt)> {
        self.tried.as_ref()
    }

    /// The operator agrees to what was asked, or does not.
    pub fn answer(&mut self, agrees: bool) {
        let Phase::Asking(wish) = &self.phase else { return };
        let wish = wish.clone();
        if agrees {
            self.granted(&wish);
        } else {
            self.end(Ending::Trouble("not agreed to: nothing was done".to_owned()));
        }
    }

    /// Ends it, motors off first. A second time it changes nothing.
    pub fn stop(&mut self, ending: Ending) {
        self.end(ending);
        self.go_on();
    }

    fn end(&mut self, ending: Ending) {
        if matches!(self.phase, Phase::Off { .. } | Phase::Over) {
            return;
        }
        if matches!(self.phase, Phase::Saving) {
            self.over(End { ending, motors: Motors::SeenOff });
        } else if self.turns {
            self.phase = Phase::Off { off: SwitchOff::new(self.clock.now()), ending };
        } else {
            self.over(End { ending, motors: Motors::NeverTurned });
        }
    }

    fn over(&mut self, end: End) {
        self.phase = Phase::Over;
        self.events.push_back(Event::Over(end));
    }

    fn trouble(&mut self, why: impl Into<String>) {
        self.end(Ending::Trouble(why.into()));
    }

    fn step(&mut self, name: &'static str, what: impl Into<String>) {
        self.events.push_back(Event::Step(name, what.into()));
    }

    /// Says a command, and keeps it with its number.
    fn command(&mut self, command: OperatorCommand) -> Sequence {
        let nonce = Nonce::default();
        let message = match command {
            OperatorCommand::Request(Request::Arm) => ToBoard::Arm(nonce),
            OperatorCommand::Request(Request::Check) => ToBoard::Check(nonce),
            OperatorCommand::Request(Request::ClearFault) => ToBoard::ClearFault(nonce),
            OperatorCommand::Request(Request::Disarm) => ToBoard::Disarm,
            OperatorCommand::Setpoint(setpoint) => ToBoard::Setpoint(setpoint),
            OperatorCommand::Zero => ToBoard::Zero,
            OperatorCommand::Accept => ToBoard::Accept(nonce),
            OperatorCommand::Revert => ToBoard::Revert,
            OperatorCommand::Inject(injection) => ToBoard::Inject(nonce, injection),
            // What it is about has to be said with it.
            OperatorCommand::Try => return Sequence::default(),
        };
        self.turns |= matches!(command, OperatorCommand::Request(Request::Arm | Request::Check));
        // The board has said who it is before anything is commanded.
        let sequence = self.client.send(&message).unwrap_or_default();
        self.said.push(Numbered { sequence, message: command });
        sequence
    }

    /// Says that a controller is to be tried.
    fn attempt(&mut self, attempt: Attempt) {
        let message = ToBoard::Trial(Nonce::default(), attempt);
        let sequence = self.client.send(&message).unwrap_or_default();
        self.said.push(Numbered { sequence, message: OperatorCommand::Try });
        self.tried = Some((sequence, attempt));
    }

    fn answered(&mut self, outcome: Outcome<Answer>) {
        if matches!(self.phase, Phase::Off { .. } | Phase::Over) {
            return;
        }
        match outcome {
            Ok(Answer::Identity(identity)) => self.found(identity),
            Ok(Answer::Parameters(kept)) => self.has(&kept),
            Ok(Answer::Replayed(_)) => {}
            Err(error) => self.trouble(error.to_string()),
        }
    }

    fn take(&mut self, message: ToHost) {
        match message {
            ToHost::Frame(frame) => self.hear(frame),
            ToHost::Health(health) => self.events.push_back(Event::Health(health)),
            ToHost::Identity(identity) => self.meet_again(&identity),
            ToHost::Verdict(verdict) => self.checked(verdict),
            // Asked for again soon.
            ToHost::Refused(twinrotor::link::Refusal::Busy) => {}
            ToHost::Refused(refusal) if self.identity.is_some() => self.trouble(words::refusal(&refusal)),
            ToHost::Refused(_) | ToHost::Parameters(_) | ToHost::Saved | ToHost::Replayed(_) => {}
        }
    }

    fn hear(&mut self, frame: Frame) {
        self.heard = self.clock.board(frame.tick);
        self.frame = Some(frame);
        self.events.push_back(Event::Frame(frame));
        if let Phase::Off { off, .. } = &mut self.phase {
            off.hear(&frame);
        }
        self.look(&frame);
    }

    /// The same board, or one that has begun anew since.
    fn meet_again(&mut self, identity: &Identity) {
        let Some(known) = &self.identity else { return };
        if known.nonce == identity.nonce {
            return;
        }
        let cause = identity.reset.as_ref().map_or_else(|| "it does not say why".to_owned(), words::reset);
        let why = format!("the board was reset: {cause}");
        self.end(if self.turns { Ending::Stopped(why) } else { Ending::Trouble(why) });
    }

    /// Whatever the present phase has to do by now.
    fn go_on(&mut self) {
        let now = self.clock.now();
        if let Phase::Off { off, ending } = &mut self.phase {
            if off.say(now) {
                self.client.send(&ToBoard::Disarm);
            }
            if off.is_over(now) {
                let motors = if off.is_seen() { Motors::SeenOff } else { Motors::NotSeenOff };
                let ending = ending.clone();
                if self.plan.save && self.accepted && ending == Ending::Flown && motors == Motors::SeenOff {
                    self.client.ask(Question::Save, now);
                    self.phase = Phase::Saving;
                } else {
                    self.over(End { ending, motors });
                }
            }
            return;
        }
        self.go_on_on_the_ground(now);
        self.go_on_in_the_air(now);
    }
}
