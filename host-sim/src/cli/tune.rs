//! `tune`: breed gains.

use super::common::{Common, catch_interrupts, interrupted, pair};
use super::{print, print_json, tables, tune_robust};
use crate::checkpoint::check_fresh;
use crate::error::{Failure, Outcome, at_least, known_name};
use crate::figures;
use crate::flight::{self, Fidelity, Flight, Plan, Scalar};
use crate::gains_file::{GainsFile, Provenance};
use crate::metrics::Criterion;
use crate::objective::{Objective, Steps};
use crate::optimise::{Bounds, Draws, FlowerPollination, FpaSettings, Variant};
use crate::output;
use crate::plot;
use crate::rig::NamedRig;
use crate::scenario::{SAMPLE_TIME, Scenario};
use crate::tuner::{Conduct, End, Search};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use twinrotor::axes::PerAxis;
use twinrotor::gains::{self, NAMES};

/// Flags of `tune`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    pub(super) common: Common,
    /// Search method: fpa-paper (the paper's Fig. 4), fpa-yang (as published), fpa-demo (the widespread demo code)
    #[arg(long, default_value = "fpa-paper")]
    pub(super) algorithm: String,
    /// What to minimise: an integral of the error, or the robust objective over many plants (with --fidelity rig)
    #[arg(long, default_value = "ise")]
    objective: Goal,
    /// What to fly: step, 1, 2, 3, 3-square, or a FILE.toml of your own
    #[arg(long, default_value = "step")]
    scenario: String,
    /// The paper's world or the rig's
    #[arg(long, default_value = "ideal")]
    fidelity: Fidelity,
    /// How long each candidate flies \[s\] instead of the scenario's duration
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    horizon: Option<f64>,
    /// Flowers, N
    #[arg(long, value_name = "N", default_value_t = 50)]
    population: usize,
    /// Generations after the first, T
    #[arg(long, value_name = "T", default_value_t = 30)]
    iterations: usize,
    /// Least and most of each gain
    #[arg(long, value_name = "LO,HI", default_value = "1,25", allow_hyphen_values = true)]
    bounds: String,
    /// Where to write the gains
    #[arg(long, value_name = "FILE", default_value = "gains.toml")]
    pub(super) out: PathBuf,
    /// Where to draw both step responses (.svg or .png) [default: beside the gains, as .svg]
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Keep the state of the search in this file, so that it can be resumed
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Go on from --checkpoint
    #[arg(long, requires = "checkpoint")]
    resume: bool,
    /// Stop after this many seconds with the best so far
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(super) time_limit: Option<f64>,
    /// Robust: which controller's design to start from
    #[arg(long, default_value = "integral", value_name = "NAME")]
    pub(super) controller: String,
    /// Robust: start from these gains instead
    #[arg(long, value_name = "FILE")]
    pub(super) start: Option<String>,
    /// Robust: which parameters to tune, such as yaw,filter.bandwidth.pitch [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub(super) parameters: Vec<String>,
    /// Robust: on how many plants
    #[arg(long, value_name = "N", default_value_t = 32)]
    pub(super) plants: usize,
    /// Robust: searches one after the other, each around the best so far and within less
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub(super) rounds: usize,
    /// Robust: factor within which each parameter is searched at first
    #[arg(long, value_name = "FACTOR", default_value_t = 4.0, allow_negative_numbers = true)]
    pub(super) range: f64,
}

/// What can be minimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Goal {
    Ise,
    Iae,
    Itae,
    Robust,
}

const ALGORITHMS: [(&str, Variant); 3] =
    [("fpa-paper", Variant::Paper), ("fpa-yang", Variant::Yang), ("fpa-demo", Variant::Demo)];

/// A gain this near to a bound (part of the range) is probably held there by it.
const NEAR_A_BOUND: f64 = 0.02;

/// The flags, resolved.
struct Request {
    named: NamedRig,
    scenario: Scenario,
    /// Of the error, where that is what is minimised.
    criterion: Criterion,
    settings: FpaSettings,
    bounds: [f64; 2],
    plot: PathBuf,
    time_limit: Option<Duration>,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let begun = Instant::now();
    let request = resolve(args)?;
    if args.objective == Goal::Robust {
        return tune_robust::run(args, &request.named, request.settings);
    }
    let objective = Objective::new(
        request.criterion,
        &request.named.rig,
        &request.scenario,
        args.fidelity,
        args.common.seed,
    );
    let mut search = begin(args, &request)?;
    catch_interrupts();
    let end = drive(args, &request, &objective, &mut search)?;
    let Some(best) = search.best().filter(|b| b.cost.is_finite()) else {
        return Err(Failure::Run("no candidate flew to the end; nothing is written".to_owned()));
    };

