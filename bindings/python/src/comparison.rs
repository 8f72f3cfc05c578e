//! Controllers on plants that they were not tuned for.

use crate::parts::{gains_of, json, named_rig, raised, within};
use numpy::PyArray1;
use pyo3::prelude::*;
use twinrotor::plant::presets::Rig;
use twinrotor_sim::{Error, rig};
use twinrotor_tune::parallel::NEVER;
use twinrotor_tune::robust::{self, Row, Score, Trial, UNSEEN};

/// For each of these gains, in order: what each plant costs, and a row as `host-sim compare --json` has it,
/// against the first.
#[pyfunction]
#[pyo3(signature = (preset, controllers, plants, seed))]
#[expect(clippy::needless_pass_by_value, reason = "as Python's values are extracted")]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    preset: &str,
    controllers: Vec<(String, Option<String>)>,
    plants: usize,
    seed: u64,
) -> PyResult<Vec<(Bound<'py, PyArray1<f64>>, String)>> {
    let named = named_rig(preset)?;
    let plants = within("plants", plants, 1, 100_000)?;
    let trial =
        Trial::new(&named.rig, plants, seed.wrapping_add(UNSEEN), robust::allowance(&named.name, &named.rig));
    let mut all: Vec<Vec<Score>> = Vec::new();
    for (_, gains) in &controllers {
        let controller = gains_of(gains.as_deref(), &named)?.controller;
        all.push(py.detach(|| trial.supervised(&controller, NEVER)).expect("nothing stops it"));
        py.check_signals()?;
    }
    let rows = controllers.iter().zip(&all).enumerate().map(|(k, ((name, _), scores))| {
        let first = (k > 0).then(|| all[0].as_slice());
        let costs = PyArray1::from_iter(py, scores.iter().map(Score::cost));
        Ok((costs, json(&Row::new(name, scores, first, Vec::new()))?))
    });
    rows.collect()
}

/// The preset files of rigs drawn around one, as the robust objective draws its plants.
#[pyfunction]
#[pyo3(signature = (preset, count, seed))]
pub(crate) fn draw(preset: &str, count: usize, seed: u64) -> PyResult<Vec<String>> {
    let nominal = named_rig(preset)?.rig;
    let count = within("count", count, 1, 100_000)?;
    let drawn =
        robust::draw(&nominal, count, seed).into_iter().map(|draw| Rig { plant: draw.plant, ..nominal });
    drawn
        .map(|drawn| {
            drawn.validate().map_err(|error| raised(&Error::from(error)))?;
            Ok(rig::to_toml(&drawn))
        })
        .collect()
}
