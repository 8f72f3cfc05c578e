//! `coverage`: do the intervals of `identify` hold what they claim?

use super::common::{Checkpoint, Common, Spreads, bar};
use super::fitted::{Fitted, gains};
use super::{print, print_json, tables};
use crate::error::{Failure, Outcome};
use crate::files;
use crate::files::checkpoint::Keeper;
use std::fmt::Write;
use twinrotor_identify::coverage::{EXCITATION, Failed, Report, Study, Verdict};
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::{Error, is_text};
use twinrotor_tune::parallel::NEVER;

/// Flags of `coverage`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    /// How many rigs to draw around the preset
    #[arg(long, value_name = "N", default_value_t = 100)]
    rigs: usize,
    #[command(flatten)]
    spreads: Spreads,
    /// What each flies for its log: a name, or a FILE.toml of your own [default: the flight of
    /// docs/identify.md]
    #[arg(long)]
    scenario: Option<String>,
    /// Gains that it is flown with, which believe the preset [default: the preset's, else the paper's]
    #[arg(long, value_name = "FILE")]
    gains: Option<String>,
    #[command(flatten)]
    fitted: Fitted,
    #[command(flatten)]
    checkpoint: Checkpoint,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    let gains = gains(args.gains.as_deref(), &named)?;
    let scenario = match &args.scenario {
        Some(name) => files::scenario(name)?,
        None => Scenario::parse("docs/identify.md", EXCITATION)?,
    };
    let question = args.fitted.question(named, args.common.seed)?;
    let study = Study::new(question, &gains, scenario, args.rigs, args.spreads.scatter()?);
    let study = study.map_err(Failure::of_flag)?;
    let mut outputs = args.common.outputs();
    outputs.reads("--gains", args.gains.as_deref().unwrap_or_default());
    outputs.reads("--scenario", args.scenario.as_deref().filter(|name| is_text(name)).unwrap_or_default());
    args.checkpoint.check(&mut outputs)?;
    let begun = args.checkpoint.resume_or(Vec::new(), |_, bytes| match study.decode(bytes)? {
        (0, verdicts) => Ok(verdicts),
        (first, _) => Err(Error::invalid("first rig", first, "0: a checkpoint, and not a cluster's chunk")),
    })?;

    let keeper = Keeper::new(args.checkpoint.file.as_deref());
    let verdicts = all(&study, begun, &keeper);
    keeper.done(&mut outputs);
    let report = study.report(&verdicts);
    if args.common.json {
        print_json(&report)?;
    } else {
        print(&summary(&report))?;
    }
    outputs.done()
}

/// Verdicts on all rigs. An interrupt ends it at once: the checkpoint has all but the rigs at work.
fn all(study: &Study, mut verdicts: Vec<Verdict>, keeper: &Keeper) -> Vec<Verdict> {
    let bar = bar(study.count(), "{bar:32} {pos}/{len} rigs, {eta} left");
    bar.set_position(verdicts.len() as u64);
    // Between two checkpoints; threads without a rig help the others, whose fits are computed in parts.
    let at_once = rayon::current_num_threads();
    while verdicts.len() < study.count() {
        let next = verdicts.len()..study.count().min(verdicts.len() + at_once);
        verdicts.extend(study.verdicts(next, NEVER, &|| bar.inc(1)).expect("nothing stops it"));
        keeper.keep_now(|| study.encode(0, &verdicts));
    }
    bar.finish_and_clear();
    verdicts
}

fn summary(report: &Report) -> String {
    let answered = report.rigs - report.failures.len();
    let mut text = format!(
        "{}: {answered} of {} rigs within {} of it, lags within {}, identified from {}\n",
        report.preset, report.rigs, report.spread, report.lag_spread, report.scenario
    );
    let or_dash = |told: Option<String>| told.unwrap_or_else(|| "–".to_owned());
    let percent = |part: f64| format!("{:.1}", 100.0 * part);
    let mut table = tables::table(&["", "held", "[%]", "95 % of it", "width", "error", "at bound"]);
    for c in &report.constants {
        let cells = [
            c.name.to_owned(),
            format!("{}/{}", c.held, c.intervals),
            or_dash(c.coverage.map(percent)),
            or_dash(c.coverage_ci95.map(|[least, most]| format!("{} to {}", percent(least), percent(most)))),
            or_dash(c.median_width.map(|x| format!("{x:.2e}"))),
            or_dash(c.median_error.map(|x| format!("{x:.2e}"))),
            c.at_bound.to_string(),
        ];
        tables::add(&mut table, cells);
    }
    let _ = writeln!(text, "{table}");
    for Failed { rig, why } in &report.failures {
        let _ = writeln!(text, "failed: rig {rig}: {why}");
    }
    text
}
