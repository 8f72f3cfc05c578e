//! Lines to boards: a simulated one, a serial port, a TCP connection.

pub mod board;
mod off;
mod simulated;
mod stream;

pub use board::Board;
pub use off::{NOT_SEEN, switch_off};
pub use simulated::Simulated;
pub use stream::Stream;

use crate::error::{Failure, Outcome};
use std::io;
use std::net::TcpStream;
use std::time::Duration;
use twinrotor::link::BAUD;

/// A line to a board.
pub trait Line {
    /// Sends `bytes` and gives what has come, for which it waits a moment.
    ///
    /// # Errors
    ///
    /// If the line is no longer there.
    fn exchange(&mut self, bytes: &[u8]) -> io::Result<Vec<u8>>;

    /// A leg of the flight began in the board's tick `tick`: what a simulated rig may have waited for.
    fn begins(&mut self, _tick: u32) {}

    /// Since it was opened, by the clock that goes with this line.
    fn now(&self) -> Duration;
}

/// What begins the name of a TCP connection.
const TCP: &str = "tcp://";
/// How long a read waits.
const MOMENT: Duration = Duration::from_millis(5);
/// How long a write may take.
const WRITE: Duration = Duration::from_millis(500);

/// Opens `DEVICE`, `tcp://HOST:PORT`, or with `auto` the one serial port at which a board answers.
///
/// # Errors
///
/// If it cannot be opened, or if no board answers, or several do.
pub fn open(name: &str) -> Outcome<(String, Box<dyn Line>)> {
    if name == "auto" {
        return find();
    }
    Ok((name.to_owned(), open_named(name)?))
}

fn open_named(name: &str) -> Outcome<Box<dyn Line>> {
    let failed =
        |error: &dyn std::fmt::Display| Failure::Run(format!("--port {name} cannot be opened: {error}"));
    if let Some(address) = name.strip_prefix(TCP) {
        let stream = TcpStream::connect(address).map_err(|e| failed(&e))?;
        let set = stream
            .set_nodelay(true)
            .and_then(|()| stream.set_read_timeout(Some(MOMENT)))
            .and_then(|()| stream.set_write_timeout(Some(WRITE)));
        set.map_err(|e| failed(&e))?;
        return Ok(Box::new(Stream::new(stream)));
    }
    let port = serialport::new(name, BAUD).timeout(MOMENT).open().map_err(|e| failed(&e))?;
    Ok(Box::new(Stream::new(port)))
}

/// Asks each serial port who is there.
fn find() -> Outcome<(String, Box<dyn Line>)> {
    let ports = serialport::available_ports()
        .map_err(|error| Failure::Run(format!("serial ports cannot be listed: {error}")))?;
    let names: Vec<String> = ports.into_iter().map(|port| port.port_name).collect();
    let answers = |name: &String| {
        let who = Board::new(open_named(name).ok()?).identify_soon()?;
        Some((name.clone(), who))
    };
    let found: Vec<_> = names.iter().filter_map(answers).collect();
    match found.as_slice() {
        [(name, _)] => Ok((name.clone(), open_named(name)?)),
        [] => Err(Failure::Run(format!(
            "no board answers at any serial port; there {}",
            if names.is_empty() { "is none".to_owned() } else { format!("are: {}", names.join(", ")) }
        ))),
        several => {
            let told: Vec<String> =
                several.iter().map(|(name, who)| format!("{name} ({})", who.chip)).collect();
            Err(Failure::Input(format!(
                "--port is 'auto', and several boards answer; allowed: the name of one, {}",
                told.join(", ")
            )))
        }
    }
}
