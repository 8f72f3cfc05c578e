//! Questions to a board: carries what the station's client has to say and to hear.

use super::Line;
use crate::error::{Failure, Outcome};
use std::time::Duration;
use twinrotor::link::Identity;
use twinrotor::parameters::Parameters;
use twinrotor::replay::{Replayed, Sample};
use twinrotor_station::{Answer, Client, Event, Question};

/// How long a port that may be anything's is listened to.
const SOON: Duration = Duration::from_secs(1);

/// A board at the other end of a line.
pub struct Board {
    line: Box<dyn Line>,
    client: Client,
}

impl Board {
    /// Not asked yet.
    #[must_use]
    pub fn new(line: Box<dyn Line>) -> Self {
        Self { line, client: Client::new() }
    }

    /// Who is there, if anybody is that says so soon.
    pub fn identify_soon(&mut self) -> Option<Identity> {
        match self.ask_until(Question::Identify, self.line.now() + SOON) {
            Ok(Some(Answer::Identity(identity))) => Some(identity),
            _ => None,
        }
    }

    /// Who is there; refuses one that keeps its parameters in another version.
    ///
    /// # Errors
    ///
    /// If nobody is, or another version.
    pub fn identify(&mut self) -> Outcome<Identity> {
        match self.ask(Question::Identify)? {
            Answer::Identity(identity) => Ok(identity),
            other => Err(astray(&other)),
        }
    }

    /// Sends the parameters, has them kept, reads them back and compares.
    ///
    /// # Errors
    ///
    /// If the board refuses them or does not read them back.
    pub fn write(&mut self, parameters: &Parameters) -> Outcome<()> {
        self.ask(Question::Write(Box::new(*parameters))).map(drop)
    }

    /// Whether the board has these parameters in force, but for whether its wiring has been checked.
    ///
    /// # Errors
    ///
    /// If it does not say.
    pub fn keeps(&mut self, parameters: &Parameters) -> Outcome<bool> {
        match self.ask(Question::Read)? {
            Answer::Parameters(read) => {
                Ok(Parameters { checked: parameters.checked, ..*read } == *parameters)
            }
            other => Err(astray(&other)),
        }
    }

    /// Ticks of a record through the board's own estimator and law, from sample 0 on in order.
    ///
    /// # Errors
    ///
    /// If the board loses the thread.
    pub fn replay(&mut self, samples: &[Sample]) -> Outcome<Vec<Replayed>> {
        match self.ask(Question::Replay(samples.to_vec()))? {
            Answer::Replayed(replayed) => Ok(replayed),
            other => Err(astray(&other)),
        }
    }

    fn ask(&mut self, question: Question) -> Outcome<Answer> {
        let answer = self.ask_until(question, Duration::MAX)?;
        answer.ok_or_else(|| Failure::Run("the board did not answer".to_owned()))
    }

    /// The answer, or nothing if it has not come by `end`.
    fn ask_until(&mut self, question: Question, end: Duration) -> Outcome<Option<Answer>> {
        self.client.resynchronise();
        self.client.ask(question, self.line.now());
        while self.line.now() < end {
            if let Some(Event::Answered(outcome)) = self.client.poll(self.line.now()) {
                return Ok(Some(outcome?));
            }
            let bytes = self.line.exchange(&self.client.take_outgoing()).map_err(failed)?;
            for event in self.client.push(&bytes, self.line.now()) {
                if let Event::Answered(outcome) = event {
                    return Ok(Some(outcome?));
                }
            }
        }
        Ok(None)
    }
}

fn failed(error: std::io::Error) -> Failure {
    Failure::Run(format!("the line to the board failed: {error}"))
}

fn astray(answer: &Answer) -> Failure {
    Failure::Run(format!("the board answered what was not asked: {answer:?}"))
}
