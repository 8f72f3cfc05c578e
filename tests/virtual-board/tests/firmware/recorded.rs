//! A long flight as a file: what went into every tick of the board and what telemetry told of it, for others
//! that claim to be the same loop (`bindings/python/tests/test_firmware.py`).

use std::fmt::Write;
use std::fs;
use std::path::Path;

use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::control_loop::OperatorCommand;
use twinrotor::supervisor::Request;
use virtual_board::machine::Setup;
use virtual_board::record;

use super::equality::{BACK, Recorded, STEP, compared};
use super::firmware;

/// Ticks in the air.
const TICKS: usize = 60_000;
/// From one setpoint to the next.
const TICKS_A_SETPOINT: usize = 1_500;
/// Of a row; numbers after the command are `f32`, as the digits of their bits.
const COLUMNS: &str = "pitch,yaw,supply,command,aim_pitch,aim_yaw,\
    angle_pitch,angle_yaw,rate_pitch,rate_yaw,disturbance_pitch,disturbance_yaw,\
    reference_pitch,reference_yaw,demand_main,demand_tail,unallocated_torque_pitch,unallocated_torque_yaw,\
    volts_main,volts_tail,told_supply";

/// The digits of these numbers' bits, each after a comma.
fn digits(numbers: &[f32]) -> String {
    numbers.iter().map(|number| format!(",{:08x}", number.to_bits())).collect()
}

/// A row of the file; what telemetry did not tell is left empty.
fn row(tick: &Recorded) -> String {
    let PerAxis { pitch, yaw } = tick.counters;
    let axes = |of: PerAxis<f32>| [of.pitch, of.yaw];
    let motors = |of: PerMotor<f32>| [of.main, of.tail];
    let command = match tick.command {
        None => ",,,".to_owned(),
        Some(OperatorCommand::Zero) => ",zero,,".to_owned(),
        Some(OperatorCommand::Request(Request::Arm)) => ",arm,,".to_owned(),
        Some(OperatorCommand::Setpoint(aim)) => format!(",aim{}", digits(&axes(aim.angle))),
        Some(other) => panic!("{other:?} was not said"),
    };
    let told = tick.frame.map_or_else(
        || ",".repeat(15),
        |frame| {
            let pairs = [
                axes(frame.angle),
                axes(frame.rate),
                axes(frame.disturbance),
                axes(frame.reference),
                motors(frame.demand),
                axes(frame.unallocated_torque),
                motors(frame.volts),
            ];
            digits(&[pairs.as_flattened(), &[frame.supply]].concat())
        },
    );
    format!("{pitch},{yaw}{}{command}{told}", digits(&[tick.supply]))
}

/// A minute of an Aero 2 with its tuned controller, every tick of it the host's own, written down.
#[test]
#[ignore = "long: what the steps in `equality.rs` show, for a minute"]
fn a_minute_on_the_board_is_the_hosts_and_is_written_down() {
    let (rig, parameters) = record::tuned("aero2");
    let setpoints: Vec<_> = [STEP, BACK].into_iter().cycle().take(TICKS / TICKS_A_SETPOINT).collect();
    let flown = compared(Setup::new(firmware()), &rig, &parameters, &setpoints, TICKS);
    let told = flown.iter().filter(|tick| tick.frame.is_some()).count();
    assert!(told > TICKS, "{told} frames");
    let mut text = format!("{COLUMNS}\n");
    for tick in &flown {
        writeln!(text, "{}", row(tick)).expect("a string takes all");
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/telemetry");
    fs::create_dir_all(&folder).expect("the build's own folder");
    fs::write(folder.join("aero2.csv"), text).expect("it has room");
}
