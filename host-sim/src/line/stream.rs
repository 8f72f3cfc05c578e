//! A line of bytes whose reads end soon: a serial port, a TCP connection.

use super::Line;
use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant};

/// \[byte\] Most that is taken at once: 40 ms of a line of a megabaud.
const AT_ONCE: usize = 4096;

/// A line by the computer's clock.
#[derive(Debug)]
pub struct Stream<P> {
    port: P,
    begun: Instant,
}

impl<P> Stream<P> {
    /// From now on.
    pub fn new(port: P) -> Self {
        Self { port, begun: Instant::now() }
    }
}

impl<P: Read + Write> Line for Stream<P> {
    fn exchange(&mut self, bytes: &[u8]) -> io::Result<Vec<u8>> {
        if !bytes.is_empty() {
            self.port.write_all(bytes)?;
            self.port.flush()?;
        }
        let mut heard = vec![0; AT_ONCE];
        let count = match self.port.read(&mut heard) {
            Ok(0) => return Err(io::Error::new(ErrorKind::UnexpectedEof, "the other end has closed it")),
            Ok(count) => count,
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
                ) =>
            {
                0
            }
            Err(error) => return Err(error),
        };
        heard.truncate(count);
        Ok(heard)
    }

    fn now(&self) -> Duration {
        self.begun.elapsed()
    }
}
