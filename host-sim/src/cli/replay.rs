//! `replay`: a log through the firmware's estimator and law.

use super::common::{Common, PAPER, drawn, tuned_elsewhere};
use super::next::next;
use super::{print, print_json, tables};
use crate::error::{Failure, Outcome, as_typed};
use crate::figures::replay::figure as drawing;
use crate::files;
use crate::files::figure;
use crate::line::{self, Board};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;
use twinrotor::parameters::Parameters;
use twinrotor::replay::{Replayed, Sample};
use twinrotor_identify::doubts::doubts;
use twinrotor_identify::log::Columns;
use twinrotor_identify::replay::{self, Report};
use twinrotor_identify::windows::Run;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_station::image;

/// Flags of `replay`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    /// The log: CSV with columns t,pitch,yaw,v0,v1 in SI units, and ref_pitch,ref_yaw where that was recorded
    #[arg(value_name = "LOG.csv", help_heading = "Output")]
    log: PathBuf,
    /// Gains: 'paper' (Table 4) or a gains file [default: paper]
    #[arg(long, value_name = "paper|FILE")]
    gains: Option<String>,
    /// Other names, signs and units of columns, such as t=time:ms,pitch=-theta:deg,v0=u_main
    #[arg(long, value_name = "LIST", default_value = "", allow_hyphen_values = true)]
    columns: String,
    /// What was wanted, where the log does not say: step, 1, 2, 3, 3-square, or a FILE.toml; time begins with
    /// the log
    #[arg(long, value_name = "SCENARIO")]
    scenario: Option<String>,
    /// Replay it on the board at this serial port (or tcp://HOST:PORT, or 'auto') as well, which must keep
    /// these gains, and compare to the bit
    #[arg(long, value_name = "DEVICE")]
    port: Option<String>,
    /// Draw rates and volts as .svg or .png
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    log: &'a str,
    preset: &'a str,
    gains: &'a GainsFile,
    #[serde(flatten)]
    report: Report,
    #[serde(skip_serializing_if = "Option::is_none")]
    on_board: Option<String>,
    notes: &'a [String],
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    let gains_name = args.gains.as_deref().unwrap_or(PAPER);
    let gains = files::gains("--gains", gains_name)?;
    let mut outputs = args.common.outputs();
    outputs.reads("--gains", gains_name);
    outputs.reads("LOG.csv", &args.log);
    if let Some(name) = &args.scenario {
        outputs.reads("--scenario", name);
    }
    drawn(args.plot.as_deref(), &mut outputs)?;
    let scenario = args.scenario.as_deref().map(files::scenario).transpose()?;
    let columns = Columns::parse(&args.columns).map_err(Failure::of_flag)?;
    let log = files::log(&args.log, &columns, &named.rig)?;
    let parameters = Parameters::new(&named.rig, &gains.settings(&named.rig));
    parameters.validate().map_err(image::unusable)?;
    let mut notes = log.notes.clone();
    notes.extend(doubts(&[Run::new(log.clone())], &named.rig.plant));
    notes.extend(tuned_elsewhere(&named.name, &gains));
    let notes: Vec<String> = notes.iter().map(|note| as_typed(note)).collect();
    let samples = replay::samples(&log, &named.rig, scenario.as_ref());
    let replayed = replay::replay(&parameters, &samples);
    let on_board =
        args.port.as_ref().map(|port| on_board(port, args, &parameters, &samples, &replayed)).transpose()?;
    let (rows, report) = replay::compare(&log, &samples, &replayed);
    let title = format!("{} through {gains_name} gains on {}", log.name, named.name);
    if let Some(path) = &args.plot {
        outputs.write(path, &figure::bytes(&drawing(&title, &rows, named.rig.volts_limit), path)?);
    }
    if args.common.json {
        let document =
            Document { log: &log.name, preset: &named.name, gains: &gains, report, on_board, notes: &notes };
        print_json(&document)?;
    } else {
        let title = format!("{title}\n{}", args.common.unsaid(Some(&args.gains)));
        print(&summary(&title, &report, on_board.as_deref(), &notes))?;
    }
    outputs.done()
}

/// The same on the board at `port`, whose answers must be the same.
fn on_board(
    port: &str,
    args: &Args,
    parameters: &Parameters,
    samples: &[Sample],
    here: &[Replayed],
) -> Outcome<String> {
    let mut board = Board::new(line::open(port)?.1);
    let identity = board.identify()?;
    if !board.keeps(parameters)? {
        let flash = next("flash")
            .of(args.gains.as_deref().unwrap_or(PAPER))
            .with("--preset", args.common.preset())
            .with("--port", port);
        let flash = flash.board(args.common.board);
        return Err(Failure::Run(format!(
            "the board at {port} keeps other parameters than these gains and this preset make: {flash}"
        )));
    }
    let there = board.replay(samples)?;
    if let Some((here, there)) = here.iter().zip(&there).find(|(here, there)| !here.same_bits(there)) {
        return Err(Failure::Run(format!(
            "the board does not compute what this program does: here {here:?}, there {there:?}"
        )));
    }
    Ok(format!(
        "{} with firmware {} gave the same bits in all {} ticks",
        identity.chip,
        identity.firmware,
        samples.len()
    ))
}

fn summary(title: &str, report: &Report, on_board: Option<&str>, notes: &[String]) -> String {
    let mut text = format!(
        "{title}{} to {} s, a row every {} ms, a tick every ms; true rates by smoothers that look {}/{} s \
         back and ahead\n",
        report.from_s,
        report.to_s,
        1e3 * report.sample_time_s,
        report.smoother_reach_s.pitch,
        report.smoother_reach_s.yaw
    );
    let mut table = tables::table(&["root mean square", "pitch", "yaw"]);
    let mut row = |name: &str, [a, b]: [f64; 2]| {
        tables::add(&mut table, [name.to_owned(), format!("{a:.4}"), format!("{b:.4}")])
    };
    row("rate error [rad/s]", [report.rate_error.pitch, report.rate_error.yaw]);
    let transient = report.rate_error_transient;
    row(
        &format!(
            "rate error, {:.1}/{:.1} s under way [rad/s]",
            report.transient_s.pitch, report.transient_s.yaw
        ),
        [transient.pitch, transient.yaw],
    );
    let _ = writeln!(text, "{table}");
    match report.volts_difference {
        Some(volts) => {
            let _ = writeln!(
                text,
                "our volts minus the logged ones: main {:.2} V, tail {:.2} V \
                rms",
                volts.main, volts.tail
            );
        }
        None => text.push_str(
            "what was wanted is not recorded: the law was not asked (--scenario, or \
            columns ref_pitch,ref_yaw)\n",
        ),
    }
    if let Some(on_board) = on_board {
        let _ = writeln!(text, "{on_board}");
    }
    for note in notes {
        let _ = writeln!(text, "note: {note}");
    }
    text
}