    let mut found = Objective::controller(&best.position);
    found.provenance = Some(Provenance {
        preset: request.named.name.clone(),
        objective: name_of(request.criterion),
        algorithm: args.algorithm.clone(),
        seed: args.common.seed,
        evaluations: search.evaluations(),
        cost: best.cost,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    });
    output::write(&args.out, found.to_toml().as_bytes())?;
    let flown = fly_both(args, &request, &found)?;
    let limit = request.named.rig.volts_limit;
    figures::comparison(&title(args, &request), [("paper", &flown[0]), ("tuned", &flown[1])], limit)
        .write(&request.plot)?;

    let wall = begun.elapsed().as_secs_f64();
    if args.common.json {
        print_json(&document(args, &request, &search, &found, wall))?;
    } else {
        print(&summary(args, &request, &search, &objective, &found, &flown, wall))?;
    }
    match end {
        End::Interrupted => Err(Failure::Interrupted),
        End::Complete | End::TimeLimit => Ok(()),
    }
}

fn resolve(args: &Args) -> Outcome<Request> {
    let named = args.common.resolve()?;
    let mut scenario = Scenario::load(&args.scenario)?;
    if let Some(horizon) = args.horizon {
        scenario.duration = at_least("--horizon", horizon, 0.0, true)?;
    }
    scenario.validate()?;
    let criterion = match args.objective {
        Goal::Ise => Criterion::Ise,
        Goal::Iae => Criterion::Iae,
        Goal::Itae => Criterion::Itae,
        Goal::Robust if args.fidelity == Fidelity::Rig => Criterion::Ise,
        Goal::Robust => {
            return Err(Failure::Input(
                "--objective is robust, --fidelity ideal; allowed: --fidelity rig with it".to_owned(),
            ));
        }
    };
    let variant = *known_name("algorithm", &args.algorithm, &ALGORITHMS)?;
    let settings = FpaSettings {
        population_size: args.population,
        iterations: args.iterations,
        ..FpaSettings::published(variant)
    };
    settings.validate().map_err(|e| Failure::Input(format!("--{e}")))?;
    let bounds = pair("--bounds", &args.bounds)?;
    at_least("--bounds: the lower one", bounds[0], 0.0, true)?;
    at_least("--bounds: the upper one", bounds[1], bounds[0], true)?;
    output::check("--out", &args.out)?;
    let plot = args.plot.clone().unwrap_or_else(|| args.out.with_extension("svg"));
    plot::check("--plot", &plot)?;
    let time_limit = match args.time_limit {
        Some(limit) => Some(Duration::try_from_secs_f64(at_least("--time-limit", limit, 0.0, true)?)),
        None => None,
    };
    let time_limit = time_limit.transpose().map_err(|e| Failure::Input(format!("--time-limit: {e}")))?;
    Ok(Request { named, scenario, criterion, settings, bounds, plot, time_limit })
}

/// A search at its beginning, or where its checkpoint left it.
fn begin(args: &Args, request: &Request) -> Outcome<Search> {
    let identity = format!(
        "{} {:?} scenario {:?} fidelity {:?} objective {} seed {} bounds {:?} {:?}",
        request.named.name,
        request.named.rig,
        request.scenario,
        args.fidelity,
        name_of(request.criterion),
        args.common.seed,
        request.bounds,
        request.settings,
    );
    match &args.checkpoint {
        Some(path) if args.resume => return Search::resume(path, &identity),
        Some(path) => check_fresh(path)?,
        None => {}
    }
    let bounds = Bounds::new(vec![request.bounds; NAMES.len()]).map_err(Failure::Input)?;
    let draws = Draws::new(args.common.seed);
    Ok(Search::new(identity, FlowerPollination::new(request.settings.clone(), bounds, draws)))
}

