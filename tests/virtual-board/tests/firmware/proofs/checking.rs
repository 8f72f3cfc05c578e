//! Every hazard of the table that can come while the first-power check turns a motor: the fault has its
//! name, and the motors are off at most two ticks later, as in flight.

use twinrotor::axes::PerMotor;
use twinrotor::first_power::Verdict;
use twinrotor::link::ToBoard;
use twinrotor::monitor::CURRENT_TICKS;
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets;
use twinrotor::supervisor::{ArmState, Condition, Request};
use virtual_board::helicopter::Helicopter;
use virtual_board::record::{paper_parameters, tuned};
use virtual_board::station::Station;

use super::super::boot::check;
use super::super::conditions::{
    SLOW_CHANGES, change_supply, expect_of, fault, ticks_to_off, with_board, with_rig,
};
use super::super::{board_with, rest};

/// A board whose check is turning the main motor, and which reports every tick.
#[track_caller]
fn checking() -> Station {
    checking_with(paper_parameters(&presets::AERO))
}

#[track_caller]
fn checking_with(parameters: Parameters) -> Station {
    let mut station = asked_to_check(parameters);
    let turns = station.machine.run_until(4_000, |board| board.outputs().live());
    assert!(turns, "{}", station.heard.summary());
    station.run(20);
    assert_eq!(station.heard.state(), Some(ArmState::Checking));
    station
}

#[track_caller]
fn asked_to_check(parameters: Parameters) -> Station {
    let mut station = board_with(&presets::AERO, &Parameters { checked: false, ..parameters });
    rest(&mut station);
    station.send(&ToBoard::Zero);
    station.send(&ToBoard::Telemetry { every: 1 });
    station.run(50);
    station.request(Request::Check);
    station.await_state(20, ArmState::Checking);
    station
}

#[test]
fn every_hazard_ends_a_check() {
    type Act = fn(&mut Station);
    let hazards: [(Condition, u32, Act); 9] = [
        (Condition::EmergencyStop, 1, |s| with_rig(s, |heli| heli.press(true, false))),
        (Condition::CurrentLimit, CURRENT_TICKS, |s| with_rig(s, |heli| heli.press(false, true))),
        (Condition::SupplyJump, 2, |s| with_rig(s, |heli| heli.set_supply(5.0))),
        // ADC1_CR2, then TIM2_CR1: off.
        (Condition::SensorStale, 2, |s| with_board(s, |board| board.poke(0x4001_2008, 0))),
        (Condition::SensorStale, 2, |s| with_board(s, |board| board.poke(0x4000_0000, 0))),
        (Condition::PitchJump, 1, |s| with_rig(s, |heli| heli.faults().slip.pitch = 100)),
        (Condition::YawJump, 1, |s| with_rig(s, |heli| heli.faults().slip.yaw = -100)),
        (Condition::TickOverrun, 5, |s| with_board(s, |board| board.stall(3))),
        (Condition::CommandTimeout, 600, |s| s.attentive = false),
    ];
    for (cause, within, hazard) in hazards {
        expect_of(&mut checking(), cause, within, hazard);
    }
}

#[test]
fn a_supply_that_sinks_or_rises_out_of_its_range_ends_a_check() {
    for (factor, last) in SLOW_CHANGES {
        change_supply(&mut checking(), factor, last);
    }
}

#[test]
fn a_rate_and_an_angle_beyond_the_envelope_end_a_check() {
    let mut slow = paper_parameters(&presets::AERO);
    slow.limits.rate.pitch = 2.0;
    // Three counts a millisecond are 6.5 rad/s.
    expect_of(&mut checking_with(slow), Condition::RateEnvelope, 100, |station| {
        with_rig(station, |heli| heli.faults().drift.pitch = 3);
    });
    // One is 2.2 rad/s: 40 degrees take a third of a second, in which the push has ended.
    expect_of(&mut checking(), Condition::AngleEnvelope, 450, |station| {
        with_rig(station, |heli| heli.faults().drift.pitch = 1);
    });
}

#[test]
fn a_number_that_is_none_ends_a_check() {
    // Thrust beyond every number, against as much: an observer believes in none as soon as a motor has volts.
    let (_, mut wild) = tuned("aero");
    let model = &mut wild.settings.model;
    (model.effectiveness.main_on_pitch, model.quadratic_effectiveness.main_on_pitch) = (3e38, -3e38);
    model.rotor_time_constant = PerMotor::zero();
    assert!(wild.settings.controller.estimator.uses_model());
    let mut station = asked_to_check(wild);
    station.run(4_000);
    let (tick, cause) = fault(&station);
    assert_eq!(cause, Condition::NonFinite);
    let late = ticks_to_off(&mut station, tick);
    assert!(late <= 2, "{late} ticks from detection to motors off");
    let turned = station.machine.trace().0.iter().filter(|outputs| outputs.live()).count();
    assert!((1..=3).contains(&turned), "for {turned} ms");
}

/// The motion rules belong to the law's flight. In the check, whose pushes are what the encoders are to show,
/// the verdict is what finds them. Every such fault on every preset is tried in the core's own tests.
#[test]
fn no_check_passes_with_an_encoder_that_is_stuck_or_reversed() {
    let spoilt: [fn(&mut Helicopter); 4] = [
        |heli| heli.faults().encoder_stuck.pitch = true,
        |heli| heli.faults().encoder_reversed.yaw = true,
        |heli| heli.faults().encoder_stuck.yaw = true,
        |heli| heli.faults().encoder_reversed.pitch = true,
    ];
    for (nth, spoil) in spoilt.into_iter().enumerate() {
        let (verdict, mut station) = check(spoil);
        assert_ne!(verdict, Verdict::Passed, "{nth}");
        assert_eq!(station.heard.state(), Some(ArmState::Disarmed), "{nth}");
        assert!(station.heard.conditions().contains(&Condition::NotChecked), "{nth}");
        assert!(!station.machine.outputs().enabled, "{nth}");
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
