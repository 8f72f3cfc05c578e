//! `compare`: controllers side by side on the same plants, none of which they were tuned on: the robust
//! objective's step, or any scenario ([`scenario`]).

pub(super) mod merge;
mod part;
mod scenario;
mod table;
mod told;
mod worst;

use super::common::{self, Common, Device, Spreads, bar, no_effect, pair, truth, within};
use super::{choices, who};
use crate::device;
use crate::error::{Failure, Outcome};
use crate::files::output::{self, Outputs};
use part::{Flown, Head};
use std::path::PathBuf;
use told::{More, Told, Tuned};
use twinrotor::axes::PerAxis;
use twinrotor::controller::ControllerSettings;
use twinrotor::plant::PlantParameters;
use twinrotor_sim::is_text;
use twinrotor_sim::rig::NamedRig;
use twinrotor_sim::scenario::Scenario;
use twinrotor_tune::design::{self, CATALOGUE, Design};
use twinrotor_tune::parallel::NEVER;
use twinrotor_tune::robust::{self, Scatter, Shard, Trial, Tuning};

/// Most plants of a comparison.
const MOST_PLANTS: usize = 10_000_000;
/// Plants that are flown together, by one controller after the other: what a card takes in a launch.
const BLOCK: usize = 1 << 20;

/// What is told of all parts together, or done before there are any.
const NOT_OF_A_PART: [&str; 7] = ["export", "plot", "report", "against", "worst", "tune", "json"];

/// The command without what changes nothing of the numbers.
fn typed_but(args: impl Iterator<Item = String>) -> String {
    const GOES: [&str; 8] =
        ["--report", "--plot", "--export", "--worst", "--shard", "--out", "--threads", "--device"];
    common::typed(args, &GOES, &["--json"])
}

