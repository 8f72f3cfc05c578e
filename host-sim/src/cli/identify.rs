//! `identify`: a rig's constants from its logs.

use super::common::{Checkpoint, Common, End, beside, within};
use super::{print, print_json, tables};
use crate::error::{Failure, Outcome, as_typed};
use crate::figures::residuals::residuals;
use crate::files;
use crate::files::checkpoint::Keeper;
use crate::files::figure;
use crate::files::output::Outputs;
use crate::stop;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;
use twinrotor::plant::presets::Rig;
use twinrotor_identify::constants;
use twinrotor_identify::doubts::doubts;
use twinrotor_identify::fit::Fit;
use twinrotor_identify::log::Columns;
use twinrotor_identify::problem::Problem;
use twinrotor_identify::search::{Effort, Search};
use twinrotor_identify::suggest::{Suggestion, suggest};
use twinrotor_identify::windows::Run;
use twinrotor_identify::{
    Parameter, THRESHOLD, WINDOW, distinct, hold_measured_lags, identified, offset_of, tachometer,
    training_windows,
};
use twinrotor_sim::Error;
use twinrotor_sim::error::at_least;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::rig::NamedRig;
use twinrotor_tune::checkpoint::Identity;

/// Flags of `identify`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    /// Logs to fit: CSV with columns t,pitch,yaw,v0,v1 in SI units
    #[arg(required = true, value_name = "LOG.csv")]
    logs: Vec<PathBuf>,
    /// Logs that are kept out of the fit and compared afterwards
    #[arg(long, value_name = "LOG.csv")]
    validate: Vec<PathBuf>,
    /// Other names, signs and units of columns, such as t=time:ms,pitch=-theta:deg,v0=u_main
    #[arg(long, value_name = "LIST", default_value = "", allow_hyphen_values = true)]
    columns: String,
    /// Constants to fit beside the usual ones, such as inertia.yaw
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    free: Vec<String>,
    /// Constants to leave as the preset has them, such as rotor_time_constant.tail
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    fix: Vec<String>,
    /// Length of the windows that are fitted, in s
    #[arg(long, value_name = "S", default_value_t = WINDOW, allow_negative_numbers = true)]
    window: f64,
    /// Flowers of the search for where to begin
    #[arg(long, value_name = "N", default_value_t = 12)]
    population: usize,
    /// Generations after the first
    #[arg(long, value_name = "T", default_value_t = 3)]
    iterations: usize,
    /// Where to write the preset, for --preset of every other command
    #[arg(long, value_name = "FILE", default_value = "preset.toml", help_heading = "Output")]
    out: PathBuf,
    /// Where to draw logs and residuals (.svg or .png) [default: beside the preset, as .svg]
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    checkpoint: Checkpoint,
    /// Write the experiment that would tell most about the worst-known constant, as a scenario to fly
    #[arg(long, value_name = "SCENARIO.toml")]
    suggest: Option<PathBuf>,
    /// Gains that the suggested experiment is flown with [default: the preset's, else the paper's]
    #[arg(long, value_name = "FILE", requires = "suggest")]
    gains: Option<String>,
}

/// How well a log is explained.
#[derive(Debug, Serialize)]
struct LogFit {
    log: String,
    role: &'static str,
    offset_deg: f64,
    #[serde(flatten)]
    fit: Fit,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    preset: &'a str,
    seed: u64,
    windows: usize,
    window_s: f64,
    cost: f64,
    descents: Vec<f64>,
    wall_s: f64,
    parameters: &'a [Parameter],
    fits: &'a [LogFit],
    notes: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    suggestion: Option<String>,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let begun = Instant::now();
    let mut named = args.common.resolve()?;
    let (plot, mut outputs) = check_paths(args)?;
    let window = at_least("--window", args.window, 0.2, false)?;
    let mut free = constants::chosen(&args.free, &args.fix).map_err(Failure::of_flag)?;
    let runs = load(&args.logs, args, &named.rig)?;
    let others = load(&args.validate, args, &named.rig)?;
    let mut notes = notes(&runs, &others);
    let (runs, repeated) = distinct(runs, &others);
    notes.extend(repeated);
    tachometer::check(&runs)?;
    notes.extend(doubts(&runs, &named.rig.plant));
    let mut notes: Vec<String> = notes.iter().map(|note| as_typed(note)).collect();

