//! The released firmware, unmodified, on the virtual board.

mod boot;
mod conditions;
mod equality;
mod listen;
mod noise;
mod parameters;
mod power_cuts;
mod proofs;
mod recorded;
mod replay;
mod resets;
mod simulated;
mod state_space;
mod timing;
mod trials;

use std::sync::OnceLock;

use twinrotor::axes::PerAxis;
use twinrotor::first_power::REST_TICKS;
use twinrotor::link::ToBoard;
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets::{self, Rig};
use twinrotor::supervisor::{ArmState, Request};
use virtual_board::firmware::Firmware;
use virtual_board::helicopter::Helicopter;
use virtual_board::machine::{Machine, Setup};
use virtual_board::record::{self, ADDRESS, image, paper_parameters};
use virtual_board::station::Station;

fn firmware() -> Firmware {
    static RELEASED: OnceLock<Firmware> = OnceLock::new();
    RELEASED.get_or_init(|| Firmware::released().unwrap_or_else(|why| panic!("{why}"))).clone()
}

/// A board at `rig`, just switched on, with `parameters` in its flash.
fn board_with(rig: &Rig, parameters: &Parameters) -> Station {
    let setup = Setup::new(firmware()).with_image(ADDRESS, image(&[*parameters]));
    start(setup, rig)
}

/// A board as `setup` has it, at `rig`.
fn start(setup: Setup, rig: &Rig) -> Station {
    Station::new(Machine::switch_on(setup, connected(rig)))
}

/// `rig`, with the supply that it wants.
fn connected(rig: &Rig) -> Helicopter {
    Helicopter::new(rig, rig.volts_limit.main.max(rig.volts_limit.tail))
}

/// Lets the rig lie for as long as it must before it may be zeroed.
#[track_caller]
fn rest(station: &mut Station) {
    station.run(u64::from(REST_TICKS) + 100);
}

/// Lets a board with good parameters boot, and zeroes it where it rests.
#[track_caller]
fn make_ready(station: &mut Station) {
    rest(station);
    station.send(&ToBoard::Zero);
    station.await_state(200, ArmState::Ready);
}

/// What the tests fly: the paper's law on the paper's rig, and the controller that the firmware has built in
/// on its rig.
fn both() -> [(Rig, Parameters); 2] {
    [(presets::PAPER, paper_parameters(&presets::PAPER)), record::tuned(record::BUILT_IN)]
}

/// A board with the paper's law at the paper's rig that reports every tick, holding the step's end after it
/// flew it.
#[track_caller]
fn flying() -> Station {
    let [(rig, parameters), _] = both();
    flying_with(&rig, &parameters)
}

/// The same with `parameters` at `rig`.
#[track_caller]
fn flying_with(rig: &Rig, parameters: &Parameters) -> Station {
    let mut station = board_with(rig, parameters);
    make_ready(&mut station);
    station.aim(PerAxis::new(0.1, 0.2));
    station.request(Request::Arm);
    station.await_state(100, ArmState::Armed);
    station.run(1500);
    station.send(&ToBoard::Telemetry { every: 1 });
    station.run(100);
    assert_eq!(station.heard.state(), Some(ArmState::Armed), "{}", station.heard.summary());
    station
}

/// A flight with the paper's law, then one in which another controller than the built-in one is being tried:
/// whatever may happen in the one may in the other.
fn flights() -> impl Iterator<Item = Station> {
    [flying as fn() -> Station, trials::trying].into_iter().map(|take_off| take_off())
}

/// The same two with `parameters` at `rig`.
fn flights_with<'a>(rig: &'a Rig, parameters: &'a Parameters) -> impl Iterator<Item = Station> + 'a {
    let both: [fn(&Rig, &Parameters) -> Station; 2] = [flying_with, trials::trying_with];
    both.into_iter().map(move |take_off| take_off(rig, parameters))
}
