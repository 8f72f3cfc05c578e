//! `merge`: the report of a comparison whose plants several machines have flown.

use super::{Wanted, part, show, told};
use crate::error::Outcome;
use crate::files::export;
use crate::files::output::Outputs;
use std::path::PathBuf;

/// Flags of `merge`.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// All files that 'compare --shard' has written, in any order
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Print one JSON document and nothing else
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Write every flight's numbers, a row each: .parquet, .npz or .csv; not of a scenario's
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    export: Option<PathBuf>,
    /// Draw how many plants cost how much with each controller (.svg or .png)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
    /// Write the comparison as a page, with its table and figure as CSV, into this folder
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    report: Option<PathBuf>,
}

pub(in crate::cli) fn run(args: &Args) -> Outcome<()> {
    let mut outputs = Outputs::new();
    for path in &args.parts {
        outputs.reads("PART", path);
    }
    if let Some(path) = &args.export {
        export::check("--export", path, false)?;
        outputs.writes("--export", path)?;
    }
    told(args.plot.as_deref(), args.report.as_deref(), &mut outputs)?;
    let (head, flown) = part::read(&args.parts)?;
    let of_scores = [
        ("--export", args.export.is_some()),
        ("--plot", args.plot.is_some()),
        ("--report", args.report.is_some()),
    ];
    let wanted = of_scores.into_iter().find(|(_, wanted)| *wanted);
    if let (Some((flag, _)), part::Flown::Scenario(..)) = (wanted, &flown) {
        return Err(crate::cli::common::no_effect(flag, "with a scenario", "its flights have no scores"));
    }
    let wanted = Wanted {
        json: args.json,
        export: args.export.as_deref(),
        plot: args.plot.as_deref(),
        report: args.report.as_deref(),
        note: "",
    };
    show(&head, &flown, &wanted, &mut outputs)?;
    outputs.done()
}
