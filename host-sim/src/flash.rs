//! Parameters onto a board: as an image of its flash sectors, and over the serial link.

use crate::error::{Failure, Outcome};
use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};
use twinrotor::link::{self, Decoder, Identity, MAX_FRAME, Refusal, ToBoard, ToHost};
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{MAX_PAYLOAD, SLOT_SIZE, Store};
use twinrotor::parameters::{self, ParameterError, Parameters};

/// Where sectors 1 to 3, which hold the parameters, begin in the board's address space.
pub const IMAGE_ADDRESS: u32 = 0x0800_4000;
/// \[baud\] Of the serial link.
pub const BAUD: u32 = 1_000_000;

/// How long a board may take for an answer, an erase of .5 s included.
const PATIENCE: Duration = Duration::from_secs(3);

/// What says which parameter cannot be used.
pub fn unusable(error: ParameterError) -> Failure {
    match error {
        ParameterError::Range { field, allowed } => {
            Failure::Input(format!("{field} cannot be used on a board; allowed: {allowed}"))
        }
        other => Failure::Run(format!("the parameter record cannot be made: {other:?}")),
    }
}

/// The exact bytes of the three sectors: the record as the board's own code writes it to erased flash, read back to check.
pub fn image(parameters: &Parameters) -> Outcome<Vec<u8>> {
    parameters.validate().map_err(unusable)?;
    let mut payload = [0; MAX_PAYLOAD];
    let payload = parameters.encode(&mut payload).map_err(unusable)?;
    let mut store = Store::new(RamFlash::default(), 0);
    let mut buffer = [0; SLOT_SIZE];
    let failed = |error| Failure::Run(format!("the image does not hold the record: {error:?}"));
    store.save(payload, &mut buffer).map_err(failed)?;
    let read = store.load(&mut buffer).map_err(failed)?.map(Parameters::decode);
    if read != Some(Ok(*parameters)) {
        return Err(Failure::Run("the image does not read back as what was written".to_owned()));
    }
    Ok(store.into_flash().bytes().to_vec())
}

/// An image as Intel HEX at [`IMAGE_ADDRESS`].
pub fn intel_hex(image: &[u8]) -> String {
    use ihex::Record;
    let upper = |address: u32| Record::ExtendedLinearAddress((address >> 16) as u16);
    let mut records = vec![upper(IMAGE_ADDRESS)];
    for (address, bytes) in (IMAGE_ADDRESS..).step_by(32).zip(image.chunks(32)) {
        if address & 0xFFFF == 0 {
            records.push(upper(address));
        }
        records.push(Record::Data { offset: (address & 0xFFFF) as u16, value: bytes.to_vec() });
    }
    records.push(Record::EndOfFile);
    ihex::create_object_file_representation(&records).expect("32 bytes are no more than a record holds")
}

/// A board at the other end of a serial port whose reads time out soon.
pub struct Board<P> {
    port: P,
    decoder: Decoder,
}

impl<P: Read + Write> Board<P> {
    /// Over `port`.
    pub fn new(port: P) -> Self {
        Self { port, decoder: Decoder::new() }
    }

    /// Who is there; refuses one that keeps its parameters in another version.
    pub fn identify(&mut self) -> Outcome<Identity> {
        let identity = self.ask(&ToBoard::Identify, |answer| match answer {
            ToHost::Identity(identity) => Some(Ok(identity)),
            _ => None,
        })?;
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
        self.ask(&ToBoard::WriteParameters(*parameters), |answer| match answer {
            ToHost::Saved => Some(Ok(())),
            ToHost::Refused(refusal) => Some(Err(Failure::Run(told(&refusal)))),
            _ => None,
        })?;
        let read = self.ask(&ToBoard::ReadParameters, |answer| match answer {
            ToHost::Parameters(parameters) => Some(Ok(parameters)),
            _ => None,
        })?;
        if read == *parameters {
            Ok(())
        } else {
            Err(Failure::Run("the board read back other parameters than were sent".to_owned()))
        }
    }

