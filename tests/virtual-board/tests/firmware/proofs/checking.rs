//! Every hazard of the table that can come while the first-power check turns a motor: the fault has its
//! name, and the motors are off at most two ticks later, as in flight.

use twinrotor::link::ToBoard;
use twinrotor::monitor::CURRENT_TICKS;
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets;
use twinrotor::supervisor::{ArmState, Condition, Request};
use virtual_board::helicopter::Helicopter;
use virtual_board::record::paper_parameters;
use virtual_board::station::Station;

use super::super::conditions::{expect_of, with_board, with_rig};
use super::super::{board_with, rest};

/// A board whose check is turning the main motor, and which reports every tick.
#[track_caller]
fn checking() -> Station {
    let rig = presets::AERO;
    let mut unchecked = Parameters { checked: false, ..paper_parameters(&rig) };
    // Three counts a millisecond are 6.5 rad/s.
    unchecked.limits.rate.pitch = 2.0;
    let mut station = board_with(&rig, &unchecked);
    rest(&mut station);
    station.send(&ToBoard::Zero);
    station.send(&ToBoard::Telemetry { every: 1 });
    station.run(50);
    station.request(Request::Check);
    station.await_state(20, ArmState::Checking);
    let turns = station.machine.run_until(4_000, |board| board.outputs().live());
    assert!(turns, "{}", station.heard.summary());
    station.run(20);
    assert_eq!(station.heard.state(), Some(ArmState::Checking));
    station
}

#[test]
fn every_hazard_ends_a_check() {
    type Act = fn(&mut Station);
    let hazards: [(Condition, u32, Act); 10] = [
        (Condition::EmergencyStop, 1, |s| with_rig(s, |heli| heli.press(true, false))),
        (Condition::CurrentLimit, CURRENT_TICKS, |s| with_rig(s, |heli| heli.press(false, true))),
        (Condition::SupplyJump, 2, |s| with_rig(s, |heli| heli.set_supply(5.0))),
        // ADC1_CR2, then TIM2_CR1: off.
        (Condition::SensorStale, 2, |s| with_board(s, |board| board.poke(0x4001_2008, 0))),
        (Condition::SensorStale, 2, |s| with_board(s, |board| board.poke(0x4000_0000, 0))),
        (Condition::PitchJump, 1, |s| with_rig(s, |heli| heli.faults().slip.pitch = 100)),
        (Condition::YawJump, 1, |s| with_rig(s, |heli| heli.faults().slip.yaw = -100)),
        (Condition::RateEnvelope, 100, |s| with_rig(s, |heli| heli.faults().drift.pitch = 3)),
        (Condition::TickOverrun, 5, |s| with_board(s, |board| board.stall(3))),
        (Condition::CommandTimeout, 600, |s| s.attentive = false),
    ];
    for (cause, within, hazard) in hazards {
        expect_of(&mut checking(), cause, within, hazard);
    }
}

#[test]
fn a_stack_that_is_nearly_used_up_ends_a_check_and_is_not_forgotten() {
    let mut station = checking();
    expect_of(&mut station, Condition::StackGuard, 1_100, |station| {
        with_board(station, |board| {
            let low = board.symbol("_stack_end") + 256;
            board.set_word(low + 64, 0);
        });
    });
    station.machine.rig(|heli: &mut Helicopter| heli.hold());
    station.request(Request::ClearFault);
    station.run(1_500);
    assert_eq!(station.heard.state(), Some(ArmState::Fault(Condition::StackGuard)), "until the next reset");
}
