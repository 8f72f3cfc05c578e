//! `tune`: breed gains.

use super::choices;
use super::common::{Checkpoint, Common, End, catch_interrupts, interrupted, pair};
use super::tune_report::{document, name_of, summary};
use super::{print, print_json, tune_robust};
use crate::error::{Failure, Outcome};
use crate::figures;
use crate::files;
use crate::files::checkpoint::Keeper;
use crate::files::figure;
use crate::files::output;
use indicatif::{ProgressBar, ProgressStyle};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use twinrotor::axes::PerAxis;
use twinrotor::gains::NAMES;
use twinrotor_sim::error::{at_least, known_name};
use twinrotor_sim::flight::{self, Fidelity, Flight, Plan, Scalar};
use twinrotor_sim::gains_file::{GainsFile, Provenance};
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::rig::NamedRig;
use twinrotor_sim::scenario::Scenario;
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::{ALGORITHMS, Bounds, Draws, Setup};
use twinrotor_tune::search::{Problem, Search};

/// Flags of `tune`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    pub(super) common: Common,
    /// Search method: fpa-paper (the paper's Fig. 4), fpa-yang (as published), fpa-demo (the widespread demo
    /// code), fpa-adaptive (ours), ga, pso, gwo, de, cmaes, nelder-mead, random, sobol
    #[arg(long, default_value = "fpa-paper")]
    pub(super) algorithm: String,
    /// What to minimise: an integral of the error, or the robust objective over many plants (with --fidelity
    /// rig)
    #[arg(long, default_value = "ise")]
    objective: Goal,
    /// What to fly: step, 1, 2, 3, 3-square, or a FILE.toml of your own
    #[arg(long, default_value = "step")]
    scenario: String,
    /// The paper's world or the rig's
    #[arg(long, default_value = "ideal")]
    pub(super) fidelity: choices::Fidelity,
    /// How long each candidate flies \[s\] instead of the scenario's duration
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    horizon: Option<f64>,
    /// Candidates a generation, N [default: what the method is usually run with, 50 for the published FPA]
    #[arg(long, value_name = "N")]
    population: Option<usize>,
    /// Generations after the first, T: N (T + 1) evaluations in all, with N = 50 if it is not given
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
    #[command(flatten)]
    pub(super) checkpoint: Checkpoint,
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
    /// Robust: keep a number that `compare --json` tells within a limit, such as overshoot_p95.yaw=2
    #[arg(long, value_name = "NUMBER=MOST", value_delimiter = ',')]
    pub(super) at_most: Vec<String>,
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

/// The flags, resolved.
pub(super) struct Request {
    pub(super) named: NamedRig,
    pub(super) scenario: Scenario,
    /// Of the error, where that is what is minimised.
    pub(super) criterion: Criterion,
    pub(super) setup: Setup,
    pub(super) bounds: [f64; 2],
    pub(super) plot: PathBuf,
    time_limit: Option<Duration>,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let begun = Instant::now();
    let request = resolve(args)?;
    if args.objective == Goal::Robust {
        return tune_robust::run(args, &request);
    }
    let objective = Objective::new(
        request.criterion,
        &request.named.rig,
        &request.scenario,
        args.fidelity.into(),
        args.common.seed,
    );
    let mut search = begin(args, &request)?;
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
    let drawn =
        figures::comparison(&title(args, &request), [("paper", &flown[0]), ("tuned", &flown[1])], limit);
    figure::write(&drawn, &request.plot)?;

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
    let mut scenario = files::scenario(&args.scenario)?;
    if let Some(horizon) = args.horizon {
        scenario.duration = at_least("--horizon", horizon, 0.0, true)?;
    }
    scenario.validate()?;
    let criterion = match args.objective {
        Goal::Ise => Criterion::Ise,
        Goal::Iae => Criterion::Iae,
        Goal::Itae => Criterion::Itae,
        Goal::Robust if args.fidelity == choices::Fidelity::Rig => Criterion::Ise,
        Goal::Robust => {
            return Err(Failure::Input(
                "--objective is robust, --fidelity ideal; allowed: --fidelity rig with it".to_owned(),
            ));
        }
    };
    let setup = Setup {
        algorithm: *known_name("algorithm", &args.algorithm, &ALGORITHMS)?,
        population: args.population,
        evaluations: args.population.unwrap_or(50).saturating_mul(args.iterations.saturating_add(1)),
    };
    setup.validate().map_err(Failure::of_flag)?;
    let bounds = pair("--bounds", &args.bounds)?;
    at_least("--bounds: the lower one", bounds[0], 0.0, true)?;
    at_least("--bounds: the upper one", bounds[1], bounds[0], true)?;
    output::check("--out", &args.out)?;
    let plot = args.plot.clone().unwrap_or_else(|| args.out.with_extension("svg"));
    figure::check("--plot", &plot)?;
    let time_limit = match args.time_limit {
        Some(limit) => Some(Duration::try_from_secs_f64(at_least("--time-limit", limit, 0.0, true)?)),
        None => None,
    };
    let time_limit = time_limit.transpose().map_err(|e| Failure::Input(format!("--time-limit: {e}")))?;
    Ok(Request { named, scenario, criterion, setup, bounds, plot, time_limit })
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
        request.setup,
    );
    let bounds = Bounds::new(vec![request.bounds; NAMES.len()])?;
    args.checkpoint.resume_or(identity, Search::resume, |identity| {
        Search::new(identity, request.setup.start(bounds, Draws::new(args.common.seed)))
    })
}

/// Drives a search to its end, with a bar on a terminal.
pub(super) fn drive(
    args: &Args,
    request: &Request,
    problem: &dyn Problem,
    search: &mut Search,
) -> Outcome<End> {
    catch_interrupts();
    let bar = ProgressBar::new(search.budget() as u64);
    let style =
        ProgressStyle::with_template("{prefix} {bar:32} {pos}/{len} evaluations, best {msg}, {eta} left");
    bar.set_style(style.expect("the template is well-formed"));
    bar.set_prefix(args.algorithm.clone());
    let progress = |evaluations: usize, cost: f64| {
        bar.set_position(evaluations as u64);
        bar.set_message(format!("{cost:.6}"));
    };
    let (begun, keeper) = (Instant::now(), Keeper::new(args.checkpoint.file.as_deref()));
    let end = search.run(problem, |search| {
        progress(search.evaluations(), search.cost());
        if let Err(failure) = keeper.keep(|| search.checkpoint()) {
            return ControlFlow::Break(Err(failure));
        }
        if interrupted() {
            return ControlFlow::Break(Ok(End::Interrupted));
        }
        if request.time_limit.is_some_and(|limit| begun.elapsed() >= limit) {
            return ControlFlow::Break(Ok(End::TimeLimit));
        }
        ControlFlow::Continue(())
    });
    bar.finish_and_clear();
    let end = end.break_value().unwrap_or(Ok(End::Complete))?;
    keeper.keep_now(|| search.checkpoint())?;
    Ok(end)
}

/// The paper's gains and those found, on the scenario that they were tuned for.
fn fly_both(args: &Args, request: &Request, found: &GainsFile) -> Outcome<[Flight; 2]> {
    let fly = |gains: &GainsFile| fly_in(args, request, gains, args.fidelity.into());
    Ok([fly(&GainsFile::paper())?, fly(found)?])
}

pub(super) fn fly_in(
    args: &Args,
    request: &Request,
    gains: &GainsFile,
    fidelity: Fidelity,
) -> Outcome<Flight> {
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
    Ok(flight::fly(&plan, Scalar::F32)?)
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