    let measured = hold_measured_lags(&runs, &mut named.rig.plant, &mut free, &args.free);
    notes.extend(
        measured.iter().map(|p| format!("{} is taken from the tachometers (--free it to fit it)", p.name)),
    );

    let windows = training_windows(&runs, window).map_err(Failure::of_flag)?;
    let count = windows.len();
    let problem = Problem::new(&runs, windows, &named.rig.plant, &free, THRESHOLD);
    let mut search = begin(args, &named, &problem, &runs)?;
    let listening = stop::listen(stop::Second::Ends);
    let (end, checkpoint) = drive(args, &problem, &mut search, &mut outputs)?;
    let go_on = checkpoint
        .map_or_else(String::new, |path| format!("; --checkpoint {} --resume goes on", path.display()));
    let Some((found, cost)) = search.best().cloned() else {
        return Err(if end == End::Interrupted {
            Failure::Interrupted(format!("no descent had come to an end yet; no preset is written{go_on}"))
        } else {
            Failure::Run("no descent came to an end; nothing is written".to_owned())
        });
    };

    let plant = problem.plant(&found.values);
    let rig = identified(&named.rig, plant, &runs).map_err(|e| with_notes(e, &notes))?;
    let (mut parameters, known) = twinrotor_identify::parameters(&problem, &found);
    outputs.write(&args.out, preset_file(&rig, args, &named).as_bytes());
    drop(listening);
    if stop::requested() {
        if !args.common.json {
            print(&outputs.unwritten())?;
        }
        outputs.done()?;
        let ended = search.descents().len();
        return Err(Failure::Interrupted(format!(
            "the best of {ended} descents, with cost {cost:.6}, is in {}{go_on}",
            args.out.display()
        )));
    }
    let mut compared: Vec<(&Run, f64, &'static str)> =
        runs.iter().zip(&found.offsets).map(|(run, offset)| (run, *offset, "train")).collect();
    compared.extend(others.iter().map(|run| (run, offset_of(run, &plant, window), "validate")));
    let fits: Vec<LogFit> =
        compared.iter().flat_map(|(run, offset, role)| log_fits(run, *offset, role, &rig)).collect();
    let drawn: Vec<(&Run, f64)> = compared.iter().map(|(run, offset, _)| (*run, *offset)).collect();
    let drawn = residuals(&format!("Windows of {window} s, simulated"), &drawn, &plant, window);
    outputs.write(&plot, &figure::bytes(&drawn, &plot)?);

    let suggestion = match &args.suggest {
        Some(path) => {
            let gains = gains(args, &named)?;
            let suggestion = suggest(&rig, &gains, &free, &found, (&parameters, &known), window)?;
            outputs.write(path, suggestion.toml.as_bytes());
            Some(suggestion)
        }
        None => None,
    };
    parameters.extend(measured);

    let wall_s = begun.elapsed().as_secs_f64();
    if args.common.json {
        print_json(&Document {
            preset: &named.name,
            seed: args.common.seed,
            windows: count,
            window_s: window,
            cost,
            descents: search.descents(),
            wall_s,
            parameters: &parameters,
            fits: &fits,
            notes: &notes,
            suggestion: suggestion.as_ref().map(told),
        })?;
    } else {
        let heading = format!("{} logs, {count} windows of {window} s, {wall_s:.1} s", runs.len());
        let summary = summary(args, &heading, &parameters, &fits, &notes, suggestion.as_ref(), &plot);
        print(&format!("{summary}{}", outputs.unwritten()))?;
    }
    outputs.done()
}

/// Refuses, before any work is done, what could not be written or searched; gives the figure's path.
fn check_paths(args: &Args) -> Outcome<(PathBuf, Outputs)> {
    within("--population", args.population, 2, 10_000)?;
    within("--iterations", args.iterations, 0, 100_000)?;
    let mut outputs = args.common.outputs();
    outputs.reads("--gains", args.gains.as_deref().unwrap_or_default());
    args.logs.iter().for_each(|log| outputs.reads("LOG.csv", log));
    args.validate.iter().for_each(|log| outputs.reads("--validate", log));
    outputs.writes("--out", &args.out)?;
    let plot = beside(args.plot.as_deref(), &args.out, &mut outputs)?;
    if let Some(path) = &args.suggest {
        outputs.writes("--suggest", path)?;
    }
    args.checkpoint.check(&mut outputs)?;
    Ok((plot, outputs))
}

fn load(paths: &[PathBuf], args: &Args, rig: &Rig) -> Outcome<Vec<Run>> {
    let columns = Columns::parse(&args.columns).map_err(Failure::of_flag)?;
    let load = |path: &PathBuf| Ok(Run::new(files::log(path, &columns, rig)?));
    paths.iter().map(load).collect()
}

fn notes(runs: &[Run], others: &[Run]) -> Vec<String> {
    let of =
        |run: &Run| run.log.notes.iter().map(|note| format!("{}: {note}", run.log.name)).collect::<Vec<_>>();
    runs.iter().chain(others).flat_map(of).collect()
}

/// What failed, with what was found odd about the logs: that may be why.
fn with_notes(error: Error, notes: &[String]) -> Failure {
    let told: Vec<String> = notes.iter().map(|note| format!("; note: {note}")).collect();
    Failure::Run(format!("{}{}", as_typed(&error.to_string()), told.concat()))
}

/// A search at its beginning, or where its checkpoint left it.
fn begin(args: &Args, named: &NamedRig, problem: &Problem<'_>, runs: &[Run]) -> Outcome<Search> {
    let effort = Effort { population: args.population, iterations: args.iterations, seed: args.common.seed };
    let logs: Vec<String> = runs.iter().map(|r| format!("{} {:08x}", r.log.name, r.log.checksum())).collect();
    let free: Vec<&str> = problem.free().iter().map(|k| constants::CONSTANTS[*k].name).collect();
    let identity = Identity::new()
        .with("preset", &named.name)
        .with_toml(&twinrotor_sim::rig::to_toml(&named.rig))
        .with("log", logs.join(", "))
        .with("columns", &args.columns)
        .with("free constants", free.join(","))
        .with("window", args.window)
        .with("population", effort.population)
        .with("iterations", effort.iterations)
        .with("seed", effort.seed);
    let begun = Search::new(identity, problem, &named.rig.plant, effort);
    args.checkpoint.resume_or(begun, |begun, bytes| begun.resume(bytes, problem))
}

/// How it ended, and where its state is kept.
fn drive(
    args: &Args,
    problem: &Problem<'_>,
    search: &mut Search,
    outputs: &mut Outputs,
) -> Outcome<(End, Option<PathBuf>)> {
    let bar = ProgressBar::new_spinner();
    bar.set_style(
        ProgressStyle::with_template("{spinner} {msg}, {elapsed}").expect("the template is well-formed"),
    );
    let progress = |what: &str, cost: f64| {
        bar.set_message(format!("{what}, best {cost:.6}"));
        bar.tick();
    };
    let keeper = Keeper::new(args.checkpoint.file.as_deref());
    let end = search.run(problem, args.window, &stop::requested, |search, what, cost| {
        progress(what, cost);
        keeper.keep_now(|| search.checkpoint());
        if stop::requested() { ControlFlow::Break(End::Interrupted) } else { ControlFlow::Continue(()) }
    });
    bar.finish_and_clear();
    let end = end.map_err(Failure::of_flag)?.break_value().unwrap_or(End::Complete);
    Ok((end, keeper.done(outputs)))
}

fn log_fits(run: &Run, offset: f64, role: &'static str, rig: &Rig) -> Vec<LogFit> {
    let named = |fit| LogFit { log: run.log.name.clone(), role, offset_deg: offset.to_degrees(), fit };
    twinrotor_identify::fits(run, &rig.plant, offset).into_iter().map(named).collect()
}

fn gains(args: &Args, named: &NamedRig) -> Outcome<GainsFile> {
    if let Some(name) = &args.gains {
        return files::gains("--gains", name);
    }
    let own = twinrotor::defaults::named(&named.name);
    Ok(own.map_or_else(GainsFile::paper, |controller| GainsFile { controller, provenance: None }))
}

/// The preset, with where it came from as a comment.
fn preset_file(rig: &Rig, args: &Args, named: &NamedRig) -> String {
    let logs: Vec<String> = args.logs.iter().map(|path| shown(path)).collect();
    format!(
        "# identified from {} on the basis of {}, seed {}, by host-sim {}\n{}",
        logs.join(", "),
        named.name,
        args.common.seed,
        env!("CARGO_PKG_VERSION"),
        twinrotor_sim::rig::to_toml(rig)
    )
}

fn shown(path: &Path) -> String {
    path.display().to_string().replace(['\n', '\r'], " ")
}

fn told(suggestion: &Suggestion) -> String {
    format!(
        "{}: {}, which leaves {:.0} % of its interval",
        suggestion.constant,
        suggestion.what,
        100.0 * suggestion.remaining
    )
}

fn summary(
    args: &Args,
    heading: &str,
    parameters: &[Parameter],
    fits: &[LogFit],
    notes: &[String],
    suggestion: Option<&Suggestion>,
    plot: &Path,
) -> String {
    let mut text = format!("{heading}\n");
    let mut table = tables::table(&["constant", "value", "95 % interval", "unit"]);
    for p in parameters {
        let interval = match p.ci95 {
            Some([least, most]) => format!("{least:.4e} to {most:.4e}"),
            None if p.at_bound => "at its bound".to_owned(),
            None => "unknown".to_owned(),
        };
        tables::add(&mut table, [p.name.to_owned(), format!("{:.4e}", p.value), interval, p.unit.to_owned()]);
    }
    let _ = writeln!(text, "{table}");
    let mut table = tables::table(&["fit [%]", "", "window [s]", "pitch", "yaw"]);
    let percent = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.1}"));
    for LogFit { log, role, fit, .. } in fits {
        let row =
            [log.clone(), (*role).to_owned(), fit.window_s.to_string(), percent(fit.pitch), percent(fit.yaw)];
        tables::add(&mut table, row);
    }
    let _ = writeln!(text, "{table}");
    for note in notes {
        let _ = writeln!(text, "note: {note}");
    }
    for p in parameters.iter().filter(|p| p.at_bound) {
        let _ = writeln!(text, "warning: {} lies at the bound {:.3e} that physics sets", p.name, p.value);
    }
    for p in parameters.iter().filter(|p| !p.identifiable && !p.at_bound) {
        let _ = writeln!(
            text,
            "warning: {} is not identifiable from this input; fix it (--fix {}) or record more (--suggest)",
            p.name, p.name
        );
    }
    if let (Some(suggestion), Some(path)) = (suggestion, &args.suggest) {
        let _ = writeln!(text, "next:    {} ({})", told(suggestion), path.display());
    }
    let _ = writeln!(text, "preset:  {}\nfigure:  {}", args.out.display(), plot.display());
    let _ = writeln!(
        text,
        "tune it: cargo run --release -p host-sim tune --preset {} --fidelity rig --objective robust",
        args.out.display()
    );
    text
}
