//! Out of MCAP (its specification, <https://mcap.dev/spec>): one channel of JSON messages, as `fly --record`
//! and `simulate --export` write it.

use super::{Flight, NAMES, unusable, without};
use serde_json::{Map, Value};
use twinrotor_sim::{Error, Outcome};

/// Such a file begins so.
pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// The channel of a flight.
const TOPIC: &str = "/flight";

/// The specification's records that are read: what they are called there, and their opcodes.
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const DATA_END: u8 = 0x0f;

/// Bytes that are read from their beginning.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, length: usize) -> Outcome<&'a [u8]> {
        let (taken, rest) =
            self.0.split_at_checked(length).ok_or_else(|| unusable("MCAP: the file ends too early"))?;
        self.0 = rest;
        Ok(taken)
    }

    /// A number of so many bytes, the least first.
    fn number(&mut self, bytes: usize) -> Outcome<u64> {
        Ok(self.take(bytes)?.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    fn counted(&mut self, bytes: usize) -> Outcome<&'a [u8]> {
        let length = self.number(bytes)?;
        self.take(usize::try_from(length).unwrap_or(usize::MAX))
    }

    /// Opcode and content of the next record.
    fn record(&mut self) -> Outcome<(u8, Self)> {
        let opcode = self.take(1)?[0];
        Ok((opcode, Self(self.counted(8)?)))
    }
}

/// What is read of a file so far.
#[derive(Default)]
struct Reading {
    /// Of the channels of that topic.
    channels: Vec<u64>,
    messages: u32,
    flight: Option<Flight>,
}

impl Reading {
    /// Records up to the end of what is to be read; chunks are not within chunks.
    fn take(&mut self, mut records: Bytes<'_>, within: bool) -> Outcome<()> {
        while !records.0.is_empty() {
            let (opcode, mut content) = records.record()?;
            match opcode {
                CHANNEL => {
                    let id = content.number(2)?;
                    let _schema = content.number(2)?;
                    if content.counted(4)? == TOPIC.as_bytes() {
                        self.channels.push(id);
                    }
                }
                CHUNK if !within => {
                    // Start time, end time, size and checksum before compression.
                    content.take(8 + 8 + 8 + 4)?;
                    let compression = content.counted(4)?;
                    if !compression.is_empty() {
                        let kind = String::from_utf8_lossy(compression);
                        let told = format!("MCAP: it is compressed by {kind}; host-sim writes it as it is");
                        return Err(unusable(&told));
                    }
                    self.take(Bytes(content.counted(8)?), true)?;
                }
                MESSAGE => {
                    let channel = content.number(2)?;
                    // Sequence, log time, publish time: the row has its own.
                    content.take(4 + 8 + 8)?;
                    if self.channels.contains(&channel) {
                        self.message(content.0)?;
                    }
                }
                DATA_END => return Ok(()),
                _ => {}
            }
        }
        Ok(())
    }

    fn message(&mut self, data: &[u8]) -> Outcome<()> {
        self.messages += 1;
        let number = self.messages;
        let wrong = |why: &str| unusable(&format!("message {number}: {why}"));
        let row: Map<String, Value> =
            serde_json::from_slice(data).map_err(|error| wrong(&error.to_string()))?;
        let flight = match &mut self.flight {
            Some(flight) => flight,
            None => {
                if let Some(missing) = NAMES.iter().take(3).position(|names| field(&row, names).is_none()) {
                    return Err(without(missing));
                }
                self.flight.insert(Flight::new(row.contains_key("v0")))
            }
        };
        let values = values(&row).map_err(|name| wrong(&format!("'{name}' is no number")))?;
        flight.take(&values).map_err(wrong)
    }
}

/// All its messages.
pub(super) fn read(file: &[u8]) -> Outcome<Flight> {
    let mut reading = Reading::default();
    reading.take(Bytes(&file[MAGIC.len()..]), false)?;
    reading.flight.ok_or_else(|| Error::Unusable(format!("the recorded flight: it has no channel {TOPIC}")))
}

/// A field under any of its names.
fn field<'a>(row: &'a Map<String, Value>, names: &[&str]) -> Option<&'a Value> {
    names.iter().find_map(|name| row.get(*name))
}

/// What is read of a message, or which of it is no number. What JSON has no number for, it has as `null`.
fn values(row: &Map<String, Value>) -> Result<[f64; NAMES.len()], &'static str> {
    let mut values = [f64::NAN; NAMES.len()];
    for (names, value) in NAMES.iter().zip(&mut values) {
        match field(row, names) {
            None | Some(Value::Null) => {}
            Some(told) => *value = told.as_f64().ok_or(names[0])?,
        }
    }
    Ok(values)
}
