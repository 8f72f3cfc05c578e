//! Many environments at once, in lanes and threads.

mod boards;
mod crew;
mod share;
mod task;
mod volts;
mod world;

use crate::parts::{named_rig, raised, stable_gains_of, within, word};
use crew::Crew;
use numpy::{
    PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1,
    PyReadwriteArray2,
};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use share::{Job, Share, Wish};
use std::sync::{Mutex, MutexGuard};
use std::thread::available_parallelism;
use task::{Autoreset, Episode, Kind, SEEN, Task};
use twinrotor::SAMPLE_TIME;
use twinrotor::pipeline::Settings;
use twinrotor::real::Real;
use twinrotor_sim::Error;
use twinrotor_sim::lanes::LANES;

const AUTORESETS: [(&str, Autoreset); 3] = [
    ("next-step", Autoreset::NextStep),
    ("same-step", Autoreset::SameStep),
    ("disabled", Autoreset::Disabled),
];

/// Many helicopters, each an environment of its own, that fly on together.
#[pyclass(module = "twinrotor._native", subclass, frozen)]
pub(crate) struct Batch {
    crew: Mutex<Crew>,
    autoreset: Autoreset,
    /// How many environments.
    #[pyo3(get)]
    count: usize,
    /// How many threads.
    #[pyo3(get)]
    threads: usize,
}

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (
        preset, count, action, gains, supervised, true_rig, spread, seconds, autoreset, threads
    ))]
    #[expect(clippy::too_many_arguments, reason = "Python gives them their names")]
    fn new(
        preset: &str,
        count: usize,
        action: &str,
        gains: Option<&str>,
        supervised: bool,
        true_rig: Option<&str>,
        spread: bool,
        seconds: f64,
        autoreset: &str,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let named = named_rig(preset)?;
        let count = within("count", count, 1, 1_000_000)?;
        let kind = if word("action", action, &[("volts", false), ("setpoint", true)])? {
            let controller = stable_gains_of(gains, &named)?.controller;
            let settings = Settings::new(&named.rig, controller, SAMPLE_TIME).map(f32::from_f64);
            Kind::Setpoint { believed: named.rig, settings, supervised }
        } else {
            Kind::Volts
        };
        let least = f64::from(task::TICKS) * SAMPLE_TIME;
        if !(least..=3600.0).contains(&seconds) {
            return Err(raised(&Error::invalid("seconds", seconds, format!("{least} to 3600"))));
        }
        let autoreset = word("autoreset", autoreset, &AUTORESETS)?;
        let groups = count.div_ceil(LANES);
        let threads = match threads {
            Some(threads) => within("threads", threads, 1, 1024)?,
            None => available_parallelism().map_or(1, Into::into),
        }
        .min(groups);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 180,000")]
        let steps = (seconds / least).round() as u32;
        let rig = true_rig.map_or(Ok(named.rig), |truth| named_rig(truth).map(|truth| truth.rig))?;
        let task = Task { rig, kind, spread, steps, autoreset };
        // Whole groups, as even as can be.
        let end = |share: usize| (groups * share / threads * LANES).min(count);
        let shares = (0..threads).map(|k| Share::new(&task, end(k + 1) - end(k))).collect();
        let crew = Crew::new(shares)
            .map_err(|error| PyRuntimeError::new_err(format!("no thread could be started: {error}")))?;
        Ok(Self { crew: Mutex::new(crew), autoreset, count, threads })
    }

    /// Those whose mask is true begin their next episode, or the first one of their seed.
    fn reset(
        &self,
        py: Python<'_>,
        mask: PyReadonlyArray1<'_, bool>,
        seeds: Option<PyReadonlyArray1<'_, u64>>,
        mut observations: PyReadwriteArray2<'_, f32>,
    ) -> PyResult<()> {
        let mask = self.column("mask", mask.as_slice()?)?;
        let seeds = seeds.as_ref().map(|seeds| self.column("seeds", seeds.as_slice()?)).transpose()?;
        let mut crew = self.crew()?;
        let mut at = 0;
        for share in crew.shares_mut() {
            for wish in &mut share.wishes {
                *wish = match (mask[at], seeds) {
                    (false, _) => Wish::Stay,
                    (true, None) => Wish::Next,
                    (true, Some(seeds)) => Wish::Seed(seeds[at]),
                };
                at += 1;
            }
        }
        work(py, &mut crew, Job::Reset)?;
        copy_rows(&crew, &mut observations, |share| &share.results.observations)
    }

    /// An action each, of two numbers within ±1; what came of it is written into the arrays.
    #[expect(clippy::too_many_arguments, reason = "Python gives them their names")]
    fn step(
        &self,
        py: Python<'_>,
        actions: PyReadonlyArray2<'_, f32>,
        mut observations: PyReadwriteArray2<'_, f32>,
        mut finals: PyReadwriteArray2<'_, f32>,
        mut rewards: PyReadwriteArray1<'_, f64>,
        mut terminated: PyReadwriteArray1<'_, bool>,
        mut truncated: PyReadwriteArray1<'_, bool>,
    ) -> PyResult<()> {
        let actions = self.column("actions", actions.as_slice()?.as_chunks::<2>().0)?;
        if let Some(at) = actions.iter().position(|action| !action.iter().all(|x| x.is_finite())) {
            let text = format!("action {at} is {:?}; allowed: finite numbers, -1 to 1", actions[at]);
            return Err(PyValueError::new_err(text));
        }
        let mut crew = self.crew()?;
        let disabled = self.autoreset == Autoreset::Disabled;
        let waits = |episode: &Episode| !episode.has_begun() || (disabled && episode.over);
        if let Some(at) = crew.shares().flat_map(Share::episodes).position(waits) {
            let text = format!("environment {at} is in no episode; allowed: a step after its reset");
            return Err(PyValueError::new_err(text));
        }
        let mut rest = actions;
        for share in crew.shares_mut() {
            let (own, others) = rest.split_at(share.count());
            share.actions.copy_from_slice(own);
            rest = others;
        }
        work(py, &mut crew, Job::Step)?;
        copy_rows(&crew, &mut observations, |share| &share.results.observations)?;
        if self.autoreset == Autoreset::SameStep {
            copy_rows(&crew, &mut finals, |share| &share.results.finals)?;
        }
        copy(&crew, rewards.as_slice_mut()?, |share| &share.results.rewards)?;
        copy(&crew, terminated.as_slice_mut()?, |share| &share.results.terminated)?;
        copy(&crew, truncated.as_slice_mut()?, |share| &share.results.truncated)
    }

    /// \[rad\] Where each is to fly: pitch and yaw, a row for each.
    fn goals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let crew = self.crew()?;
        let goals = crew.shares().flat_map(Share::episodes).flat_map(|episode| episode.goal.to_array());
        PyArray1::from_iter(py, goals).reshape([self.count, 2])
    }
}

