//! What a page draws of every frame, as one row of numbers.

use serde::Serialize;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::PerMotor;
use twinrotor::supervisor::ArmState;
use twinrotor::telemetry::Frame;

/// \[ticks\] From one row to the next: 200 a second.
pub const EVERY: u32 = 5;

/// A number of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Column {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
}

const fn column(name: &'static str, unit: &'static str) -> Column {
    Column { name, unit }
}

/// How many numbers a row has.
pub const COLUMNS: usize = 21;

/// All of them, in order.
pub const TABLE: [Column; COLUMNS] = [
    column("time", "s"),
    column("pitch", "°"),
    column("yaw", "°"),
    column("pitch_reference", "°"),
    column("yaw_reference", "°"),
    column("pitch_rate", "°/s"),
    column("yaw_rate", "°/s"),
    column("pitch_error", "°"),
    column("yaw_error", "°"),
    column("main_volts", "V"),
    column("tail_volts", "V"),
    column("main_demand", "V"),
    column("tail_demand", "V"),
    column("pitch_disturbance", "rad/s²"),
    column("yaw_disturbance", "rad/s²"),
    column("main_rotor", "V"),
    column("tail_rotor", "V"),
    column("supply", "V"),
    column("state", "-"),
    column("trial_share", "%"),
    column("clipped", "-"),
];

/// A frame as a row; `rotors` \[V\] are the volts in effect at the rotors, which telemetry does not tell: not
/// a number where they are not known.
#[must_use]
pub fn row(frame: &Frame, rotors: Option<PerMotor<f32>>) -> [f32; COLUMNS] {
    let (angle, reference, rate) = (frame.angle, frame.reference, frame.rate);
    let error = reference.minus(angle);
    let deg = f32::to_degrees;
    let rotors = rotors.unwrap_or(PerMotor::both(f32::NAN));
    #[expect(clippy::cast_possible_truncation, reason = "milliseconds are told apart for hours")]
    let time = (f64::from(frame.tick) * SAMPLE_TIME) as f32;
    let beyond = |demand: f32, volts: f32| demand.abs() > volts.abs() + 1e-3;
    let main = beyond(frame.demand.main, frame.volts.main);
    let tail = beyond(frame.demand.tail, frame.volts.tail);
    [
        time,
        deg(angle.pitch),
        deg(angle.yaw),
        deg(reference.pitch),
        deg(reference.yaw),
        deg(rate.pitch),
        deg(rate.yaw),
        deg(error.pitch),
        deg(error.yaw),
        frame.volts.main,
        frame.volts.tail,
        frame.demand.main,
        frame.demand.tail,
        frame.disturbance.pitch,
        frame.disturbance.yaw,
        rotors.main,
        rotors.tail,
        frame.supply,
        code(frame.state),
        f32::from(frame.controller.blend),
        f32::from(u8::from(main) + 2 * u8::from(tail)),
    ]
}

/// 0 to 4, in the order in which the states are declared.
const fn code(state: ArmState) -> f32 {
    match state {
        ArmState::Disarmed => 0.0,
        ArmState::Ready => 1.0,
        ArmState::Checking => 2.0,
        ArmState::Armed => 3.0,
        ArmState::Fault(_) => 4.0,
    }
}
