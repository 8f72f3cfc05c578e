//! Every hazard, brought about while the motors turn: the fault has its name, comes within the time its rule
//! says, and the motors are off at most two ticks later.

use twinrotor::axes::PerAxis;
use twinrotor::monitor::CURRENT_TICKS;
use twinrotor::plant::presets;
use twinrotor::supervisor::{ArmState, Condition, Request};
use twinrotor::telemetry::InForce;
use virtual_board::helicopter::Helicopter;
use virtual_board::machine::Live;
use virtual_board::record;
use virtual_board::station::Station;

use super::trials::trying_with;
use super::{board_with, both, flights, flights_with, flying_with, make_ready, paper_parameters};

/// The tick in which the fault came, and its cause.
#[track_caller]
pub(super) fn fault(station: &Station) -> (u32, Condition) {
    let found = station.heard.frames.iter().find_map(|frame| match frame.state {
        ArmState::Fault(cause) => Some((frame.tick, cause)),
        _ => None,
    });
    found.unwrap_or_else(|| panic!("no fault: {}", station.heard.summary()))
}

/// Ticks from that of the fault until the motors are off for good: no volts on them, the amplifiers disabled.
pub(super) fn ticks_to_off(station: &mut Station, fault: u32) -> usize {
    let (trace, ticks) = station.machine.trace();
    let last_alive = trace.iter().rfind(|outputs| outputs.enabled || outputs.live());
    let last_alive = last_alive.expect("it was armed").at;
    let until_then = ticks.iter().filter(|tick| tick.at <= last_alive).count();
    // The first tick has number 0, so this many ticks had run when the motors were last seen alive.
    until_then.saturating_sub(fault as usize)
}

/// Brings a hazard about while flying, with the paper's law and while another controller than the built-in
/// one is tried, and checks all that must follow. `within` is its rule's time \[ticks\]. The built-in
/// controller alone meets what can befall a rig in `simulated.rs`.
#[track_caller]
fn expect(cause: Condition, within: u32, hazard: impl Fn(&mut Station)) {
    expect_one(&[cause], within, hazard);
}

/// The same where one of several rules may be first.
#[track_caller]
fn expect_one(causes: &[Condition], within: u32, hazard: impl Fn(&mut Station)) {
    flights().for_each(|mut station| expect_one_of(&mut station, causes, within, &hazard));
}

#[track_caller]
pub(super) fn expect_of(station: &mut Station, cause: Condition, within: u32, hazard: impl Fn(&mut Station)) {
    expect_one_of(station, &[cause], within, hazard);
}

#[track_caller]
fn expect_one_of(station: &mut Station, causes: &[Condition], within: u32, hazard: impl Fn(&mut Station)) {
    let before = station.heard.frames.last().expect("frames").tick;
    hazard(station);
    station.run_until(u64::from(within), |heard| matches!(heard.state(), Some(ArmState::Fault(_))));
    station.run(100);
    let (tick, cause) = fault(station);
    assert!(causes.contains(&cause), "{causes:?} expected: {}", station.heard.summary());
    // Two ticks of grace: one until the rig is looked at, one that the tick takes to tell.
    let taken = tick - before;
    assert!(taken <= within + 2, "{cause:?} came after {taken} ticks, allowed are {within}");
    let late = ticks_to_off(station, tick);
    assert!(late <= 2, "{cause:?}: {late} ticks from detection to motors off");
    station.request(Request::Arm);
    station.run(50);
    // A tick without fresh sensors does not feed the watchdog, which then ends it all.
    let latched = match station.heard.state() {
        Some(ArmState::Fault(Condition::ResetByWatchdog)) => cause == Condition::SensorStale,
        state => state == Some(ArmState::Fault(cause)),
    };
    assert!(latched, "a fault stays until it is cleared: {}", station.heard.summary());
    let last = station.heard.frames.last().expect("frames");
    assert_eq!(last.controller, InForce::default(), "no trial outlives a fault");
}

