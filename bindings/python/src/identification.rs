//! A rig's constants from its logs, with progress and Ctrl-C on the way.

use crate::logs::{Given, columns_of, read};
use crate::parts::{json, named_rig, raised, take_lag, within};
use crate::waiting::interruptible;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;
use twinrotor::plant::presets::Rig;
use twinrotor_identify::doubts::doubts;
use twinrotor_identify::fit::Fit;
use twinrotor_identify::log::Log;
use twinrotor_identify::problem::Problem;
use twinrotor_identify::search::{Effort, Search};
use twinrotor_identify::windows::Run;
use twinrotor_identify::{
    Parameter, THRESHOLD, constants, distinct, hold_measured_lags, identified, offset_of, tachometer,
    training_windows,
};
use twinrotor_sim::error::at_least;
use twinrotor_sim::rig;
use twinrotor_tune::checkpoint::Identity;
use twinrotor_tune::parallel::Stop;

/// How well a log is explained.
#[derive(Serialize)]
struct LogFit {
    log: String,
    role: &'static str,
    offset_deg: f64,
    #[serde(flatten)]
    fit: Fit,
}

/// What is said of an identification: the same as `host-sim identify --json` says.
#[derive(Serialize)]
struct Document {
    preset: String,
    seed: u64,
    windows: usize,
    window_s: f64,
    cost: f64,
    descents: Vec<f64>,
    parameters: Vec<Parameter>,
    fits: Vec<LogFit>,
    notes: Vec<String>,
}

/// All that was asked for, known to be sound.
struct Wanted {
    preset: String,
    rig: Rig,
    free: Vec<usize>,
    freed: Vec<String>,
    window: f64,
    effort: Effort,
}

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
    let wanted = Wanted {
        free: constants::chosen(&free, &fix).map_err(|error| raised(&error))?,
        freed: free,
        window: at_least("window", window, 0.2, false).map_err(|error| raised(&error))?,
        effort: Effort {
            population: within("population", population, 2, 10_000)?,
            iterations: within("iterations", iterations, 0, 100_000)?,
            seed,
        },
        preset: named.name,
        rig: named.rig,
    };
    let none = || raised(&twinrotor_sim::Error::invalid("logs", "empty", "at least one log"));
    let logs = Some(read(&logs, &columns, &wanted.rig)?).filter(|logs| !logs.is_empty()).ok_or_else(none)?;
    let others = read(&validate, &columns, &wanted.rig)?;
    interruptible(py, |stop| found(wanted, logs, others, stop, progress.as_ref()))
}

fn runs(logs: Vec<Log>) -> Vec<Run> {
    logs.into_iter().map(Run::new).collect()
}

/// The whole of it, in the order of `host-sim identify`.
fn found(
    wanted: Wanted,
    logs: Vec<Log>,
    others: Vec<Log>,
    stop: Stop<'_>,
    progress: Option<&Py<PyAny>>,
) -> PyResult<(String, String)> {
    let Wanted { preset, mut rig, mut free, freed, window, effort } = wanted;
    let input = |error| raised(&error);
    let mut notes: Vec<String> = logs
        .iter()
        .chain(&others)
        .flat_map(|log| log.notes.iter().map(|note| format!("{}: {note}", log.name)))
        .collect();
    let others = runs(others);
    let (runs, repeated) = distinct(runs(logs), &others);
    notes.extend(repeated);
    tachometer::check(&runs).map_err(input)?;
    notes.extend(doubts(&runs, &rig.plant));
    let measured = hold_measured_lags(&runs, &mut rig.plant, &mut free, &freed);
    notes.extend(
        measured.iter().map(|p| format!("{} is taken from the tachometers (free it to fit it)", p.name)),
    );

    let windows = training_windows(&runs, window).map_err(input)?;
    let count = windows.len();
    let problem = Problem::new(&runs, windows, &rig.plant, &free, THRESHOLD);
    let mut search = Search::new(Identity::new(), &problem, &rig.plant, effort);
    drive(&mut search, &problem, window, stop, progress)?;
    let ended = || PyRuntimeError::new_err("no descent came to an end");
    let (best, cost) = search.best().cloned().ok_or_else(ended)?;

    let plant = problem.plant(&best.values);
    let rig = identified(&rig, plant, &runs).map_err(|error| {
        let told: Vec<String> = notes.iter().map(|note| format!("; note: {note}")).collect();
        PyRuntimeError::new_err(format!("{error}{}", told.concat()))
    })?;
    let (mut parameters, _) = twinrotor_identify::parameters(&problem, &best);
    parameters.extend(measured);
    let trained = runs.iter().zip(&best.offsets).map(|(run, offset)| (run, *offset, "train"));
    let kept_out = others.iter().map(|run| (run, offset_of(run, &plant, window), "validate"));
    let of_log = |(run, offset, role): (&Run, f64, &'static str)| {
        let log = run.log.name.clone();
        let fits = twinrotor_identify::fits(run, &rig.plant, offset);
        fits.into_iter().map(move |fit| LogFit {
            log: log.clone(),
            role,
            offset_deg: offset.to_degrees(),
            fit,
        })
    };
    let document = Document {
        preset,
        seed: effort.seed,
        windows: count,
        window_s: window,
        cost,
        descents: search.descents(),
        parameters,
        fits: trained.chain(kept_out).flat_map(of_log).collect(),
        notes,
    };
    Ok((rig::to_toml(&rig), json(&document)?))
}

/// Searches to the end; `progress` is called after every exchange with what was done and the best cost.
fn drive(
    search: &mut Search,
    problem: &Problem<'_>,
    window: f64,
    stop: Stop<'_>,
    progress: Option<&Py<PyAny>>,
) -> PyResult<()> {
    let tell = |what: &str, cost: f64| match progress {
        None => Ok(()),
        Some(progress) => Python::attach(|py| progress.call1(py, (what, cost)).map(drop)),
    };
    let outcome = search
        .run(problem, window, stop, |_, what, cost| {
            // What was stopped in the middle has not been done.
            if stop() {
                return ControlFlow::Break(PyRuntimeError::new_err("interrupted"));
            }
            tell(what, cost).map_or_else(ControlFlow::Break, ControlFlow::Continue)
        })
        .map_err(|error| raised(&error))?;
    outcome.break_value().map_or(Ok(()), Err)
}