fn drive(args: &Args, request: &Request, objective: &Objective, search: &mut Search) -> Outcome<End> {
    let budget = request.settings.population_size * (request.settings.iterations + 1);
    let bar = ProgressBar::new(budget as u64);
    let style =
        ProgressStyle::with_template("{prefix} {bar:32} {pos}/{len} evaluations, best {msg}, {eta} left");
    bar.set_style(style.expect("the template is well-formed"));
    bar.set_prefix(args.algorithm.clone());
    let progress = |evaluations: usize, cost: f64| {
        bar.set_position(evaluations as u64);
        bar.set_message(format!("{cost:.6}"));
    };
    let conduct = Conduct {
        checkpoint: args.checkpoint.clone(),
        time_limit: request.time_limit,
        interrupted: &interrupted,
        progress: &progress,
    };
    let end = search.run(objective, &conduct);
    bar.finish_and_clear();
    end
}

/// The paper's gains and those found, on the scenario that they were tuned for.
fn fly_both(args: &Args, request: &Request, found: &GainsFile) -> Outcome<[Flight; 2]> {
    let fly = |gains: &GainsFile| fly_in(args, request, gains, args.fidelity);
    Ok([fly(&GainsFile::paper())?, fly(found)?])
}

fn fly_in(args: &Args, request: &Request, gains: &GainsFile, fidelity: Fidelity) -> Outcome<Flight> {
    let rig = &request.named.rig;
    let settings = gains.settings(rig);
    let plan = Plan {
        rig,
        settings: &settings,
        scenario: &request.scenario,
        initial: PerAxis::both(0.0),
        fidelity,
        seed: args.common.seed,
    };
    flight::fly(&plan, Scalar::F32)
}

fn name_of(criterion: Criterion) -> String {
    format!("{criterion:?}").to_lowercase()
}

fn title(args: &Args, request: &Request) -> String {
    format!(
        "{}, scenario {}: Table 4 and gains tuned by {} on {}",
        request.named.name,
        request.scenario.name,
        args.algorithm,
        name_of(request.criterion).to_uppercase()
    )
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    algorithm: &'a str,
    preset: &'a str,
    objective: Criterion,
    scenario: &'a str,
    fidelity: Fidelity,
    seed: u64,
    evaluations: usize,
    cost: f64,
    wall_s: f64,
    horizon_s: f64,
    tick_s: f64,
    steps_simulated: u64,
    steps_skipped: u64,
    gains: &'a GainsFile,
    history: &'a [(usize, f64)],
}

fn document<'a>(
    args: &'a Args,
    request: &'a Request,
    search: &'a Search,
    found: &'a GainsFile,
    wall_s: f64,
) -> Document<'a> {
    let Steps { simulated, skipped } = search.steps();
    Document {
        algorithm: &args.algorithm,
        preset: &request.named.name,
        objective: request.criterion,
        scenario: &request.scenario.name,
        fidelity: args.fidelity,
        seed: args.common.seed,
        evaluations: search.evaluations(),
        cost: search.best().map_or(f64::INFINITY, |b| b.cost),
        wall_s,
        horizon_s: request.scenario.duration,
        tick_s: SAMPLE_TIME,
        steps_simulated: simulated,
        steps_skipped: skipped,
        gains: found,
        history: search.history(),
    }
}

fn summary(
    args: &Args,
    request: &Request,
    search: &Search,
    objective: &Objective,
    found: &GainsFile,
    flown: &[Flight; 2],
    wall: f64,
) -> String {
    let mut text = String::new();
    let objective_name = name_of(request.criterion).to_uppercase();
    let paper = objective.cost(&GainsFile::paper());
    let best = search.best().map_or(f64::INFINITY, |b| b.cost);
    let Steps { simulated, skipped } = search.steps();
    let _ = writeln!(
        text,
        "{} on preset {}, scenario {}: {} evaluations, {:.2} million steps and {:.2} million skipped, in {:.2} s",
        args.algorithm,
        request.named.name,
        request.scenario.name,
        search.evaluations(),
        simulated as f64 / 1e6,
        skipped as f64 / 1e6,
        wall
    );
    let mut table = tables::table(&["", "paper (Table 4)", "tuned", "change"]);
    gain_rows(&mut table, found);
    let change = |a: f64, b: f64| format!("{:+.1} %", 100.0 * (b / a - 1.0));
    tables::add(
        &mut table,
        [
            format!("{objective_name}, what was minimised"),
            format!("{paper:.6}"),
            format!("{best:.6}"),
            change(paper, best),
        ],
    );
    flight_rows(&mut table, flown);
    let _ = writeln!(text, "{table}");
    text.push_str(&bound_warnings(request, found));
    text.push_str(&in_the_rigs_world(args, request, found, &objective_name));
    let _ = writeln!(text, "gains:   {}\nfigure:  {}", args.out.display(), request.plot.display());
    let _ = writeln!(text, "fly it:  cargo run -p host-sim simulate --gains {}", shown(&args.out));
    text
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}

