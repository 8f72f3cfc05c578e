//! A rig's constants from its logs, with progress and Ctrl-C on the way.

use crate::logs::{Given, columns_of, read};
use crate::parts::{json, named_rig, raised, take_lag};
use crate::waiting::interruptible;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use twinrotor_identify::identification::{Evidence, Question};
use twinrotor_identify::search::Effort;
use twinrotor_sim::rig;
use twinrotor_tune::parallel::Stop;

/// The preset file, and how it was found.
#[pyfunction]
#[pyo3(signature = (
    logs, validate, preset, columns, free, fix, window, population, iterations, seed, rotor_lag, progress
))]
#[expect(clippy::too_many_arguments, reason = "Python gives them their names")]
#[expect(clippy::needless_pass_by_value, reason = "as Python's values are extracted")]
pub(crate) fn identify(
    py: Python<'_>,
    logs: Vec<Given<'_>>,
    validate: Vec<Given<'_>>,
    preset: &str,
    columns: &str,
    free: Vec<String>,
    fix: Vec<String>,
    window: f64,
    population: usize,
    iterations: usize,
    seed: u64,
    rotor_lag: Option<f64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    let mut named = named_rig(preset)?;
    take_lag(&mut named.rig, rotor_lag)?;
    let columns = columns_of(columns)?;
    let rig = named.rig;
    let effort = Effort { population, iterations, seed };
    let question = Question::new(named, &free, &fix, window, effort).map_err(|error| raised(&error))?;
    let (logs, others) = (read(&logs, &columns, &rig)?, read(&validate, &columns, &rig)?);
    interruptible(py, |stop| {
        let evidence = question.put_to(logs, others).map_err(|error| raised(&error))?;
        found(&evidence, stop, progress.as_ref())
    })
}

/// The preset file, and what `host-sim identify --json` says; `progress` is called after every exchange with
/// what was done and the best cost.
fn found(evidence: &Evidence, stop: Stop<'_>, progress: Option<&Py<PyAny>>) -> PyResult<(String, String)> {
    let tell = |what: &str, cost: f64| match progress {
        None => Ok(()),
        Some(progress) => Python::attach(|py| progress.call1(py, (what, cost)).map(drop)),
    };
    let outcome = evidence.solve(stop, |_, what, cost| {
        // What was stopped in the middle has not been done.
        if stop() {
            return ControlFlow::Break(PyRuntimeError::new_err("interrupted"));
        }
        tell(what, cost).map_or_else(ControlFlow::Break, ControlFlow::Continue)
    });
    match outcome.map_err(|error| raised(&error))? {
        ControlFlow::Break(error) => Err(error),
        ControlFlow::Continue(answer) => {
            let report = evidence.report(&answer, &evidence.compared(&answer));
            Ok((rig::to_toml(&answer.rig), json(&report)?))
        }
    }
}
