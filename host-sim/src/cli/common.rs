//! Flags that several commands share, and how they are resolved.

use crate::error::{Failure, Outcome};
use crate::files;
use crate::files::checkpoint;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use twinrotor::axes::PerMotor;
use twinrotor::settings::LARGEST;
use twinrotor_sim::Error;
use twinrotor_sim::error::at_least;
use twinrotor_sim::rig::NamedRig;

/// Of every command that computes.
#[derive(Debug, Args)]
pub(super) struct Common {
    /// Rig: paper, paper-fixed, aero, aero2, aero-lab, heli, or a FILE.toml of your own
    #[arg(long, default_value = "paper")]
    pub preset: String,
    /// Rotor lag of both motors \[s\] instead of the preset's; it acts with --fidelity rig
    #[arg(long, value_name = "S")]
    pub rotor_lag: Option<f64>,
    /// Of everything random
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Print one JSON document and nothing else
    #[arg(long)]
    pub json: bool,
    /// Threads to compute on [default: all]; the results do not depend on it
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
}

impl Common {
    /// Reads the rig and sets the threads.
    pub(super) fn resolve(&self) -> Outcome<NamedRig> {
        let mut named = files::rig(&self.preset)?;
        if let Some(lag) = self.rotor_lag {
            named.rig.plant.rotor_time_constant = PerMotor::both(at_least("--rotor-lag", lag, 0.0, false)?);
        }
        if let Some(threads) = self.threads {
            if threads == 0 || threads > 1024 {
                return Err(Failure::Input(format!("--threads is {threads}; allowed: 1 to 1024")));
            }
            // Fails only if the pool was set before, which one command does not do.
            let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
        }
        Ok(named)
    }
}

/// Of every command that searches.
#[derive(Debug, Args)]
pub(super) struct Checkpoint {
    /// Keep the state of the search in this file, so that it can be resumed
    #[arg(id = "checkpoint", long = "checkpoint", value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Go on from --checkpoint
    #[arg(long, requires = "checkpoint")]
    pub resume: bool,
}

impl Checkpoint {
    /// What the file holds with `--resume`; without, a new search and a checkpoint that nothing is lost by.
    pub(super) fn resume_or<S>(
        &self,
        identity: String,
        resume: fn(&[u8], &str) -> Result<S, Error>,
        new: impl FnOnce(String) -> S,
    ) -> Outcome<S> {
        match &self.file {
            Some(path) if self.resume => {
                let resumed = resume(&checkpoint::read(path)?, &identity);
                return Ok(resumed.map_err(|e| e.within(path.display()))?);
            }
            Some(path) => checkpoint::check_fresh(path)?,
            None => {}
        }
        Ok(new(identity))
    }
}

/// What says that a flag would not be heeded, and why.
pub(super) fn no_effect(flag: &str, when: &str, why: &str) -> Failure {
    Failure::Input(format!("{flag} has no effect {when}: {why}; leave it out"))
}

/// Requires a number of at least `least` and at most `most`.
pub(super) fn within(flag: &str, value: usize, least: usize, most: usize) -> Outcome<usize> {
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    Err(Failure::Input(format!("{flag} is {value}; allowed: {least} to {most}")))
}

/// A bar on a terminal for `total` pieces of work, drawn as `template` says.
pub(super) fn bar(total: usize, template: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(template).expect("the template is well-formed");
    ProgressBar::new(total as u64).with_style(style)
}

/// How a search ended, but for one that failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// The budget is used up.
    Complete,
    /// The time limit came first.
    TimeLimit,
    /// It was interrupted.
    Interrupted,
}

/// Two numbers with a comma between them.
pub(super) fn pair(flag: &str, text: &str) -> Outcome<[f64; 2]> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let usable = |number: &f64| number.is_finite() && number.abs() <= LARGEST;
    match numbers.as_deref() {
        Some([first, second]) if usable(first) && usable(second) => Ok([*first, *second]),
        _ => Err(Failure::Input(format!(
            "{flag} is '{text}'; allowed: two finite numbers such as 1,25, each at most {LARGEST:e} in size"
        ))),
    }
}
