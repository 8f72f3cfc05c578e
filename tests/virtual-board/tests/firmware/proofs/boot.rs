//! What a board boots with: a rail that is low, a crystal that is missing, wrong or stops, caches.

use twinrotor::axes::PerAxis;
use twinrotor::link::{Nonce, ToBoard};
use twinrotor::supervisor::{ArmState, Condition, Request};
use virtual_board::chip::{Settings, Tolerance};
use virtual_board::helicopter::Helicopter;
use virtual_board::machine::Setup;
use virtual_board::station::Station;

use super::super::{ADDRESS, firmware, flights_with, image, make_ready, rest, start};
use super::{built_in, trace, traced};

const TOLERANCES: [Tolerance; 3] = [Tolerance::Minimum, Tolerance::Typical, Tolerance::Maximum];

fn board(settings: Settings) -> Station {
    let (rig, parameters) = built_in();
    let setup = Setup::new(firmware()).with_settings(settings).with_image(ADDRESS, image(&[parameters]));
    start(setup, &rig)
}

#[test]
fn boards_of_3_0_and_of_3_3_volts_run_wherever_their_detector_lies() {
    for detector in TOLERANCES {
        for rail_millivolts in [3_000, 3_135, 3_300] {
            let mut station = board(Settings { rail_millivolts, detector, ..Settings::default() });
            make_ready(&mut station);
            assert_eq!(station.machine.resets(), [], "{rail_millivolts} mV, {detector:?}");
        }
    }
}

#[test]
fn a_rail_that_sinks_ends_the_flight_before_the_flash_may_fail_wherever_the_detector_lies() {
    for detector in TOLERANCES {
        let mut station = board(Settings { detector, ..Settings::default() });
        make_ready(&mut station);
        station.request(Request::Arm);
        station.await_state(20, ArmState::Armed);
        let from = traced(&mut station);
        // Every level of the detector, at its lowest, is above the 2.7 V from which words are programmed.
        station.machine.with(|board| {
            let (at, _) = board.now();
            board.board().chip().set_rail(at, 2_740);
        });
        station.run(20);
        let enabled = trace(&mut station, from).iter().rposition(|outputs| outputs.enabled);
        assert!(enabled.is_none_or(|last| last <= 2), "{detector:?}: {enabled:?} ms");
        // Its rail stays low: it does not run, and does not hang.
        station.run(200);
        assert!(trace(&mut station, from + 5).iter().all(|outputs| !outputs.enabled));
    }
}

/// Lit milliseconds of a second, and how often the LED went on.
fn flashes(station: &mut Station) -> usize {
    let from = traced(station);
    station.run(2_000);
    trace(station, from).windows(2).filter(|pair| !pair[0].lit && pair[1].lit).count()
}

#[test]
fn a_missing_or_another_crystal_is_told_by_link_and_led_and_nothing_arms() {
    for crystal_hz in [0, 4_000_000, 12_000_000, 16_000_000, 25_000_000] {
        let mut station = board(Settings { crystal_hz, ..Settings::default() });
        rest(&mut station);
        station.run(200);
        station.send(&ToBoard::Zero);
        station.run(50);
        assert_eq!(station.heard.conditions(), [Condition::ClockFallback], "{crystal_hz} Hz");
        let from = traced(&mut station);
        station.request(Request::Arm);
        station.run(100);
        station.request(Request::Check);
        station.run(100);
        assert_eq!(station.heard.state(), Some(ArmState::Disarmed), "{crystal_hz} Hz");
        assert!(trace(&mut station, from).iter().all(|outputs| !outputs.enabled));
        let flashes = flashes(&mut station);
        assert!((5..=7).contains(&flashes), "three flashes a second: {flashes} in two");
        assert_eq!(station.machine.resets(), []);
        // Parameters may be written all the same, and do not make the board forget.
        let (_, parameters) = built_in();
        station.send(&ToBoard::WriteParameters(Nonce::default(), parameters));
        assert!(station.run_until(2_000, |heard| heard.saved == 1));
        station.run(50);
        assert!(station.heard.conditions().contains(&Condition::ClockFallback));
    }
}

#[test]
fn a_crystal_within_its_tolerance_is_the_boards_clock() {
    for crystal_hz in [7_999_000, 8_001_000] {
        let mut station = board(Settings { crystal_hz, ..Settings::default() });
        make_ready(&mut station);
    }
}

#[test]
fn a_crystal_that_stops_in_flight_ends_it_at_once_and_the_next_boot_says_so() {
    let (rig, parameters) = built_in();
    flights_with(&rig, &parameters).for_each(|mut station| stop_crystal(&mut station));
}

fn stop_crystal(station: &mut Station) {
    let from = traced(station);
    station.attentive = false;
    station.machine.with(|board| board.stop_crystal());
    station.run(600);
    let alive = trace(station, from).iter().rposition(|o| o.live() || o.enabled);
    assert!(alive.is_none_or(|last| last <= 1), "{alive:?} ms");
    let reset = station.heard.identities.last().and_then(|identity| identity.reset).expect("a reset");
    assert_eq!(reset.cause, Condition::ResetByClock);
    assert!(reset.ticks > 1_000);
    assert_eq!(station.heard.state(), Some(ArmState::Fault(Condition::ResetByClock)));
    assert!(station.heard.conditions().contains(&Condition::ClockFallback));
    station.attentive = true;
    station.machine.rig(|heli: &mut Helicopter| heli.hold());
    station.request(Request::ClearFault);
    rest(station);
    station.send(&ToBoard::Zero);
    station.aim(PerAxis::zero());
    station.request(Request::Arm);
    station.run(100);
    assert_eq!(station.heard.state(), Some(ArmState::Disarmed), "without a crystal nothing arms");
}

#[test]
fn caches_are_on_and_serve_no_line_from_before_a_save() {
    const ACR: u64 = 0x4002_3C00;
    const PREFETCH_AND_CACHES: u64 = 0b111 << 8;
    let (_, parameters) = built_in();
    let mut station = board(Settings::default());
    station.run(100);
    let on = |station: &mut Station| station.machine.with(|board| board.register(ACR) & PREFETCH_AND_CACHES);
    assert_eq!(on(&mut station), PREFETCH_AND_CACHES);
    // Through an erase of the next page, and on.
    for nth in 1..=20 {
        station.send(&ToBoard::WriteParameters(Nonce::default(), parameters));
        assert!(station.run_until(2_000, |heard| heard.saved == nth));
        let stale = station.machine.with(|board| board.flash().serves_stale_lines());
        assert_eq!(stale, [false; 2], "save {nth}");
        assert_eq!(on(&mut station), PREFETCH_AND_CACHES, "save {nth}");
    }
}

#[test]
fn the_supply_is_read_right_whatever_the_converters_own_supply_is() {
    for rail_millivolts in [3_000, 3_135, 3_300, 3_500] {
        let mut station = board(Settings { rail_millivolts, ..Settings::default() });
        station.run(200);
        let read = station.heard.frames.last().expect("frames").supply;
        let (rig, _) = built_in();
        let supply = rig.volts_limit.main.max(rig.volts_limit.tail);
        assert!(
            (f64::from(read) / supply - 1.0).abs() < 0.01,
            "{read} V of {supply} V at {rail_millivolts} mV"
        );
    }
}
