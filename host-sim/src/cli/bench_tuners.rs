//! `bench-tuners`: methods of search side by side on one problem.

use super::common::{Common, Device, bar, drawn, no_effect, within};
use super::{print, print_json, tables};
use crate::device::{self, Found};
use crate::error::{Failure, Outcome};
use crate::figures;
use crate::files::export;
use crate::files::figure;
use serde::Serialize;
use std::path::PathBuf;
use twinrotor::gains;
use twinrotor_sim::error::{at_least, known_name};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::rig::NamedRig;
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::table::{Column, Table};
use twinrotor_tune::contest::{Peer, Standing, best_known, standings};
use twinrotor_tune::design::CATALOGUE;
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::{ALGORITHMS, Bounds, Setup};
use twinrotor_tune::robust::{self, Robust, Trial};
use twinrotor_tune::search::Problem;
use twinrotor_tune::tunable::Tunable;

/// Candidates that a method with a population asks for at once.
const USUAL_GENERATION: usize = 50;

/// Flags of `bench-tuners`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    device: Device,
    /// Which, by the names of `tune --algorithm`; the others are tested against the first [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    algorithms: Vec<String>,
    /// Searches of each
    #[arg(long, value_name = "N", default_value_t = 20)]
    seeds: usize,
    /// The problem: the paper's four gains on its ISE, or all of a controller's parameters on the robust
    /// objective
    #[arg(long, default_value = "ise")]
    objective: Goal,
    /// Evaluations of each search [default: 1550 for ISE, 600 for robust]
    #[arg(long, value_name = "N")]
    evaluations: Option<usize>,
    /// Robust: whose parameters, around its design [default: integral]
    #[arg(long, value_name = "NAME")]
    controller: Option<String>,
    /// Robust: on how many plants [default: 32]
    #[arg(long, value_name = "N")]
    plants: Option<usize>,
    /// Robust: factor within which each parameter is searched [default: 4]
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    range: Option<f64>,
    /// Write every run as a row: method, seed, cost, coordinates (.parquet, .npz or .csv)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    export: Option<PathBuf>,
    /// Draw convergence (.svg or .png)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub(super) enum Goal {
    /// The paper's four gains on its ISE
    Ise,
    /// The robust objective
    Robust,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    preset: &'a str,
    objective: Goal,
    seed: u64,
    seeds: usize,
    evaluations: usize,
    best_known: f64,
    standings: Vec<Standing>,
    algorithms: &'a [Peer],
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    let setups = setups(args)?;
    let mut outputs = args.common.outputs();
    drawn(args.plot.as_deref(), &mut outputs)?;
    if let Some(path) = &args.export {
        export::check("--export", path, false)?;
        outputs.writes("--export", path)?;
    }
    let found = args.device.find()?;
    let (peers, what, [each, each_core]) = match args.objective {
        Goal::Ise => {
            refuse_for_ise(args)?;
            let step = Scenario::named("step")?;
            let problem =
                Objective::new(Criterion::Ise, &named.rig, &step, Fidelity::Ideal, args.common.seed)
                    .on(found.device());
            let bounds = Bounds::new(vec![gains::PAPER_BOUNDS; 4])?;
            let what = "ISE of the step, four gains in 1..25".to_owned();
            (search(args, &setups, &bounds, &problem), what, [1, device::IDEAL_FLIGHTS])
        }
        Goal::Robust => robust_problem(args, &named, &setups, &found)?,
    };
    let peers = found.all(peers)?;
    let known = best_known(&peers);
    let standings = standings(&peers, known);
    if let Some(path) = &args.plot {
        let title = format!("{}: {what}; median of {} seeds, quarter points", named.name, args.seeds);
        let figure = figures::convergence(&title, &peers, known, setups[0].1.evaluations);
        outputs.write(path, &figure::bytes(&figure, path)?);
    }
    if let Some(path) = &args.export {
        outputs.write(path, &export::bytes(&runs(&peers), path)?);
    }
    if args.common.json {
        print_json(&Document {
            preset: &named.name,
            objective: args.objective,
            seed: args.common.seed,
            seeds: args.seeds,
            evaluations: setups[0].1.evaluations,
            best_known: known,
            standings,
            algorithms: &peers,
        })?;
    } else {
        let flights = args.seeds.saturating_mul(USUAL_GENERATION).saturating_mul(each);
        let note = found.note(flights, each_core);
        print(&format!(
            "{}: {what}; {} seeds, {} evaluations each\n{}\n{note}",
            named.name,
            args.seeds,
            setups[0].1.evaluations,
            table(&standings)
        ))?;
    }
    outputs.done()
}

