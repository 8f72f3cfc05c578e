//! Tuning, with progress and Ctrl-C on the way.

use crate::flight::FIDELITIES;
use crate::parts::{gains_of, json, named_rig, raised, scenario_of, within, word};
use crate::waiting::interruptible;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::Serialize;
use std::ops::ControlFlow;
use std::sync::Mutex;
use twinrotor::gains::NAMES;
use twinrotor_sim::error::at_least;
use twinrotor_sim::gains_file::{GainsFile, Provenance};
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::{Error, rig};
use twinrotor_tune::checkpoint::Identity;
use twinrotor_tune::design::CATALOGUE;
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::{ALGORITHMS, Bounds, Candidate, Draws, MOST_EVALUATIONS, Setup};
use twinrotor_tune::parallel::Stop;
use twinrotor_tune::robust::{self, Limit, Plan, Robust, Trial};
use twinrotor_tune::search::{Effort, Problem, Search};
use twinrotor_tune::tunable::{AtBound, Tunable};

const CRITERIA: [(&str, Criterion); 3] =
    [("ise", Criterion::Ise), ("iae", Criterion::Iae), ("itae", Criterion::Itae)];

/// What is said of a search.
#[derive(Serialize)]
pub(crate) struct Document<'a> {
    pub(crate) cost: f64,
    pub(crate) evaluations: usize,
    pub(crate) history: &'a [(usize, f64)],
    /// What it has left at a bound of its box, or of its last round's.
    pub(crate) at_bounds: Vec<AtBound>,
}

/// Who is told where a search stands, after every exchange.
struct Watched<'a> {
    /// Of evaluations, budget and best cost.
    progress: Option<&'a Py<PyAny>>,
    /// Of a checkpoint.
    keep: Option<&'a Py<PyAny>>,
}

impl Watched<'_> {
    fn tell(&self, search: &Search) -> PyResult<()> {
        if self.progress.is_none() && self.keep.is_none() {
            return Ok(());
        }
        Python::attach(|py| {
            if let Some(keep) = self.keep {
                keep.call1(py, (PyBytes::new(py, &search.checkpoint()),))?;
            }
            if let Some(progress) = self.progress {
                progress.call1(py, (search.evaluations(), search.budget(), search.cost()))?;
            }
            Ok(())
        })
    }
}

/// Drives a search to its end; an exception of whoever is told ends it, as Ctrl-C does.
fn drive(py: Python<'_>, search: &mut Search, problem: &dyn Problem, watched: &Watched<'_>) -> PyResult<()> {
    interruptible(py, |stop| {
        let outcome = search.run(problem, stop, |search| match watched.tell(search) {
            Ok(()) if stop() => ControlFlow::Break(Ok(())),
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => ControlFlow::Break(Err(error)),
        });
        outcome.break_value().unwrap_or(Ok(()))
    })
}

/// The method, and what it may use: as the command line counts.
pub(crate) fn setup(algorithm: &str, population: Option<usize>, iterations: usize) -> PyResult<Setup> {
    let algorithm = word("algorithm", algorithm, &ALGORITHMS)?;
    let each = population.unwrap_or(50);
    let setup = Setup { algorithm, population, evaluations: each };
    setup.validate().map_err(|error| raised(&error))?;
    within("iterations", iterations, 0, MOST_EVALUATIONS / each - 1)?;
    Ok(Setup { evaluations: each * (iterations + 1), ..setup })
}

fn told(search: &Search, found: &GainsFile, at_bounds: Vec<AtBound>) -> PyResult<(String, String)> {
    let document = Document {
        cost: search.cost(),
        evaluations: search.evaluations(),
        history: search.history(),
        at_bounds,
    };
    Ok((found.to_toml(), json(&document)?))
}

pub(crate) fn nothing() -> PyErr {
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
    drive(py, &mut search, &problem, &Watched { progress: progress.as_ref(), keep: None })?;
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
    told(&search, &found, Objective::at_bounds(&search.reached(), &best.position))
}

/// What a robust tuning minimises.
struct Minimised {
    preset: String,
    tunable: Tunable,
    trial: Trial,
    limits: Vec<Limit>,
    identity: Identity,
}

impl Minimised {
    fn new(
        preset: &str,
        controller: &str,
        start: Option<&str>,
        parameters: &[String],
        at_most: &[String],
        plants: usize,
        seed: u64,
    ) -> PyResult<Self> {
        let named = named_rig(preset)?;
        let input = |error| raised(&error);
        let start = match start {
            Some(start) => gains_of(Some(start), &named)?.controller,
            None => word("controller", controller, &CATALOGUE)?(&named.rig),
        };
        let tunable = Tunable::new(&start, parameters).map_err(input)?;
        let plants = within("plants", plants, 1, 100_000)?;
        let limits: Vec<Limit> =
            at_most.iter().map(|text| Limit::parse(text).map_err(input)).collect::<PyResult<_>>()?;
        let trial = Trial::new(&named.rig, plants, seed, robust::allowance(&named.name, &named.rig));
        let identity = Identity::new()
            .with("version", env!("CARGO_PKG_VERSION"))
            .with("preset", &named.name)
            .with("plants", plants)
            .with("seed", seed)
            .with("at_most", at_most.join(", "))
            .with("parameters", parameters.join(", "))
            .with("start", GainsFile { controller: start, provenance: None }.to_toml())
            .with_toml(&rig::to_toml(&named.rig));
        Ok(Self { preset: named.name, tunable, trial, limits, identity })
    }

