//! A board at the other end of a serial line: who it is, which parameters it keeps, what it makes of a
//! record.

use crate::error::{Failure, Outcome};
use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};
use twinrotor::link::{self, Decoder, Identity, LinkError, MAX_FRAME, Nonce, Refusal, ToBoard, ToHost};
use twinrotor::parameters::{self, Parameters};
use twinrotor::replay::{Replayed, Sample};
use twinrotor::sequence::Sequence;

/// \[baud\] Of the serial link.
pub const BAUD: u32 = 1_000_000;

/// How long a board may take for an answer, an erase of .5 s included.
const PATIENCE: Duration = Duration::from_secs(3);

/// Samples that a board takes in one go: its buffer has 512 bytes.
pub const AT_ONCE: usize = 8;

fn failed(error: std::io::Error) -> Failure {
    Failure::Run(format!("the serial port failed: {error}"))
}

/// A board at the other end of a serial port whose reads time out soon.
pub struct Board<P> {
    port: P,
    decoder: Decoder,
    /// Number of the next message.
    sequence: Sequence,
    /// Of the board's boot, once it has said who it is.
    nonce: Option<Nonce>,
}

impl<P: Read + Write> Board<P> {
    /// Over `port`.
    pub fn new(port: P) -> Self {
        Self { port, decoder: Decoder::new(), sequence: Sequence::default(), nonce: None }
    }

    /// Who is there; refuses one that keeps its parameters in another version.
    pub fn identify(&mut self) -> Outcome<Identity> {
        let identity = self.ask(ToBoard::Identify, |answer| match answer {
            ToHost::Identity(identity) => Some(Ok(identity)),
            _ => None,
        })?;
        self.sequence = identity.expected;
        self.nonce = Some(identity.nonce);
        if identity.parameters == parameters::VERSION {
            return Ok(identity);
        }
        Err(Failure::Run(format!(
            "the board keeps parameters of version {}, this program those of version {}: build both from the same source",
            identity.parameters,
            parameters::VERSION
        )))
    }

    /// Sends the parameters, has them kept, reads them back and compares.
    pub fn write(&mut self, parameters: &Parameters) -> Outcome<()> {
        let nonce = self.nonce()?;
        self.ask(ToBoard::WriteParameters(nonce, *parameters), |answer| match answer {
            ToHost::Saved => Some(Ok(())),
            ToHost::Refused(refusal) => Some(Err(Failure::Run(told(&refusal)))),
            _ => None,
        })?;
        if self.read()? == *parameters {
            Ok(())
        } else {
            Err(Failure::Run("the board read back other parameters than were sent".to_owned()))
        }
    }

    /// Whether the board has these parameters in force, but for whether its wiring has been checked.
    pub fn keeps(&mut self, parameters: &Parameters) -> Outcome<bool> {
        let read = self.read()?;
        Ok(Parameters { checked: parameters.checked, ..read } == *parameters)
    }

    fn read(&mut self) -> Outcome<Parameters> {
        self.nonce()?;
        self.ask(ToBoard::ReadParameters, |answer| match answer {
            ToHost::Parameters(parameters) => Some(Ok(parameters)),
            _ => None,
        })
    }

    /// Ticks of a record through the board's own estimator and law, from sample 0 on in order. No more than
    /// [`AT_ONCE`] fit its buffer.
    pub fn replay(&mut self, samples: &[Sample]) -> Outcome<Vec<Replayed>> {
        self.nonce()?;
        self.say(samples.iter().map(|sample| ToBoard::Replay(*sample)))?;
        let mut answers = Vec::with_capacity(samples.len());
        self.hear(|answer| match answer {
            ToHost::Replayed(replayed) => {
                answers.push(replayed);
                (answers.len() == samples.len()).then_some(Ok(()))
            }
            ToHost::Refused(refusal) => Some(Err(Failure::Run(told(&refusal)))),
            _ => None,
        })?;
        Ok(answers)
    }

    /// Sends a message and waits for the answer that `pick` takes.
    fn ask<T>(&mut self, message: ToBoard, pick: impl FnMut(ToHost) -> Option<Outcome<T>>) -> Outcome<T> {
        self.say([message])?;
        self.hear(pick)
    }