/// Refuses what ISE in the paper's world would not heed.
fn refuse_for_ise(args: &Args) -> Outcome<()> {
    let given = [
        ("--controller", args.controller.is_some(), "ISE is of the paper's law"),
        ("--plants", args.plants.is_some(), "ISE is of one plant"),
        ("--range", args.range.is_some(), "gains are searched in 1..25"),
        ("--rotor-lag", args.common.rotor_lag.is_some(), "rotors of the paper's world have none"),
    ];
    match given.into_iter().find(|(_, given, _)| *given) {
        Some((flag, _, why)) => Err(no_effect(flag, "with --objective ise", why)),
        None => Ok(()),
    }
}

fn setups(args: &Args) -> Outcome<Vec<(String, Setup)>> {
    within("--seeds", args.seeds, 2, 10_000)?;
    let usual = if args.objective == Goal::Ise { 1550 } else { 600 };
    let evaluations = args.evaluations.unwrap_or(usual);
    let all = || ALGORITHMS.iter().map(|(name, _)| (*name).to_owned()).collect();
    let names: Vec<String> = if args.algorithms.is_empty() { all() } else { args.algorithms.clone() };
    let setup = |name: String| {
        let algorithm = *known_name("algorithm", &name, &ALGORITHMS)?;
        let setup = Setup { algorithm, population: None, evaluations };
        setup.validate().map_err(Failure::of_flag)?;
        Ok((name, setup))
    };
    names.into_iter().map(setup).collect()
}

/// The methods on it unless what flies has failed, what it is, how many flights a candidate is and how many a
/// core flies in the time of a launch.
fn robust_problem(
    args: &Args,
    named: &NamedRig,
    setups: &[(String, Setup)],
    found: &Found,
) -> Outcome<(Option<Vec<Peer>>, String, [usize; 2])> {
    let range = at_least("--range", args.range.unwrap_or(4.0), 1.0, true)?;
    let plants = within("--plants", args.plants.unwrap_or(32), 1, 100_000)?;
    let controller = args.controller.as_deref().unwrap_or("integral");
    let design = known_name("controller", controller, &CATALOGUE)?;
    let tunable = Tunable::new(&design(&named.rig), &[])?;
    let allowance = robust::allowance(&named.name, &named.rig);
    let trial = Trial::new(&named.rig, plants, args.common.seed, allowance).on(found.device());
    let reach = range.ln();
    let bounds = Bounds::new(vec![[-reach, reach]; tunable.names().len()])?;
    let what = format!(
        "robust objective of '{}' on {} plants, {} parameters within a factor of {}",
        controller,
        plants,
        tunable.names().len(),
        range
    );
    let peers = search(args, setups, &bounds, &Robust::new(&trial, &tunable));
    Ok((peers, what, [plants, device::RIG_FLIGHTS]))
}

fn search(
    args: &Args,
    setups: &[(String, Setup)],
    bounds: &Bounds,
    problem: &dyn Problem,
) -> Option<Vec<Peer>> {
    let total = setups.iter().map(|(_, s)| s.evaluations.saturating_mul(args.seeds));
    let total = total.fold(0, usize::saturating_add);
    let bar = bar(total, "{prefix:12} {bar:32} {pos}/{len} evaluations, {eta} left");
    let seeds: Vec<u64> = (0..args.seeds as u64).map(|k| args.common.seed.wrapping_add(k)).collect();
    let seen = |evaluations: usize| bar.inc(evaluations as u64);
    let one = |(name, setup): &(String, Setup)| {
        bar.set_prefix(name.clone());
        Peer::search(name, setup, bounds, &seeds, problem, &seen)
    };
    let peers = setups.iter().map(one).collect();
    bar.finish_and_clear();
    peers
}

/// Every run as a row: method, seed, cost and where it was found.
fn runs(peers: &[Peer]) -> Table {
    let all = || peers.iter().flat_map(|p| p.runs.iter().map(move |r| (p, r)));
    let mut table = Table::default();
    table.push("algorithm", Column::Words(all().map(|(p, _)| p.name.clone()).collect()));
    table.push("seed", Column::Counts(all().map(|(_, r)| r.seed).collect()));
    table.push("cost", Column::Numbers(all().map(|(_, r)| r.cost).collect()));
    let dimension = all().next().map_or(0, |(_, r)| r.position.len());
    for k in 0..dimension {
        table.push(&format!("x{}", k + 1), Column::Numbers(all().map(|(_, r)| r.position[k]).collect()));
    }
    table
}

fn table(standings: &[Standing]) -> tables::Table {
    let mut table = tables::table(&["", "median", "IQR", "best", "worst", "to 1 %", "to .1 %", "p"]);
    for s in standings {
        let count = |n: Option<f64>| n.map_or_else(|| "–".to_owned(), |n| format!("{n:.0}"));
        tables::add(
            &mut table,
            [
                s.name.clone(),
                format!("{:.7}", s.median),
                format!("{:.1e}", s.interquartile_range),
                format!("{:.7}", s.best),
                format!("{:.7}", s.worst),
                count(s.evaluations_to_1_percent),
                count(s.evaluations_to_01_percent),
                s.p_value.map_or_else(String::new, |p| format!("{p:.1e}")),
            ],
        );
    }
    table
}
