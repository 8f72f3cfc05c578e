//! Which references the motors could follow, by the inverse model.

use crate::scenes::{Scene, Wave};
use std::f64::consts::TAU;
use twinrotor::allocation::CurrentLimitSettings;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{PlantParameters, RigidBody, State};

/// Points of a period.
const POINTS: u32 = 2_000;
/// \[-\] Of volts and currents, at most.
const MOST: f64 = 0.9;

/// Whether the sine takes at most nine tenths of the volts, of the continuous and of the peak current.
/// Squares are not feasible at any amplitude.
pub(crate) fn is_feasible(rig: &Rig, scene: &Scene) -> bool {
    if scene.wave == Wave::Square {
        return false;
    }
    let in_effect = volts_in_effect(&rig.plant, scene);
    let step = 1.0 / (scene.hertz * f64::from(POINTS));
    let motor = rig.motor.map(|motor| CurrentLimitSettings::new(&motor));
    let (mut peak, mut square) = (PerMotor::both(0.0), PerMotor::both(0.0));
    let points = in_effect.len();
    for k in 0..points {
        let (before, after) = (in_effect[(k + points - 1) % points], in_effect[(k + 1) % points]);
        let slope = after.minus(before).scaled(0.5 / step);
        let lead = rig.plant.rotor_time_constant.zip(slope, |tau, slope| tau * slope);
        let volts = in_effect[k].plus(lead);
        if volts.main.abs() > MOST * rig.volts_limit.main || volts.tail.abs() > MOST * rig.volts_limit.tail {
            return false;
        }
        if let Some(motor) = &motor {
            let current = volts.minus(in_effect[k].scaled(motor.back_emf)).scaled(1.0 / motor.resistance);
            peak = peak.zip(current, |peak: f64, now| peak.max(now.abs()));
            square = square.plus(current.map(|current| current * current));
        }
    }
    motor.is_none_or(|motor| {
        let mean = square.scaled(1.0 / f64::from(POINTS)).map(f64::sqrt);
        mean.main.max(mean.tail) <= MOST * motor.continuous && peak.main.max(peak.tail) <= MOST * motor.peak
    })
}

/// \[V\] That must be in effect, over one period.
fn volts_in_effect(plant: &PlantParameters<f64>, scene: &Scene) -> Vec<PerMotor<f64>> {
    let body = RigidBody::new(plant);
    let omega = TAU * scene.hertz;
    let amplitude = scene.amplitude();
    let mut volts = PerMotor::both(1.0);
    (0..POINTS)
        .map(|k| {
            let (sine, cosine) = (TAU * f64::from(k) / f64::from(POINTS)).sin_cos();
            let state = State { angle: amplitude.scaled(sine), rate: amplitude.scaled(omega * cosine) };
            let friction = plant.coulomb_friction.zip(state.rate, |f, rate| f * (rate / 0.02).tanh());
            let wanted = body.at(&state).torque(amplitude.scaled(-omega * omega * sine)).plus(friction);
            volts = solve(plant, wanted, volts);
            volts
        })
        .collect()
}

/// \[V\] Whose thrust is `wanted` \[N m\], by Newton's method with bounded steps from `volts`.
fn solve(plant: &PlantParameters<f64>, wanted: PerAxis<f64>, volts: PerMotor<f64>) -> PerMotor<f64> {
    let (linear, quadratic) = (plant.effectiveness, plant.quadratic_effectiveness);
    let mut volts = volts;
    for _ in 0..200 {
        let given = linear.torque(volts).plus(quadratic.torque(volts.map(|v| v * v.abs())));
        let missing = wanted.minus(given);
        let (main, tail) = (2.0 * (volts.main.abs() + 0.2), 2.0 * (volts.tail.abs() + 0.2));
        let mut slope = linear;
        slope.main_on_pitch += quadratic.main_on_pitch * main;
        slope.main_on_yaw += quadratic.main_on_yaw * main;
        slope.tail_on_pitch += quadratic.tail_on_pitch * tail;
        slope.tail_on_yaw += quadratic.tail_on_yaw * tail;
        volts = volts.plus(slope.volts(missing).map(|step| (0.5 * step).clamp(-1.0, 1.0)));
        if missing.pitch.abs().max(missing.yaw.abs()) < 1e-9 {
            break;
        }
    }
    volts
}
