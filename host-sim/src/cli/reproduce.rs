//! `reproduce`: the paper's tables, figures and claims beside ours.

use super::{print, print_json, who};
use crate::error::Outcome;
use crate::files::output::{self, Outputs};
use crate::report::{Report, Size, Tally};
use crate::threads;
use indicatif::ProgressBar;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use twinrotor::plant::presets::PAPER;
use twinrotor_sim::is_text;
use twinrotor_sim::rig::NamedRig;

/// Flags of `reproduce`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder for index.html, report.json and the CSV files; made if it is not there
    #[arg(long, value_name = "DIR", default_value = "report", help_heading = "Output")]
    out: PathBuf,
    /// More rows for Table 6, in no verdict: names or gains files, as 'compare --controllers' takes them, for
    /// the paper's preset
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    controllers: Vec<String>,
    /// Folder of the tuned gains that names of --controllers stand for, as of 'compare'
    #[arg(long, value_name = "DIR", default_value = "gains")]
    gains: PathBuf,
    /// Few seeds, plants and evaluations: a first look in a second or two, which leaves verdicts undecided
    #[arg(long)]
    quick: bool,
    /// Of everything random
    #[arg(long, default_value_t = 1, help_heading = "Computing")]
    seed: u64,
    /// Print the report as one JSON document and nothing else
    #[arg(long, help_heading = "Output")]
    json: bool,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let begun = Instant::now();
    let named = NamedRig { name: "paper".to_owned(), rig: PAPER };
    let own = args.controllers.iter().map(|name| who::one(name, &args.gains, &named));
    let own = own.collect::<Outcome<Vec<_>>>()?;
    output::check_folder("--out", &args.out)?;
    threads::begin(None);
    let bar = ProgressBar::new_spinner();
    bar.enable_steady_tick(Duration::from_millis(200));
    let size = if args.quick { Size::QUICK } else { Size::FULL };
    let report = Report::compute(size, args.seed, &own, &|doing| bar.set_message(doing.to_owned()))?;
    let mut outputs = Outputs::new();
    for name in args.controllers.iter().filter(|name| is_text(name)) {
        outputs.reads("--controllers", name);
    }
    report.write(&args.out, &mut outputs)?;
    bar.finish_and_clear();
    if args.json {
        print_json(&report.document())?;
        return outputs.done();
    }
    let Tally { checked, reproduced, within_ambiguity, not_reproduced, undecided, contradictions, given } =
        report.tally();
    print(&format!(
        "of {checked} statements {reproduced} reproduced, {within_ambiguity} within the paper's ambiguity, \
         {not_reproduced} not reproduced, {undecided} undecided; {contradictions} contradictions, {given} \
         numbers taken as given; {:.1} s\n{}\nreport: {}\n",
        begun.elapsed().as_secs_f64(),
        report.summary.last().map_or("", String::as_str),
        args.out.join("index.html").display()
    ))?;
    outputs.done()
}
