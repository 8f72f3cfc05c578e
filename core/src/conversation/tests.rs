mod trial;

use super::*;
use crate::SAMPLE_TIME;
use crate::axes::PerAxis;
use crate::bench::Injection;
use crate::gains;
use crate::pipeline::Settings;
use crate::plant::presets;
use crate::reference::Reference;
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::vec::Vec;

const NONCE: Nonce = Nonce(0xC0FF_EE01);

fn parameters() -> Parameters {
    Parameters::new(&presets::AERO2, &Settings::paper(&presets::AERO2, gains::PAPER, SAMPLE_TIME))
}

const BOARD: Board = Board {
    firmware: "0.1.0",
    chip: "stm32f405rg",
    port: RigPort::Pwm,
    serial: ChipSerial([7; 12]),
    nonce: NONCE,
    reset: None,
    baud: link::BAUD,
};

fn board(provenance: Provenance) -> Conversation {
    Conversation::new(BOARD, parameters(), provenance)
}

/// Disarmed, with room for everything.
const IDLE: Loop = Loop {
    takes_command: true,
    takes_candidate: true,
    status: Status { armed: false, flash_may_be_written: true, trial: TrialPhase::None, accepted: None },
};

/// A host that counts its messages.
struct Host {
    board: Conversation,
    sequence: Sequence,
    now: Loop,
}

impl Host {
    fn new(provenance: Provenance) -> Self {
        let mut host = Self { board: board(provenance), sequence: Sequence(777), now: IDLE };
        let Action::Answer(ToHost::Identity(identity)) = host.say(ToBoard::Identify) else {
            panic!("the board says who it is");
        };
        host.sequence = identity.expected;
        assert_eq!((identity.nonce, identity.provenance), (NONCE, provenance));
        assert_eq!(identity.serial, BOARD.serial);
        host
    }

    fn say(&mut self, message: ToBoard) -> Action {
        let numbered = message.numbered(self.sequence);
        self.sequence = self.sequence.next();
        self.board.receive(Ok(numbered), &self.now).action
    }
}

fn refusal(action: Action) -> Refusal {
    let Action::Answer(ToHost::Refused(refusal)) = action else { panic!("refused: {action:?}") };
    refusal
}

/// One message of each kind that does something, a setpoint of its own each time.
fn acting(nonce: Nonce) -> Vec<ToBoard> {
    let setpoint = Reference::at_rest(PerAxis::new(0.1, 0.2));
    std::vec![
        ToBoard::Setpoint(setpoint),
        ToBoard::Zero,
        ToBoard::Arm(nonce),
        ToBoard::ClearFault(nonce),
        ToBoard::Check(nonce),
        ToBoard::Telemetry { every: 7 },
        ToBoard::ReadParameters,
        ToBoard::WriteParameters(nonce, parameters()),
        ToBoard::Revert,
        ToBoard::Save(nonce),
    ]
}

#[test]
fn each_message_has_its_action_once() {
    let mut host = Host::new(Provenance::Stored);
    for message in acting(NONCE) {
        let sequence = host.sequence;
        let action = host.say(message.clone());
        let expected = match &message {
            ToBoard::Setpoint(setpoint) => Some(OperatorCommand::Setpoint(*setpoint)),
            ToBoard::Zero => Some(OperatorCommand::Zero),
            ToBoard::Arm(_) => Some(OperatorCommand::Request(Request::Arm)),
            ToBoard::ClearFault(_) => Some(OperatorCommand::Request(Request::ClearFault)),
            ToBoard::Check(_) => Some(OperatorCommand::Request(Request::Check)),
            ToBoard::Revert => Some(OperatorCommand::Revert),
            _ => None,
        };
        match (expected, action) {
            (Some(command), action) => {
                assert_eq!(action, Action::Command(Numbered { sequence, message: command }));
            }
            (None, Action::FrameEvery(every)) => assert_eq!(every, 7),
            (None, Action::Answer(ToHost::Parameters(read))) => assert_eq!(read, parameters()),
            (None, Action::Keep(kept)) => assert_eq!(kept, parameters()),
            (None, Action::Answer(ToHost::Saved)) => assert_eq!(message, ToBoard::Save(NONCE)),
            (None, action) => panic!("{message:?}: {action:?}"),
        }
        // The same bytes once more.
        let again = host.board.receive(Ok(message.numbered(sequence)), &IDLE);
        assert_eq!(again, Response { heard: false, action: Action::Nothing });
    }
    assert_eq!(host.board.stale(), 10);
    assert_eq!(host.say(ToBoard::Alive), Action::Nothing);
}

