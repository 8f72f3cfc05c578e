//! The operator's end of the link: what to ask of a board, what it says, and when it has been silent too
//! long. Bytes and time go in, events and bytes come out; whoever holds the line, a serial port, an emulator
//! or a page, carries them.

mod echo;

pub use echo::Echo;

use crate::words;
use std::time::Duration;
use twinrotor::axes::PerAxis;
use twinrotor::link::{self, Decoder, Identity, LinkError, MAX_FRAME, Nonce, ToBoard, ToHost};
use twinrotor::parameters::{self, Parameters};
use twinrotor::reference::Reference;
use twinrotor::replay::{Replayed, Sample};
use twinrotor::sequence::Sequence;
use twinrotor::supervisor::Request;
use twinrotor_sim::{Error, Outcome};

/// How often an attentive operator's program says that it is there.
pub const ALIVE_EVERY: Duration = Duration::from_millis(100);

/// How long a board may take for an answer, an erase of .5 s included.
const PATIENCE: Duration = Duration::from_secs(3);

/// When what is not answered is asked once more: an answer, too, can be lost on a line.
const ASK_AGAIN: Duration = Duration::from_secs(1);

/// Samples that a board takes in one go: its buffer has 512 bytes.
const AT_ONCE: usize = 8;

/// What can be asked of a board, one thing at a time.
#[derive(Debug, Clone, PartialEq)]
pub enum Question {
    /// Who is there? Refuses one that keeps its parameters in another version.
    Identify,
    /// Which parameters are in force?
    Read,
    /// Keep these, which are then read back and compared.
    Write(Box<Parameters>),
    /// Keep the accepted controller; what is kept is then read back.
    Save,
    /// What do estimator and law make of these ticks, from sample 0 on in order?
    Replay(Vec<Sample>),
}

/// What it answers.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// Who is there.
    Identity(Identity),
    /// The parameters in force, those just written or saved too.
    Parameters(Box<Parameters>),
    /// A tick for each sample.
    Replayed(Vec<Replayed>),
}

/// What came over the line.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one at a time, and soon read")]
pub enum Event {
    /// A message.
    Message(ToHost),
    /// A message that was damaged on the way.
    Damaged,
    /// What was asked is answered, or will not be.
    Answered(Outcome<Answer>),
}

/// What is being asked.
#[derive(Debug)]
struct Pending {
    question: Question,
    /// Of a record: what came back so far.
    replayed: Vec<Replayed>,
    /// It is kept; what is missing is its reading back.
    saved: bool,
    again: Duration,
    /// When the board has been silent too long.
    deadline: Duration,
}

impl Pending {
    fn new(question: Question, now: Duration) -> Self {
        let (again, deadline) = (now + ASK_AGAIN, now + PATIENCE);
        Self { question, replayed: Vec::new(), saved: false, again, deadline }
    }

    /// What asks it. Of a record each sample counts, and is said once.
    fn message(&self) -> Option<ToBoard> {
        match &self.question {
            Question::Identify => Some(ToBoard::Identify),
            Question::Read => Some(ToBoard::ReadParameters),
            Question::Write(_) | Question::Save if self.saved => Some(ToBoard::ReadParameters),
            Question::Write(parameters) => Some(ToBoard::WriteParameters(Nonce::default(), **parameters)),
            Question::Save => Some(ToBoard::Save(Nonce::default())),
            Question::Replay(_) => None,
        }
    }
}

/// An operator's program with a board at the other end. Time is any that does not run backwards.
///
/// A board takes a message only with a number newer than any before, and what may turn a motor only for the
/// boot that it says it is in ([`twinrotor::link`]). So until it has said who it is, it is asked, and what is
/// to be sent waits; motors off does not.
#[derive(Debug, Default)]
pub struct Client {
    decoder: Decoder,
    outgoing: Vec<u8>,
    /// Number of the next message.
    sequence: Sequence,
    /// Of the board's boot, once it has said so.
    nonce: Option<Nonce>,
    /// What waits for that.
    unsent: Vec<ToBoard>,
    pending: Option<Pending>,
    silent: bool,
    alive_at: Duration,
}

