//! The operator's way to a stop, and what must not go on without an operator.

use twinrotor::axes::PerAxis;
use twinrotor::link::{Refusal, ToBoard};
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets;
use twinrotor::reference::Reference;
use twinrotor::supervisor::{ArmState, Condition, Request};
use virtual_board::board::Inputs;
use virtual_board::helicopter::Helicopter;
use virtual_board::machine::{Machine, Setup};
use virtual_board::record::paper_parameters;
use virtual_board::station::Station;

use super::super::{ADDRESS, board_with, firmware, flights_with, image, make_ready, rest, start};
use super::{built_in, driven, states, trace, traced};

/// Flies until the telemetry of each tick tells when a `Disarm` behind `before` other messages was taken.
fn disarm_behind(setpoints: usize, mut station: Station) -> usize {
    let from = traced(&mut station);
    for _ in 0..setpoints {
        station.aim(PerAxis::new(0.1, 0.2));
    }
    station.request(Request::Disarm);
    station.run(60);
    assert_eq!(station.heard.state(), Some(ArmState::Ready), "{}", station.heard.summary());
    trace(&mut station, from).iter().rposition(|outputs| outputs.enabled).map_or(0, |last| last + 1)
}

#[test]
fn a_disarm_is_taken_within_two_ticks_of_its_last_byte_whatever_comes_before_it() {
    // A setpoint takes up to 38 bytes: .38 ms of the line.
    let (rig, parameters) = built_in();
    for setpoints in [0, 3, 8, 16, 40] {
        for station in flights_with(&rig, &parameters) {
            let off = disarm_behind(setpoints, station);
            let on_the_line = setpoints * 38 / 100;
            assert!(off <= on_the_line + 4, "behind {setpoints} setpoints, motors off after {off} ms");
        }
    }
}

#[test]
fn a_disarm_in_a_stream_at_the_lines_rate_is_not_refused() {
    let (rig, parameters) = built_in();
    for mut station in flights_with(&rig, &parameters) {
        let frame = station.heard.frames.len();
        for _ in 0..100 {
            station.aim(PerAxis::new(0.1, 0.2));
        }
        station.request(Request::Disarm);
        for _ in 0..100 {
            station.aim(PerAxis::new(0.1, 0.2));
        }
        station.run(100);
        let passed = [ArmState::Armed, ArmState::Disarmed, ArmState::Ready];
        assert_eq!(states(&station, frame), passed);
    }
}

#[test]
fn a_check_ends_when_its_host_has_gone_and_is_refused_without_parameters() {
    let rig = presets::AERO;
    let unchecked = Parameters { checked: false, ..paper_parameters(&rig) };
    let mut station = board_with(&rig, &unchecked);
    make_zeroed(&mut station);
    let from = traced(&mut station);
    station.request(Request::Check);
    station.await_state(20, ArmState::Checking);
    station.attentive = false;
    station.run(8_000);
    assert_eq!(station.heard.state(), Some(ArmState::Fault(Condition::CommandTimeout)));
    assert!(driven(&mut station, from) <= 520, "{} ms", driven(&mut station, from));

    let mut station = start(Setup::new(firmware()), &built_in().0);
    make_zeroed(&mut station);
    let from = traced(&mut station);
    station.request(Request::Check);
    station.run(3_000);
    assert_eq!(station.heard.refusals, [Refusal::NoParameters]);
    assert_eq!(driven(&mut station, from), 0);
}

fn make_zeroed(station: &mut Station) {
    rest(station);
    station.send(&ToBoard::Zero);
    station.run(50);
}

#[test]
fn a_setpoint_that_moves_comes_to_rest_and_one_beyond_the_envelope_is_refused_with_the_range() {
    let (rig, parameters) = built_in();
    flights_with(&rig, &parameters).for_each(|mut station| move_setpoint(&mut station, &parameters));
}

fn move_setpoint(station: &mut Station, parameters: &Parameters) {
    let setpoint =
        Reference { angle: PerAxis::new(0.1, 0.2), rate: PerAxis::new(0.0, 1.0), accel: PerAxis::zero() };
    station.send(&ToBoard::Setpoint(setpoint));
    station.run(6_000);
    let last = station.heard.frames.last().expect("frames");
    // It moves for 500 ms at 1 rad/s, to .7 rad, and rests; governor and command filter come there by and by.
    assert!(last.state == ArmState::Armed && (last.reference.yaw - 0.7).abs() < 0.02, "{last:?}");
    station.aim(PerAxis::new(1.5, 0.2));
    station.run(20);
    let pitch = parameters.limits.pitch;
    let refusal = station.heard.refusals.last().expect("a refusal");
    assert!(
        matches!(refusal, Refusal::Setpoint { field, low, high }
        if field == "setpoint.angle.pitch" && (*low, *high) == (-pitch, pitch)),
        "{refusal:?}"
    );
    station.run(500);
    assert_eq!(station.heard.state(), Some(ArmState::Armed));
}

#[test]
fn a_supply_that_reads_too_low_gives_no_motor_more_than_was_asked_for() {
    let (rig, parameters) = built_in();
    let readings = [(0.5, 1), (3.0, 1), (0.5, 10)];
    let cases = readings
        .into_iter()
        .flat_map(|reading| flights_with(&rig, &parameters).map(move |station| (reading, station)));
    for ((reading, every), mut station) in cases {
        station.run(4_000);
        let (frame, from) = (station.heard.frames.len(), traced(&mut station));
        for nth in 0..20_u32 {
            if nth % every == 0 {
                station.machine.with(move |board| {
                    let (at, _) = board.now();
                    let inputs = *board.board().inputs();
                    board.board().apply(at, Inputs { supply: reading, ..inputs });
                });
            }
            station.run(1);
        }
        let asked = station.heard.frames[frame - 100..frame]
            .iter()
            .fold(0.0_f32, |most, f| most.max(f.demand.main.abs()).max(f.demand.tail.abs()));
        let supply = rig.volts_limit.main.max(rig.volts_limit.tail);
        let most = trace(&mut station, from)
            .iter()
            .flat_map(|outputs| outputs.duty())
            .fold(0.0_f64, |most, duty| most.max(duty.abs() * supply));
        assert!(most <= 1.3 * f64::from(asked) + 0.2, "{reading} V read: {most} V for {asked} V");
        assert_eq!(station.heard.state(), Some(ArmState::Fault(Condition::SupplyJump)), "{reading} V");
    }
}

#[test]
fn an_aero_2_arms_at_its_own_24_volts() {
    let (rig, parameters) = built_in();
    let setup = Setup::new(firmware()).with_image(ADDRESS, image(&[parameters]));
    let mut station = Station::new(Machine::start(setup, Helicopter::new(&rig, 24.0)));
    make_ready(&mut station);
    station.request(Request::Arm);
    station.await_state(20, ArmState::Armed);
}
