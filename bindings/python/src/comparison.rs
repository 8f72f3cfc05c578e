//! Controllers on plants that they were not tuned for, all at once or chunk by chunk on any number of
//! machines.

use crate::parts::{json, named_rig, raised, stable_gains_of, within};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use twinrotor::controller::ControllerSettings;
use twinrotor::plant::presets::Rig;
use twinrotor_sim::{Error, rig};
use twinrotor_tune::checkpoint::{self, Identity};
use twinrotor_tune::parallel::NEVER;
use twinrotor_tune::robust::{self, Row, Score, Trial, UNSEEN};

/// Names, and gains as they are given.
type Named = (String, Option<String>);

/// What is compared on what, and its name for chunks that are kept.
struct Compared {
    trial: Trial,
    controllers: Vec<(String, ControllerSettings<f64>)>,
    identity: Identity,
}

impl Compared {
    fn new(preset: &str, controllers: &[Named], plants: usize, seed: u64) -> PyResult<Self> {
        let named = named_rig(preset)?;
        let plants = within("plants", plants, 1, 100_000)?;
        let allowance = robust::allowance(&named.name, &named.rig);
        let trial = Trial::new(&named.rig, plants, seed.wrapping_add(UNSEEN), allowance);
        let mut identity = Identity::new()
            .with("version", env!("CARGO_PKG_VERSION"))
            .with("plants", plants)
            .with("seed", seed)
            .with_toml(&rig::to_toml(&named.rig));
        let mut settings = Vec::new();
        for (name, gains) in controllers {
            let gains = stable_gains_of(gains.as_deref(), &named)?;
            identity = identity.with(name, gains.to_toml());
            settings.push((name.clone(), gains.controller));
        }
        Ok(Self { trial, controllers: settings, identity })
    }

    fn rows<'py>(
        &self,
        py: Python<'py>,
        all: &[Vec<Score>],
    ) -> PyResult<Vec<(Bound<'py, PyArray1<f64>>, String)>> {
        let rows = self.controllers.iter().zip(all).enumerate().map(|(k, ((name, _), scores))| {
            let first = (k > 0).then(|| all[0].as_slice());
            let costs = PyArray1::from_iter(py, scores.iter().map(Score::cost));
            Ok((costs, json(&Row::new(name, scores, first, Vec::new()))?))
        });
        rows.collect()
    }
}

/// Every controller's scores on these of the trial's plants.
fn scores(py: Python<'_>, compared: &Compared, trial: &Trial) -> PyResult<Vec<Vec<Score>>> {
    let mut all = Vec::new();
    for (_, controller) in &compared.controllers {
        all.push(py.detach(|| trial.scores_until(controller, NEVER)).expect("nothing stops it"));
        py.check_signals()?;
    }
    Ok(all)
}

/// For each of these gains, in order: what each plant costs, and a row as `host-sim compare --json` has it,
/// against the first.
#[pyfunction]
#[pyo3(signature = (preset, controllers, plants, seed))]
#[expect(clippy::needless_pass_by_value, reason = "as Python's values are extracted")]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    preset: &str,
    controllers: Vec<Named>,
    plants: usize,
    seed: u64,
) -> PyResult<Vec<(Bound<'py, PyArray1<f64>>, String)>> {
    let compared = Compared::new(preset, &controllers, plants, seed)?;
    let all = scores(py, &compared, &compared.trial)?;
    compared.rows(py, &all)
}

/// A chunk of [`compare`]: the plants from `first` to before `end`, as bytes for [`compare_chunks`].
#[pyfunction]
#[pyo3(signature = (preset, controllers, plants, seed, first, end))]
#[expect(clippy::needless_pass_by_value, reason = "as Python's values are extracted")]
pub(crate) fn compare_chunk<'py>(
    py: Python<'py>,
    preset: &str,
    controllers: Vec<Named>,
    plants: usize,
    seed: u64,
    first: usize,
    end: usize,
) -> PyResult<Bound<'py, PyBytes>> {
    let compared = Compared::new(preset, &controllers, plants, seed)?;
    within("first", first, 0, plants - 1)?;
    within("end", end, first + 1, plants)?;
    let all = scores(py, &compared, &compared.trial.only(first..end))?;
    Ok(PyBytes::new(py, &checkpoint::encode(&compared.identity, &(first, all))))
}

/// [`compare`] from all of its chunks, in the order of their plants.
#[pyfunction]
#[pyo3(signature = (preset, controllers, plants, seed, chunks))]
#[expect(clippy::needless_pass_by_value, reason = "as Python's values are extracted")]
pub(crate) fn compare_chunks<'py>(
    py: Python<'py>,
    preset: &str,
    controllers: Vec<Named>,
    plants: usize,
    seed: u64,
    chunks: Vec<Vec<u8>>,
) -> PyResult<Vec<(Bound<'py, PyArray1<f64>>, String)>> {
    let compared = Compared::new(preset, &controllers, plants, seed)?;
    let mut all: Vec<Vec<Score>> = vec![Vec::new(); controllers.len()];
    for (number, chunk) in chunks.iter().enumerate() {
        let told = |error: Error| PyValueError::new_err(format!("chunk {number}: {error}"));
        let (first, scores): (usize, Vec<Vec<Score>>) =
            checkpoint::decode(chunk, &compared.identity).map_err(told)?;
        let follows = scores.len() == all.len() && all.iter().all(|before| before.len() == first);
        if !follows {
            return Err(PyValueError::new_err(format!(
                "chunk {number} begins with plant {first}; allowed: in order"
            )));
        }
        all.iter_mut().zip(scores).for_each(|(all, scores)| all.extend(scores));
    }
    if all.iter().any(|scores| scores.len() != plants) {
        return Err(PyValueError::new_err(format!(
            "chunks do not have {plants} plants; allowed: all of them"
        )));
    }
    compared.rows(py, &all)
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
