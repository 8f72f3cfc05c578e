//! `merge`: the report of a comparison whose plants several machines have flown.

use super::part::{self, Flown};
use super::told::{self, More, Told};
use crate::cli::common::no_effect;
use crate::error::Outcome;
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
    #[command(flatten)]
    told: Told,
}

pub(in crate::cli) fn run(args: &Args) -> Outcome<()> {
    let mut outputs = Outputs::new();
    for path in &args.parts {
        outputs.reads("PART", path);
    }
    args.told.check(&mut outputs)?;
    let (head, flown) = part::read(&args.parts)?;
    if let (Some(flag), Flown::Scenario(..)) = (args.told.of_scores(), &flown) {
        return Err(no_effect(flag, "with a scenario", "its flights have no scores"));
    }
    told::show(&head, &flown, More::default(), &args.told, args.json, &mut outputs)?;
    outputs.done()
}