impl Client {
    /// Attentive: tells the board ten times a second that somebody is there.
    pub fn new() -> Self {
        Self::default()
    }

    /// Falls silent, as a program that hangs or a cable that is pulled, or is attentive again.
    pub fn set_attentive(&mut self, attentive: bool) {
        self.silent = !attentive;
    }

    /// Ends whatever noise came before on the line.
    pub fn resynchronise(&mut self) {
        self.outgoing.push(0);
    }

    /// Sends a message, numbered and meant for the board's present boot: whatever [`Nonce`] is in it does not
    /// count. Gives its number, or `None` where it has to wait.
    pub fn send(&mut self, message: &ToBoard) -> Option<Sequence> {
        match (self.nonce, message) {
            (Some(nonce), _) => Some(self.transmit(message.clone().meant_for(nonce))),
            (None, ToBoard::Disarm | ToBoard::Identify) => Some(self.transmit(message.clone())),
            (None, ToBoard::Alive) => Some(self.transmit(ToBoard::Identify)),
            (None, _) => {
                if self.unsent.is_empty() {
                    self.transmit(ToBoard::Identify);
                }
                self.unsent.push(message.clone());
                None
            }
        }
    }

    fn transmit(&mut self, message: ToBoard) -> Sequence {
        let mut buffer = [0; MAX_FRAME];
        let sequence = self.sequence;
        let numbered = message.numbered(sequence);
        self.sequence = sequence.next();
        // Ends whatever noise came before: a `Disarm` must not be lost to it.
        self.outgoing.push(0);
        self.outgoing.extend(link::encode(&numbered, &mut buffer).expect("every message fits its frame"));
        sequence
    }

    /// Learns how to speak to the board, and says what has waited for that.
    fn meet(&mut self, identity: &Identity) {
        // What it expects may be older than what is on its way to it.
        if identity.expected.is_newer_than(self.sequence) {
            self.sequence = identity.expected;
        }
        self.nonce = Some(identity.nonce);
        for message in std::mem::take(&mut self.unsent) {
            self.send(&message);
        }
    }

    /// Asks something of the supervisor.
    pub fn request(&mut self, request: Request) -> Option<Sequence> {
        let nonce = Nonce::default();
        self.send(&match request {
            Request::Arm => ToBoard::Arm(nonce),
            Request::Disarm => ToBoard::Disarm,
            Request::ClearFault => ToBoard::ClearFault(nonce),
            Request::Check => ToBoard::Check(nonce),
        })
    }

    /// Wants the helicopter at rest there \[rad\].
    pub fn aim(&mut self, angle: PerAxis<f32>) {
        self.send(&ToBoard::Setpoint(Reference::at_rest(angle)));
    }

    /// Asks a question; one that is not answered yet is given up.
    pub fn ask(&mut self, question: Question, now: Duration) {
        if let Question::Replay(samples) = &question {
            self.send_samples(samples);
        }
        let pending = Pending::new(question, now);
        if let Some(message) = pending.message() {
            self.send(&message);
        }
        self.pending = Some(pending);
    }

    fn send_samples(&mut self, samples: &[Sample]) {
        for sample in samples.iter().take(AT_ONCE) {
            self.send(&ToBoard::Replay(*sample));
        }
    }

