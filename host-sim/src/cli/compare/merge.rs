//! `merge`: the report of a comparison whose plants several machines have flown.

use super::{Wanted, part, show};
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
    let (head, flown) = part::read(&args.parts)?;
    if args.export.is_some() && matches!(flown, part::Flown::Scenario(..)) {
        return Err(crate::cli::common::no_effect(
            "--export",
            "with a scenario",
            "its flights have no scores",
        ));
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
