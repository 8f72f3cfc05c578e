//! Words that come badly, at every phase of a message, by thousands: no message is dealt with twice, and
//! every `Disarm` said after the last of them is dealt with.

use twinrotor::axes::PerAxis;
use twinrotor::link::ToBoard;
use twinrotor::supervisor::{ArmState, Condition, Request};
use virtual_board::helicopter::Helicopter;
use virtual_board::station::Station;

use super::super::trials::begin_trial;
use super::super::{board_with, flying_with, make_ready};
use super::{FLAWS, built_in};

/// Bad words in each state, unless `TWINROTOR_BAD_WORDS` says otherwise.
const BAD_WORDS: usize = 250;
/// \[ms\] In which a `Disarm` must be dealt with.
const DISARMED_WITHIN: u64 = 20;

fn bad_words() -> usize {
    std::env::var("TWINROTOR_BAD_WORDS").map_or(BAD_WORDS, |n| n.parse().expect("a number"))
}

/// xorshift64.
struct Chance(u64);

impl Chance {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 % limit as u64).expect("below a usize")
    }
}

/// A message with a bad word in it, before it or behind it.
fn disturb(station: &mut Station, chance: &mut Chance) {
    let messages = [
        ToBoard::Identify,
        ToBoard::Alive,
        ToBoard::Setpoint(twinrotor::reference::Reference::at_rest(PerAxis::new(0.12, 0.22))),
        ToBoard::Telemetry { every: 1 },
        ToBoard::Zero,
    ];
    let message = &messages[chance.below(messages.len())];
    let flaw = FLAWS[chance.below(FLAWS.len())];
    station.send_flawed(message, chance.below(50), flaw);
}

/// What was dealt with: each number once at most, and in order.
#[track_caller]
fn nothing_twice(station: &Station, said: usize) {
    assert!(station.heard.identities.len() <= said, "{} answers", station.heard.identities.len());
    let stale = station.heard.health.last().map_or(0, |health| health.messages_stale);
    assert_eq!(stale, 0, "a whole message came twice");
}

#[test]
fn while_disarmed_and_in_a_fault_bad_words_change_nothing() {
    let (rig, parameters) = built_in();
    let mut ready = board_with(&rig, &parameters);
    make_ready(&mut ready);
    let mut fault = flying_with(&rig, &parameters);
    fault.attentive = false;
    fault.run(700);
    fault.machine.rig(|heli: &mut Helicopter| heli.hold());
    for (mut station, state) in
        [(ready, ArmState::Ready), (fault, ArmState::Fault(Condition::CommandTimeout))]
    {
        let mut chance = Chance(0x5EED_0000_0000_0001);
        let (frames, known) = (station.heard.frames.len(), station.heard.identities.len());
        station.attentive = false;
        for _ in 0..bad_words() {
            disturb(&mut station, &mut chance);
            station.run(2);
        }
        station.run(1_000);
        nothing_twice(&station, known + bad_words());
        assert!(station.heard.frames[frames..].iter().all(|frame| frame.state == state), "{state:?}");
        assert_eq!(station.machine.resets(), []);
    }
}

#[test]
fn while_armed_every_disarm_after_the_last_bad_word_is_dealt_with_within_20_ms() {
    disarm_after_bad_words(|_| {});
}

/// The same in the shadow of a trial, which each `Disarm` ends.
#[test]
fn while_a_controller_is_tried_every_disarm_after_the_last_bad_word_is_dealt_with_within_20_ms() {
    disarm_after_bad_words(|station| {
        let (_, parameters) = built_in();
        begin_trial(station, &parameters);
    });
}

/// Whenever it has armed, `first` comes first.
fn disarm_after_bad_words(first: fn(&mut Station)) {
    let (rig, parameters) = built_in();
    let mut station = flying_with(&rig, &parameters);
    first(&mut station);
    let mut chance = Chance(0x5EED_0000_0000_0002);
    let known = station.heard.identities.len();
    let mut words = 0;
    while words < bad_words() {
        let burst = 1 + chance.below(6);
        for _ in 0..burst {
            disturb(&mut station, &mut chance);
            station.run(chance.below(3) as u64);
        }
        words += burst;
        // The last bad word has come: an overrun takes the word behind it too, which is not to be the
        // `Disarm`'s.
        station.run(5);
        assert_eq!(station.heard.state(), Some(ArmState::Armed), "{}", station.heard.summary());
        station.request(Request::Disarm);
        station.run(DISARMED_WITHIN);
        let state = station.heard.state();
        assert_eq!(state, Some(ArmState::Ready), "after {words} words, {}", station.heard.summary());
        station.request(Request::Arm);
        station.await_state(20, ArmState::Armed);
        first(&mut station);
    }
    nothing_twice(&station, known + words);
    assert_eq!(station.machine.resets(), []);
}
