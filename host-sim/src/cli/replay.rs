//! `replay`: a log through the firmware's estimator and law.

use super::common::Common;
use super::{print, print_json, tables};
use crate::error::{Failure, Outcome};
use crate::gains_file::GainsFile;
use crate::log::{Columns, Log};
use crate::plot;
use crate::replay::{self, Report};
use crate::scenario::Scenario;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Flags of `replay`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    /// The log: CSV with columns t,pitch,yaw,v0,v1 in SI units, and ref_pitch,ref_yaw where that was recorded
    #[arg(value_name = "LOG.csv")]
    log: PathBuf,
    /// Gains: 'paper' (Table 4) or a gains file
    #[arg(long, default_value = "paper", value_name = "paper|FILE")]
    gains: String,
    /// Other names, signs and units of columns, such as t=time:ms,pitch=-theta:deg,v0=u_main
    #[arg(long, value_name = "LIST", default_value = "", allow_hyphen_values = true)]
    columns: String,
    /// What was wanted, where the log does not say: step, 1, 2, 3, 3-square, or a FILE.toml; time begins with the log
    #[arg(long, value_name = "SCENARIO")]
    scenario: Option<String>,
    /// Draw rates and volts as .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    log: &'a str,
    preset: &'a str,
    gains: &'a GainsFile,
    #[serde(flatten)]
    report: Report,
    notes: &'a [String],
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    let gains = GainsFile::load(&args.gains)?;
    if let Some(path) = &args.plot {
        plot::check("--plot", path)?;
    }
    let scenario = args.scenario.as_deref().map(Scenario::load).transpose()?;
    let columns = Columns::parse(&args.columns).map_err(Failure::Input)?;
    let log = Log::load(&args.log, &columns)?;
    log.check_volts(named.rig.volts_limit)?;
    let wanted = replay::references(&log, scenario.as_ref());
    let (rows, report) = replay::replay(&log, &named.rig, &gains.controller, wanted.as_deref());
    let title = format!("{} through {} gains on {}", log.name, args.gains, named.name);
    if let Some(path) = &args.plot {
        replay::figure(&title, &rows, named.rig.volts_limit).write(path)?;
    }
    if args.common.json {
        let document =
            Document { log: &log.name, preset: &named.name, gains: &gains, report, notes: &log.notes };
        return print_json(&document);
    }
    print(&summary(&title, &report, &log.notes))
}

fn summary(title: &str, report: &Report, notes: &[String]) -> String {
    let mut text = format!(
        "{title}\n{} to {} s, a tick every {} ms; true rates by a smoother that looks {} s back and ahead\n",
        report.from_s,
        report.to_s,
        1e3 * report.sample_time_s,
        report.smoother_reach_s
    );
    let mut table = tables::table(&["root mean square", "pitch", "yaw"]);
    let mut row = |name: &str, [a, b]: [f64; 2]| {
        tables::add(&mut table, [name.to_owned(), format!("{a:.4}"), format!("{b:.4}")])
    };
    row("rate error [rad/s]", [report.rate_error.pitch, report.rate_error.yaw]);
    let transient = report.rate_error_transient;
    row(
        &format!("rate error, {:.1} s under way [rad/s]", report.transient_s),
        [transient.pitch, transient.yaw],
    );
    let _ = writeln!(text, "{table}");
    match report.volts_difference {
        Some(volts) => {
            let _ = writeln!(text, "our volts minus the logged ones: main {:.2} V, tail {:.2} V rms", volts.main, volts.tail);
        }
        None => text.push_str("what was wanted is not recorded: the law was not asked (--scenario, or columns ref_pitch,ref_yaw)\n"),
    }
    for note in notes {
        let _ = writeln!(text, "note: {note}");
    }
    text
}
