//! The far end of the board's serial line: what it has still to say, and what it heard.

use std::collections::VecDeque;

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

/// What becomes of a word on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Flaw {
    /// It arrives as it was sent.
    #[default]
    None,
    /// With noise on it: other data bits, and `NF`.
    Noise,
    /// Without its stop bit: other data bits, and `FE`.
    Framing,
    /// It arrives as it was sent, but the DMA does not fetch it before the next has come, which is lost:
    /// `ORE`.
    Overrun,
}

/// The host's end of the line.
#[derive(Debug, Default)]
pub struct Line {
    outgoing: VecDeque<(u8, Flaw)>,
    heard: Vec<u8>,
    /// What becomes of the word that the port is taking in.
    on_wire: Flaw,
}

impl Line {
    /// Puts bytes on the line, to cross as fast as the baud rate lets them.
    pub fn say(&mut self, bytes: &[u8]) {
        self.outgoing.extend(bytes.iter().map(|&byte| (byte, Flaw::None)));
    }

    /// Puts one byte on the line that arrives with `flaw`.
    pub fn say_flawed(&mut self, byte: u8, flaw: Flaw) {
        self.outgoing.push_back((byte, flaw));
    }

    /// Takes what was heard since the last call.
    pub fn take_heard(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.heard)
    }

    /// The bytes not yet on the wire.
    pub fn waiting(&self) -> usize {
        self.outgoing.len()
    }

    /// What becomes of the word that was put on the wire last.
    pub fn on_wire(&self) -> Flaw {
        self.on_wire
    }
}

impl Store for Line {}

impl Peer for Line {
    fn receive(&mut self, word: u16, _context: &mut Timeline<'_, '_>) {
        self.heard.push(word.to_le_bytes()[0]);
    }

    fn transmit(&mut self, _now: VirtualNanos) -> Option<u16> {
        let (byte, flaw) = self.outgoing.pop_front()?;
        self.on_wire = flaw;
        Some(u16::from(byte))
    }
}
