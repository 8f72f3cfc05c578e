//! Rigs, gains and scenarios by name, from a file or as text; what is wrong with them as Python's errors.

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use serde::Serialize;
use twinrotor::axes::PerMotor;
use twinrotor::defaults;
use twinrotor::plant::presets::{self, Rig};
use twinrotor_sim::error::at_least;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::rig::{self, NamedRig};
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::{Error, Outcome, is_text};

/// Input that is wrong is a `ValueError`, with field, value and what is allowed; all else a `RuntimeError`.
pub(crate) fn raised(error: &Error) -> PyErr {
    if error.is_input() {
        PyValueError::new_err(error.to_string())
    } else {
        PyRuntimeError::new_err(error.to_string())
    }
}

/// A text that is named: a file's.
fn read(path: &str) -> Outcome<String> {
    std::fs::read_to_string(path)
        .map_err(|error| Error::invalid(path, error, "the path of a file that can be read"))
}

/// Is this the text itself and not its name?
fn is_written_out(text: &str) -> bool {
    text.contains('\n')
}

pub(crate) fn named_rig(preset: &str) -> PyResult<NamedRig> {
    let loaded = if is_written_out(preset) {
        rig::parse("the rig", preset).map(|rig| NamedRig { name: "a rig of your own".to_owned(), rig })
    } else {
        rig::load(preset, &read)
    };
    loaded.map_err(|error| raised(&error))
}

/// \[s\] Rotor lag of both motors instead of the preset's, where it is given.
pub(crate) fn take_lag(rig: &mut Rig, lag: Option<f64>) -> PyResult<()> {
    if let Some(lag) = lag {
        let lag = at_least("rotor_lag", lag, 0.0, false).map_err(|error| raised(&error))?;
        rig.plant.rotor_time_constant = PerMotor::both(lag);
    }
    Ok(())
}

/// `None` is what the preset's board boots with.
pub(crate) fn gains_of(gains: Option<&str>, rig: &NamedRig) -> PyResult<GainsFile> {
    let loaded = match gains {
        None => {
            let controller = defaults::named(&rig.name);
            controller.map(|controller| GainsFile { controller, provenance: None }).ok_or_else(|| {
                Error::invalid("gains", "left out", "gains: a rig of your own has none of its own")
            })
        }
        Some(text) if is_written_out(text) => GainsFile::parse("the gains", text),
        Some(name) => GainsFile::load(name, &read),
    };
    loaded.map_err(|error| raised(&error))
}

/// The same, to be flown: refused where it is a law of matrices whose loop on `rig` is unstable.
pub(crate) fn stable_gains_of(gains: Option<&str>, rig: &NamedRig) -> PyResult<GainsFile> {
    let loaded = gains_of(gains, rig)?;
    loaded.require_stable(&rig.name, &rig.rig).map_err(|error| raised(&error))?;
    Ok(loaded)
}

pub(crate) fn scenario_of(scenario: &str) -> PyResult<Scenario> {
    let loaded = if is_written_out(scenario) {
        Scenario::parse("the scenario", scenario)
    } else if is_text(scenario) {
        Scenario::load(scenario, &read)
    } else {
        Scenario::named(scenario)
    };
    loaded.map_err(|error| raised(&error))
}

/// One of several words.
pub(crate) fn word<T: Copy>(field: &str, value: &str, known: &[(&str, T)]) -> PyResult<T> {
    twinrotor_sim::error::known_name(field, value, known).copied().map_err(|error| raised(&error))
}

/// A number within bounds.
pub(crate) fn within(field: &str, value: usize, least: usize, most: usize) -> PyResult<usize> {
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    Err(raised(&Error::invalid(field, value, format!("{least} to {most}"))))
}

/// For `json.loads`.
pub(crate) fn json(value: &impl Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// The names of the rigs that are built in.
#[pyfunction(name = "presets")]
pub(crate) fn preset_names() -> Vec<&'static str> {
    presets::ALL.iter().map(|(name, _)| *name).collect()
}

/// A rig's name and its preset file.
#[pyfunction(name = "rig")]
pub(crate) fn rig_file(preset: &str) -> PyResult<(String, String)> {
    let named = named_rig(preset)?;
    Ok((named.name, rig::to_toml(&named.rig)))
}

/// A gains file, from its name, path or text; `None`: those that the preset's board boots with.
#[pyfunction(name = "gains")]
#[pyo3(signature = (gains, preset))]
pub(crate) fn gains_file(gains: Option<&str>, preset: &str) -> PyResult<String> {
    Ok(gains_of(gains, &named_rig(preset)?)?.to_toml())
}
