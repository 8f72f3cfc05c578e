//! Nonsense on the serial line.

use twinrotor::axes::PerAxis;
use twinrotor::link::{MAX_FRAME, ToBoard, encode};
use twinrotor::reference::Reference;
use twinrotor::sequence::Sequence;
use virtual_board::station::Station;

use super::flights;

/// xorshift64.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, limit: usize) -> usize {
        usize::try_from(self.next() % limit as u64).expect("below a usize")
    }
}

/// Bytes that are no message: noise, or a message with its end missing or a bit turned round.
fn nonsense(chance: &mut Chance) -> Vec<u8> {
    let messages = [
        ToBoard::Disarm,
        ToBoard::Zero,
        ToBoard::Setpoint(Reference::at_rest(PerAxis::new(0.5, -0.5))),
        ToBoard::Telemetry { every: 1 },
    ]
    .map(|message| message.numbered(Sequence(30_000)));
    let mut buffer = [0; MAX_FRAME];
    let whole = encode(&messages[chance.below(messages.len())], &mut buffer).expect("room").to_vec();
    match chance.below(3) {
        0 => (0..chance.below(200)).map(|_| chance.next().to_le_bytes()[3]).collect(),
        1 => {
            let mut cut = whole[..chance.below(whole.len() - 1)].to_vec();
            cut.push(0);
            cut
        }
        _ => {
            let mut turned = whole.clone();
            let at = chance.below(whole.len() - 1);
            turned[at] ^= 1 << chance.below(8);
            turned
        }
    }
}

/// As fast as a third of the line lets it come, besides what the operator says ten times a second.
#[test]
fn eighteen_hundred_pieces_of_nonsense_on_the_line_change_nothing() {
    flights().for_each(|mut station| say_nonsense(&mut station));
}

fn say_nonsense(station: &mut Station) {
    // Until its reference rests.
    station.run(6_000);
    station.send(&ToBoard::Telemetry { every: 10 });
    station.run(10);
    let before = *station.heard.frames.last().expect("frames");
    let rejected = station.heard.health.last().map_or(0, |health| health.messages_rejected);
    let mut chance = Chance(0x5EED_1234_5678_9ABC);
    for _ in 0..600 {
        for _ in 0..3 {
            let bytes = nonsense(&mut chance);
            station.machine.say(&bytes);
        }
        // A zero ends whatever the noise began, so that the next true message arrives.
        station.machine.say(&[0]);
        station.run(20);
    }
    let after = station.heard.frames.last().expect("frames");
    assert_eq!(after.state, before.state, "{}", station.heard.summary());
    assert_eq!((after.reference, after.controller), (before.reference, before.controller));
    assert!(station.heard.refusals.is_empty() && station.heard.verdicts.is_empty());
    let health = station.heard.health.last().expect("a report a second");
    assert!(health.messages_rejected > rejected + 500, "{health:?}");
    assert_eq!(station.machine.resets(), []);
    assert!((after.angle.pitch - 0.1).abs() < 0.02 && (after.angle.yaw - 0.2).abs() < 0.02, "{after:?}");
}
