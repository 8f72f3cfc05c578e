//! `pareto`: no single best, but the choice there is.

use super::common::{Common, Device, Spreads, bar, within};
use super::{choices, print, print_json, tables};
use crate::error::{Failure, Outcome};
use crate::figures;
use crate::files;
use crate::files::export;
use crate::files::figure;
use crate::files::output::{self, Outputs};
use crate::stop;
use serde::Serialize;
use std::path::{Path, PathBuf};
use twinrotor_sim::error::{at_least, known_name};
use twinrotor_sim::gains_file::{GainsFile, Provenance};
use twinrotor_sim::rig::NamedRig;
use twinrotor_sim::table::{Column, Table};
use twinrotor_tune::design::CATALOGUE;
use twinrotor_tune::optimise::{Bounds, Compromise, Draws, knee, pareto_front};
use twinrotor_tune::robust::{self, Score, Terms, Trial};
use twinrotor_tune::tunable::Tunable;

/// Flags of `pareto`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    device: Device,
    /// Whose parameters, around its design
    #[arg(long, default_value = "integral", value_name = "NAME")]
    controller: String,
    /// Start from these gains instead
    #[arg(long, value_name = "FILE", conflicts_with = "controller")]
    start: Option<String>,
    /// On how many plants
    #[arg(long, value_name = "N", default_value_t = 16)]
    plants: usize,
    #[command(flatten)]
    spreads: Spreads,
    /// What is flown on each plant; a controller that fails in any flight loses to all that do not
    #[arg(long, default_value = "step")]
    scenes: choices::Scenes,
    /// Points of the front, at most
    #[arg(long, value_name = "N", default_value_t = 40)]
    population: usize,
    /// Generations after the first
    #[arg(long, value_name = "N", default_value_t = 25)]
    iterations: usize,
    /// Factor within which each parameter is searched
    #[arg(long, value_name = "FACTOR", default_value_t = 4.0, allow_negative_numbers = true)]
    range: f64,
    /// Folder for front.svg, front.csv and the gains of every point, 01.toml and so on; made if it is not
    /// there
    #[arg(long, value_name = "DIR", default_value = "front")]
    out: PathBuf,
}

/// What is traded: means over the plants of [`Terms`], as the robust objective weighs them.
const OBJECTIVES: [&str; 3] = ["settling_s", "disturbance_rms_deg", "voltage_variation_v_per_s"];

#[derive(Debug, Serialize)]
struct Document<'a> {
    preset: &'a str,
    controller: &'a str,
    seed: u64,
    plants: usize,
    spread: f64,
    lag_spread: f64,
    evaluations: usize,
    objectives: [&'static str; 3],
    /// Counted from 1, as the files are.
    chosen: usize,
    front: &'a [Compromise],
}

/// What positions cost, unless nobody waits for it.
fn costs(trial: &Trial, tunable: &Tunable, positions: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let controllers: Vec<_> = positions.iter().map(|x| (tunable.controller(x), f64::INFINITY)).collect();
    let flown = trial.all_below(&controllers, &stop::requested)?;
    flown.into_iter().map(|(scores, _)| scores.as_deref().map(cost)).collect()
}

/// What a controller with these scores costs.
fn cost(scores: &[Score]) -> Vec<f64> {
    let mean = Terms::mean(scores.iter().map(Score::terms));
    // A controller that fails on some plants is no compromise: it loses to any that does not.
    let failed = 100.0 * scores.iter().filter(|s| s.failed).count() as f64;
    vec![mean.settling + failed, mean.disturbance + failed, 1e3 * (mean.variation + failed)]
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    check(args)?;
    let flying = args.device.find()?;
    let start = match &args.start {
        Some(path) => files::gains("--start", path)?.controller,
        None => known_name("controller", &args.controller, &CATALOGUE)?(&named.rig),
    };
    let tunable = Tunable::new(&start, &[])?;
    let allowance = robust::allowance(&named.name, &named.rig);
    let scatter = args.spreads.scatter()?;
    let trial = Trial::within(&named.rig, args.plants, args.common.seed, allowance, &scatter)
        .flying(args.scenes.into())
        .on(flying.device());
    let reach = args.range.ln();
    let bounds = Bounds::new(vec![[-reach, reach]; tunable.names().len()])?;
    output::check_folder("--out", &args.out)?;

    let mut outputs = args.common.outputs();
    outputs.reads("--start", args.start.as_deref().unwrap_or_default());
    for name in names(&args.out) {
        outputs.spares("--out", &name)?;
    }

    let listening = stop::listen(stop::Second::Ends);
    let bar = bar(args.population * (args.iterations + 1), "{bar:32} {pos}/{len} evaluations, {eta} left");
    let (front, evaluations) = pareto_front(
        &bounds,
        Draws::new(args.common.seed),
        [args.population, args.iterations],
        |all| costs(&trial, &tunable, all),
        |evaluations| bar.set_position(evaluations as u64),
    );
    bar.finish_and_clear();
    if front.is_empty() {
        flying.all(flying.failure().is_none().then_some(()))?;
        return Err(Failure::Interrupted(
            "the first generation had not flown yet; nothing is written".to_owned(),
        ));
    }
    let chosen = knee(&front);
    let found = Found { front: &front, chosen, evaluations, spread: scatter.told() };
    write(args, &named, &tunable, &found, &mut outputs)?;
    drop(listening);
    if args.common.json {
        print_json(&Document {
            preset: &named.name,
            controller: &args.controller,
            seed: args.common.seed,
            plants: args.plants,
            spread: scatter.constants,
            lag_spread: scatter.lag,
            evaluations,
            objectives: OBJECTIVES,
            chosen: chosen + 1,
            front: &front,
        })?;
    } else {
        print(&format!("{}{}", summary(args, &named, &found), outputs.unwritten()))?;
    }
    outputs.done()?;
    let kept = format!("the front after {evaluations} evaluations is in {}", args.out.display());
    match flying.failure() {
        Some(why) => Err(Failure::Run(format!("{why}; {kept}"))),
        None if stop::requested() => Err(Failure::Interrupted(kept)),
        None => Ok(()),
    }
}

