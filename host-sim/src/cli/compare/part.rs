//! A comparison in parts: what each machine writes of its plants, and what is told of all.

use crate::error::{Failure, Outcome};
use crate::files::checkpoint as file;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use twinrotor::axes::PerMotor;
use twinrotor::controller::ControllerSettings;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::rig;
use twinrotor_sim::scenario::Scenario;
use twinrotor_tune::checkpoint::{self, Identity};
use twinrotor_tune::robust::{Judged, Scatter, Scenes, Score, Shard, Trial};

/// What a comparison is, for its report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Head {
    /// What was typed, but for where it goes.
    pub(super) command: String,
    pub(super) preset: String,
    pub(super) plants: usize,
    pub(super) scatter: Scatter,
    pub(super) scenes: Scenes,
    pub(super) seed: u64,
    pub(super) rotor_lag: PerMotor<f64>,
    /// Each with what it has beyond its law.
    pub(super) controllers: Vec<(String, Vec<String>)>,
}

/// A scenario, for its report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Course {
    pub(super) name: String,
    pub(super) duration: f64,
    pub(super) hot: bool,
}

/// What came of each controller's flights, in the order of the plants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) enum Flown {
    /// The robust objective's step, and its scenes.
    Steps(Vec<Vec<Score>>),
    /// A scenario.
    Scenario(Course, Vec<Vec<Judged>>),
}

impl Flown {
    /// That of the plants that follow.
    fn join(&mut self, next: Self) -> bool {
        fn join<T>(all: &mut [Vec<T>], next: Vec<Vec<T>>) -> bool {
            let fits = all.len() == next.len();
            all.iter_mut().zip(next).for_each(|(all, next)| all.extend(next));
            fits
        }
        match (self, next) {
            (Self::Steps(all), Self::Steps(next)) => join(all, next),
            (Self::Scenario(_, all), Self::Scenario(_, next)) => join(all, next),
            _ => false,
        }
    }

    /// Are there so many controllers, each with so many flights?
    fn has(&self, controllers: usize, plants: usize) -> bool {
        fn fits<T>(all: &[Vec<T>], controllers: usize, plants: usize) -> bool {
            all.len() == controllers && all.iter().all(|flights| flights.len() == plants)
        }
        match self {
            Self::Steps(all) => fits(all, controllers, plants),
            Self::Scenario(_, all) => fits(all, controllers, plants),
        }
    }
}

/// All that decides what comes out.
pub(super) fn identity(
    head: &Head,
    trial: &Trial,
    controllers: &[(String, ControllerSettings<f64>)],
    scenario: Option<&Scenario>,
) -> Identity {
    let mut identity = Identity::new()
        .with("version", env!("CARGO_PKG_VERSION"))
        .with("preset", &head.preset)
        .with("seed", head.seed)
        .with("plants", head.plants)
        .with("spread", head.scatter.constants)
        .with("lag spread", head.scatter.lag)
        .with("scenes", format!("{:?}", trial.scenes))
        .with("step", format!("{:?}", trial.step))
        .with("allowance", trial.allowance)
        .with("scenario", scenario.map_or_else(|| "none".to_owned(), |scenario| format!("{scenario:?}")))
        .with("controllers", controllers.iter().map(|(name, _)| &**name).collect::<Vec<_>>().join(","))
        .with_toml(&rig::to_toml(&trial.rig))
        .with("true rig", rig::to_toml(&trial.truth))
        .with("board", format!("{:?} {:?}", trial.rig.board, trial.truth.board))
        .with("first plant", format!("{:?}", trial.plants.first()));
    for (name, controller) in controllers {
        let gains = GainsFile { controller: *controller, provenance: None };
        identity = identity.with(&format!("gains of {name}"), gains.to_toml());
    }
    identity
}

/// A part's file.
pub(super) fn encode(identity: &Identity, head: &Head, shard: Shard, flown: &Flown) -> Vec<u8> {
    checkpoint::encode(identity, &(head, shard, flown))
}

/// The whole that these files are the parts of, in any order.
pub(super) fn read(paths: &[PathBuf]) -> Outcome<(Head, Flown)> {
    let mut run = None;
    let mut parts: Vec<(&Path, Head, Shard, Flown)> = Vec::new();
    for path in paths {
        let bytes = file::read(path)?;
        let told = |error: twinrotor_sim::Error| error.within(path.display());
        let run = match &run {
            Some(run) => run,
            None => run.insert(checkpoint::identity(&bytes).map_err(told)?),
        };
        let (head, shard, flown) = checkpoint::decode::<(Head, Shard, Flown)>(&bytes, run).map_err(told)?;
        let sound = shard.is_sound()
            && (2..=super::MOST_PLANTS).contains(&head.plants)
            && flown.has(head.controllers.len(), shard.range(head.plants).len());
        if !sound {
            return Err(told(checkpoint::damaged()).into());
        }
        parts.push((path, head, shard, flown));
    }
    parts.sort_by_key(|(_, _, shard, _)| shard.number);
    let of = parts.first().map_or(0, |(_, _, shard, _)| shard.of);
    let input = |text: String| Failure::Input(text);
    for (path, _, shard, _) in &parts {
        if shard.of != of {
            let here = path.display();
            return Err(input(format!(
                "{here} is one of {} parts; allowed: of {of}, as the others",
                shard.of
            )));
        }
    }
    for pair in parts.windows(2) {
        let [(first, _, shard, _), (second, _, next, _)] = pair else { continue };
        if shard == next {
            let (first, second) = (first.display(), second.display());
            return Err(input(format!(
                "{first} and {second} are both part {}; allowed: each once",
                next.number
            )));
        }
    }
    let missing: Vec<String> = (1..=of)
        .filter(|number| !parts.iter().any(|(_, _, shard, _)| shard.number == *number))
        .take(5)
        .map(|number| number.to_string())
        .collect();
    if !missing.is_empty() {
        let (there, which) = (parts.len(), missing.join(", "));
        return Err(input(format!("there are {there} parts of {of}; allowed: all; missing: {which}")));
    }
    let mut parts = parts.into_iter();
    let none = || Failure::Input("no part is named; allowed: all parts of a comparison".to_owned());
    let (_, head, _, mut flown) = parts.next().ok_or_else(none)?;
    for (path, its, _, next) in parts {
        if its != head || !flown.join(next) {
            return Err(checkpoint::damaged().within(path.display()).into());
        }
    }
    Ok((head, flown))
}
