//! Old commands: after a word that came badly nothing is dealt with that was dealt with before.

use twinrotor::axes::PerAxis;
use twinrotor::link::ToBoard;
use twinrotor::supervisor::{ArmState, Condition, Request};
use virtual_board::chip::{Settings, StreamStop};
use virtual_board::machine::Setup;
use virtual_board::serial::Flaw;
use virtual_board::station::Station;

use super::super::{ADDRESS, board_with, firmware, flights_with, image, make_ready, start};
use super::{FLAWS, built_in, driven, states, traced};

/// The control register of the receiver's DMA stream, and what is left of its lap.
const STREAM_CR: u64 = 0x4002_6088;
const STREAM_NDTR: u64 = 0x4002_608C;

fn bad_word(station: &mut Station, flaw: Flaw) {
    station.machine.say_flawed(0x55, flaw);
    station.run(2);
}

/// Says that the host is there until the receiver's place in its ring is just past `place`.
fn alive_until(station: &mut Station, place: u64) {
    for _ in 0..400 {
        let now = station.machine.with(|board| 512 - board.register(STREAM_NDTR));
        if (place..place + 30).contains(&now) {
            return;
        }
        station.send(&ToBoard::Alive);
        station.run(1);
    }
    panic!("the receiver's place never was {place}");
}

/// Nothing but a bad word, then silence: no state changes, no motor turns, nobody is answered.
#[track_caller]
fn changes_nothing(station: &mut Station, flaw: Flaw) {
    let (frames, identities) = (station.heard.frames.len(), station.heard.identities.len());
    let (from, saved) = (traced(station), station.heard.saved);
    let before = station.heard.state();
    bad_word(station, flaw);
    station.run(1_500);
    assert_eq!(states(station, frames), before.into_iter().collect::<Vec<_>>(), "{flaw:?}");
    assert_eq!(driven(station, from), 0, "{flaw:?}");
    assert_eq!((station.heard.identities.len(), station.heard.saved), (identities, saved), "{flaw:?}");
    assert_eq!(station.heard.health.last().expect("a report a second").messages_stale, 0, "{flaw:?}");
}

/// Ready, with [setpoint, `Arm`] in the upper half of the ring, flown, and disarmed in its lower half.
fn flown_and_disarmed(settings: Settings) -> Station {
    let (rig, parameters) = built_in();
    let setup = Setup::new(firmware()).with_settings(settings).with_image(ADDRESS, image(&[parameters]));
    let mut station = start(setup, &rig);
    make_ready(&mut station);
    station.attentive = false;
    alive_until(&mut station, 290);
    station.aim(PerAxis::new(0.3, 0.8));
    station.request(Request::Arm);
    station.await_state(20, ArmState::Armed);
    alive_until(&mut station, 20);
    station.request(Request::Disarm);
    station.run(5_000);
    assert_eq!(station.heard.state(), Some(ArmState::Ready), "{}", station.heard.summary());
    station
}

#[test]
fn a_bad_word_long_after_a_disarm_arms_nothing_whatever_a_stopped_stream_does() {
    for stream_stop in StreamStop::READINGS {
        let mut station = flown_and_disarmed(Settings { stream_stop, ..Settings::default() });
        for flaw in FLAWS {
            changes_nothing(&mut station, flaw);
        }
    }
}

#[test]
fn a_bad_word_after_the_host_has_gone_leaves_the_fault_as_it_is() {
    let (rig, parameters) = built_in();
    for mut station in flights_with(&rig, &parameters) {
        station.attentive = false;
        station.run(700);
        assert_eq!(station.heard.state(), Some(ArmState::Fault(Condition::CommandTimeout)));
        station.machine.rig(|heli: &mut virtual_board::helicopter::Helicopter| heli.hold());
        for flaw in FLAWS {
            changes_nothing(&mut station, flaw);
        }
    }
}