#[test]
fn disarm_and_identify_count_whatever_their_number_and_only_a_new_one_is_a_sign_of_life() {
    let mut host = Host::new(Provenance::Stored);
    host.now.takes_command = false;
    host.say(ToBoard::Alive);
    let newest = host.sequence;
    for behind in 0..=u16::MAX {
        let sequence = Sequence(newest.0.wrapping_sub(behind));
        if sequence.is_newer_than(Sequence(newest.0.wrapping_sub(1))) {
            continue;
        }
        let said = host.board.receive(Ok(ToBoard::Disarm.numbered(sequence)), &host.now);
        assert_eq!(said, Response { heard: false, action: Action::Disarm });
        let said = host.board.receive(Ok(ToBoard::Identify.numbered(sequence)), &host.now);
        assert!(!said.heard && matches!(said.action, Action::Answer(ToHost::Identity(_))));
    }
    assert_eq!(host.board.stale(), 0);
    let said = host.board.receive(Ok(ToBoard::Disarm.numbered(newest)), &host.now);
    assert_eq!(said, Response { heard: true, action: Action::Disarm });
}

/// What can turn a motor, clear a fault or change what flies is refused to a host of another boot.
#[test]
fn another_boots_nonce_is_refused() {
    let mut host = Host::new(Provenance::Stored);
    let mut refused = 0;
    for message in acting(Nonce(NONCE.0 ^ 1)) {
        let needs = message.nonce().is_some();
        let action = host.say(message);
        let denied = action == Action::Answer(ToHost::Refused(Refusal::Nonce));
        assert_eq!(denied, needs, "{action:?}");
        refused += u32::from(denied);
    }
    assert_eq!(refused, 5);
}

#[test]
fn no_check_with_parameters_that_are_not_the_rigs() {
    for provenance in
        [Provenance::Missing, Provenance::OtherVersion { found: 3 }, Provenance::Damaged, Provenance::Stored]
    {
        let mut host = Host::new(provenance);
        let action = host.say(ToBoard::Check(NONCE));
        assert_eq!(
            action == Action::Answer(ToHost::Refused(Refusal::NoParameters)),
            provenance != Provenance::Stored
        );
        // Once a record is kept, there is.
        assert_eq!(host.board.kept(&parameters(), Ok(())), ToHost::Saved);
        assert!(matches!(host.say(ToBoard::Check(NONCE)), Action::Command(_)));
    }
}

#[test]
fn a_setpoint_outside_the_envelope_is_refused_with_the_range() {
    let mut host = Host::new(Provenance::Stored);
    let action = host.say(ToBoard::Setpoint(Reference::at_rest(PerAxis::new(1.5, 0.0))));
    let Refusal::Setpoint { field, low, high } = refusal(action) else { panic!("with its range") };
    let limit = parameters().limits.pitch;
    assert_eq!((field.as_str(), low, high), ("setpoint.angle.pitch", -limit, limit));
}

#[test]
fn commands_that_find_no_room_are_refused_and_all_else_is_not() {
    let mut host = Host::new(Provenance::Stored);
    host.now.takes_command = false;
    for message in acting(NONCE) {
        let action = host.say(message);
        assert!(!matches!(action, Action::Command(_)));
    }
    assert_eq!(refusal(host.say(ToBoard::Zero)), Refusal::Busy);
    assert_eq!(host.say(ToBoard::Disarm), Action::Disarm);
}

#[test]
fn a_record_is_kept_only_with_every_value_in_its_range_and_in_force_only_when_kept() {
    let mut host = Host::new(Provenance::Missing);
    let mut other = parameters();
    other.limits.command_timeout = 0;
    let Refusal::Range { field, .. } = refusal(host.say(ToBoard::WriteParameters(NONCE, other))) else {
        panic!("out of range")
    };
    assert_eq!(field.as_str(), "limits.command_timeout");
    other.limits.command_timeout = 250;
    assert_eq!(host.say(ToBoard::WriteParameters(NONCE, other)), Action::Keep(other));
    let refused = host.board.kept(&other, Err(Refusal::MotorsMayTurn));
    assert_eq!(refused, ToHost::Refused(Refusal::MotorsMayTurn));
    assert_eq!((host.board.parameters(), host.board.provenance), (&parameters(), Provenance::Missing));
    assert_eq!(host.board.kept(&other, Ok(())), ToHost::Saved);
    assert_eq!((host.board.parameters(), host.board.provenance), (&other, Provenance::Stored));
}

#[test]
fn telemetry_every_1_to_1000_ticks_and_as_often_as_the_line_carries() {
    let mut host = Host::new(Provenance::Stored);
    for every in [1, 5, 1000] {
        assert_eq!(host.say(ToBoard::Telemetry { every }), Action::FrameEvery(every));
    }
    for every in [0, 1001, u16::MAX] {
        assert!(matches!(refusal(host.say(ToBoard::Telemetry { every })), Refusal::Range { .. }));
    }
    let slow = Board { baud: 115_200, ..BOARD };
    host.board = Conversation::new(slow, parameters(), Provenance::Stored);
    for every in [1, 7] {
        assert_eq!(refusal(host.say(ToBoard::Telemetry { every })), Refusal::TooOften { least: 8 });
    }
    assert_eq!(host.say(ToBoard::Telemetry { every: 8 }), Action::FrameEvery(8));
}

