//! `tune`: breed gains. What is minimised decides what else can be said: an integral of the error takes a
//! scenario ([`integral`]), the robust objective plants and a controller ([`robust`]).

mod beside;
mod integral;
mod proof;
mod report;
mod request;
mod robust;

use super::common::{Checkpoint, Common, Device};
use crate::error::Outcome;
use request::Request;
use std::path::PathBuf;
use twinrotor_sim::metrics::Criterion;

/// Flags of `tune`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    shared: Shared,
    #[command(flatten)]
    integral: integral::Args,
    #[command(flatten)]
    robust: robust::Args,
}

/// Flags that act whatever is minimised.
#[derive(Debug, clap::Args)]
struct Shared {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    device: Device,
    /// Search method: fpa-paper (the paper's Fig. 4), fpa-yang (as published), fpa-demo (the widespread demo
    /// code), fpa-adaptive (ours), ga, pso, gwo, de, cmaes, nelder-mead, random, sobol [default: fpa-paper;
    /// with --objective robust fpa-adaptive]
    #[arg(long, value_name = "NAME")]
    algorithm: Option<String>,
    /// What to minimise: an integral of the error, or the robust objective over many plants in the rig's
    /// world
    #[arg(long, default_value = "ise")]
    objective: Goal,
    /// Candidates a generation, N [default: what the method is usually run with, 50 for the published FPA, 25
    /// for fpa-adaptive]
    #[arg(long, value_name = "N")]
    population: Option<usize>,
    /// Generations after the first, T: N (T + 1) evaluations in all, with N = 50 if it is not given [default:
    /// 30; with --objective robust and N = 25 39 in each round]
    #[arg(long, value_name = "T")]
    iterations: Option<usize>,
    /// Where to write the gains
    #[arg(long, value_name = "FILE", default_value = "gains.toml", help_heading = "Output")]
    out: PathBuf,
    #[command(flatten)]
    checkpoint: Checkpoint,
    /// Stop after this many seconds with the best so far
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    time_limit: Option<f64>,
}

/// What can be minimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Goal {
    Ise,
    Iae,
    Itae,
    Robust,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let criterion = match args.shared.objective {
        Goal::Ise => Criterion::Ise,
        Goal::Iae => Criterion::Iae,
        Goal::Itae => Criterion::Itae,
        Goal::Robust => {
            args.integral.refuse_for_robust()?;
            return robust::run(&args.robust, &Request::new(&args.shared, &args.robust.inputs())?);
        }
    };
    args.robust.refuse_for_integral()?;
    integral::run(&args.integral, &Request::new(&args.shared, &args.integral.inputs())?, criterion)
}
