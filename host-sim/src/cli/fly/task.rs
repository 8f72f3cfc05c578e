//! What is to be flown, checked before any line is opened.

use super::Args;
use super::inject::by_tick;
use crate::cli::common::tuned_elsewhere;
use crate::cli::next::next;
use crate::cli::simulate::cannot_hold;
use crate::error::{Failure, Outcome};
use crate::files;
use twinrotor::conversation::goal;
use twinrotor::defaults;
use twinrotor::link::{BAUD, Refusal, ticks_per_frame};
use twinrotor::parameters::Parameters;
use twinrotor::real::Real;
use twinrotor::trial::Attempt;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::rig::NamedRig;
use twinrotor_sim::scenario::{Scenario, Start};
use twinrotor_station::image;
use twinrotor_station::session::{Leg, Plan, Write};

/// \[s\] Longest scenario that gains are tried in.
const LONGEST_TRIAL: f64 = 540.0;
/// \[s\] That a trial may take beside the scenario.
const TRIAL_MARGIN: f64 = 60.0;

/// What is to be flown.
pub(super) struct Task {
    pub(super) named: NamedRig,
    pub(super) gains: GainsFile,
    pub(super) gains_name: String,
    pub(super) trial: Option<GainsFile>,
    pub(super) scenario: Scenario,
    /// Those of `--report`, after it.
    pub(super) others: Vec<Scenario>,
    pub(super) parameters: Parameters,
    pub(super) notes: Vec<String>,
}

/// What the flags ask for.
pub(super) fn task(args: &Args, simulated: bool) -> Outcome<Task> {
    let mut named = files::rig(&args.preset)?;
    named.rig.board = args.board;
    let (gains_name, gains) = match &args.gains {
        Some(name) => (name.clone(), files::gains("--gains", name)?),
        None => {
            let controller = defaults::named(&args.preset).ok_or_else(|| {
                Failure::Input(format!(
                    "--gains is missing, and a rig of your own has none built in; tune some: {}",
                    next("tune").with("--preset", &args.preset).with("--objective", "robust")
                ))
            })?;
            (format!("{}'s own", args.preset), GainsFile { controller, provenance: None })
        }
    };
    gains.require_stable(&named.name, &named.rig).map_err(|error| error.within(&gains_name))?;
    let parameters = Parameters::new(&named.rig, &gains.settings(&named.rig));
    parameters.validate().map_err(image::unusable)?;
    let mut scenario = files::scenario_to_inject(&args.scenario)?;
    let mut notes = Vec::new();
    if scenario.start != Start::default() {
        notes.push("the scenario's start is left out: a board begins where its rig rests".to_owned());
        scenario.start = Start::default();
    }
    if !simulated && !scenario.is_undisturbed() {
        let why = "nothing but the air disturbs a rig, and its hardware is what it is";
        notes.push(format!("the scenario's disturbances, events and hardware are left out: {why}"));
        scenario = scenario.undisturbed();
    }
    if args.report.is_some() && !scenario.inject.is_empty() {
        let why = "a report is of sound flights; leave one out";
        let name = &scenario.name;
        return Err(Failure::Input(format!(
            "--report cannot be with --scenario {name}, which injects: {why}"
        )));
    }
    if args.verify && !scenario.is_undisturbed() {
        return Err(Failure::Input(format!(
            "--verify cannot be with --scenario {}: what befalls the rig is not computed once more; leave \
             one out",
            scenario.name
        )));
    }
    refuse_out_of_range(&scenario, &parameters)?;
    notes.extend(cannot_hold(&gains.settings(&named.rig), &scenario));
    notes.extend(told_of(&gains_name, tuned_elsewhere(&named.name, &gains)));
    let trial = |name: &String| -> Outcome<GainsFile> {
        let gains = files::gains("--trial", name)?;
        gains.require_stable(&named.name, &named.rig).map_err(|error| error.within(name))?;
        Ok(gains)
    };
    let trial = args.trial.as_ref().map(trial).transpose()?;
    if let (Some(name), Some(gains)) = (&args.trial, &trial) {
        notes.extend(told_of(name, tuned_elsewhere(&named.name, gains)));
    }
    if trial.is_some() && scenario.duration > LONGEST_TRIAL {
        return Err(Failure::Input(format!(
            "--scenario {} lasts {} s; allowed: at most {LONGEST_TRIAL} s with --trial, which a board ends \
             after 10 minutes",
            scenario.name, scenario.duration
        )));
    }
    let others = if args.report.is_some() { others(args, &parameters, &mut notes)? } else { Vec::new() };
    Ok(Task { named, gains, gains_name, trial, scenario, others, parameters, notes })
}

