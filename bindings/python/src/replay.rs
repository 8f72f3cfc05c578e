//! A log through the firmware's estimator and law.

use crate::logs::{Given, columns_of, read};
use crate::parts::{gains_of, json, named_rig, raised, scenario_of, take_lag};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use twinrotor::parameters::Parameters;
use twinrotor_identify::doubts::doubts;
use twinrotor_identify::replay::{self as engine, Report, Row};
use twinrotor_identify::windows::Run;
use twinrotor_station::image;

/// What is said of a replay: the same as `host-sim replay --json` says.
#[derive(Serialize)]
struct Document {
    #[serde(flatten)]
    report: Report,
    notes: Vec<String>,
}

/// A column, and what it has of a tick; volts of a law that was not asked are NaN.
type Column = (&'static str, fn(&Row) -> f64);

const COLUMNS: [Column; 9] = [
    ("t", |row| row.time),
    ("rate_pitch", |row| row.estimated.pitch),
    ("rate_yaw", |row| row.estimated.yaw),
    ("smoothed_pitch", |row| row.smoothed.pitch),
    ("smoothed_yaw", |row| row.smoothed.yaw),
    ("v0", |row| row.volts.main),
    ("v1", |row| row.volts.tail),
    ("ours_v0", |row| row.ours.map_or(f64::NAN, |volts| volts.main)),
    ("ours_v1", |row| row.ours.map_or(f64::NAN, |volts| volts.tail)),
];

/// Every tick as columns, and what is said of them.
#[pyfunction]
#[pyo3(signature = (log, preset, gains, columns, scenario, rotor_lag))]
pub(crate) fn replay<'py>(
    py: Python<'py>,
    log: Given<'py>,
    preset: &str,
    gains: Option<&str>,
    columns: &str,
    scenario: Option<&str>,
    rotor_lag: Option<f64>,
) -> PyResult<(Bound<'py, PyDict>, String)> {
    let mut named = named_rig(preset)?;
    let gains = gains_of(gains, &named)?;
    take_lag(&mut named.rig, rotor_lag)?;
    let scenario = scenario.map(scenario_of).transpose()?;
    let log = read(&[log], &columns_of(columns)?, &named.rig)?.remove(0);
    let parameters = Parameters::new(&named.rig, &gains.settings(&named.rig));
    parameters.validate().map_err(|error| raised(&image::unusable(error)))?;
    let (rows, report, notes) = py.detach(|| {
        let mut notes = log.notes.clone();
        notes.extend(doubts(&[Run::new(log.clone())], &named.rig.plant));
        let samples = engine::samples(&log, &named.rig, scenario.as_ref());
        let replayed = engine::replay(&parameters, &samples);
        let (rows, report) = engine::compare(&log, &samples, &replayed);
        (rows, report, notes)
    });
    let arrays = PyDict::new(py);
    for (name, of) in COLUMNS {
        arrays.set_item(name, PyArray1::from_iter(py, rows.iter().map(of)))?;
    }
    Ok((arrays, json(&Document { report, notes })?))
}
