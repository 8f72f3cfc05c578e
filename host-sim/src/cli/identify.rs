//! `identify`: a rig's constants from its logs.

use super::common::{Checkpoint, Common, End, beside};
use super::fitted::{Fitted, gains};
use super::next::next;
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
use twinrotor::plant::{Effectiveness, PlantParameters};
use twinrotor_identify::identification::{Course, Evidence, Findings, LogFit, Report};
use twinrotor_identify::log::{Columns, Log};
use twinrotor_identify::problem::Problem;
use twinrotor_identify::search::Search;
use twinrotor_identify::suggest::{Suggestion, suggest};
use twinrotor_identify::windows::Run;
use twinrotor_sim::Error;
use twinrotor_sim::rig::NamedRig;

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
    #[command(flatten)]
    fitted: Fitted,
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

#[derive(Debug, Serialize)]
struct Document<'a> {
    #[serde(flatten)]
    course: &'a Course,
    wall_s: f64,
    #[serde(flatten)]
    findings: &'a Findings,
    #[serde(skip_serializing_if = "Option::is_none")]
    suggestion: Option<String>,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let begun = Instant::now();
    let named = args.common.resolve()?;
    let (question, window) = (args.fitted.question(named.clone(), args.common.seed)?, args.fitted.window);
    let (plot, mut outputs) = check_paths(args)?;
    let (logs, others) = (load(&args.logs, args, &named.rig)?, load(&args.validate, args, &named.rig)?);
    let evidence = question.put_to(logs, others).map_err(told)?;
    let problem = evidence.problem();
    let search = evidence.search(&problem, &args.columns);
    let mut search = args.checkpoint.resume_or(search, |search, bytes| search.resume(bytes, &problem))?;
    let listening = stop::listen(stop::Second::Ends);
    let (end, checkpoint) = drive(args, &evidence, &problem, &mut search, &mut outputs)?;
    let go_on = checkpoint
        .map_or_else(String::new, |path| format!("; --checkpoint {} --resume goes on", path.display()));
    if search.best().is_none() {
        return Err(if end == End::Interrupted {
            Failure::Interrupted(format!("no descent had come to an end yet; no preset is written{go_on}"))
        } else {
            Failure::Run("no descent came to an end; nothing is written".to_owned())
        });
    }

    let answer = evidence.answer(&search, &problem)?;
    outputs.write(&args.out, preset_file(&answer.rig, args, &named).as_bytes());
    drop(listening);
    if stop::requested() {
        if !args.common.json {
            print(&outputs.unwritten())?;
        }
        outputs.done()?;
        let (ended, cost) = (answer.descents.len(), answer.cost);
        return Err(Failure::Interrupted(format!(
            "the best of {ended} descents, with cost {cost:.6}, is in {}{go_on}",
            args.out.display()
        )));
    }
    let compared = evidence.compared(&answer);
    let drawn: Vec<(&Run, f64)> = compared.iter().map(|(run, offset, _)| (*run, *offset)).collect();
    let title = format!("Windows of {} s, simulated", window);
    let drawn = residuals(&title, &drawn, &answer.rig.plant, window);
    outputs.write(&plot, &figure::bytes(&drawn, &plot)?);

    let suggestion = match &args.suggest {
        Some(path) => {
            let gains = gains(args.gains.as_deref(), &named)?;
            let known = (&answer.parameters[..], &answer.known);
            let suggestion = suggest(&answer.rig, &gains, evidence.free(), &answer.found, known, window)?;
            outputs.write(path, suggestion.toml.as_bytes());
            Some(suggestion)
        }
        None => None,
    };
    let Report { course, mut findings } = evidence.report(&answer, &compared);
    findings.notes.iter_mut().for_each(|note| *note = as_typed(note));

    let wall_s = begun.elapsed().as_secs_f64();
    if args.common.json {
        let suggestion = suggestion.as_ref().map(in_words);
        print_json(&Document { course: &course, wall_s, findings: &findings, suggestion })?;
    } else {
        let (logs, windows) = (evidence.runs.len(), course.windows);
        let heading = format!(
            "{logs} logs, from preset {}, {windows} windows of {window} s, {wall_s:.1} s\n{}",
            named.name,
            args.common.unsaid(None)
        );
        let summary = summary(
            args,
            &heading,
            &findings,
            suggestion.as_ref(),
            &plot,
            [&answer.rig.plant, &named.rig.plant],
        );
        print(&format!("{summary}{}", outputs.unwritten()))?;
    }
    outputs.done()
}

/// What the library says: of a value that came by a flag, or of a log.
fn told(error: Error) -> Failure {
    if matches!(error, Error::Invalid { .. }) { Failure::of_flag(error) } else { error.into() }
}