/// A note with the file that it is of.
fn told_of(name: &str, note: Option<String>) -> Option<String> {
    note.map(|note| format!("{name}: {note}"))
}

/// Every scenario of a folder, by name, but for those beyond what the rig may do.
fn others(args: &Args, parameters: &Parameters, notes: &mut Vec<String>) -> Outcome<Vec<Scenario>> {
    let folder = &args.scenarios;
    let failed = |error: std::io::Error| {
        Failure::Input(format!("--scenarios {} cannot be read: {error}", folder.display()))
    };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            names.push(path.display().to_string());
        }
    }
    names.sort();
    let mut found = Vec::new();
    for name in names {
        let mut scenario = files::scenario_to_inject(&name)?;
        if !scenario.inject.is_empty() {
            notes.push(format!("left out: {name}: it injects something"));
            continue;
        }
        scenario.disturbance = None;
        match refuse_out_of_range(&scenario, parameters) {
            Ok(()) => found.push(scenario),
            Err(beyond) => notes.push(format!("left out: {beyond}")),
        }
    }
    Ok(found)
}

/// Before anything is armed: a scenario that a board would refuse a setpoint of.
fn refuse_out_of_range(scenario: &Scenario, parameters: &Parameters) -> Outcome<()> {
    let references = scenario.references::<f32>();
    let found = (0_u32..)
        .zip(&references)
        .find_map(|(tick, reference)| Some((tick, reference, goal::outside(&parameters.limits, reference)?)));
    let Some((tick, reference, Refusal::Setpoint { field, high, .. })) = found else { return Ok(()) };
    let (value, unit) = match field.as_str() {
        "setpoint.angle.pitch" => (reference.angle.pitch, "rad"),
        "setpoint.angle.yaw" => (reference.angle.yaw, "rad"),
        "setpoint.rate.pitch" => (reference.rate.pitch, "rad/s"),
        "setpoint.rate.yaw" => (reference.rate.yaw, "rad/s"),
        "setpoint.accel.pitch" => (reference.accel.pitch, "rad/s²"),
        _ => (reference.accel.yaw, "rad/s²"),
    };
    Err(Failure::Input(format!(
        "--scenario {}: after {:.3} s {field} is {value} {unit}; allowed: {} to {high} {unit}",
        scenario.name,
        f64::from(tick) * twinrotor::SAMPLE_TIME,
        -high
    )))
}

/// The session that flies it.
pub(super) fn plan(args: &Args, task: &Task, simulated: bool) -> Outcome<Plan> {
    let fly = || Leg::Fly(task.scenario.references());
    let mut legs = vec![fly()];
    if let Some(trial) = &task.trial {
        // What is compared begins with motors as warm: both flights come after one.
        legs.push(fly());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 10 minutes")]
        let revert_ms = ((task.scenario.duration + TRIAL_MARGIN) * 1e3) as u32;
        let controller = trial.settings(&task.named.rig).map(f32::from_f64).controller;
        let last = if args.accept { Leg::Accept } else { Leg::Revert };
        let attempt = Attempt { revert_ms, ..Attempt::new(controller) };
        legs.extend([Leg::Try(Box::new(attempt)), fly(), last]);
    }
    legs.extend(task.others.iter().map(|other| Leg::Fly(other.references())));
    Ok(Plan {
        board: args.board,
        parameters: task.parameters,
        write: match (args.write, args.yes) {
            (true, _) => Write::Always,
            (false, true) => Write::Never,
            (false, false) => Write::Ask,
        },
        ask: !simulated && !args.yes,
        frame_every: ticks_per_frame(BAUD),
        injections: by_tick(&[&args.inject[..], &task.scenario.inject].concat(), task.scenario.duration)?,
        legs,
        save: args.save,
    })
}