fn gain_rows(table: &mut comfy_table::Table, found: &GainsFile) {
    let (paper, tuned) =
        (gains::PAPER.to_paper_order(), found.gains().expect("the paper's law").to_paper_order());
    for (k, name) in NAMES.iter().enumerate() {
        tables::add(
            table,
            [
                format!("k{} {name} [1/s]", k + 1),
                format!("{:.3}", paper[k]),
                format!("{:.3}", tuned[k]),
                String::new(),
            ],
        );
    }
}

fn flight_rows(table: &mut comfy_table::Table, flown: &[Flight; 2]) {
    let mut row = |name: &str, of: &dyn Fn(&Flight) -> String| {
        tables::add(table, [name.to_owned(), of(&flown[0]), of(&flown[1]), String::new()]);
    };
    row("settling 2 %, pitch [s]", &|f| tables::seconds(f.report.pitch.settling_time_2));
    row("settling 2 %, yaw [s]", &|f| tables::seconds(f.report.yaw.settling_time_2));
    row("overshoot, pitch [%]", &|f| tables::percent(f.report.pitch.overshoot_percent));
    row("overshoot, yaw [%]", &|f| tables::percent(f.report.yaw.overshoot_percent));
    row("main motor beyond its limit [ms]", &|f| format!("{:.0}", 1e3 * f.report.main.saturation_time));
    row("tail motor beyond its limit [ms]", &|f| format!("{:.0}", 1e3 * f.report.tail.saturation_time));
    row("peak demand, main [V]", &|f| format!("{:.1}", f.report.main.peak_demand));
    row("peak demand, tail [V]", &|f| format!("{:.1}", f.report.tail.peak_demand));
}

fn bound_warnings(request: &Request, found: &GainsFile) -> String {
    let [low, high] = request.bounds;
    let near = NEAR_A_BOUND * (high - low);
    let mut text = String::new();
    for (name, value) in NAMES.iter().zip(found.gains().expect("the paper's law").to_paper_order()) {
        let bound = if value - low < near {
            low
        } else if high - value < near {
            high
        } else {
            continue;
        };
        let _ = writeln!(
            text,
            "warning: {name} = {value:.3} lies at the bound {bound}: the objective wants more than the bounds allow"
        );
    }
    text
}

/// The same two sets of gains with what an objective in the paper's world does not see.
fn in_the_rigs_world(args: &Args, request: &Request, found: &GainsFile, objective_name: &str) -> String {
    if args.fidelity == Fidelity::Rig {
        return String::new();
    }
    let mut text = format!(
        "\nWhat {objective_name} in the paper's world does not see: the same gains in the rig's (--fidelity rig: \
         rotor lag {} s, encoder counts, estimated rates, one tick of delay)\n",
        request.named.rig.plant.rotor_time_constant.main
    );
    let flights = [GainsFile::paper(), found.clone()].map(|g| fly_in(args, request, &g, Fidelity::Rig));
    let cell = |f: &Outcome<Flight>, of: &dyn Fn(&Flight) -> String| match f {
        Ok(flight) => of(flight),
        Err(_) => "diverges".to_owned(),
    };
    let mut table = tables::table(&["", "paper (Table 4)", "tuned"]);
    let mut row = |name: &str, of: &dyn Fn(&Flight) -> String| {
        tables::add(&mut table, [name.to_owned(), cell(&flights[0], of), cell(&flights[1], of)]);
    };
    row("settling 2 %, pitch / yaw [s]", &|f| {
        format!(
            "{} / {}",
            tables::seconds(f.report.pitch.settling_time_2),
            tables::seconds(f.report.yaw.settling_time_2)
        )
    });
    row("overshoot, pitch / yaw [%]", &|f| {
        format!(
            "{} / {}",
            tables::percent(f.report.pitch.overshoot_percent),
            tables::percent(f.report.yaw.overshoot_percent)
        )
    });
    row("motors beyond their limits [ms]", &|f| {
        format!("{:.0}", 1e3 * (f.report.main.saturation_time + f.report.tail.saturation_time))
    });
    let _ = writeln!(text, "{table}");
    text
}