pub(super) fn with_rig(station: &mut Station, act: impl FnOnce(&mut Helicopter) + Send + 'static) {
    station.machine.rig(act);
}

pub(super) fn with_board(station: &mut Station, act: impl FnOnce(&mut Live<'_>) + Send + 'static) {
    station.machine.with(act);
}

#[test]
fn the_emergency_stop() {
    expect(Condition::EmergencyStop, 1, |station| with_rig(station, |heli| heli.press(true, false)));
}

#[test]
fn the_amplifiers_current_limit() {
    expect(Condition::CurrentLimit, CURRENT_TICKS, |station| {
        with_rig(station, |heli| heli.press(false, true))
    });
}

#[test]
fn a_supply_that_is_read_too_low_or_too_high_at_once() {
    for wrong in [0.5, 5.0, 33.0] {
        // One tick until the converter has the new value.
        expect(Condition::SupplyJump, 2, move |station| {
            with_rig(station, move |heli| heli.set_supply(wrong))
        });
    }
}

#[test]
fn a_supply_that_sinks_or_rises_out_of_its_range() {
    for (factor, last) in SLOW_CHANGES {
        flights().for_each(|mut station| change_supply(&mut station, factor, last));
    }
}

/// Of the supply: the factor of each step, and where it ends \[V\].
pub(super) const SLOW_CHANGES: [(f64, f64); 2] = [(0.95, 15.0), (1.05, 30.0)];

/// No step of it is a jump; the end is out of range.
#[track_caller]
pub(super) fn change_supply(station: &mut Station, factor: f64, last: f64) {
    let mut supply = f64::from(station.heard.frames.last().expect("frames").supply);
    while (supply < last) == (factor > 1.0) {
        supply *= factor;
        with_rig(station, move |heli| heli.set_supply(supply));
        station.run(4);
    }
    station.run(50);
    let (tick, cause) = fault(station);
    assert_eq!(cause, Condition::SupplyRange);
    let late = ticks_to_off(station, tick);
    assert!(late <= 2, "{late} ticks from detection to motors off");
}

#[test]
fn an_encoder_that_jumps() {
    expect(Condition::PitchJump, 1, |station| with_rig(station, |heli| heli.faults().slip.pitch = 100));
    expect(Condition::YawJump, 1, |station| with_rig(station, |heli| heli.faults().slip.yaw = -100));
}

#[test]
fn an_encoder_that_is_stuck_or_swapped_while_the_rig_is_told_to_move() {
    type Case = (&'static [Condition], fn(&mut Helicopter));
    let cases: [Case; 4] = [
        (&[Condition::PitchMotion], |heli| heli.faults().encoder_stuck.pitch = true),
        // It runs away from the goal, and may be at its limit before a disturbance is out of the question.
        (&[Condition::PitchMotion, Condition::AngleEnvelope], |heli| {
            heli.faults().encoder_reversed.pitch = true;
        }),
        (&[Condition::YawMotion], |heli| heli.faults().encoder_stuck.yaw = true),
        (&[Condition::YawMotion], |heli| heli.faults().encoder_reversed.yaw = true),
    ];
    for (causes, spoil) in cases {
        // Twice the second that a rule took which knew of no disturbance (docs/motion-monitor.md).
        expect_one(causes, 2_000, |station| {
            with_rig(station, spoil);
            station.aim(PerAxis::new(-0.3, -1.5));
        });
    }
}

#[test]
fn pitch_beyond_the_envelope() {
    // Four counts a millisecond are 8.7 rad/s, and 40 degrees in 80 ms: more than any rig here can climb.
    expect(Condition::AngleEnvelope, 100, |station| with_rig(station, |heli| heli.faults().drift.pitch = 4));
}

#[test]
fn a_rate_beyond_the_envelope() {
    for (rig, mut parameters) in both() {
        // Three counts a millisecond are 6.5 rad/s; an observer of 8 rad/s takes its time to believe it.
        parameters.limits.rate.pitch = 2.0;
        let station = &mut flying_with(&rig, &parameters);
        expect_of(station, Condition::RateEnvelope, 100, |station| {
            with_rig(station, |heli| heli.faults().drift.pitch = 3)
        });
    }
    let (rig, mut parameters) = record::tuned(record::BUILT_IN);
    parameters.limits.rate.pitch = 2.0;
    expect_of(&mut trying_with(&rig, &parameters), Condition::RateEnvelope, 100, |station| {
        with_rig(station, |heli| heli.faults().drift.pitch = 3)
    });
}

#[test]
fn a_host_that_falls_silent() {
    expect(Condition::CommandTimeout, 600, |station| {
        station.attentive = false;
        // Not yet: half a second is allowed.
        station.run(400);
        assert_eq!(station.heard.state(), Some(ArmState::Armed));
    });
}

#[test]
fn a_converter_that_measures_no_more() {
    // ADC1_CR2: off.
    expect(Condition::SensorStale, 2, |station| with_board(station, |board| board.poke(0x4001_2008, 0)));
}

#[test]
fn an_encoder_timer_that_counts_no_more() {
    // TIM2_CR1: off.
    expect(Condition::SensorStale, 2, |station| with_board(station, |board| board.poke(0x4000_0000, 0)));
}

#[test]
fn a_tick_that_is_left_out() {
    expect(Condition::TickOverrun, 5, |station| with_board(station, |board| board.stall(3)));
}

#[test]
fn a_stack_that_is_nearly_used_up() {
    expect(Condition::StackGuard, 1_100, |station| {
        with_board(station, |board| {
            let low = board.symbol("_stack_end") + 256;
            board.set_word(low + 64, 0);
        });
    });
}

#[test]
fn a_number_that_is_none() {
    let rig = presets::PAPER;
    let mut wild = paper_parameters(&rig);
    // A body that no torque moves: what the law asks for is beyond every number.
    wild.settings.model.inertia = PerAxis::both(1e38);
    let mut station = board_with(&rig, &wild);
    station.send(&twinrotor::link::ToBoard::Telemetry { every: 1 });
    make_ready(&mut station);
    station.aim(PerAxis::new(0.2, 0.2));
    station.request(Request::Arm);
    station.run(100);
    let (tick, cause) = fault(&station);
    assert_eq!(cause, Condition::NonFinite);
    let late = ticks_to_off(&mut station, tick);
    assert!(late <= 2);
    let turned = station.machine.trace().0.iter().any(|outputs| outputs.live());
    assert!(!turned, "what is not a number gives no volts");
}

#[test]
fn a_cleared_fault_arms_again_and_the_estimate_starts_afresh() {
    let papers = (presets::PAPER, paper_parameters(&presets::PAPER));
    for (rig, parameters) in [papers, record::tuned("paper")] {
        clear_and_fly_on(&mut flying_with(&rig, &parameters));
    }
    let (rig, parameters) = record::tuned("aero2");
    flights_with(&rig, &parameters).for_each(|mut station| clear_and_fly_on(&mut station));
}

fn clear_and_fly_on(station: &mut Station) {
    with_rig(station, |heli| heli.press(true, false));
    station.run(20);
    station.request(Request::ClearFault);
    station.run(20);
    assert_eq!(
        station.heard.state(),
        Some(ArmState::Fault(Condition::EmergencyStop)),
        "the stop is still pressed"
    );
    with_rig(station, |heli| {
        heli.press(false, false);
        heli.hold();
    });
    // Until the rotors stand.
    station.run(3_000);
    station.request(Request::ClearFault);
    station.await_state(100, ArmState::Ready);
    station.request(Request::Arm);
    station.await_state(100, ArmState::Armed);
    station.aim(PerAxis::new(0.1, 0.2));
    station.run(12_000);
    let last = station.heard.frames.last().expect("frames");
    assert_eq!((last.state, last.controller), (ArmState::Armed, InForce::default()));
    assert!((last.angle.pitch - 0.1).abs() < 0.02 && (last.angle.yaw - 0.2).abs() < 0.02, "{last:?}");
}
