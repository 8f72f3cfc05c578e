//! What ends the firmware against its will: the amplifiers go off first, and the next boot says why.

use rigless::device::ResetCause;
use twinrotor::link::ToBoard;
use twinrotor::plant::presets;
use twinrotor::supervisor::{ArmState, Condition, Request};
use twinrotor::telemetry::InForce;
use virtual_board::helicopter::Helicopter;
use virtual_board::machine::{Live, Setup};
use virtual_board::station::Station;

use super::{ADDRESS, firmware, flights, image, paper_parameters, rest, start};

/// Where the vector table lies.
const VECTORS: u64 = 0x0800_0000;

/// Brings an end about; answers how long the motors then stayed alive \[ms\].
#[track_caller]
fn end(station: &mut Station, act: impl FnOnce(&mut Live<'_>) + Send + 'static) -> u64 {
    let (began, _) = station.machine.now();
    station.attentive = false;
    station.machine.with(act);
    station.run(300);
    let (trace, _) = station.machine.trace();
    let last = trace.iter().rfind(|outputs| outputs.enabled || outputs.live());
    last.map_or(0, |outputs| outputs.at.0.saturating_sub(began.0)) / 1_000_000
}

#[track_caller]
fn assert_reported(station: &mut Station, cause: Condition) {
    let reset = station.heard.identities.last().and_then(|identity| identity.reset);
    assert_eq!(reset.map(|reset| reset.cause), Some(cause), "{:?}", station.machine.resets());
    assert_eq!(station.heard.state(), Some(ArmState::Fault(cause)), "and it is latched as a fault");
    let controller = station.heard.frames.last().map(|frame| frame.controller);
    assert_eq!(controller, Some(InForce::default()), "no trial outlives a reset");
    station.attentive = true;
    station.machine.rig(|helicopter: &mut Helicopter| helicopter.hold());
    station.request(Request::ClearFault);
    rest(station);
    station.send(&ToBoard::Zero);
    station.await_state(500, ArmState::Ready);
}

#[test]
fn a_stalled_loop_ends_at_the_watchdog_within_20_ms() {
    for mut station in flights() {
        // TIM1_CR1: the counter stops, and with it the tick.
        let alive = end(&mut station, |board| board.poke(0x4001_0000, 0));
        assert!(alive <= 20, "{alive} ms");
        assert_reported(&mut station, Condition::ResetByWatchdog);
    }
}

#[test]
fn a_stuck_core_ends_at_the_watchdog_within_20_ms() {
    for mut station in flights() {
        let alive = end(&mut station, |board| board.stall(100));
        assert!(alive <= 20, "{alive} ms");
        assert_eq!(station.machine.resets().len(), 1);
    }
}

#[test]
fn a_fault_exception_switches_off_and_says_where() {
    for mut station in flights() {
        // The tick's next access to its timer is answered with a bus error.
        let alive = end(&mut station, |board| board.fail_next(0x4001_0000));
        assert!(alive <= 2, "{alive} ms");
        let reset = station.heard.identities.last().and_then(|identity| identity.reset).expect("a reset");
        let place = firmware().locate(u64::from(reset.program_counter));
        assert!(!place.starts_with("0x"), "{place} is no place in the firmware");
        assert!(reset.ticks > 1_000, "{reset:?}");
        assert_reported(&mut station, Condition::ResetByFault);
    }
}

#[test]
fn a_brown_out_switches_off_before_the_supply_is_gone() {
    for mut station in flights() {
        let alive = end(&mut station, |board| {
            let (at, _) = board.now();
            board.board().chip().set_rail(at, 2_700);
        });
        assert!(alive <= 2, "{alive} ms");
        station.machine.with(|board| {
            let (at, _) = board.now();
            board.board().chip().set_rail(at, 3_300);
        });
        station.run(300);
        let reset = station.heard.identities.last().and_then(|identity| identity.reset);
        assert_eq!(reset.map(|reset| reset.cause), Some(Condition::ResetByBrownOut));
    }
}

#[test]
fn a_stack_that_overflows_faults_and_is_reported() {
    let rig = presets::PAPER;
    let setup = Setup {
        protects_memory: true,
        refusals_allowed: true,
        ..Setup::new(firmware()).with_image(ADDRESS, image(&[paper_parameters(&rig)]))
    };
    let mut station = start(setup, &rig);
    station.run(100);
    // The vector table's first word is where the stack begins: at the next reset, a fraction of what it
    // needs. Once that has ended it, the word is put right again.
    station.machine.with(|board| {
        let low = u32::try_from(board.symbol("_stack_end")).expect("32 bits");
        board.replace_flash(VECTORS, &(low + 0x700).to_le_bytes());
        board.cut_power();
    });
    let overflowed = station.machine.run_until(100, |board| {
        let ended = board.resets().iter().any(|reset| reset.cause == ResetCause::Core);
        if ended {
            let high = u32::try_from(board.symbol("_stack_start")).expect("32 bits");
            board.replace_flash(VECTORS, &high.to_le_bytes());
        }
        ended
    });
    assert!(overflowed, "{:?}", station.machine.resets());
    station.run(200);
    let (trace, _) = station.machine.trace();
    assert!(trace.iter().all(|outputs| !outputs.enabled));
    assert_reported(&mut station, Condition::ResetByStackOverflow);
}

/// Where the registers of a floating-point unit are put late, at the first instruction that needs them
/// (ARMv7-M reference manual, B1.5.7, B3.2.23).
const FPCAR: u32 = 0xE000_EF38;

/// A handler that sends the registers to `address`: MOVW and MOVT of r0 and r1, STR r1, [r0], VMOV s0, s0,
/// B . (A7.7.76, A7.7.79, A7.7.161, A7.7.240, A7.7.12).
fn saves_registers_at(address: u32) -> Vec<u8> {
    let half = |register: u32, value: u32, opcode: u32| {
        let (i, imm4, imm3, imm8) = (value >> 11 & 1, value >> 12, value >> 8 & 7, value & 0xFF);
        [opcode | i << 10 | imm4, imm3 << 12 | register << 8 | imm8]
    };
    let word = |register, value: u32| {
        [half(register, value & 0xFFFF, 0xF240), half(register, value >> 16, 0xF2C0)].concat()
    };
    let code = [word(0, FPCAR), word(1, address), vec![0x6001, 0xEEB0, 0x0A40, 0xE7FE]].concat();
    code.iter().flat_map(|&half| u16::try_from(half).expect("16 bits").to_le_bytes()).collect()
}

/// The floating-point registers of an interrupt are stacked late, and may meet the guard then: that is the
/// stack's overflow too, and no fault of the instruction's. Of the emergency stop's interrupt,
/// whose code another takes the place of.
#[test]
fn registers_that_cannot_be_stacked_late_are_an_overflow() {
    let rig = presets::PAPER;
    let guard = u32::try_from(firmware().address("_stack_end").expect("a stack")).expect("32 bits");
    let setup = Setup {
        protects_memory: true,
        refusals_allowed: true,
        ..Setup::new(firmware()).with_image(ADDRESS, image(&[paper_parameters(&rig)]))
    };
    let mut station = start(setup, &rig);
    station.run(100);
    station.machine.with(move |board| {
        board.replace_flash(board.symbol("EXTI15_10"), &saves_registers_at(guard));
    });
    station.machine.rig(|heli: &mut Helicopter| heli.press(true, false));
    station.run(5);
    station.machine.rig(|heli: &mut Helicopter| heli.press(false, false));
    station.run(300);
    assert_reported(&mut station, Condition::ResetByStackOverflow);
}
