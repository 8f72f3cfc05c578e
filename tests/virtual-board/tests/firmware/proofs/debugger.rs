//! The build for a debugger: it stands still at a breakpoint, and lets nothing turn. Any other build ends.

use twinrotor::link::ToBoard;
use twinrotor::supervisor::{ArmState, Condition, Request};
use virtual_board::firmware::Firmware;
use virtual_board::machine::Setup;

use super::super::{ADDRESS, board_with, image, rest, start};
use super::built_in;

#[test]
fn a_build_for_a_debugger_outlives_a_breakpoint_and_neither_arms_nor_checks() {
    let firmware = Firmware::for_a_debugger().unwrap_or_else(|why| panic!("{why}"));
    let (rig, parameters) = built_in();
    let mut station = start(Setup::new(firmware).with_image(ADDRESS, image(&[parameters])), &rig);
    rest(&mut station);
    station.send(&ToBoard::Zero);
    station.run(50);
    assert_eq!(station.heard.conditions(), [Condition::DebugBuild]);
    for request in [Request::Arm, Request::Check] {
        station.request(request);
        station.run(50);
        assert_eq!(station.heard.state(), Some(ArmState::Disarmed), "{request:?}");
    }
    station.machine.with(|board| board.halt(500));
    station.run(700);
    assert_eq!(station.machine.resets(), []);
    assert_eq!(station.heard.conditions(), [Condition::DebugBuild]);
    assert!(station.machine.trace().0.iter().all(|outputs| !outputs.enabled));
}

#[test]
fn the_released_build_ends_at_a_breakpoint() {
    let (rig, parameters) = built_in();
    let mut station = board_with(&rig, &parameters);
    station.run(100);
    station.machine.with(|board| board.halt(100));
    station.run(300);
    let reset = station.heard.identities.last().and_then(|identity| identity.reset);
    assert_eq!(reset.map(|reset| reset.cause), Some(Condition::ResetByWatchdog));
}
