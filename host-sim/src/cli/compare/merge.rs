//! `merge`: the report of a comparison whose plants several machines have flown.

use super::{part, show};
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
    #[arg(long)]
    json: bool,
    /// Write every flight's numbers, a row each: .parquet, .npz or .csv; not of a scenario's
    #[arg(long, value_name = "FILE")]
    export: Option<PathBuf>,
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
    show(&head, &flown, args.json, args.export.as_deref(), &mut outputs)?;
    outputs.done()
}
