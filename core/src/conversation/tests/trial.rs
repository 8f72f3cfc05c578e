//! A controller that is tried: what is handed to the tick, what is refused, and what is read back.

use super::*;
use crate::controller::ControllerSettings;
use crate::trial::Attempt;

/// Another controller than the record's.
fn other() -> ControllerSettings<f32> {
    let own = parameters().settings.controller;
    ControllerSettings { law: own.law.map(|gain| 0.9 * gain), ..own }
}

fn with_other() -> Parameters {
    let mut with = parameters();
    with.settings.controller = other();
    with
}

fn armed() -> Host {
    let mut host = Host::new(Provenance::Stored);
    host.now.status = Status { armed: true, flash_may_be_written: false, ..Status::default() };
    host
}

/// Says that `other` is to be tried; gives the number of that message.
fn try_other(host: &mut Host) -> Sequence {
    let sequence = host.sequence;
    let action = host.say(ToBoard::Trial(NONCE, Attempt::new(other())));
    assert_eq!(action, Action::Try(Numbered { sequence, message: OperatorCommand::Try }));
    let candidate = host.board.candidate().expect("it was asked for");
    let expected = Candidate::new(&parameters(), &Attempt::new(other()), sequence).unwrap();
    assert_eq!(candidate, expected);
    sequence
}

#[track_caller]
fn reads_back(host: &mut Host, expected: &Parameters) {
    let action = host.say(ToBoard::ReadParameters);
    let Action::Answer(ToHost::Parameters(read)) = action else { panic!("{action:?}") };
    // Bit for bit: what is compared is what is stored.
    let bytes = |p: &Parameters| p.encode(&mut [0; parameters::store::MAX_PAYLOAD]).unwrap().to_vec();
    assert_eq!(bytes(&read), bytes(expected));
}

#[test]
fn what_is_read_back_is_what_flies_through_a_trial_that_is_accepted_and_saved() {
    let mut host = armed();
    let tried = try_other(&mut host);
    // The tick has not taken it.
    host.now.takes_candidate = false;
    reads_back(&mut host, &parameters());
    host.now.takes_candidate = true;
    for trial in [TrialPhase::Shadow, TrialPhase::FadingIn] {
        host.now.status.trial = trial;
        reads_back(&mut host, &parameters());
    }
    host.now.status.trial = TrialPhase::Flying;
    reads_back(&mut host, &with_other());
    assert_eq!(host.board.parameters(), &parameters(), "not accepted yet");
    let sequence = host.sequence;
    let accept = Action::Command(Numbered { sequence, message: OperatorCommand::Accept });
    assert_eq!(host.say(ToBoard::Accept(NONCE)), accept);
    host.now.status = Status { accepted: Some(tried), trial: TrialPhase::None, ..host.now.status };
    reads_back(&mut host, &with_other());
    // Only with motors that cannot turn.
    assert_eq!(refusal(host.say(ToBoard::Save(NONCE))), Refusal::MotorsMayTurn);
    host.now.status = Status { armed: false, flash_may_be_written: true, ..host.now.status };
    assert_eq!(host.say(ToBoard::Save(NONCE)), Action::Keep(with_other()));
    assert_eq!(host.board.kept(&with_other(), Ok(())), ToHost::Saved);
    host.now.status.accepted = None;
    reads_back(&mut host, &with_other());
    // An answer that was lost is said again, and flash is left alone.
    assert_eq!(host.say(ToBoard::Save(NONCE)), Action::Answer(ToHost::Saved));
}

#[test]
fn what_is_taken_back_is_read_back_no_more_and_another_may_be_tried() {
    let mut host = armed();
    try_other(&mut host);
    host.now.status.trial = TrialPhase::Flying;
    reads_back(&mut host, &with_other());
    let sequence = host.sequence;
    let revert = Action::Command(Numbered { sequence, message: OperatorCommand::Revert });
    assert_eq!(host.say(ToBoard::Revert), revert);
    host.now.status.trial = TrialPhase::FadingOut;
    reads_back(&mut host, &parameters());
    assert_eq!(refusal(host.say(ToBoard::Trial(NONCE, Attempt::new(other())))), Refusal::TrialUnderWay);
    host.now.status.trial = TrialPhase::None;
    reads_back(&mut host, &parameters());
    assert_eq!(host.board.candidate(), None);
    try_other(&mut host);
}

