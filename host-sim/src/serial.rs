//! A board at a serial port: carries what the station's client has to say and to hear.

use crate::error::{Failure, Outcome};
use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};
use twinrotor::link::BAUD;
use twinrotor::link::Identity;
use twinrotor::parameters::Parameters;
use twinrotor::replay::{Replayed, Sample};
use twinrotor_station::{Answer, Client, Event, Question};

/// A board at the other end of a serial port whose reads time out soon.
pub struct Board<P> {
    port: P,
    client: Client,
    begun: Instant,
}

/// Opens the serial port called `name`.
///
/// # Errors
///
/// If it cannot be opened.
pub fn open(name: &str) -> Outcome<Board<Box<dyn serialport::SerialPort>>> {
    let port = serialport::new(name, BAUD).timeout(Duration::from_millis(50)).open();
    let port = port.map_err(|error| Failure::Run(format!("--port {name} cannot be opened: {error}")))?;
    Ok(Board { port, client: Client::new(), begun: Instant::now() })
}

impl<P: Read + Write> Board<P> {
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
        self.client.resynchronise();
        self.client.ask(question, self.begun.elapsed());
        let mut bytes = [0; 256];
        loop {
            if let Some(Event::Answered(outcome)) = self.client.poll(self.begun.elapsed()) {
                return Ok(outcome?);
            }
            let outgoing = self.client.take_outgoing();
            self.port.write_all(&outgoing).and_then(|()| self.port.flush()).map_err(failed)?;
            let count = match self.port.read(&mut bytes) {
                Ok(count) => count,
                Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => 0,
                Err(error) => return Err(failed(error)),
            };
            for event in self.client.push(&bytes[..count], self.begun.elapsed()) {
                if let Event::Answered(outcome) = event {
                    return Ok(outcome?);
                }
            }
        }
    }
}

fn failed(error: std::io::Error) -> Failure {
    Failure::Run(format!("the serial port failed: {error}"))
}

fn astray(answer: &Answer) -> Failure {
    Failure::Run(format!("the board answered what was not asked: {answer:?}"))
}
