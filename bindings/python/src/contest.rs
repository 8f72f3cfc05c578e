//! Methods of search side by side, and tests on ranks.

use crate::parts::{json, named_rig, raised};
use crate::search::{Document, nothing, setup};
use pyo3::prelude::*;
use twinrotor::gains::{NAMES, PAPER_BOUNDS};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::Provenance;
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::scenario::Scenario;
use twinrotor_tune::contest::{self, Peer, Run};
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::Bounds;

/// A method's name, and of each of its searches the best cost, and evaluations and cost at every improvement.
type Searched = (String, Vec<(f64, Vec<(usize, f64)>)>);

/// One search of `host-sim bench-tuners`: gains file and course, with the evaluation of every improvement.
#[pyfunction]
#[pyo3(signature = (preset, algorithm, seed, population, iterations))]
pub(crate) fn bench_tuner(
    py: Python<'_>,
    preset: &str,
    algorithm: &str,
    seed: u64,
    population: Option<usize>,
    iterations: usize,
) -> PyResult<(String, String)> {
    let named = named_rig(preset)?;
    let setup = setup(algorithm, population, iterations)?;
    let scenario = Scenario::named("step").map_err(|error| raised(&error))?;
    let problem = Objective::new(Criterion::Ise, &named.rig, &scenario, Fidelity::Ideal, seed);
    let bounds = Bounds::new(vec![PAPER_BOUNDS; NAMES.len()]).map_err(|error| raised(&error))?;
    let peer = py.detach(|| Peer::search(algorithm, &setup, &bounds, &[seed], &problem, &|_| ()));
    let peer = peer.ok_or_else(nothing)?;
    let Run { cost, position, history, .. } = peer.best();
    if !cost.is_finite() {
        return Err(nothing());
    }
    let mut found = Objective::controller(position);
    found.provenance = Some(Provenance {
        preset: named.name,
        objective: "ise".to_owned(),
        algorithm: algorithm.to_owned(),
        seed,
        evaluations: setup.evaluations,
        cost: *cost,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    });
    let at_bounds = Objective::at_bounds(&bounds.reached(position), position);
    let document = Document { cost: *cost, evaluations: setup.evaluations, history, at_bounds };
    Ok((found.to_toml(), json(&document)?))
}

/// The lowest cost that is known, and the `standings` of `host-sim bench-tuners --json`.
#[pyfunction]
#[pyo3(signature = (peers))]
pub(crate) fn standings(peers: Vec<Searched>) -> PyResult<(f64, String)> {
    let run = |(seed, (cost, history)): (u64, (f64, Vec<(usize, f64)>))| Run {
        seed,
        cost,
        position: Vec::new(),
        history,
    };
    let peer = |(name, runs): Searched| Peer { name, runs: (0..).zip(runs).map(run).collect() };
    let peers: Vec<Peer> = peers.into_iter().map(peer).collect();
    let best_known = contest::best_known(&peers);
    Ok((best_known, json(&contest::standings(&peers, best_known))?))
}

/// The p-value of Wilcoxon's rank-sum test of two samples.
#[pyfunction]
#[pyo3(signature = (a, b))]
#[expect(clippy::needless_pass_by_value, reason = "as Python's values are extracted")]
pub(crate) fn rank_sum(a: Vec<f64>, b: Vec<f64>) -> f64 {
    contest::rank_sum(&a, &b)
}

/// Holm's correction.
#[pyfunction]
#[pyo3(signature = (p_values))]
#[expect(clippy::needless_pass_by_value, reason = "as Python's values are extracted")]
pub(crate) fn holm(p_values: Vec<f64>) -> Vec<f64> {
    contest::holm(&p_values)
}
