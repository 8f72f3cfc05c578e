//! The far end of the board's serial line: what it has still to say, and what it heard.

use std::collections::VecDeque;

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

/// The host's end of the line.
#[derive(Debug, Default)]
pub struct Line {
    outgoing: VecDeque<u8>,
    heard: Vec<u8>,
}

impl Line {
    /// Puts bytes on the line, to cross as fast as the baud rate lets them.
    pub fn say(&mut self, bytes: &[u8]) {
        self.outgoing.extend(bytes);
    }

    /// Takes what was heard since the last call.
    pub fn take_heard(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.heard)
    }

    /// The bytes not yet on the wire.
    pub fn waiting(&self) -> usize {
        self.outgoing.len()
    }
}

impl Store for Line {}

impl Peer for Line {
    fn receive(&mut self, word: u16, _context: &mut Timeline<'_, '_>) {
        self.heard.push(word.to_le_bytes()[0]);
    }

    fn transmit(&mut self, _now: VirtualNanos) -> Option<u16> {
        self.outgoing.pop_front().map(u16::from)
    }
}