#[test]
fn noise_does_not_stand_in_for_the_host() {
    let (rig, parameters) = built_in();
    for flaw in FLAWS {
        for mut station in flights_with(&rig, &parameters) {
            station.attentive = false;
            for _ in 0..3 {
                bad_word(&mut station, flaw);
                station.run(248);
            }
            let state = station.heard.state();
            assert_eq!(state, Some(ArmState::Fault(Condition::CommandTimeout)), "{flaw:?}");
        }
    }
}

#[test]
fn a_bad_word_brings_no_old_setpoint_back() {
    let (rig, parameters) = built_in();
    for mut station in flights_with(&rig, &parameters) {
        alive_until(&mut station, 300);
        station.aim(PerAxis::new(0.3, -1.0));
        station.run(100);
        alive_until(&mut station, 20);
        station.aim(PerAxis::new(0.1, 0.2));
        station.run(5_000);
        for flaw in FLAWS {
            bad_word(&mut station, flaw);
            station.run(1_000);
        }
        let after = station.heard.frames.last().expect("frames");
        let away = after.reference.minus(PerAxis::new(0.1, 0.2));
        assert!(away.pitch.abs() < 0.001 && away.yaw.abs() < 0.001, "{:?}", after.reference);
        assert_eq!(after.state, ArmState::Armed);
    }
}

#[test]
fn every_message_after_a_bad_word_is_heard_and_none_before_it_again() {
    let (rig, parameters) = built_in();
    for stream_stop in StreamStop::READINGS {
        let settings = Settings { stream_stop, ..Settings::default() };
        let setup = Setup::new(firmware()).with_settings(settings).with_image(ADDRESS, image(&[parameters]));
        let mut station = start(setup, &rig);
        station.attentive = false;
        station.run(100);
        for flaw in FLAWS {
            for _ in 0..70 {
                station.send(&ToBoard::Identify);
                station.run(3);
            }
            bad_word(&mut station, flaw);
            let known = station.heard.identities.len();
            station.run(200);
            assert_eq!(station.heard.identities.len(), known, "{flaw:?}: nothing was said");
            for _ in 0..10 {
                station.send(&ToBoard::Identify);
                station.run(5);
            }
            assert_eq!(station.heard.identities.len() - known, 10, "{flaw:?}, {stream_stop:?}");
        }
    }
}

#[test]
fn a_stream_that_a_bus_error_ends_is_started_again_and_hands_out_nothing_old() {
    let (rig, parameters) = built_in();
    for stream_stop in StreamStop::READINGS {
        let settings = Settings { stream_stop, ..Settings::default() };
        let setup = Setup::new(firmware()).with_settings(settings).with_image(ADDRESS, image(&[parameters]));
        let mut station = start(setup, &rig);
        station.attentive = false;
        station.run(100);
        for _ in 0..70 {
            station.send(&ToBoard::Identify);
            station.run(3);
        }
        let known = station.heard.identities.len();
        station.machine.with(|board| {
            let control = u32::try_from(board.register(STREAM_CR)).expect("32 bits");
            board.poke(STREAM_CR, control & !1);
        });
        station.run(100);
        assert_eq!(station.heard.identities.len(), known, "{stream_stop:?}");
        for _ in 0..10 {
            station.send(&ToBoard::Identify);
            station.run(5);
        }
        assert_eq!(station.heard.identities.len() - known, 10, "{stream_stop:?}");
    }
}

#[test]
fn no_message_is_lost_on_a_busy_line() {
    let (rig, parameters) = built_in();
    let mut station = board_with(&rig, &parameters);
    station.attentive = false;
    station.run(100);
    let known = station.heard.identities.len();
    for nth in 0..500_usize {
        station.send(&ToBoard::Identify);
        station.machine.say(&vec![0; nth % 37]);
        station.run(3);
    }
    station.run(20);
    assert_eq!(station.heard.identities.len() - known, 500);
}
