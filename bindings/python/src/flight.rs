//! One flight.

use crate::parts::{gains_of, json, named_rig, raised, scenario_of, word};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use twinrotor::axes::PerAxis;
use twinrotor_sim::Error;
use twinrotor_sim::flight::{self, BoardState, Fidelity, Flight, Moment, Plan, Reading, Scalar};
use twinrotor_sim::metrics::Report;

pub(crate) const FIDELITIES: [(&str, Fidelity); 2] = [("ideal", Fidelity::Ideal), ("rig", Fidelity::Rig)];
const SCALARS: [(&str, Scalar); 2] = [("f32", Scalar::F32), ("f64", Scalar::F64)];

/// What is said of a flight: the same as `host-sim simulate --json` says.
#[derive(Serialize)]
struct Document {
    #[serde(flatten)]
    report: Report,
    board: Option<BoardState>,
    left_envelope: Option<Moment>,
}

/// A flight's truth, what a logger would have written of it, and its report.
type Told<'py> = (Bound<'py, PyDict>, Bound<'py, PyDict>, String);

/// Flies a scenario.
#[pyfunction]
#[pyo3(signature = (preset, gains, scenario, fidelity, scalar, seed, initial, duration, true_rig))]
#[expect(clippy::too_many_arguments, reason = "Python gives them their names")]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    preset: &str,
    gains: Option<&str>,
    scenario: &str,
    fidelity: &str,
    scalar: &str,
    seed: u64,
    initial: Option<[f64; 2]>,
    duration: Option<f64>,
    true_rig: Option<&str>,
) -> PyResult<Told<'py>> {
    let named = named_rig(preset)?;
    let gains = gains_of(gains, &named)?;
    let settings = gains.settings(&named.rig);
    let mut scenario = scenario_of(scenario)?;
    if let Some(duration) = duration {
        scenario.duration = duration;
    }
    scenario.validate().map_err(|error| raised(&error))?;
    let (fidelity, scalar) = (word("fidelity", fidelity, &FIDELITIES)?, word("scalar", scalar, &SCALARS)?);
    gains.require_stable_in(fidelity, &named.name, &named.rig).map_err(|error| raised(&error))?;
    if let (Fidelity::Ideal, Some(what)) = (fidelity, scenario.of_the_rigs_world()) {
        return Err(raised(&Error::invalid("fidelity", "ideal", format!("rig: the scenario has {what}"))));
    }
    let initial = initial.map_or_else(|| scenario.start.angle(), |[pitch, yaw]| PerAxis::new(pitch, yaw));
    let truth = true_rig.map(named_rig).transpose()?.map_or(named.rig, |true_rig| true_rig.rig);
    let flown: Flight = py
        .detach(|| {
            let rig = &named.rig;
            let plan = Plan {
                rig,
                truth: &truth,
                settings: &settings,
                scenario: &scenario,
                initial,
                fidelity,
                seed,
            };
            flight::fly(&plan, scalar)
        })
        .map_err(|error| raised(&error))?;
    let arrays = |columns: &[(&str, Reading)]| {
        let arrays = PyDict::new(py);
        for (name, of) in columns {
            arrays.set_item(name, PyArray1::from_iter(py, flown.rows.iter().map(*of)))?;
        }
        Ok::<_, PyErr>(arrays)
    };
    let (columns, log) = (arrays(&flight::COLUMNS)?, arrays(&flight::LOG_COLUMNS)?);
    let Flight { report, board, left_envelope, .. } = flown;
    Ok((columns, log, json(&Document { report, board, left_envelope })?))
}
