//! Tuning, with progress and Ctrl-C on the way.

use crate::flight::FIDELITIES;
use crate::parts::{gains_of, json, named_rig, raised, scenario_of, within, word};
use crate::waiting::interruptible;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;
use twinrotor::gains::NAMES;
use twinrotor_sim::error::at_least;
use twinrotor_sim::gains_file::{GainsFile, Provenance};
use twinrotor_sim::metrics::Criterion;
use twinrotor_tune::checkpoint::Identity;
use twinrotor_tune::design::CATALOGUE;
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::{ALGORITHMS, Bounds, Draws, MOST_EVALUATIONS, Setup};
use twinrotor_tune::robust::{self, Limit, Plan, Robust, Trial};
use twinrotor_tune::search::{Problem, Search};
use twinrotor_tune::tunable::Tunable;

const CRITERIA: [(&str, Criterion); 3] =
    [("ise", Criterion::Ise), ("iae", Criterion::Iae), ("itae", Criterion::Itae)];

#[derive(Serialize)]
struct Document<'a> {
    cost: f64,
    evaluations: usize,
    history: &'a [(usize, f64)],
}

/// Drives a search to its end. `progress` is called after every exchange with evaluations, budget and best
/// cost; an exception in it ends the search, as Ctrl-C does.
fn drive(
    py: Python<'_>,
    search: &mut Search,
    problem: &dyn Problem,
    progress: Option<&Py<PyAny>>,
) -> PyResult<()> {
    let tell = |search: &Search| match progress {
        None => Ok(()),
        Some(progress) => Python::attach(|py| {
            progress.call1(py, (search.evaluations(), search.budget(), search.cost())).map(drop)
        }),
    };
    interruptible(py, |stop| {
        let outcome = search.run(problem, stop, |search| match tell(search) {
            Ok(()) if stop() => ControlFlow::Break(Ok(())),
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => ControlFlow::Break(Err(error)),
        });
        outcome.break_value().unwrap_or(Ok(()))
    })
}

/// The method, and what it may use: as the command line counts.
fn setup(algorithm: &str, population: Option<usize>, iterations: usize) -> PyResult<Setup> {
    let algorithm = word("algorithm", algorithm, &ALGORITHMS)?;
    let each = population.unwrap_or(50);
    let setup = Setup { algorithm, population, evaluations: each };
    setup.validate().map_err(|error| raised(&error))?;
    within("iterations", iterations, 0, MOST_EVALUATIONS / each - 1)?;
    Ok(Setup { evaluations: each * (iterations + 1), ..setup })
}

fn told(search: &Search, found: &GainsFile) -> PyResult<(String, String)> {
    let document =
        Document { cost: search.cost(), evaluations: search.evaluations(), history: search.history() };
    Ok((found.to_toml(), json(&document)?))
}

fn nothing() -> PyErr {
    PyRuntimeError::new_err("no candidate flew to the end")
}

/// Gains of the paper's law that minimise an integral of the error: gains file and course.
#[pyfunction]
#[pyo3(signature = (preset, objective, algorithm, seed, population, iterations, scenario, fidelity, bounds,
    progress))]
#[expect(clippy::too_many_arguments, reason = "Python gives them their names")]
pub(crate) fn tune(
    py: Python<'_>,
    preset: &str,
    objective: &str,
    algorithm: &str,
    seed: u64,
    population: Option<usize>,
    iterations: usize,
    scenario: &str,
    fidelity: &str,
    bounds: [f64; 2],
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    let named = named_rig(preset)?;
    let criterion = word("objective", objective, &CRITERIA)?;
    let setup = setup(algorithm, population, iterations)?;
    let scenario = scenario_of(scenario)?;
    at_least("bounds: the lower one", bounds[0], 0.0, true).map_err(|error| raised(&error))?;
    at_least("bounds: the upper one", bounds[1], bounds[0], true).map_err(|error| raised(&error))?;
    let fidelity = word("fidelity", fidelity, &FIDELITIES)?;
    let problem = Objective::new(criterion, &named.rig, &scenario, fidelity, seed);
    let bounds = Bounds::new(vec![bounds; NAMES.len()]).map_err(|error| raised(&error))?;
    let mut search = Search::new(Identity::new(), setup.start(bounds, Draws::new(seed)));
    drive(py, &mut search, &problem, progress.as_ref())?;
    let best = search.best().filter(|best| best.cost.is_finite()).ok_or_else(nothing)?;
    let mut found = Objective::controller(&best.position);
    found.provenance = Some(Provenance {
        preset: named.name,
        objective: objective.to_owned(),
        algorithm: algorithm.to_owned(),
        seed,
        evaluations: search.evaluations(),
        cost: best.cost,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    });
    told(&search, &found)
}

/// Any parameter of any controller on many plants: gains file and course.
#[pyfunction]
#[pyo3(signature = (
    preset, controller, start, parameters, at_most, plants, rounds, range, algorithm, seed, population,
    iterations, progress
))]
#[expect(clippy::too_many_arguments, reason = "Python gives them their names")]
#[expect(clippy::needless_pass_by_value, reason = "as Python's values are extracted")]
pub(crate) fn tune_robust(
    py: Python<'_>,
    preset: &str,
    controller: &str,
    start: Option<&str>,
    parameters: Vec<String>,
    at_most: Vec<String>,
    plants: usize,
    rounds: usize,
    range: f64,
    algorithm: &str,
    seed: u64,
    population: Option<usize>,
    iterations: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    let named = named_rig(preset)?;
    let start = match start {
        Some(start) => gains_of(Some(start), &named)?.controller,
        None => word("controller", controller, &CATALOGUE)?(&named.rig),
    };
    let input = |error| raised(&error);
    let tunable = Tunable::new(&start, &parameters).map_err(input)?;
    let range = at_least("range", range, 1.0, true).map_err(input)?;
    let plants = within("plants", plants, 1, 100_000)?;
    let rounds = within("rounds", rounds, 1, 1_000)?;
    let limits: Vec<Limit> =
        at_most.iter().map(|text| Limit::parse(text).map_err(input)).collect::<PyResult<_>>()?;
    let trial = Trial::new(&named.rig, plants, seed, robust::allowance(&named.name, &named.rig));
    let plan = Plan { setup: setup(algorithm, population, iterations)?, rounds, range, seed };
    let mut search = Search::new(Identity::new(), plan.start(tunable.names().len()));
    drive(py, &mut search, &Robust::new(&trial, &tunable).within(&limits), progress.as_ref())?;
    let best = search.best().ok_or_else(nothing)?;
    let objective: Vec<String> =
        std::iter::once(format!("robust, {plants} plants")).chain(at_most.iter().cloned()).collect();
    let found = GainsFile {
        controller: tunable.controller(&best.position),
        provenance: Some(Provenance {
            preset: named.name,
            objective: objective.join(", "),
            algorithm: format!("{algorithm}, {rounds} rounds"),
            seed,
            evaluations: search.evaluations(),
            cost: best.cost,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }),
    };
    told(&search, &found)
}