/// Refuses, before any work is done, what could not be written; gives the figure's path.
fn check_paths(args: &Args) -> Outcome<(PathBuf, Outputs)> {
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

fn load(paths: &[PathBuf], args: &Args, rig: &Rig) -> Outcome<Vec<Log>> {
    let columns = Columns::parse(&args.columns).map_err(Failure::of_flag)?;
    paths.iter().map(|path| files::log(path, &columns, rig)).collect()
}

/// How it ended, and where its state is kept.
fn drive(
    args: &Args,
    evidence: &Evidence,
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
    let end = evidence.drive(search, problem, &stop::requested, |search, what, cost| {
        progress(what, cost);
        keeper.keep_now(|| search.checkpoint());
        if stop::requested() { ControlFlow::Break(End::Interrupted) } else { ControlFlow::Continue(()) }
    });
    bar.finish_and_clear();
    let end = end.map_err(told)?.break_value().unwrap_or(End::Complete);
    Ok((end, keeper.done(outputs)))
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

fn in_words(suggestion: &Suggestion) -> String {
    format!(
        "{}: {}, which leaves {:.0} % of its interval",
        suggestion.constant,
        suggestion.what,
        100.0 * suggestion.remaining
    )
}

/// \[V\] At which thrust is compared.
const COMPARED_AT: f64 = 10.0;

/// What the motors do by both parts of their thrust, which share it: either alone may lie far from its
/// preset's where the sum does not.
fn torques([found, preset]: [&PlantParameters<f64>; 2]) -> tables::Table {
    let heading = format!("torque at {COMPARED_AT} V [N m]");
    let mut table = tables::table(&[&heading, "value", "preset", "change"]);
    let at = |plant: &PlantParameters<f64>| plant.effectiveness_at(COMPARED_AT).map(|k| k * COMPARED_AT);
    let pairs = at(found).zip(at(preset), |value, preset| [value, preset]);
    let Effectiveness { main_on_pitch, tail_on_pitch, main_on_yaw, tail_on_yaw } = pairs;
    for (name, [value, preset]) in [
        ("main on pitch", main_on_pitch),
        ("tail on pitch", tail_on_pitch),
        ("main on yaw", main_on_yaw),
        ("tail on yaw", tail_on_yaw),
    ] {
        let numbers = [value, preset].map(|x| format!("{x:.4e}"));
        let [shown, before] = numbers;
        tables::add(&mut table, [name.to_owned(), shown, before, change(value, preset)]);
    }
    table
}

/// How far a constant lies from what was believed before.
fn change(value: f64, preset: f64) -> String {
    let percent = 100.0 * (value - preset) / preset.abs();
    match percent.abs() {
        _ if value.total_cmp(&preset).is_eq() => "none".to_owned(),
        _ if preset.abs() == 0.0 => "from 0".to_owned(),
        0.0..1e3 => format!("{percent:+.1} %"),
        1e3..1e5 => format!("{percent:+.0} %"),
        _ => format!("{percent:+.0e} %"),
    }
}

fn summary(
    args: &Args,
    heading: &str,
    findings: &Findings,
    suggestion: Option<&Suggestion>,
    plot: &Path,
    plants: [&PlantParameters<f64>; 2],
) -> String {
    let Findings { parameters, fits, notes } = findings;
    let mut text = heading.to_owned();
    let mut table = tables::table(&["constant", "value", "preset", "change", "95 % interval", "unit"]);
    for p in parameters {
        let interval = match p.ci95 {
            Some([least, most]) => format!("{least:.4e} to {most:.4e}"),
            None if p.at_bound => "at its bound".to_owned(),
            None => "unknown".to_owned(),
        };
        let [value, preset] = [p.value, p.preset].map(|x| format!("{x:.4e}"));
        let change = change(p.value, p.preset);
        tables::add(&mut table, [p.name.to_owned(), value, preset, change, interval, p.unit.to_owned()]);
    }
    let _ = writeln!(text, "{table}\n{}", torques(plants));
    let mut table = tables::table(&["fit [%]", "", "window [s]", "pitch", "yaw"]);
    let percent = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.1}"));
    for LogFit { log, role, fit, .. } in fits {
        let row = [
            log.clone(),
            role.name().to_owned(),
            fit.window_s.to_string(),
            percent(fit.pitch),
            percent(fit.yaw),
        ];
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
        let _ = writeln!(text, "next:    {} ({})", in_words(suggestion), path.display());
    }
    let _ = writeln!(text, "preset:  {}\nfigure:  {}", args.out.display(), plot.display());
    let tune = next("tune").with("--preset", args.out.display()).with("--objective", "robust");
    let tune = tune.board(args.common.board);
    let _ = writeln!(text, "tune it: {tune}");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_told_in_few_letters_whatever_it_is() {
        let cases = [
            (1.0, 1.0, "none"),
            (0.1, 0.0, "from 0"),
            (0.15, 0.1, "+50.0 %"),
            (-0.05, -0.1, "+50.0 %"),
            (-0.1, 0.1, "-200.0 %"),
            (0.0, 2.0, "-100.0 %"),
            (3.0, 0.1, "+2900 %"),
            (3.0, -1e-9, "+3e11 %"),
        ];
        for (value, preset, told) in cases {
            assert_eq!(change(value, preset), told, "{value} after {preset}");
            assert!(told.len() <= 8);
        }
    }
}