impl Batch {
    fn crew(&self) -> PyResult<MutexGuard<'_, Crew>> {
        self.crew.try_lock().map_err(|_| PyRuntimeError::new_err("another thread is flying this batch"))
    }

    /// As many as there are environments.
    fn column<'a, T>(&self, name: &str, given: &'a [T]) -> PyResult<&'a [T]> {
        if given.len() == self.count {
            return Ok(given);
        }
        let text = format!("{name} has {} rows; allowed: {}, one for each plant", given.len(), self.count);
        Err(PyValueError::new_err(text))
    }
}

/// On all threads, while Python goes on.
fn work(py: Python<'_>, crew: &mut Crew, job: Job) -> PyResult<()> {
    let all = py.detach(|| crew.work(job));
    all.then_some(()).ok_or_else(|| PyRuntimeError::new_err("a thread of this batch has ended"))
}

/// What all shares have of something, one after the other.
fn copy<T: Copy>(crew: &Crew, into: &mut [T], of: impl Fn(&Share) -> &[T]) -> PyResult<()> {
    let mut rest = into;
    for share in crew.shares() {
        let own = of(share);
        let Some((here, others)) = rest.split_at_mut_checked(own.len()) else {
            return Err(PyValueError::new_err("an array is too short for the batch"));
        };
        here.copy_from_slice(own);
        rest = others;
    }
    Ok(())
}

fn copy_rows(
    crew: &Crew,
    into: &mut PyReadwriteArray2<'_, f32>,
    of: impl Fn(&Share) -> &[[f32; SEEN]],
) -> PyResult<()> {
    copy(crew, into.as_slice_mut()?.as_chunks_mut::<SEEN>().0, of)
}