    /// Sends a message and waits for the answer that `pick` takes.
    fn ask<T>(
        &mut self,
        message: &ToBoard,
        mut pick: impl FnMut(ToHost) -> Option<Outcome<T>>,
    ) -> Outcome<T> {
        let failed = |error: std::io::Error| Failure::Run(format!("the serial port failed: {error}"));
        let mut buffer = [0; MAX_FRAME];
        let frame = link::encode(message, &mut buffer).expect("every message fits its frame");
        // The zero byte ends whatever noise came before.
        self.port
            .write_all(&[0])
            .and_then(|()| self.port.write_all(frame))
            .and_then(|()| self.port.flush())
            .map_err(failed)?;
        let deadline = Instant::now() + PATIENCE;
        let mut bytes = [0; 256];
        while Instant::now() < deadline {
            let count = match self.port.read(&mut bytes) {
                Ok(count) => count,
                Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => 0,
                Err(error) => return Err(failed(error)),
            };
            for &byte in &bytes[..count] {
                if let Some(Ok(answer)) = self.decoder.push::<ToHost>(byte)
                    && let Some(outcome) = pick(answer)
                {
                    return outcome;
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
        Refusal::Busy => "the board is busy: try again".to_owned(),
        Refusal::Flash => "the board's flash did not hold what was written".to_owned(),
        Refusal::Range { field, allowed } => format!("the board refuses {field}; allowed: {allowed}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;
    use twinrotor::gains;
    use twinrotor::parameters::SAMPLE_TIME;
    use twinrotor::pipeline::Settings;
    use twinrotor::plant::presets;
    use twinrotor::telemetry::Frame;

    fn parameters() -> Parameters {
        Parameters::new(&presets::AERO, &Settings::paper(&presets::AERO, gains::PAPER, SAMPLE_TIME))
    }

    #[test]
    fn an_image_is_the_whole_area_and_holds_the_record_once() {
        let image = image(&parameters()).unwrap();
        assert_eq!(image.len(), 3 * 16 * 1024);
        let used = image.iter().rposition(|&byte| byte != 0xFF).unwrap();
        assert!(used < SLOT_SIZE, "one record at the beginning, {used} bytes");
    }

    #[test]
    fn what_cannot_fly_makes_no_image() {
        let mut bad = parameters();
        bad.limits.approach_rate = f32::NAN;
        let error = image(&bad).unwrap_err();
        assert!(error.to_string().contains("limits.approach_rate"), "{error}");
        assert_eq!(error.exit_status(), 2);
    }

    #[test]
    fn intel_hex_holds_the_image_at_its_address() {
        let image = image(&parameters()).unwrap();
        let (mut memory, mut base) = (vec![0; image.len()], 0);
        for record in ihex::Reader::new(&intel_hex(&image)) {
            match record.unwrap() {
                ihex::Record::ExtendedLinearAddress(upper) => base = u32::from(upper) << 16,
                ihex::Record::Data { offset, value } => {
                    let at = (base + u32::from(offset) - IMAGE_ADDRESS) as usize;
                    memory[at..at + value.len()].copy_from_slice(&value);
                }
                _ => {}
            }
        }
        assert_eq!(memory, image);
    }

    /// A board that answers as the firmware does, telemetry and noise in between.
    #[derive(Default)]
    struct Wire {
        decoder: Decoder,
        kept: Option<Parameters>,
        forgets: bool,
        version: u16,
        out: VecDeque<u8>,
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
                match self.decoder.push::<ToBoard>(byte) {
                    Some(Ok(ToBoard::Identify)) => self.say(&ToHost::Identity(Identity {
                        firmware: link::text("0.1.0"),
                        chip: link::text("stm32f405rg"),
                        parameters: self.version,
                        reset: None,
                    })),
                    Some(Ok(ToBoard::WriteParameters(new))) if new.limits.command_timeout == 1 => {
                        self.say(&ToHost::Refused(Refusal::MotorsMayTurn));
                    }
                    Some(Ok(ToBoard::WriteParameters(new))) => {
                        self.kept = Some(new);
                        self.say(&ToHost::Saved);
                    }
                    Some(Ok(ToBoard::ReadParameters)) => {
                        let kept = if self.forgets { None } else { self.kept };
                        self.say(&ToHost::Parameters(
                            kept.unwrap_or(Parameters { checked: true, ..parameters() }),
                        ));
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
        let wire = Wire { version: parameters::VERSION, ..Wire::default() };
        let mut board = Board::new(wire);
        assert_eq!(board.identify().unwrap().chip, "stm32f405rg");
        board.write(&parameters()).unwrap();
        assert_eq!(board.port.kept, Some(parameters()));
    }

    #[test]
    fn a_board_that_forgets_refuses_or_speaks_another_version_is_told() {
        let mut forgetful = Board::new(Wire { forgets: true, ..Wire::default() });
        assert!(forgetful.write(&parameters()).unwrap_err().to_string().contains("other parameters"));
        let mut refused = parameters();
        refused.limits.command_timeout = 1;
        let error = Board::new(Wire::default()).write(&refused).unwrap_err();
        assert!(error.to_string().contains("disarm"), "{error}");
        let error = Board::new(Wire { version: 99, ..Wire::default() }).identify().unwrap_err();
        assert!(error.to_string().contains("version 99"), "{error}");
        assert_eq!(error.exit_status(), 1);
    }
}
