//! Whether the intervals of an identification hold the truth, chunk by chunk on any number of machines.

use crate::parts::{gains_of, json, named_rig, raised, scenario_of};
use crate::waiting::interruptible;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use twinrotor_identify::coverage::{EXCITATION, Study, Verdict};
use twinrotor_identify::identification::Question;
use twinrotor_identify::search::Effort;
use twinrotor_sim::Error;
use twinrotor_sim::scenario::Scenario;
use twinrotor_tune::robust::Scatter;

/// What is studied: a dict.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Studied {
    preset: String,
    gains: Option<String>,
    scenario: Option<String>,
    rigs: usize,
    spread: f64,
    lag_spread: f64,
    free: Vec<String>,
    fix: Vec<String>,
    window: f64,
    population: usize,
    iterations: usize,
    seed: u64,
}

impl Studied {
    fn study(self) -> PyResult<Study> {
        let named = named_rig(&self.preset)?;
        let gains = gains_of(self.gains.as_deref(), &named)?;
        let scenario = match &self.scenario {
            Some(scenario) => scenario_of(scenario)?,
            None => Scenario::parse("docs/identify.md", EXCITATION).map_err(|error| raised(&error))?,
        };
        let effort = Effort { population: self.population, iterations: self.iterations, seed: self.seed };
        let scatter = Scatter { constants: self.spread, lag: self.lag_spread };
        Question::new(named, &self.free, &self.fix, self.window, effort)
            .and_then(|question| Study::new(question, &gains, scenario, self.rigs, scatter))
            .map_err(|error| raised(&error))
    }
}

/// A chunk of a study: the rigs from `first` to before `end`, as bytes for [`coverage_chunks`].
#[pyfunction]
#[pyo3(signature = (studied, first, end))]
pub(crate) fn coverage_chunk(
    py: Python<'_>,
    studied: Studied,
    first: usize,
    end: usize,
) -> PyResult<Bound<'_, PyBytes>> {
    let study = studied.study()?;
    if !(first < end && end <= study.count()) {
        let allowed = format!("some of the {} rigs", study.count());
        return Err(raised(&Error::invalid("chunk", format!("{first} to before {end}"), allowed)));
    }
    let bytes = interruptible(py, |stop| {
        let verdicts = study.verdicts(first..end, stop, &|| ());
        let verdicts = verdicts.ok_or_else(|| PyRuntimeError::new_err("interrupted"))?;
        Ok(study.encode(first, &verdicts))
    })?;
    Ok(PyBytes::new(py, &bytes))
}

/// What `host-sim coverage --json` says, from all chunks in the order of their rigs.
#[pyfunction]
#[pyo3(signature = (studied, chunks))]
#[expect(clippy::needless_pass_by_value, reason = "as Python's values are extracted")]
pub(crate) fn coverage_chunks(studied: Studied, chunks: Vec<Vec<u8>>) -> PyResult<String> {
    let study = studied.study()?;
    let mut all: Vec<Verdict> = Vec::new();
    for (number, chunk) in chunks.iter().enumerate() {
        let told = |error: Error| PyValueError::new_err(format!("chunk {number}: {error}"));
        let (first, verdicts) = study.decode(chunk).map_err(told)?;
        if first != all.len() {
            return Err(PyValueError::new_err(format!(
                "chunk {number} begins with rig {first}; allowed: in order"
            )));
        }
        all.extend(verdicts);
    }
    if all.len() != study.count() {
        return Err(PyValueError::new_err(format!(
            "chunks do not have {} rigs; allowed: all of them",
            study.count()
        )));
    }
    json(&study.report(&all))
}
