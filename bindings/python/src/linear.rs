//! The plant near a pose that it holds, as a linear system.

use crate::parts::{named_rig, raised};
use numpy::PyArray2;
use pyo3::prelude::*;
use twinrotor_sim::Error;
use twinrotor_sim::linear::{self, Rows};

type Matrix<'py> = Bound<'py, PyArray2<f64>>;
/// A, B, C, D, and the volts that hold the pose.
type Linear<'py> = (Matrix<'py>, Matrix<'py>, Matrix<'py>, Matrix<'py>, [f64; 2]);

/// Eqs (1)-(2) with lag, reaction and gyroscopic torque of the rotors, near rest at `pitch` \[rad\]. States:
/// θ, ψ, θ̇, ψ̇, and the volts in effect of each motor that lags; inputs: the volts applied; outputs: θ, ψ.
/// Coulomb friction, which has no slope, is left out.
#[pyfunction]
#[pyo3(signature = (preset, pitch))]
pub(crate) fn linearize<'py>(py: Python<'py>, preset: &str, pitch: f64) -> PyResult<Linear<'py>> {
    let named = named_rig(preset)?;
    let plant = &named.rig.plant;
    let most = core::f64::consts::FRAC_PI_2;
    if pitch.is_nan() || pitch.abs() >= most {
        return Err(raised(&Error::invalid("pitch", pitch, format!("an angle within ±{most:.4} rad"))));
    }
    let linear = linear::Linear::of(plant, pitch);
    let matrix = |rows: &Rows| {
        PyArray2::from_vec2(py, rows)
            .map_err(|error| pyo3::exceptions::PyRuntimeError::new_err(error.to_string()))
    };
    let linear::Linear { a, b, c, d, volts, .. } = &linear;
    Ok((matrix(a)?, matrix(b)?, matrix(c)?, matrix(d)?, [volts.main, volts.tail]))
}