fn check(args: &Args) -> Outcome<()> {
    at_least("--range", args.range, 1.0, true)?;
    within("--plants", args.plants, 4, 100_000)?;
    within("--population", args.population, 4, 10_000)?;
    within("--iterations", args.iterations, 4, 100_000)?;
    Ok(())
}

/// What came out.
struct Found<'a> {
    front: &'a [Compromise],
    /// Which of it.
    chosen: usize,
    evaluations: usize,
    /// The spread of the plants, where it is not the usual.
    spread: Option<String>,
}

/// How the points of a front say what they are.
const POINT: &str = "Pareto point ";

fn write(
    args: &Args,
    named: &NamedRig,
    tunable: &Tunable,
    found: &Found<'_>,
    outputs: &mut Outputs,
) -> Outcome<()> {
    let Found { front, chosen, evaluations, ref spread } = *found;
    remove_others(args, front.len());
    let mut table = Table::default();
    table.push("point", Column::Numbers((1..=front.len()).map(|k| k as f64).collect()));
    for (k, name) in OBJECTIVES.iter().enumerate() {
        table.push(name, Column::Numbers(front.iter().map(|p| p.costs[k]).collect()));
    }
    let path = args.out.join("front.csv");
    outputs.write(&path, &export::bytes(&table, &path)?);
    let title = format!("{}: the trade-off on {} plants", named.name, args.plants);
    let path = args.out.join("front.svg");
    outputs.write(&path, &figure::bytes(&figures::front(&title, front, chosen), &path)?);
    for (k, point) in front.iter().enumerate() {
        let provenance = Provenance {
            preset: named.name.clone(),
            objective: std::iter::once(format!(
                "{POINT}{} of {}, {} plants",
                k + 1,
                front.len(),
                args.plants
            ))
            .chain(spread.clone())
            .collect::<Vec<_>>()
            .join(", "),
            algorithm: "nsga-ii".to_owned(),
            seed: args.common.seed,
            evaluations,
            cost: point.costs.iter().sum(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        let file =
            GainsFile { controller: tunable.controller(&point.position), provenance: Some(provenance) };
        outputs.write(&point_path(args, k + 1), file.to_toml().as_bytes());
    }
    Ok(())
}

fn point_path(args: &Args, number: usize) -> PathBuf {
    args.out.join(format!("{number:02}.toml"))
}

/// What is in the folder under a name that a front has.
fn names(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let ours = |path: &PathBuf| {
        let number =
            path.file_stem().and_then(|stem| stem.to_str()).and_then(|stem| stem.parse::<usize>().ok());
        number.is_some() && files::ending(path).as_deref() == Some("toml")
            || ["front.csv", "front.svg"].iter().any(|name| path.ends_with(name))
    };
    entries.map(|entry| entry.path()).filter(ours).collect()
}

/// Points of an earlier front would pass for some of this one, which writes the first `count`.
fn remove_others(args: &Args, count: usize) {
    let is_point = |path: &Path| {
        let file = files::gains("--out", &path.to_string_lossy()).ok().and_then(|file| file.provenance);
        file.is_some_and(|provenance| provenance.objective.starts_with(POINT))
    };
    let kept: Vec<PathBuf> = (1..=count).map(|number| point_path(args, number)).collect();
    for path in names(&args.out).into_iter().filter(|path| !kept.contains(path) && is_point(path)) {
        let _ = std::fs::remove_file(path);
    }
}

fn summary(args: &Args, named: &NamedRig, found: &Found<'_>) -> String {
    let Found { front, chosen, evaluations, .. } = *found;
    let mut table =
        tables::table(&["point", "settling, both [s]", "disturbed RMS, both [°]", "variation [V/s]", ""]);
    for (k, point) in front.iter().enumerate() {
        let mark = if k == chosen { "nearest to the best of all three" } else { "" };
        tables::add(
            &mut table,
            [
                format!("{:02}", k + 1),
                format!("{:.3}", point.costs[0]),
                format!("{:.3}", point.costs[1]),
                format!("{:.0}", point.costs[2]),
                mark.to_owned(),
            ],
        );
    }
    format!(
        "{}: means over {} plants, {evaluations} evaluations\n{table}\nfigure: {}\ngains of a point: {}\n",
        named.name,
        args.plants,
        args.out.join("front.svg").display(),
        point_path(args, chosen + 1).display()
    )
}
