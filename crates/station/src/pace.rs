//! How fast a simulated board may run for whoever is at the other end of its line.

use std::time::Duration;
use twinrotor::link::{Decoder, ToBoard};
use twinrotor::sequence::Numbered;

/// \[ticks\] A board that runs as fast as it can waits for its host when it has heard nothing for so long. A
/// host says that it is there when it has seen so many more, so that what is on the way to it does not grow.
const LONGEST_ALONE: u64 = 100;
/// How long it waits at most: then the host is gone, and the board is to find out.
const PATIENCE: Duration = Duration::from_secs(10);
/// \[ticks\] Most that a late board in real time makes good; what is beyond that is lost.
const MOST_LATE: u64 = 100;

/// When the next tick may be.
#[derive(Debug, Clone)]
pub struct Pace {
    real: bool,
    begun: Duration,
    ticks: u64,
    /// When the host was heard last: in which tick, and by the clock.
    heard: (u64, Duration),
    decoder: Decoder,
}

impl Pace {
    /// In real time, or as fast as it goes.
    #[must_use]
    pub const fn new(real: bool, now: Duration) -> Self {
        Self { real, begun: now, ticks: 0, heard: (0, now), decoder: Decoder::new() }
    }

    /// The host has said this. Setpoints come many times in a tenth of a second: they do not tell how much of
    /// what the board said has been heard.
    pub fn hear(&mut self, bytes: &[u8], now: Duration) {
        for &byte in bytes {
            match self.decoder.push::<Numbered<ToBoard>>(byte) {
                None | Some(Ok(Numbered { message: ToBoard::Setpoint(_), .. })) => {}
                Some(_) => self.meet(now),
            }
        }
    }

    /// A host has come.
    pub fn meet(&mut self, now: Duration) {
        self.heard = (self.ticks, now);
    }

    /// \[ticks\] That may pass now; they count as passed.
    pub fn due(&mut self, now: Duration) -> u64 {
        let due = if self.real {
            let passed = u64::try_from((now - self.begun).as_millis()).unwrap_or(u64::MAX);
            let late = passed.saturating_sub(self.ticks);
            self.begun += Duration::from_millis(late.saturating_sub(MOST_LATE));
            late.min(MOST_LATE)
        } else {
            let (tick, at) = self.heard;
            let alone = self.ticks - tick;
            // Once it is lost, it does not come back by waiting for it again.
            u64::from(alone < LONGEST_ALONE || now > at + PATIENCE)
        };
        self.ticks += due;
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::client::ALIVE_EVERY;
    use twinrotor::axes::PerAxis;
    use twinrotor::link::{MAX_FRAME, encode};
    use twinrotor::reference::Reference;
    use twinrotor::sequence::Sequence;

    const fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn real_time_keeps_to_the_clock() {
        let mut pace = Pace::new(true, ms(500));
        let ticks: u64 = (0..60_000_u64).step_by(3).map(|k| pace.due(ms(500 + k))).sum();
        assert_eq!(ticks, 59_997);
        // A machine that slept a second makes good a part of it, and keeps to the clock again.
        assert_eq!((pace.due(ms(61_500)), pace.due(ms(61_500)), pace.due(ms(61_510))), (100, 0, 10));
    }

    #[test]
    fn as_fast_as_it_goes_waits_for_its_host_and_gives_it_up() {
        let mut pace = Pace::new(false, ms(0));
        let run = |pace: &mut Pace, at: u64| (0..10_000).map(|_| pace.due(ms(at))).sum::<u64>();
        let say = |pace: &mut Pace, message: ToBoard| {
            let mut buffer = [0; MAX_FRAME];
            pace.hear(encode(&message.numbered(Sequence(1)), &mut buffer).unwrap(), ms(9_000));
        };
        assert_eq!(ms(LONGEST_ALONE), ALIVE_EVERY);
        assert_eq!(run(&mut pace, 1), 100);
        assert_eq!(run(&mut pace, 9_000), 0);
        say(&mut pace, ToBoard::Setpoint(Reference::at_rest(PerAxis::zero())));
        assert_eq!(run(&mut pace, 9_000), 0);
        say(&mut pace, ToBoard::Alive);
        assert_eq!(run(&mut pace, 9_001), 100);
        assert_eq!(run(&mut pace, 19_002), 10_000);
    }
}
