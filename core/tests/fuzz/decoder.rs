//! Bytes as they may come over a line.

use super::{Chance, inputs};
use twinrotor::axes::PerAxis;
use twinrotor::link::{Decoder, MAX_FRAME, Nonce, ToBoard, encode};
use twinrotor::reference::Reference;
use twinrotor::sequence::{Numbered, Sequence};

fn message(chance: &mut Chance) -> ToBoard {
    match chance.below(8) {
        0 => ToBoard::Alive,
        1 => ToBoard::Identify,
        2 => ToBoard::Disarm,
        3 => {
            let both = PerAxis::new(chance.float(), 1.0);
            ToBoard::Setpoint(Reference { angle: both, rate: both, accel: both })
        }
        4 => ToBoard::Arm(Nonce(chance.word())),
        5 => ToBoard::Telemetry { every: 5 },
        6 => ToBoard::ReadParameters,
        _ => ToBoard::Zero,
    }
}

/// A frame with up to three bits turned, its end missing, or bytes of the line's own before it.
fn spoil(frame: &mut Vec<u8>, chance: &mut Chance) {
    match chance.below(4) {
        0 => {
            for _ in 0..=chance.below(3) {
                let at = chance.index(frame.len());
                frame[at] ^= 1 << chance.below(8);
            }
        }
        1 => frame.truncate(chance.index(frame.len())),
        2 => {
            let at = chance.index(frame.len());
            frame.insert(at, chance.byte());
        }
        _ => *frame = (0..chance.below(80)).map(|_| chance.byte()).collect(),
    }
    frame.push(0);
}

#[test]
fn whole_messages_come_through_and_spoilt_ones_are_none() {
    let mut chance = Chance(1);
    let mut decoder = Decoder::new();
    let mut buffer = [0; MAX_FRAME];
    let (mut whole, mut rejected) = (0_u64, 0_u64);
    for nth in 0..inputs() {
        #[expect(clippy::cast_possible_truncation, reason = "it wraps")]
        let said = message(&mut chance).numbered(Sequence(nth as u16));
        let sound = encode(&said, &mut buffer).expect("every message fits").to_vec();
        let spoilt = chance.one_in(2);
        let mut frame = sound.clone();
        if spoilt {
            spoil(&mut frame, &mut chance);
        }
        let heard: Vec<Result<Numbered<ToBoard>, _>> =
            frame.iter().filter_map(|&byte| decoder.push(byte)).collect();
        let messages = heard.iter().flatten();
        if spoilt {
            // Where a spoilt frame still says something, nothing was spoilt but what stands before or behind.
            messages.for_each(|message| assert_eq!(bits(message), bits(&said), "{nth}: {frame:?}"));
            rejected += u64::from(heard.iter().any(Result::is_err));
        } else {
            assert!(heard.len() == 1 && messages.count() == 1, "{nth}: {heard:?}");
            whole += 1;
        }
    }
    println!("{whole} whole messages, {rejected} spoilt ones found");
    assert!(whole > inputs() / 3 && rejected > inputs() / 4);
}

/// Compared as bytes: a NaN is not equal to itself.
fn bits(message: &Numbered<ToBoard>) -> Vec<u8> {
    encode(message, &mut [0; MAX_FRAME]).expect("it came from a frame").to_vec()
}
