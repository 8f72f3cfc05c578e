//! Methods of search side by side, and tests on ranks.

use crate::parts::json;
use pyo3::prelude::*;
use twinrotor_tune::contest::{self, Peer, Run};

/// A method's name, and of each of its searches the best cost, and evaluations and cost at every improvement.
type Searched = (String, Vec<(f64, Vec<(usize, f64)>)>);

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
