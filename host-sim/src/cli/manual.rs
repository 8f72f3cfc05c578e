//! `manual`: the help of every command as manual pages, and completions for shells.

use crate::error::Outcome;
use std::path::PathBuf;

/// Flags of `manual`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Where to write them
    #[arg(long, default_value = "manual", value_name = "FOLDER", help_heading = "Output")]
    out: PathBuf,
}

/// Writes a page for each command and a file for each shell.
#[cfg(feature = "manual")]
pub(super) fn run(args: &Args, command: clap::Command) -> Outcome<()> {
    use crate::error::Failure;
    use clap::ValueEnum;
    let failed = |e: std::io::Error| Failure::Run(format!("{}: cannot be written: {e}", args.out.display()));
    std::fs::create_dir_all(&args.out).map_err(failed)?;
    clap_mangen::generate_to(command.clone(), &args.out).map_err(failed)?;
    for shell in clap_complete::Shell::value_variants() {
        clap_complete::generate_to(*shell, &mut command.clone(), "host-sim", &args.out).map_err(failed)?;
    }
    super::print(&format!(
        "{}: manual pages (man -l {0}/host-sim.1) and completions (source {0}/host-sim.bash)\n",
        args.out.display()
    ))
}

/// Says how to get a program that does.
#[cfg(not(feature = "manual"))]
pub(super) fn run(args: &Args, _: clap::Command) -> Outcome<()> {
    Err(crate::error::Failure::Input(format!(
        "manual needs what this build leaves out: cargo run -p host-sim --features manual -- manual --out {}",
        args.out.display()
    )))
}
