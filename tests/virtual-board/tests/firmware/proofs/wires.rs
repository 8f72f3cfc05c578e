//! Wires that are cut, and what else a board cannot see without help.

use twinrotor::axes::PerAxis;
use twinrotor::plant::presets;
use twinrotor::supervisor::{ArmState, Condition, Request};
use virtual_board::chip::timer::Drive;
use virtual_board::firmware::Firmware;
use virtual_board::machine::{Live, Setup};
use virtual_board::record::{ADDRESS, image, paper_parameters};
use virtual_board::station::Station;

use super::super::{board_with, firmware, flights, make_ready, start};
use super::built_in;

/// `PUPDR` of port A: two bits a pin, 1 is up.
const GPIOA_PUPDR: u64 = 0x4002_000C;
const SERIAL_IN: u32 = 3;
/// Port C, pin 3.
const FAULT_WIRE: (usize, u8) = (2, 3);

/// The wire hangs in the air for `milliseconds`.
fn cut(station: &mut Station, (port, pin): (usize, u8), milliseconds: u64) {
    for _ in 0..milliseconds {
        station.machine.with(move |board: &mut Live<'_>| {
            let (at, _) = board.now();
            board.board().chip().drive_pin(at, port, pin, None);
        });
        station.run(1);
    }
}

#[test]
fn a_cut_fault_wire_reads_as_a_fault() {
    for mut station in flights() {
        cut(&mut station, FAULT_WIRE, 30);
        assert_eq!(station.heard.state(), Some(ArmState::Fault(Condition::CurrentLimit)));
    }
}

#[test]
fn a_serial_cable_that_is_pulled_leaves_a_quiet_line() {
    let (rig, parameters) = built_in();
    let mut station = board_with(&rig, &parameters);
    station.run(100);
    let pulls = station.machine.with(|board| board.register(GPIOA_PUPDR)) >> (2 * SERIAL_IN) & 3;
    assert_eq!(pulls, 1, "a pull-up at the serial input");
}

#[test]
fn a_stopped_cycle_counter_does_not_hide_a_tick_that_was_left_out() {
    for mut station in flights() {
        // A probe that detaches clears DEMCR.TRCENA: the core's counter reads the same for ever.
        station.machine.with(|board| board.poke(0xE000_EDFC, 0));
        station.run(100);
        assert_eq!(station.heard.state(), Some(ArmState::Armed));
        station.machine.with(|board| board.stall(3));
        station.run(50);
        assert_eq!(station.heard.state(), Some(ArmState::Fault(Condition::TickOverrun)));
    }
}

#[test]
fn a_board_counts_its_ticks_time_without_the_cores_counter() {
    let (rig, parameters) = built_in();
    let mut station = board_with(&rig, &parameters);
    station.machine.with(|board| board.poke(0xE000_EDFC, 0));
    make_ready(&mut station);
    station.run(1_100);
    let cycles = station.heard.health.last().expect("a report a second").tick_cycles_max;
    // The instructions of a tick and the bus: never none, and far below a millisecond.
    assert!((300..20_000).contains(&cycles), "{cycles} cycles");
}

/// The largest share of a period for which any half bridge was high, in a step that asks for all the volts.
fn highest(firmware: Firmware) -> f64 {
    let rig = presets::PAPER;
    let setup = Setup::new(firmware).with_image(ADDRESS, image(&[paper_parameters(&rig)]));
    let mut station = start(setup, &rig);
    make_ready(&mut station);
    station.aim(PerAxis::new(0.1, 0.2));
    station.request(Request::Arm);
    station.run(1_500);
    assert_eq!(station.heard.state(), Some(ArmState::Armed));
    for goal in [PerAxis::new(0.5, 1.5), PerAxis::new(-0.4, -1.0)] {
        station.aim(goal);
        station.run(1_500);
    }
    let (trace, _) = station.machine.trace();
    let shares = trace.iter().flat_map(|outputs| outputs.legs.as_flattened().to_vec());
    shares.filter_map(Drive::share_high).fold(0.0, f64::max)
}

/// A bootstrap's 3 % of each period, 1.5 us: the released firmware takes the whole supply where it is asked
/// for.
#[test]
fn a_build_for_bootstrapped_bridges_leaves_each_time_to_charge() {
    let limited = highest(Firmware::bootstrap().unwrap_or_else(|why| panic!("{why}")));
    assert!((0.95..0.9701).contains(&limited), "{limited}");
    assert!(highest(firmware()) > 0.99);
}
