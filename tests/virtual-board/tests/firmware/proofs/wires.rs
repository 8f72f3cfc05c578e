//! Wires that are cut, and what else a board cannot see without help.

use twinrotor::supervisor::{ArmState, Condition};
use virtual_board::machine::Live;
use virtual_board::station::Station;

use super::super::{board_with, flying, make_ready};
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
    let mut station = flying();
    cut(&mut station, FAULT_WIRE, 30);
    assert_eq!(station.heard.state(), Some(ArmState::Fault(Condition::CurrentLimit)));
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
    let mut station = flying();
    // A probe that detaches clears DEMCR.TRCENA: the core's counter reads the same for ever.
    station.machine.with(|board| board.poke(0xE000_EDFC, 0));
    station.run(100);
    assert_eq!(station.heard.state(), Some(ArmState::Armed));
    station.machine.with(|board| board.stall(3));
    station.run(50);
    assert_eq!(station.heard.state(), Some(ArmState::Fault(Condition::TickOverrun)));
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
