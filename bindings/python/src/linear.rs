//! The plant near a pose that it holds, as a linear system.

use crate::parts::{named_rig, raised};
use numpy::PyArray2;
use pyo3::prelude::*;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::plant::{PlantParameters, RigidBody, State};
use twinrotor::static_reach::hold_volts;
use twinrotor_sim::Error;

/// A matrix's rows.
type Rows = Vec<Vec<f64>>;
type Matrix<'py> = Bound<'py, PyArray2<f64>>;
/// A, B, C, D, and the volts that hold the pose.
type Linear<'py> = (Matrix<'py>, Matrix<'py>, Matrix<'py>, Matrix<'py>, [f64; 2]);

/// One motor's numbers in what follows: in volts of that motor.
struct Column {
    /// \[N m/V\] On pitch and yaw, of the volts in effect.
    thrust: [f64; 2],
    /// \[N m s/V\] On pitch and yaw, of how fast they change.
    reaction: [f64; 2],
    /// \[s\]
    lag: f64,
}

/// At a pitch where yaw feels `tilt` of what the motors do to it on a level body.
fn columns(plant: &PlantParameters<f64>, volts: PerMotor<f64>, tilt: f64) -> [Column; 2] {
    // d/dv (a v + b v|v|) = a + 2 b |v|.
    let slope = |v: f64| plant.effectiveness.zip(plant.quadratic_effectiveness, |a, b| a + 2.0 * b * v.abs());
    let (main, tail) = (slope(volts.main), slope(volts.tail));
    let (lag, reaction) = (plant.rotor_time_constant, plant.rotor_reaction);
    [
        Column {
            thrust: [main.main_on_pitch, tilt * main.main_on_yaw],
            reaction: [0.0, tilt * reaction.main],
            lag: lag.main,
        },
        Column {
            thrust: [tail.tail_on_pitch, tilt * tail.tail_on_yaw],
            reaction: [reaction.tail, 0.0],
            lag: lag.tail,
        },
    ]
}

/// Eqs (1)-(2) with lag, reaction and gyroscopic torque of the rotors, near rest at `pitch` \[rad\]. States: θ, ψ, θ̇,
/// ψ̇, and the volts in effect of each motor that lags; inputs: the volts applied; outputs: θ, ψ. Coulomb
/// friction, which has no slope, is left out.
#[pyfunction]
#[pyo3(signature = (preset, pitch))]
pub(crate) fn linearize<'py>(py: Python<'py>, preset: &str, pitch: f64) -> PyResult<Linear<'py>> {
    let named = named_rig(preset)?;
    let plant = &named.rig.plant;
    let most = core::f64::consts::FRAC_PI_2;
    if pitch.is_nan() || pitch.abs() >= most {
        return Err(raised(&Error::invalid("pitch", pitch, format!("an angle within ±{most:.4} rad"))));
    }
    let volts = hold_volts(plant, pitch);
    let moment = plant.mass * plant.center_of_mass;
    let inertia = RigidBody::new(plant).at(&State::at_rest(PerAxis::new(pitch, 0.0))).inertia;
    let inertia = [inertia.pitch, inertia.yaw];
    let damping = [plant.damping.pitch, plant.damping.yaw];
    let motors = columns(plant, volts, 1.0 + plant.tilting_thrust * (pitch.cos() - 1.0));
    let states = 4 + motors.iter().filter(|motor| motor.lag > 0.0).count();
    let (mut a, mut b): (Rows, Rows) = (vec![vec![0.0; states]; states], vec![vec![0.0; 2]; states]);
    // At rest, with the torque in balance, yaw feels nothing of pitch.
    a[2][0] = (moment * plant.gravity * pitch.sin() - plant.stiffness * pitch.cos()) / inertia[0];
    for axis in 0..2 {
        a[axis][2 + axis] = 1.0;
        a[2 + axis][2 + axis] = -damping[axis] / inertia[axis];
    }
    let gyroscopic = plant.rotor_momentum * volts.main * pitch.sin();
    a[2][3] -= gyroscopic / inertia[0];
    a[3][2] += gyroscopic / inertia[1];
    let mut state = 4;
    for (input, motor) in motors.iter().enumerate() {
        let lags = motor.lag > 0.0;
        for axis in 0..2 {
            let thrust = motor.thrust[axis] / inertia[axis];
            if lags {
                let reaction = motor.reaction[axis] / motor.lag / inertia[axis];
                a[2 + axis][state] = thrust - reaction;
                b[2 + axis][input] = reaction;
            } else {
                b[2 + axis][input] = thrust;
            }
        }
        if lags {
            a[state][state] = -1.0 / motor.lag;
            b[state][input] = 1.0 / motor.lag;
            state += 1;
        }
    }
    let mut c = vec![vec![0.0; states]; 2];
    (c[0][0], c[1][1]) = (1.0, 1.0);
    let matrix = |rows: &Rows| {
        PyArray2::from_vec2(py, rows)
            .map_err(|error| pyo3::exceptions::PyRuntimeError::new_err(error.to_string()))
    };
    Ok((matrix(&a)?, matrix(&b)?, matrix(&c)?, matrix(&vec![vec![0.0; 2]; 2])?, [volts.main, volts.tail]))
}