#[test]
fn a_replay_needs_its_beginning_and_ends_with_other_parameters() {
    let sample = |number| Sample {
        number,
        counts: PerAxis::new(3, -5),
        volts: crate::axes::PerMotor::new(6.0, 0.5),
        wanted: None,
    };
    let mut host = Host::new(Provenance::Stored);
    assert_eq!(refusal(host.say(ToBoard::Replay(sample(1)))), Refusal::NoReplay);
    let mut here = Replay::new(&parameters(), &sample(0));
    for number in 0..3 {
        let Action::Answer(ToHost::Replayed(told)) = host.say(ToBoard::Replay(sample(number))) else {
            panic!("replayed")
        };
        assert!(told.same_bits(&here.step(&sample(number))));
    }
    host.board.kept(&parameters(), Ok(()));
    assert_eq!(refusal(host.say(ToBoard::Replay(sample(3)))), Refusal::NoReplay);
}

proptest! {
    /// A line that hands out any stretch of its last 512 bytes again, loses and damages messages: no command
    /// is dealt with twice, and every `Disarm` is obeyed.
    #[test]
    fn no_command_is_dealt_with_twice(
        start in any::<u16>(),
        steps in prop::collection::vec((0_usize..8, 0_usize..64, any::<bool>()), 1..200),
    ) {
        let mut board = board(Provenance::Stored);
        // As a host that has talked for long: the number is anywhere.
        for jump in [start / 2, start - start / 2] {
            let _ = board.order.admit(Sequence(board.order.expected().0.wrapping_add(jump)));
        }
        let mut sequence = board.order.expected();
        let mut line: Vec<Numbered<ToBoard>> = Vec::new();
        let mut dealt = BTreeSet::new();
        let kinds = acting(NONCE);
        for (kind, again, damaged) in steps {
            let message = kinds[kind].clone().numbered(sequence);
            sequence = sequence.next();
            line.push(message.clone());
            let received = if damaged { Err(LinkError::Damaged) } else { Ok(message.clone()) };
            let first = board.receive(received, &IDLE);
            prop_assert_eq!(first.heard, !damaged);
            if first.heard {
                prop_assert!(dealt.insert(message.sequence.0));
            }
            let said = Ok(ToBoard::Disarm.numbered(sequence));
            prop_assert_eq!(board.receive(said, &IDLE).action, Action::Disarm);
            sequence = sequence.next();
            for old in line.iter().rev().take(again).rev() {
                let repeated = board.receive(Ok(old.clone()), &IDLE);
                prop_assert_eq!(repeated, Response { heard: false, action: Action::Nothing });
            }
        }
    }
}

/// What befalls a rig is told to a simulated one only, within its range, and for this boot.
#[test]
fn only_a_board_with_a_simulated_rig_lets_something_befall_it() {
    let say = |port, injection| {
        let board = Conversation::new(Board { port, ..BOARD }, parameters(), Provenance::Stored);
        Host { board, ..Host::new(Provenance::Stored) }.say(ToBoard::Inject(NONCE, injection))
    };
    assert_eq!(refusal(say(RigPort::Pwm, Injection::Rest)), Refusal::NotSimulated);
    let taken = say(RigPort::Simulated, Injection::Supply(12.0));
    let Action::Command(Numbered { message, .. }) = taken else { panic!("{taken:?}") };
    assert_eq!(message, OperatorCommand::Inject(Injection::Supply(12.0)));
    let beyond = refusal(say(RigPort::Simulated, Injection::Supply(76.0)));
    assert_eq!(beyond, Refusal::range("inject.supply", "0 to 75 V"));
    let mut host = Host::new(Provenance::Stored);
    let other = host.say(ToBoard::Inject(Nonce(NONCE.0 + 1), Injection::Rest));
    assert_eq!(refusal(other), Refusal::Nonce);
}

/// A record that was checked on a simulated rig does not arm a real one, nor the other way round.
#[test]
fn what_was_checked_at_another_kind_of_port_is_kept_as_not_checked() {
    for (own, other) in [(RigPort::Pwm, RigPort::Simulated), (RigPort::Simulated, RigPort::Pwm)] {
        let keep = |port| {
            let board = Conversation::new(Board { port: own, ..BOARD }, parameters(), Provenance::Stored);
            let record = Parameters { checked: true, port, ..parameters() };
            let mut host = Host { board, ..Host::new(Provenance::Stored) };
            let Action::Keep(kept) = host.say(ToBoard::WriteParameters(NONCE, record)) else { panic!() };
            (kept.checked, kept.port)
        };
        assert_eq!(keep(own), (true, own));
        assert_eq!(keep(other), (false, own));
    }
}
