use super::*;
use crate::SAMPLE_TIME;
use crate::allocation::{AllocationSettings, CurrentLimitSettings};
use crate::axes::{PerAxis, PerMotor};
use crate::command_filter::FilterSettings;
use crate::controller::ControllerSettings;
use crate::estimator::{EstimatorSettings, ObserverGains};
use crate::gains;
use crate::law::{LawSettings, StateSpaceGains};
use crate::lead::Lead;
use crate::parameters::LostLink;
use crate::pipeline::Settings;
use crate::plant::presets;
use crate::supervisor::{ArmState, Conditions};
use crate::telemetry::{InForce, Kept, Taken, TrialPhase};
use crc::{CRC_32_ISO_HDLC, Crc};
use proptest::prelude::*;
use serde::de::DeserializeOwned;
use std::string::ToString;
use std::vec;
use std::vec::Vec;

fn parameters() -> Parameters {
    Parameters::new(&presets::AERO, &Settings::paper(&presets::AERO, gains::PAPER, SAMPLE_TIME))
}

fn to_board() -> impl Strategy<Value = Numbered<ToBoard>> {
    (any::<u16>(), message()).prop_map(|(sequence, message)| message.numbered(Sequence(sequence)))
}

fn message() -> impl Strategy<Value = ToBoard> {
    let number = || prop::num::f32::NORMAL | prop::num::f32::ZERO;
    let pair = move || (number(), number()).prop_map(|(p, y)| PerAxis::new(p, y));
    prop_oneof![
        Just(ToBoard::Alive),
        Just(ToBoard::Identify),
        Just(ToBoard::ReadParameters),
        Just(ToBoard::Disarm),
        Just(ToBoard::Zero),
        any::<u32>().prop_map(|nonce| ToBoard::Arm(Nonce(nonce))),
        any::<u32>().prop_map(|nonce| ToBoard::ClearFault(Nonce(nonce))),
        any::<u16>().prop_map(|every| ToBoard::Telemetry { every }),
        (pair(), pair(), pair())
            .prop_map(|(angle, rate, accel)| { ToBoard::Setpoint(Reference { angle, rate, accel }) }),
        (any::<u32>(), any::<[i32; 2]>(), pair(), prop::option::of(pair())).prop_map(
            |(number, [pitch, yaw], volts, wanted)| {
                ToBoard::Replay(Sample {
                    number,
                    counts: PerAxis::new(pitch, yaw),
                    volts: PerMotor::new(volts.pitch, volts.yaw),
                    wanted: wanted.map(Reference::at_rest),
                })
            }
        ),
        any::<u32>().prop_map(|nonce| ToBoard::Accept(Nonce(nonce))),
        any::<u32>().prop_map(|nonce| ToBoard::Save(Nonce(nonce))),
        Just(ToBoard::Revert),
        (any::<[u32; 3]>(), number()).prop_map(|([nonce, fade_ms, revert_ms], gain)| {
            let controller = parameters().settings.controller;
            let controller = ControllerSettings { law: controller.law.map(|_| gain), ..controller };
            ToBoard::Trial(Nonce(nonce), Attempt { controller, fade_ms, revert_ms })
        }),
        (any::<u32>(), number()).prop_map(|(nonce, gain)| {
            let mut parameters = parameters();
            parameters.settings.model.damping.yaw = gain;
            ToBoard::WriteParameters(Nonce(nonce), parameters)
        }),
    ]
}

fn framed<M: Serialize>(message: &M) -> Vec<u8> {
    encode(message, &mut [0; MAX_FRAME]).unwrap().to_vec()
}