#[test]
fn a_trial_that_cannot_be_is_refused_with_its_reason_and_nothing_is_handed_over() {
    let trial = |attempt| ToBoard::Trial(NONCE, attempt);
    let sound = Attempt::new(other());
    let mut host = Host::new(Provenance::Stored);
    assert_eq!(refusal(host.say(trial(sound))), Refusal::NotArmed);
    let mut host = armed();
    let nan = ControllerSettings { law: other().law.map(|_| f32::NAN), ..other() };
    for (attempt, name) in [
        (Attempt { fade_ms: 0, ..sound }, "trial.fade_ms"),
        (Attempt { fade_ms: 10_001, ..sound }, "trial.fade_ms"),
        (Attempt { revert_ms: 0, ..sound }, "trial.revert_ms"),
        (Attempt { revert_ms: 600_001, ..sound }, "trial.revert_ms"),
        (Attempt { controller: nan, ..sound }, "trial.controller"),
    ] {
        let Refusal::Range { field, .. } = refusal(host.say(trial(attempt))) else { panic!("{name}") };
        assert_eq!(field.as_str(), name);
    }
    let negative = ControllerSettings { law: other().law.map(|gain| -gain), ..other() };
    let Refusal::Range { field, .. } = refusal(host.say(trial(Attempt::new(negative)))) else { panic!() };
    assert_eq!(Some(field.as_str()), negative.validate().err().map(|invalid| invalid.field));
    for (takes_command, takes_candidate) in [(false, true), (true, false)] {
        host.now = Loop { takes_command, takes_candidate, ..host.now };
        assert_eq!(refusal(host.say(trial(sound))), Refusal::Busy);
    }
    host.now = Loop { takes_command: true, takes_candidate: true, ..host.now };
    // The number of one that was accepted, 65,536 messages later.
    host.now.status.accepted = Some(host.sequence);
    assert_eq!(refusal(host.say(trial(sound))), Refusal::Busy);
    assert_eq!(host.board.candidate(), None);
    try_other(&mut host);
}

#[test]
fn only_what_flies_alone_is_accepted() {
    let mut host = armed();
    let phases = [TrialPhase::None, TrialPhase::Shadow, TrialPhase::FadingIn, TrialPhase::FadingOut];
    for trial in phases {
        host.now.status.trial = trial;
        assert_eq!(refusal(host.say(ToBoard::Accept(NONCE))), Refusal::NothingToAccept, "{trial:?}");
    }
}

/// A `Disarm` forgets what waits: the board knows that nothing is tried.
#[test]
fn what_a_disarming_forgot_is_not_under_way() {
    let mut host = armed();
    try_other(&mut host);
    host.now.takes_candidate = false;
    assert_eq!(host.say(ToBoard::Disarm), Action::Disarm);
    host.now = IDLE;
    reads_back(&mut host, &parameters());
    host.now.status.armed = true;
    try_other(&mut host);
}

/// What was accepted in flight is not what flew with a record that is written, and goes with it.
#[test]
fn another_record_ends_what_was_accepted() {
    let mut host = armed();
    let tried = try_other(&mut host);
    host.now = IDLE;
    host.now.status.accepted = Some(tried);
    reads_back(&mut host, &with_other());
    assert_eq!(host.board.kept(&parameters(), Ok(())), ToHost::Saved);
    host.now = IDLE;
    reads_back(&mut host, &parameters());
}

#[test]
fn built_in_parameters_are_not_saved_as_the_rigs() {
    let mut host = Host::new(Provenance::Missing);
    assert_eq!(refusal(host.say(ToBoard::Save(NONCE))), Refusal::NoParameters);
}
