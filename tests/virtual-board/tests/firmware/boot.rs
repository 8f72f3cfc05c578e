//! From power-on to the first arming.

use twinrotor::first_power::{Fault, Motor, Verdict};
use twinrotor::link::{ChipSerial, ToBoard};
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets;
use twinrotor::supervisor::{ArmState, Condition, Request};
use virtual_board::helicopter::Helicopter;
use virtual_board::machine::{Machine, SERIAL, Setup};
use virtual_board::record;
use virtual_board::station::Station;

use super::parameters::read;
use super::{board_with, connected, firmware, make_ready, paper_parameters, rest, start};

#[test]
fn an_empty_board_says_who_it_is_and_what_it_lacks_and_will_not_arm() {
    let mut station = start(Setup::new(firmware()), &presets::PAPER);
    station.run(100);
    assert_eq!(
        read(&mut station),
        Parameters { checked: false, ..record::tuned(record::BUILT_IN).1 },
        "what it would fly is tuned"
    );
    let identity = station.heard.identities.first().expect("it introduces itself");
    assert_eq!((identity.chip.as_str(), identity.reset), ("stm32f405rg", None));
    assert_eq!(identity.serial, ChipSerial(SERIAL));
    let lacks = station.heard.conditions();
    for reason in [Condition::ParametersMissing, Condition::NotZeroed, Condition::NotChecked] {
        assert!(lacks.contains(&reason), "{lacks:?}");
    }
    station.request(Request::Arm);
    station.run(100);
    assert_eq!(station.heard.state(), Some(ArmState::Disarmed));
    let (trace, _) = station.machine.trace();
    assert!(trace.iter().all(|outputs| !outputs.live() && !outputs.enabled));
}

#[test]
fn a_board_with_good_parameters_is_ready_once_zeroed() {
    let rig = presets::PAPER;
    let mut station = board_with(&rig, &paper_parameters(&rig));
    station.run(200);
    assert_eq!(station.heard.conditions(), [Condition::NotZeroed]);
    make_ready(&mut station);
    let (trace, _) = station.machine.trace();
    assert!(trace.iter().all(|outputs| !outputs.enabled), "nothing was switched on on the way");
}

/// What the first-power check says of a rig after `spoil` broke it.
#[track_caller]
pub(super) fn check(spoil: fn(&mut Helicopter)) -> (Verdict, Station) {
    let rig = presets::AERO;
    let mut unchecked = paper_parameters(&rig);
    unchecked.checked = false;
    let mut station = board_with(&rig, &unchecked);
    station.machine.rig(move |helicopter: &mut Helicopter| spoil(helicopter));
    rest(&mut station);
    station.send(&ToBoard::Zero);
    station.run(100);
    assert_eq!(station.heard.conditions(), [Condition::NotChecked]);
    station.request(Request::Arm);
    station.run(50);
    assert_eq!(station.heard.state(), Some(ArmState::Disarmed), "unchecked, it does not arm");
    station.request(Request::Check);
    station.await_state(100, ArmState::Checking);
    let ended = station.run_until(60_000, |heard| !heard.verdicts.is_empty());
    assert!(ended, "{}", station.heard.summary());
    station.run(50);
    (station.heard.verdicts[0], station)
}

#[test]
fn the_first_power_check_passes_a_well_wired_rig_and_lets_it_arm() {
    let (verdict, mut station) = check(|_| {});
    assert_eq!(verdict, Verdict::Passed);
    station.await_state(1_000, ArmState::Ready);
}

#[test]
fn the_first_power_check_names_what_is_wired_wrongly() {
    type Case = (fn(&mut Helicopter), Verdict);
    let cases: [Case; 3] = [
        (|heli| heli.faults().motors_swapped = true, Verdict::Wrong(Fault::MotorsSwapped)),
        (|heli| heli.faults().encoder_reversed.yaw = true, Verdict::Wrong(Fault::YawReversed)),
        (
            |heli| {
                heli.faults().encoder_stuck.pitch = true;
                heli.faults().encoder_stuck.yaw = true;
            },
            Verdict::NoMotion { motor: Motor::Main },
        ),
    ];
    for (spoil, expected) in cases {
        let (verdict, station) = check(spoil);
        assert_eq!(verdict, expected);
        assert_ne!(station.heard.state(), Some(ArmState::Ready));
    }
}

#[test]
fn two_runs_are_the_same_to_the_instruction_and_another_seed_changes_no_output() {
    let run = |seed, protects_memory| {
        let rig = presets::PAPER;
        let setup = Setup { protects_memory, ..Setup::new(firmware()).with_seed(seed) };
        let image = super::image(&[paper_parameters(&rig)]);
        let setup = setup.with_image(super::ADDRESS, image);
        let mut station = Station::new(Machine::start(setup, connected(&rig)));
        make_ready(&mut station);
        station.request(Request::Arm);
        station.run(300);
        let (at, instructions) = station.machine.now();
        let compares: Vec<_> = station.machine.trace().0.iter().map(|each| each.compare).collect();
        (at, instructions, compares)
    };
    let first = run(1, false);
    assert_eq!(first, run(1, false));
    assert_eq!(first, run(1, true), "memory protection that nothing violates changes nothing");
    assert_eq!(first.2, run(2, false).2, "what the RAM held at power-on decides nothing");
}