fn feed<M: DeserializeOwned>(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Result<M, LinkError>> {
    bytes.iter().filter_map(|&byte| decoder.push(byte)).collect()
}

proptest! {
    #[test]
    fn what_is_sent_arrives(messages in prop::collection::vec(to_board(), 1..8)) {
        let bytes: Vec<u8> = messages.iter().flat_map(framed).collect();
        let got = feed::<Numbered<ToBoard>>(&mut Decoder::new(), &bytes);
        prop_assert_eq!(got, messages.into_iter().map(Ok).collect::<Vec<_>>());
    }

    /// Nothing that a broken line can do panics, and the message after the next zero byte arrives.
    #[test]
    fn noise_is_dropped_and_the_next_message_arrives(
        noise in prop::collection::vec(any::<u8>(), 0..3000), message in to_board(),
    ) {
        let mut decoder = Decoder::new();
        for got in feed::<Numbered<ToBoard>>(&mut decoder, &noise) {
            prop_assert!(got.is_err());
        }
        decoder.push::<Numbered<ToBoard>>(0);
        prop_assert_eq!(feed::<Numbered<ToBoard>>(&mut decoder, &framed(&message)), [Ok(message)]);
    }

    /// A flipped bit, a lost byte, a cut: never another message.
    #[test]
    fn damage_is_noticed(
        message in to_board(), at in any::<prop::sample::Index>(), flip in 1_u8.., cut in any::<bool>(),
    ) {
        let mut bytes = framed(&message);
        let at = at.index(bytes.len() - 1);
        if cut { bytes.remove(at); } else { bytes[at] ^= flip; }
        for got in feed::<Numbered<ToBoard>>(&mut Decoder::new(), &bytes) {
            prop_assert!(got.is_err(), "{:?}", got);
        }
    }
}

/// The longest frame there can be: every number of varying length at its longest, and no zero byte, which
/// COBS makes no difference of.
#[test]
fn telemetry_takes_at_most_90_bytes() {
    let axes = PerAxis::both(1.2345);
    let motors = PerMotor::both(-17.89);
    let longest = Frame {
        tick: u32::MAX,
        state: ArmState::Fault(Condition::ResetByBrownOut),
        conditions: Condition::ALL.into_iter().fold(Conditions::NONE, |all, one| all.with(one, true)),
        angle: axes,
        rate: axes,
        disturbance: axes,
        reference: axes,
        demand: motors,
        unallocated_torque: axes,
        volts: motors,
        supply: 23.97,
        taken: Taken { sequence: Sequence(u16::MAX), ago: u8::MAX },
        controller: InForce { accepted: Kept::Unsaved, trial: TrialPhase::FadingOut, blend: 100 },
    };
    let length = framed(&ToHost::Frame(longest)).len();
    assert!(length <= MAX_TELEMETRY as usize, "{length} bytes");
}

#[test]
fn a_line_carries_the_frames_that_it_is_said_to() {
    for (baud, ticks) in
        [(2_000_000, 1), (1_000_000, 1), (921_600, 1), (460_800, 2), (115_200, 8), (9_600, 100)]
    {
        assert_eq!(ticks_per_frame(baud), ticks, "{baud} baud");
        // Start bit, 8 bits, stop bit.
        let seconds_a_frame = 90.0 * 10.0 / f64::from(baud);
        assert!(f64::from(ticks) * 1e-3 >= seconds_a_frame);
    }
}

/// As ST's programmers print it: the word at the lowest address first, its most significant digit first.
#[test]
fn a_chips_number_has_24_digits() {
    let serial = ChipSerial([0x78, 0x56, 0x34, 0x12, 0, 0, 0, 0, 0xEF, 0xBE, 0xAD, 0xDE]);
    assert_eq!(serial.to_string(), "1234567800000000DEADBEEF");
}

#[test]
fn another_version_is_named() {
    let mut plain = [VERSION + 1, 0, 0, 0, 0, 0];
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&plain[..2]).to_le_bytes();
    plain[2..].copy_from_slice(&crc);
    let mut frame = [0; 16];
    let length = cobs::try_encode(&plain, &mut frame).unwrap();
    let got = feed::<Numbered<ToBoard>>(&mut Decoder::new(), &frame[..=length]);
    assert_eq!(got, [Err(LinkError::Version { found: VERSION + 1 })]);
    let told = |found| LinkError::Version { found }.to_string();
    assert!(told(VERSION + 1).ends_with("update this program"));
    assert!(told(VERSION - 1).ends_with("update the board's firmware"));
}

/// The controller with the most numbers, and every whole number at its longest: as a record to be written, as
/// one that is read, as one that is tried.
#[test]
fn the_longest_record_and_the_longest_trial_fit() {
    let axes = PerAxis::both(1.2345);
    let mut longest = parameters();
    let settings = &mut longest.settings;
    settings.current_limit =
        Some(CurrentLimitSettings { resistance: 1.0, back_emf: 1.0, peak: 1.0, continuous: 1.0 });
    settings.controller = ControllerSettings {
        law: LawSettings::StateSpace(StateSpaceGains { states: 8, inputs: 4, ..StateSpaceGains::none() }),
        estimator: EstimatorSettings::Observer {
            gains: PerAxis::both(ObserverGains { angle: 1.0, rate: 1.0, disturbance: 1.0 }),
        },
        filter: Some(FilterSettings {
            bandwidth: axes,
            damping: Some(axes),
            advance: Some(axes),
            reach: Some(axes),
        }),
        allocation: AllocationSettings::Weighted { pitch_weight: 1.0 },
        lead: Some(Lead { factor: 1.0 }),
        cancellation: Some(axes),
    };
    longest.encoders.pitch.rest_counts = i32::MIN;
    longest.encoders.yaw.rest_counts = i32::MIN;
    longest.limits.command_timeout = u32::MAX;
    longest.limits.lost_link = LostLink::Hold { ticks: u32::MAX };
    let attempt = Attempt { controller: longest.settings.controller, fade_ms: u32::MAX, revert_ms: u32::MAX };
    for message in
        [ToBoard::WriteParameters(Nonce(u32::MAX), longest), ToBoard::Trial(Nonce(u32::MAX), attempt)]
    {
        let message = message.numbered(Sequence(u16::MAX));
        assert_eq!(feed(&mut Decoder::new(), &framed(&message)), [Ok(message)]);
    }
    let answer = ToHost::Parameters(longest);
    assert_eq!(feed::<ToHost>(&mut Decoder::new(), &framed(&answer)), [Ok(answer)]);
}

#[test]
fn every_answer_fits() {
    let refusal = ToHost::Refused(Refusal::from(ParameterError::Range { field: "f", allowed: "a" }));
    for message in [ToHost::Parameters(parameters()), ToHost::Frame(Frame::default()), refusal] {
        assert_eq!(feed::<ToHost>(&mut Decoder::new(), &framed(&message)), [Ok(message)]);
    }
}