/// Flags of `compare`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    device: Device,
    /// How many plants to draw around the preset
    #[arg(long, value_name = "N", default_value_t = 300)]
    plants: usize,
    #[command(flatten)]
    spreads: Spreads,
    /// What is flown on each plant; J_step is of the step alone
    #[arg(long, default_value = "step", conflicts_with = "scenario")]
    scenes: choices::Scenes,
    /// The rig's world is the only one that controllers are compared in
    #[arg(long, default_value = "rig")]
    fidelity: choices::Fidelity,
    /// Which, by name or gains file, instead of all there are; 'ours' is always there
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    controllers: Vec<String>,
    /// Fly this scenario instead of the robust objective's step: a name, or a FILE.toml of your own
    #[arg(long, conflicts_with_all = ["step", "allowance", "tune", "export", "plot", "report"])]
    scenario: Option<String>,
    /// Begin the scenario with motors that a minute of squares has warmed
    #[arg(long, requires = "scenario")]
    hot: bool,
    /// Step to fly, in degrees, both positive, instead of 15,40
    #[arg(long, value_name = "PITCH,YAW", allow_hyphen_values = true)]
    step: Option<String>,
    /// When the disturbance sets in, and half of the flight, in s, instead of what the preset allows
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    allowance: Option<f64>,
    /// True lag of both rotors, in s, in every plant, whatever the controllers believe
    #[arg(long, value_name = "S", help_heading = "Rig")]
    true_lag: Option<f64>,
    /// Fly the same plants again with every lag at these multiples of what is believed, such as .2,.5,1,2,3
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        allow_negative_numbers = true,
        conflicts_with_all = ["true_lag", "scenario", "shard"],
        help_heading = "Rig"
    )]
    true_lags: Vec<f64>,
    /// Rig that every plant is in truth, all of it, whatever the controllers believe; lag and disturbance are
    /// still drawn
    #[arg(long, value_name = "RIG", help_heading = "Rig")]
    true_rig: Option<String>,
    /// Folder of the tuned gains: DIR/PRESET.toml is ours, DIR/compared/PRESET/NAME.toml the others'
    #[arg(long, value_name = "DIR", default_value = "gains")]
    gains: PathBuf,
    #[command(flatten)]
    told: Told,
    /// Keep the five plants that cost each controller most in this folder, as files that 'simulate' flies
    #[arg(long, value_name = "DIR", help_heading = "Output", conflicts_with = "scenario")]
    worst: Option<PathBuf>,
    /// Fly one part of N of the plants and write it into --out, for 'merge': I/N, such as 3/16
    #[arg(long, value_name = "I/N", requires = "out", conflicts_with_all = NOT_OF_A_PART)]
    shard: Option<Shard>,
    /// File of the part
    #[arg(long, value_name = "PART", requires = "shard", help_heading = "Output")]
    out: Option<PathBuf>,
    /// First tune all but ours with one budget, N searches of 500 evaluations, and write the gains into the
    /// folder
    #[arg(long, value_name = "N")]
    tune: Option<usize>,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    if args.fidelity != choices::Fidelity::Rig {
        return Err(Failure::Input("--fidelity is ideal; allowed: rig".to_owned()));
    }
    within("--plants", args.plants, 2, MOST_PLANTS)?;
    let scatter = args.spreads.scatter()?;
    let lags = args.true_lags.iter().map(|lag| robust::check_multiple(*lag).map_err(Failure::of_flag));
    let lags = lags.collect::<Outcome<Vec<_>>>()?;
    let found = args.device.find()?;
    let trial = trial(args, &named, &scatter)?.on(found.device());
    let mut outputs = outputs(args, &named)?;
    let tunings = match args.tune {
        Some(rounds) => tune_all(args, &named, rounds, &scatter, &mut outputs)?,
        None => Vec::new(),
    };
    let controllers = who::all(&args.controllers, &args.gains, &named)?;
    let scenario = args.scenario.as_deref().map(|name| scenario::read(args, name)).transpose()?;
    let typed = std::env::args_os().skip(1).map(|arg| arg.to_string_lossy().into_owned());
    let head = Head {
        command: typed_but(typed),
        preset: named.name.clone(),
        plants: args.plants,
        scatter,
        scenes: args.scenes.into(),
        seed: args.common.seed,
        rotor_lag: named.rig.plant.rotor_time_constant,
        controllers: controllers
            .iter()
            .map(|(name, controller)| (name.clone(), design::uses(controller)))
            .collect(),
    };
    args.told.reference(&head)?;
    if let (Some(shard), Some(path)) = (args.shard, &args.out) {
        let identity = part::identity(&head, &trial, &controllers, scenario.as_ref());
        let flown = fly(&trial.only(shard.range(args.plants)), &controllers, scenario.as_ref(), &found)?;
        outputs.write(path, &part::encode(&identity, &head, shard, &flown));
        return outputs.done();
    }
    if let Some(folder) = &args.worst {
        worst::check(folder, controllers.iter().map(|(name, _)| name), &mut outputs)?;
    }
    let flown = fly(&trial, &controllers, scenario.as_ref(), &found)?;
    let wrong = |(_, controller): &(_, _)| found.all(trial.lag_rows(controller, &lags, NEVER));
    let wrong = controllers.iter().map(wrong).collect::<Outcome<Vec<_>>>()?;
    let mut note = found.note(args.plants, device::RIG_FLIGHTS);
    if let (Some(folder), Flown::Steps(scores)) = (&args.worst, &flown) {
        note += &worst::write(folder, args.common.preset(), &trial, &controllers, scores, &mut outputs);
    }
    note += &tunings.iter().map(Tuned::warnings).collect::<String>();
    let more = More { lags: wrong, tunings, note };
    told::show(&head, &flown, more, &args.told, args.common.json, &mut outputs)?;
    outputs.done()
}

/// All controllers on all plants of the trial.
fn fly(
    trial: &Trial,
    controllers: &[(String, ControllerSettings<f64>)],
    scenario: Option<&Scenario>,
    found: &device::Found,
) -> Outcome<Flown> {
    if let Some(scenario) = scenario {
        return scenario::fly(trial, controllers, scenario);
    }
    let plants = trial.plants.len();
    let bar = bar(plants * controllers.len(), "{bar:32} {pos}/{len} flights, {eta} left");
    let mut all: Vec<_> = controllers.iter().map(|_| Vec::with_capacity(plants)).collect();
    for from in (0..plants).step_by(BLOCK) {
        let block = (plants > BLOCK).then(|| trial.only(from..plants.min(from + BLOCK)));
        let block = block.as_ref().unwrap_or(trial);
        for ((_, controller), scores) in controllers.iter().zip(&mut all) {
            scores.extend(found.all(block.scores_until(controller, NEVER))?);
            bar.inc(block.plants.len() as u64);
        }
    }
    bar.finish_and_clear();
    Ok(Flown::Steps(all))
}

