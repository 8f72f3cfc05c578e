//! `--worst`: the plants that cost most, as files that `simulate` flies.

use crate::cli::tables;
use crate::error::Outcome;
use crate::files::output::{self, Outputs};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use twinrotor::controller::ControllerSettings;
use twinrotor::plant::presets::Rig;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::{is_text, rig};
use twinrotor_tune::robust::{Draw, Score, Trial};

/// Plants that are kept of each controller.
const KEPT: usize = 5;

/// A controller's name as that of a file.
fn stem(name: &str) -> String {
    let name = name.split_once(" (").map_or(name, |(name, _)| name);
    if is_text(name) {
        return Path::new(name).file_stem().map_or_else(|| name.into(), |s| s.to_string_lossy()).into_owned();
    }
    name.to_owned()
}

/// The files of a controller: its gains, then of each plant the rig and the scenario.
fn names(folder: &Path, name: &str) -> (PathBuf, Vec<[PathBuf; 2]>) {
    let stem = stem(name);
    let of = |k: usize| {
        [format!("{stem}-{k}.toml"), format!("{stem}-{k}-scenario.toml")].map(|file| folder.join(file))
    };
    (folder.join(format!("{stem}.toml")), (1..=KEPT).map(of).collect())
}

/// Can they be written?
pub(super) fn check<'a>(
    folder: &Path,
    controllers: impl Iterator<Item = &'a String>,
    outputs: &mut Outputs,
) -> Outcome<()> {
    output::check_folder("--worst", folder)?;
    for name in controllers {
        let (gains, plants) = names(folder, name);
        outputs.writes("--worst", &gains)?;
        for file in plants.iter().flatten() {
            outputs.writes("--worst", file)?;
        }
    }
    Ok(())
}

/// Writes those of each controller, and says how they are flown.
pub(super) fn write(
    folder: &Path,
    preset: &str,
    trial: &Trial,
    controllers: &[(String, ControllerSettings<f64>)],
    scores: &[Vec<Score>],
    outputs: &mut Outputs,
) -> String {
    let mut told = "worst plants, most first:\n".to_owned();
    for ((name, controller), scores) in controllers.iter().zip(scores) {
        let (gains, files) = names(folder, name);
        outputs.write(&gains, GainsFile { controller: *controller, provenance: None }.to_toml().as_bytes());
        let mut plants = Vec::new();
        for ((plant, score), [rig_file, scenario_file]) in worst(scores).into_iter().zip(&files) {
            let Some(draw) = trial.plants.get(plant) else { continue };
            outputs.write(rig_file, rig::to_toml(&Rig { plant: draw.plant, ..trial.truth }).as_bytes());
            outputs.write(scenario_file, scenario(trial, draw).as_bytes());
            let failed = if score.failed { ", failed" } else { "" };
            plants.push(format!("{} (c {:.2}{failed})", plant + 1, score.cost()));
        }
        told += &tables::listed(&format!("  {name}:"), &plants);
        told.push('\n');
    }
    let (gains, files) = names(folder, &controllers[0].0);
    let [rig_file, scenario_file] = &files[0];
    let _ = writeln!(
        told,
        "the step of the first once more:\n  \
         host-sim simulate --preset {preset} --fidelity rig --gains {} \\\n    \
         --true-rig {} --scenario {}",
        gains.display(),
        rig_file.display(),
        scenario_file.display()
    );
    told
}

/// The plants that failed first, then by what they cost, most first.
fn worst(scores: &[Score]) -> Vec<(usize, &Score)> {
    let mut all: Vec<(usize, &Score)> = scores.iter().enumerate().collect();
    let before = |a: &(usize, &Score), b: &(usize, &Score)| {
        b.1.failed.cmp(&a.1.failed).then(b.1.cost().total_cmp(&a.1.cost())).then(a.0.cmp(&b.0))
    };
    // Of millions, few are put in order.
    if all.len() > KEPT {
        all.select_nth_unstable_by(KEPT - 1, before);
        all.truncate(KEPT);
    }
    all.sort_by(before);
    all
}

/// The step of the robust objective with what is this plant's own.
fn scenario(trial: &Trial, draw: &Draw) -> String {
    let Trial { allowance, step, .. } = trial;
    let (phase, volts) = (draw.encoder_phase, draw.disturbance);
    let end = 2.0 * allowance;
    // As it was typed, and not what is left of it after radians.
    let [pitch, yaw] = [step.pitch, step.yaw].map(|angle| (1e9 * angle.to_degrees()).round() / 1e9);
    format!(
        "duration = {end:?}\n\n\
         [start]\nencoder_phase = [{:?}, {:?}]\n\n\
         [pitch.steps]\ninitial_deg = {pitch:?}\njumps = []\n\n\
         [yaw.steps]\ninitial_deg = {yaw:?}\njumps = []\n\n\
         [[events.step]]\nwindow = [{allowance:?}, {end:?}]\nvolts = [{:?}, {:?}]\n",
        phase.pitch, phase.yaw, volts.main, volts.tail
    )
}
