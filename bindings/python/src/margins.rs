//! How far a rig may be from what its controller believes.

use crate::parts::{gains_of, json, named_rig, take_lag};
use pyo3::prelude::*;
use twinrotor_sim::margins::Margins;

/// As `host-sim margins --json` says, without preset and gains.
#[pyfunction]
#[pyo3(signature = (preset, gains, rotor_lag))]
pub(crate) fn margins(
    py: Python<'_>,
    preset: &str,
    gains: Option<&str>,
    rotor_lag: Option<f64>,
) -> PyResult<String> {
    let mut named = named_rig(preset)?;
    let gains = gains_of(gains, &named)?;
    take_lag(&mut named.rig, rotor_lag)?;
    let settings = gains.settings(&named.rig);
    json(&py.detach(|| Margins::of(&named.rig, &settings)))
}