    /// What the board's boot is known by. Before it has said so, it takes no message of ours for new.
    fn nonce(&mut self) -> Outcome<Nonce> {
        match self.nonce {
            Some(nonce) => Ok(nonce),
            None => Ok(self.identify()?.nonce),
        }
    }

    fn say(&mut self, messages: impl IntoIterator<Item = ToBoard>) -> Outcome<()> {
        // A zero byte ends whatever noise came before.
        let mut bytes = vec![0];
        for message in messages {
            let mut buffer = [0; MAX_FRAME];
            let numbered = message.numbered(self.sequence);
            self.sequence = self.sequence.next();
            bytes.extend(link::encode(&numbered, &mut buffer).expect("every message fits its frame"));
        }
        self.port.write_all(&bytes).and_then(|()| self.port.flush()).map_err(failed)
    }

    fn hear<T>(&mut self, mut pick: impl FnMut(ToHost) -> Option<Outcome<T>>) -> Outcome<T> {
        let deadline = Instant::now() + PATIENCE;
        let mut bytes = [0; 256];
        while Instant::now() < deadline {
            let count = match self.port.read(&mut bytes) {
                Ok(count) => count,
                Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => 0,
                Err(error) => return Err(failed(error)),
            };
            for &byte in &bytes[..count] {
                match self.decoder.push::<ToHost>(byte) {
                    Some(Ok(answer)) => {
                        if let Some(outcome) = pick(answer) {
                            return outcome;
                        }
                    }
                    Some(Err(error @ LinkError::Version { .. })) => {
                        return Err(Failure::Run(error.to_string()));
                    }
                    Some(Err(LinkError::Damaged | LinkError::TooLong)) | None => {}
                }
            }
        }
        Err(Failure::Run(format!(
            "the board did not answer within {} s: is it powered, is this its port, does it run this firmware?",
            PATIENCE.as_secs()
        )))
    }
}

fn told(refusal: &Refusal) -> String {
    match refusal {
        Refusal::MotorsMayTurn => {
            "the board keeps parameters only while disarmed: disarm it and clear its fault".to_owned()
        }
        Refusal::NoReplay => "the board has lost the beginning of the record: begin again".to_owned(),
        Refusal::Busy => "the board is busy: try again".to_owned(),
        Refusal::Nonce => "the board has been reset since it said who it is: begin again".to_owned(),
        Refusal::NoParameters => {
            "no first-power check with built-in parameters: write those of the rig first".to_owned()
        }
        Refusal::Setpoint { field, low, high } => {
            format!("the board refuses {field}; allowed: {low} to {high}")
        }
        Refusal::Flash => "the board's flash did not hold what was written".to_owned(),
        Refusal::Range { field, allowed } => format!("the board refuses {field}; allowed: {allowed}"),
    }
}

