//! The released firmware, unmodified, on the virtual board.

mod boot;
mod conditions;
mod equality;
mod noise;
mod parameters;
mod power_cuts;
mod resets;
mod timing;

use std::sync::OnceLock;

use twinrotor::axes::PerAxis;
use twinrotor::control_loop::Wish;
use twinrotor::first_power::STILL_TICKS;
use twinrotor::gains::PAPER;
use twinrotor::link::ToBoard;
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{MAX_PAYLOAD, SLOT_SIZE, Store};
use twinrotor::parameters::{Parameters, SAMPLE_TIME};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{self, Rig};
use twinrotor::supervisor::{Request, State};
use virtual_board::firmware::Firmware;
use virtual_board::helicopter::Helicopter;
use virtual_board::machine::{Machine, Setup};
use virtual_board::station::Station;

/// Where the parameter sectors begin.
const PARAMETERS: u64 = 0x0800_4000;

fn firmware() -> Firmware {
    static RELEASED: OnceLock<Firmware> = OnceLock::new();
    RELEASED.get_or_init(|| Firmware::released().unwrap_or_else(|why| panic!("{why}"))).clone()
}

/// The paper's controller for `rig`, its wiring checked.
fn parameters(rig: &Rig) -> Parameters {
    let settings = Settings::paper(rig, PAPER, SAMPLE_TIME);
    Parameters { checked: true, ..Parameters::new(rig, &settings) }
}

/// The parameter sectors with these records saved in turn.
fn image(records: &[Parameters]) -> Vec<u8> {
    let mut store = Store::new(RamFlash::default(), 0);
    for record in records {
        let mut buffer = [0; MAX_PAYLOAD];
        let bytes = record.encode(&mut buffer).expect("it has room");
        store.save(bytes, &mut [0; SLOT_SIZE]).expect("a flash that never fails");
    }
    store.into_flash().bytes().to_vec()
}

/// A board at `rig`, just switched on, with `parameters` in its flash.
fn board_with(rig: &Rig, parameters: &Parameters) -> Station {
    let setup = Setup::new(firmware()).with_image(PARAMETERS, image(&[*parameters]));
    start(setup, rig)
}

/// A board as `setup` has it, at `rig`.
fn start(setup: Setup, rig: &Rig) -> Station {
    let supply = rig.volts_limit.main.max(rig.volts_limit.tail);
    Station::new(Machine::start(setup, Helicopter::new(rig, supply)))
}

/// Lets the rig lie for as long as it must before it may be zeroed.
#[track_caller]
fn rest(station: &mut Station) {
    station.run(u64::from(STILL_TICKS) + 100);
}

/// Lets a board with good parameters boot, and zeroes it where it rests.
#[track_caller]
fn make_ready(station: &mut Station) {
    rest(station);
    station.send(&ToBoard::Control(Wish::Zero));
    station.await_state(200, State::Ready);
}

/// A board at the paper's rig that reports every tick, holding the step's end after it flew it.
#[track_caller]
fn flying() -> Station {
    let mut station = board_with(&presets::PAPER, &parameters(&presets::PAPER));
    make_ready(&mut station);
    station.aim(PerAxis::new(0.1, 0.2));
    station.request(Request::Arm);
    station.await_state(100, State::Armed);
    station.run(1500);
    station.send(&ToBoard::Telemetry { every: 1 });
    station.run(100);
    assert_eq!(station.heard.state(), Some(State::Armed), "{}", station.heard.summary());
    station
}