    fn problem(&self) -> Robust<'_> {
        Robust::new(&self.trial, &self.tunable).within(&self.limits)
    }
}

/// Costs that a function of Python answers, from positions and bounds: on other machines, for instance.
struct Elsewhere {
    evaluate: Py<PyAny>,
    failed: Mutex<Option<PyErr>>,
}

impl Problem for Elsewhere {
    fn costs_until(&self, candidates: &[Candidate], _: Stop<'_>) -> Option<Vec<f64>> {
        let asked: Vec<(&[f64], f64)> =
            candidates.iter().map(|candidate| (&*candidate.position, candidate.bound)).collect();
        let answered = Python::attach(|py| {
            let costs: Vec<f64> = self.evaluate.call1(py, (asked,))?.extract(py)?;
            if costs.len() == candidates.len() {
                return Ok(costs);
            }
            let (there, wanted) = (costs.len(), candidates.len());
            Err(PyRuntimeError::new_err(format!("{there} costs came back; allowed: {wanted}")))
        });
        answered.map_err(|error| *self.failed.lock().expect("nobody panics with it") = Some(error)).ok()
    }

    fn effort(&self) -> Effort {
        Effort::default()
    }
}

/// The costs of positions that may be lost from a bound on: the pure function that may be computed anywhere.
#[pyfunction]
#[pyo3(signature = (preset, controller, start, parameters, at_most, plants, seed, candidates))]
#[expect(clippy::too_many_arguments, reason = "Python gives them their names")]
#[expect(clippy::needless_pass_by_value, reason = "as Python's values are extracted")]
pub(crate) fn robust_costs(
    py: Python<'_>,
    preset: &str,
    controller: &str,
    start: Option<&str>,
    parameters: Vec<String>,
    at_most: Vec<String>,
    plants: usize,
    seed: u64,
    candidates: Vec<(Vec<f64>, f64)>,
) -> PyResult<Vec<f64>> {
    let minimised = Minimised::new(preset, controller, start, &parameters, &at_most, plants, seed)?;
    let dimension = minimised.tunable.names().len();
    let candidates: Vec<Candidate> =
        candidates.into_iter().map(|(position, bound)| Candidate { position, bound }).collect();
    if let Some(wrong) = candidates.iter().find(|candidate| candidate.position.len() != dimension) {
        let error = Error::invalid("a position", wrong.position.len(), format!("{dimension} numbers"));
        return Err(raised(&error));
    }
    Ok(py.detach(|| minimised.problem().costs(&candidates)))
}

/// Any parameter of any controller on many plants: gains file and course. With `evaluate`, costs come of it;
/// `keep` is shown a checkpoint after every exchange, from which `resume` goes on.
#[pyfunction]
#[pyo3(signature = (
    preset, controller, start, parameters, at_most, plants, rounds, range, algorithm, seed, population,
    iterations, progress, evaluate, keep, resume
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
    evaluate: Option<Py<PyAny>>,
    keep: Option<Py<PyAny>>,
    resume: Option<Vec<u8>>,
) -> PyResult<(String, String)> {
    let input = |error| raised(&error);
    let minimised = Minimised::new(preset, controller, start, &parameters, &at_most, plants, seed)?;
    let range = at_least("range", range, 1.0, true).map_err(input)?;
    let rounds = within("rounds", rounds, 1, 1_000)?;
    let plan = Plan { setup: setup(algorithm, population, iterations)?, rounds, range, seed };
    let tunable = &minimised.tunable;
    let identity = minimised.identity.clone().with("plan", format!("{plan:?}"));
    let mut search = Search::new(identity, plan.start(tunable.names().len()));
    if let Some(bytes) = resume {
        search = search
            .resume(&bytes)
            .map_err(|error| PyValueError::new_err(format!("the checkpoint {error}")))?;
    }
    let watched = Watched { progress: progress.as_ref(), keep: keep.as_ref() };
    match evaluate {
        None => drive(py, &mut search, &minimised.problem(), &watched)?,
        Some(evaluate) => {
            let elsewhere = Elsewhere { evaluate, failed: Mutex::new(None) };
            let driven = drive(py, &mut search, &elsewhere, &watched);
            if let Some(error) = elsewhere.failed.into_inner().expect("nobody panics with it") {
                return Err(error);
            }
            driven?;
        }
    }
    let best = search.best().ok_or_else(nothing)?;
    let objective: Vec<String> =
        std::iter::once(format!("robust, {plants} plants")).chain(at_most.iter().cloned()).collect();
    let found = GainsFile {
        controller: tunable.controller(&best.position),
        provenance: Some(Provenance {
            preset: minimised.preset.clone(),
            objective: objective.join(", "),
            algorithm: format!("{algorithm}, {rounds} rounds"),
            seed,
            evaluations: search.evaluations(),
            cost: best.cost,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }),
    };
    told(&search, &found, search.at_bounds_of(tunable))
}