    /// Takes what came over the line.
    pub fn push(&mut self, bytes: &[u8], now: Duration) -> Vec<Event> {
        let mut events = Vec::new();
        for &byte in bytes {
            match self.decoder.push::<ToHost>(byte) {
                Some(Ok(message)) => {
                    if let ToHost::Identity(identity) = &message {
                        self.meet(identity);
                    }
                    let answered = self.pending.take().and_then(|pending| self.take(pending, &message, now));
                    events.push(Event::Message(message));
                    events.extend(answered.map(Event::Answered));
                }
                Some(Err(error @ LinkError::Version { .. })) if self.pending.take().is_some() => {
                    events.push(Event::Answered(Err(Error::Failed(error.to_string()))));
                }
                Some(Err(_)) => events.push(Event::Damaged),
                None => {}
            }
        }
        events
    }

    /// Does what is due by now: says that somebody is there, and gives up waiting.
    pub fn poll(&mut self, now: Duration) -> Option<Event> {
        if now >= self.alive_at {
            if !self.silent {
                self.send(&ToBoard::Alive);
            }
            self.alive_at = now + ALIVE_EVERY;
        }
        if let Some(pending) = self.pending.as_mut().filter(|pending| now >= pending.again) {
            pending.again = now + ASK_AGAIN;
            if let Some(message) = pending.message() {
                self.send(&message);
            }
        }
        self.pending.take_if(|pending| now >= pending.deadline).map(|_| {
            Event::Answered(Err(Error::Failed(format!(
                "the board did not answer within {} s: is it powered, is this its port, does it run this \
                 firmware?",
                PATIENCE.as_secs()
            ))))
        })
    }

    /// When [`Client::poll`] has something to do next, for all that it knows now.
    pub fn due(&self) -> Duration {
        let due = self.pending.as_ref().map(|pending| pending.again.min(pending.deadline));
        due.map_or(self.alive_at, |due| due.min(self.alive_at))
    }

    /// What is to be sent; it is forgotten here.
    pub fn take_outgoing(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.outgoing)
    }

    /// A message while something is asked: the answer, if it is complete.
    fn take(&mut self, mut pending: Pending, message: &ToHost, now: Duration) -> Option<Outcome<Answer>> {
        match (&pending.question, message) {
            (Question::Identify, ToHost::Identity(identity)) => return Some(of_our_version(identity)),
            (Question::Read | Question::Save, ToHost::Parameters(parameters)) => {
                return Some(Ok(Answer::Parameters(Box::new(*parameters))));
            }
            (Question::Write(_) | Question::Save, ToHost::Saved) => {
                self.send(&ToBoard::ReadParameters);
                pending.saved = true;
                (pending.again, pending.deadline) = (now + ASK_AGAIN, now + PATIENCE);
            }
            // Before it is saved, a late answer to an earlier question.
            (Question::Write(wanted), ToHost::Parameters(kept)) if pending.saved => {
                // What was checked at another kind of port is not checked there.
                return Some(if wanted.at_port(kept.port) == *kept {
                    Ok(Answer::Parameters(Box::new(*kept)))
                } else {
                    Err(Error::Failed("the board read back other parameters than were sent".to_owned()))
                });
            }
            (Question::Replay(samples), ToHost::Replayed(replayed)) => {
                pending.replayed.push(*replayed);
                pending.deadline = now + PATIENCE;
                let done = pending.replayed.len();
                if done == samples.len() {
                    return Some(Ok(Answer::Replayed(pending.replayed)));
                }
                if done.is_multiple_of(AT_ONCE) {
                    self.send_samples(&samples[done..]);
                }
            }
            (Question::Write(_) | Question::Save | Question::Replay(_), ToHost::Refused(refusal)) => {
                return Some(Err(Error::Failed(words::refusal(refusal))));
            }
            _ => {}
        }
        self.pending = Some(pending);
        None
    }
}

fn of_our_version(identity: &Identity) -> Outcome<Answer> {
    if identity.parameters == parameters::VERSION {
        return Ok(Answer::Identity(identity.clone()));
    }
    Err(Error::Failed(format!(
        "the board keeps parameters of version {}, this program those of version {}: build both from the \
         same source",
        identity.parameters,
        parameters::VERSION
    )))
}

#[cfg(test)]
mod tests;