/// Opens the serial port called `name`.
pub fn open(name: &str) -> Outcome<Board<Box<dyn serialport::SerialPort>>> {
    let port = serialport::new(name, BAUD).timeout(Duration::from_millis(50)).open();
    let port = port.map_err(|error| Failure::Run(format!("--port {name} cannot be opened: {error}")))?;
    Ok(Board::new(port))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;
    use twinrotor::SAMPLE_TIME;
    use twinrotor::axes::{PerAxis, PerMotor};
    use twinrotor::conversation::{self, Action, Conversation};
    use twinrotor::gains;
    use twinrotor::parameters::Provenance;
    use twinrotor::pipeline::Settings;
    use twinrotor::plant::presets;
    use twinrotor::replay::Replay;
    use twinrotor::telemetry::Frame;

    fn parameters() -> Parameters {
        Parameters::new(&presets::AERO, &Settings::paper(&presets::AERO, gains::PAPER, SAMPLE_TIME))
    }

    /// A board that answers as the firmware does, telemetry and noise in between.
    struct Wire {
        decoder: Decoder,
        board: Conversation,
        refuses: bool,
        forgets: bool,
        version: u16,
        out: VecDeque<u8>,
    }

    impl Default for Wire {
        fn default() -> Self {
            let board =
                conversation::Board { firmware: "0.1.0", chip: "stm32f405rg", nonce: Nonce(7), reset: None };
            Self {
                decoder: Decoder::new(),
                board: Conversation::new(board, parameters(), Provenance::Missing),
                refuses: false,
                forgets: false,
                version: parameters::VERSION,
                out: VecDeque::new(),
            }
        }
    }

    impl Wire {
        fn say(&mut self, message: &ToHost) {
            self.out.extend([7, 0]);
            for message in [&ToHost::Frame(Frame::default()), message] {
                self.out.extend(link::encode(message, &mut [0; MAX_FRAME]).unwrap());
            }
        }
    }

    impl Write for Wire {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            for &byte in bytes {
                let Some(received) = self.decoder.push(byte) else { continue };
                match self.board.receive(received, true).action {
                    Action::Answer(ToHost::Identity(identity)) => {
                        self.say(&ToHost::Identity(Identity { parameters: self.version, ..identity }));
                    }
                    Action::Answer(answer) => self.say(&answer),
                    Action::Keep(_) if self.forgets => self.say(&ToHost::Saved),
                    Action::Keep(new) => {
                        let outcome = if self.refuses { Err(Refusal::MotorsMayTurn) } else { Ok(()) };
                        let answer = self.board.kept(&new, outcome);
                        self.say(&answer);
                    }
                    _ => {}
                }
            }
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    impl Read for Wire {
        fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
            self.out.read(bytes)
        }
    }

    #[test]
    fn parameters_are_sent_read_back_and_compared() {
        let mut board = Board::new(Wire::default());
        assert_eq!(board.identify().unwrap().chip, "stm32f405rg");
        board.write(&parameters()).unwrap();
        assert_eq!(board.port.board.parameters(), &parameters());
    }

    #[test]
    fn a_board_that_forgets_refuses_or_speaks_another_version_is_told() {
        let mut other = parameters();
        other.limits.command_timeout = 250;
        let error = Board::new(Wire { forgets: true, ..Wire::default() }).write(&other).unwrap_err();
        assert!(error.to_string().contains("other parameters"), "{error}");
        let error = Board::new(Wire { refuses: true, ..Wire::default() }).write(&other).unwrap_err();
        assert!(error.to_string().contains("disarm"), "{error}");
        let mut outside = parameters();
        outside.limits.command_timeout = 0;
        let error = Board::new(Wire::default()).write(&outside).unwrap_err();
        assert!(error.to_string().contains("limits.command_timeout"), "{error}");
        let error = Board::new(Wire { version: 99, ..Wire::default() }).identify().unwrap_err();
        assert!(error.to_string().contains("version 99"), "{error}");
        assert_eq!(error.exit_status(), 1);
    }

    /// Older firmware: its telemetry alone tells.
    #[test]
    fn another_version_of_the_link_says_who_must_be_updated() {
        let mut wire = Wire::default();
        let body = [link::VERSION - 1, 0];
        let crc = crc32fast::hash(&body).to_le_bytes();
        let whole: Vec<u8> = body.into_iter().chain(crc).collect();
        wire.out.extend(stuffed(&whole));
        let error = Board::new(wire).identify().unwrap_err();
        assert!(error.to_string().ends_with("update the board's firmware"), "{error}");
    }

    /// COBS of a short message, and the zero.
    fn stuffed(bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        for block in bytes.split(|&byte| byte == 0) {
            out.push(u8::try_from(block.len() + 1).unwrap());
            out.extend(block);
        }
        out.push(0);
        out
    }

    #[test]
    fn a_record_comes_back_answered_in_order_and_its_beginning_must_be_there() {
        let sample = |number| Sample {
            number,
            counts: PerAxis::new(3, -5),
            volts: PerMotor::new(6.0, 0.5),
            wanted: None,
        };
        let samples: Vec<Sample> = (0..6).map(sample).collect();
        let mut board = Board::new(Wire::default());
        assert!(board.replay(&samples[1..]).unwrap_err().to_string().contains("beginning"));
        let mut board = Board::new(Wire::default());
        let answers = board.replay(&samples).unwrap();
        let mut here = Replay::new(&parameters(), &samples[0]);
        assert!(samples.iter().zip(&answers).all(|(sample, answer)| here.step(sample).same_bits(answer)));
        assert_eq!(answers.len(), samples.len());
    }
}
