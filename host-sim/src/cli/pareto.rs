//! `pareto`: no single best, but the choice there is.

use super::common::{Common, bar, within};
use super::{print, print_json, tables};
use crate::error::{Failure, Outcome};
use crate::figures;
use crate::files;
use crate::files::export::{Column, Table};
use crate::files::figure;
use crate::files::output;
use crate::report;
use crate::stop;
use rayon::prelude::*;
use serde::Serialize;
use std::path::PathBuf;
use twinrotor_sim::error::{at_least, known_name};
use twinrotor_sim::gains_file::{GainsFile, Provenance};
use twinrotor_sim::rig::NamedRig;
use twinrotor_tune::design::CATALOGUE;
use twinrotor_tune::optimise::{Bounds, Compromise, Draws, knee, pareto_front};
use twinrotor_tune::robust::{self, Score, Terms, Trial};
use twinrotor_tune::tunable::Tunable;

/// Flags of `pareto`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    /// Whose parameters, around its design
    #[arg(long, default_value = "integral", value_name = "NAME")]
    controller: String,
    /// Start from these gains instead
    #[arg(long, value_name = "FILE", conflicts_with = "controller")]
    start: Option<String>,
    /// On how many plants
    #[arg(long, value_name = "N", default_value_t = 16)]
    plants: usize,
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
    objectives: [&'static str; 3],
    /// Counted from 1, as the files are.
    chosen: usize,
    front: &'a [Compromise],
}

fn costs(trial: &Trial, tunable: &Tunable, position: &[f64]) -> Vec<f64> {
    let scores = trial.scores(&tunable.controller(position));
    let mean = Terms::mean(scores.iter().map(Score::terms));
    // A controller that fails on some plants is no compromise: it loses to any that does not.
    let failed = 100.0 * scores.iter().filter(|s| s.failed).count() as f64;
    vec![mean.settling + failed, mean.disturbance + failed, 1e3 * (mean.variation + failed)]
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    check(args)?;
    let start = match &args.start {
        Some(path) => files::gains("--start", path)?.controller,
        None => known_name("controller", &args.controller, &CATALOGUE)?(&named.rig),
    };
    let tunable = Tunable::new(&start, &[])?;
    let allowance = robust::allowance(&named.name, &named.rig);
    let trial = Trial::new(&named.rig, args.plants, args.common.seed, allowance);
    let reach = args.range.ln();
    let bounds = Bounds::new(vec![[-reach, reach]; tunable.names().len()])?;
    report::prepare(&args.out)?;

    let _listening = stop::listen(stop::Second::Ends);
    let bar = bar(args.population * (args.iterations + 1), "{bar:32} {pos}/{len} evaluations, {eta} left");
    let front = pareto_front(
        &bounds,
        Draws::new(args.common.seed),
        [args.population, args.iterations],
        |all| all.par_iter().map(|position| costs(&trial, &tunable, position)).collect(),
        |evaluations| {
            bar.set_position(evaluations as u64);
            !stop::requested()
        },
    );
    bar.finish_and_clear();
    let chosen = knee(&front);
    write(args, &named, &tunable, &front, chosen)?;
    if args.common.json {
        print_json(&Document {
            preset: &named.name,
            controller: &args.controller,
            seed: args.common.seed,
            plants: args.plants,
            objectives: OBJECTIVES,
            chosen: chosen + 1,
            front: &front,
        })?;
    } else {
        print(&summary(args, &named, &front, chosen))?;
    }
    if stop::requested() { Err(Failure::Interrupted) } else { Ok(()) }
}

fn check(args: &Args) -> Outcome<()> {
    at_least("--range", args.range, 1.0, true)?;
    within("--plants", args.plants, 4, 100_000)?;
    within("--population", args.population, 4, 10_000)?;
    within("--iterations", args.iterations, 4, 100_000)?;
    Ok(())
}

fn write(
    args: &Args,
    named: &NamedRig,
    tunable: &Tunable,
    front: &[Compromise],
    chosen: usize,
) -> Outcome<()> {
    let mut table = Table::default();
    table.push("point", Column::Numbers((1..=front.len()).map(|k| k as f64).collect()));
    for (k, name) in OBJECTIVES.iter().enumerate() {
        table.push(name, Column::Numbers(front.iter().map(|p| p.costs[k]).collect()));
    }
    table.write(&args.out.join("front.csv"))?;
    let title = format!("{}: the trade-off on {} plants", named.name, args.plants);
    figure::write(&figures::front(&title, front, chosen), &args.out.join("front.svg"))?;
    for (k, point) in front.iter().enumerate() {
        let provenance = Provenance {
            preset: named.name.clone(),
            objective: format!("Pareto point {} of {}, {} plants", k + 1, front.len(), args.plants),
            algorithm: "nsga-ii".to_owned(),
            seed: args.common.seed,
            evaluations: args.population * (args.iterations + 1),
            cost: point.costs.iter().sum(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        let file =
            GainsFile { controller: tunable.controller(&point.position), provenance: Some(provenance) };
        output::write(&args.out.join(format!("{:02}.toml", k + 1)), file.to_toml().as_bytes())?;
    }
    Ok(())
}

fn summary(args: &Args, named: &NamedRig, front: &[Compromise], chosen: usize) -> String {
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
        "{}: means over {} plants, {} evaluations\n{table}\nfigure: {}\ngains of a point: {}\n",
        named.name,
        args.plants,
        args.population * (args.iterations + 1),
        args.out.join("front.svg").display(),
        args.out.join(format!("{:02}.toml", chosen + 1)).display()
    )
}