/// What is read and written.
fn outputs(args: &Args, named: &NamedRig) -> Outcome<Outputs> {
    let mut outputs = args.common.outputs();
    outputs.reads("--scenario", args.scenario.as_deref().unwrap_or_default());
    outputs.reads("--true-rig", args.true_rig.as_deref().unwrap_or_default());
    outputs.reads("--gains", who::ours_path(&args.gains, named));
    for name in args.controllers.iter().filter(|name| is_text(name)) {
        outputs.reads("--controllers", name);
    }
    if let Some(rounds) = args.tune {
        within("--tune", rounds, 1, 1_000)?;
        for (name, _) in tuned(args) {
            let path = who::compared_path(&args.gains, named, name);
            output::check_folder("--gains", path.parent().unwrap_or(&args.gains))?;
            outputs.writes("--gains", &path)?;
        }
    }
    args.told.check(&mut outputs)?;
    if let Some(path) = &args.out {
        outputs.writes("--out", path)?;
    }
    Ok(outputs)
}

/// The plants to fly, and how.
fn trial(args: &Args, named: &NamedRig, scatter: &Scatter) -> Outcome<Trial> {
    let allowance = match args.allowance {
        Some(allowance) if (1.0..=120.0).contains(&allowance) => allowance,
        Some(allowance) => {
            return Err(Failure::Input(format!("--allowance is {allowance}; allowed: 1 to 120 s")));
        }
        None => robust::allowance(&named.name, &named.rig),
    };
    let seed = args.common.seed.wrapping_add(robust::UNSEEN);
    let mut trial =
        Trial::within(&named.rig, args.plants, seed, allowance, scatter).flying(args.scenes.into());
    if let Some(text) = &args.step {
        let [pitch, yaw] = pair("--step", text)?;
        if !(pitch > 0.0 && pitch <= 90.0 && yaw > 0.0 && yaw <= 360.0) {
            return Err(Failure::Input(format!("--step is {text}; allowed: above 0 to 90,360 degrees")));
        }
        trial.step = PerAxis::new(pitch, yaw).map(f64::to_radians);
    }
    trial.truth = truth(args.true_rig.as_deref(), args.true_lag, named)?;
    let plant = trial.truth.plant;
    for draw in &mut trial.plants {
        if args.true_rig.is_some() {
            let rotor_time_constant = draw.plant.rotor_time_constant;
            draw.plant = PlantParameters { rotor_time_constant, ..plant };
        }
        if args.true_lag.is_some() {
            draw.plant.rotor_time_constant = plant.rotor_time_constant;
        }
    }
    if args.true_rig.is_some() && args.spreads.spread.is_some() {
        return Err(no_effect("--spread", "with --true-rig", "every plant is that rig"));
    }
    if args.true_lag.is_some() && args.spreads.lag_spread.is_some() {
        return Err(no_effect("--lag-spread", "with --true-lag", "every rotor has that lag"));
    }
    Ok(trial)
}

/// Tunes every kind of controller with the same budget on the same plants, and writes their gains. What flies
/// by default has had more.
fn tune_all(
    args: &Args,
    named: &NamedRig,
    rounds: usize,
    scatter: &Scatter,
    outputs: &mut Outputs,
) -> Outcome<Vec<Tuned>> {
    let tuning = Tuning::standard(named, rounds, args.common.seed, scatter);
    let mut all = Vec::new();
    for (name, design) in tuned(args) {
        let tuned = tuning.run(design)?;
        outputs
            .write(&who::compared_path(&args.gains, named, name), tuning.file(&tuned).to_toml().as_bytes());
        let (evaluations, cost, failures) = (tuned.evaluations(), tuned.cost(), tuning.failures(&tuned));
        let at_bounds = tuned.at_bounds();
        all.push(Tuned { name, rounds, evaluations, cost, failures, at_bounds });
    }
    Ok(all)
}

/// What is tuned for the comparison.
fn tuned(args: &Args) -> impl Iterator<Item = (&'static str, Design)> {
    let wanted = |name: &str| args.controllers.is_empty() || args.controllers.iter().any(|c| c == name);
    CATALOGUE.into_iter().filter(move |(name, _)| *name != "paper" && wanted(name))
}
