//! The command line: flags as typed, resolved into what the library takes; exit status decided here and
//! nowhere else.
//!
//! 0 done; 1 the run failed; 2 bad input, told in one line; 3 the flight left the
//! envelope or a fault stopped it; 130 after Ctrl-C, SIGTERM or SIGHUP, with what it says is kept.

mod bench;
mod bench_tuners;
mod choices;
mod common;
mod compare;
mod coverage;
mod examples;
mod fitted;
mod flash;
mod fly;
mod identify;
mod manual;
mod map;
mod margins;
mod monitor;
mod next;
mod page;
mod pareto;
mod replay;
mod reproduce;
mod simulate;
mod tables;
mod tune;
mod who;

use crate::error::{Failure, Outcome};
use crate::stop;
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, CommandFactory, FromArgMatches, Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;

/// What an exit status says, as help tells it.
const STATUSES: &str = "\
Exit status: 0 done, 1 the run failed, 2 bad input, 130 interrupted,
             3 the flight left the envelope or a fault stopped it
Begin with:  host-sim tune, host-sim fly
             docs/first-flight.md goes the whole road";

/// Simulate, tune and check the controller that flies on the board: the same core, bit for bit.
#[derive(Debug, Parser)]
#[command(name = "host-sim", version, about, after_help = STATUSES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print tables as lines with tabs between columns, for other programs
    #[arg(long, global = true, help_heading = "Output")]
    plain: bool,
}

/// In the order in which people need them.
#[derive(Debug, Subcommand)]
enum Command {
    /// Breed gains by flower pollination, set them beside the paper's and write them to a file
    #[command(after_help = examples::TUNE)]
    Tune(tune::Args),
    /// Fly one scenario and report settling, overshoot, error integrals and what the motors were asked for
    #[command(after_help = examples::SIMULATE)]
    Simulate(simulate::Args),
    /// Fly a board, from connecting to disarmed: a simulated one, one at a serial port, or one over TCP
    #[command(after_help = examples::FLY)]
    Fly(fly::Args),
    /// A board, real or simulated, to watch, tune and fly in a browser
    #[command(after_help = examples::MONITOR)]
    Monitor(monitor::Args),
    /// The simulated board and the tuner as one file to open in a browser
    #[command(after_help = examples::PAGE)]
    Page(page::Args),
    /// Put gains on a board: by an image, a debug probe or the serial link
    #[command(after_help = examples::FLASH)]
    Flash(flash::Args),
    /// A rig's constants, with intervals, from logs of its own runs
    #[command(after_help = examples::IDENTIFY)]
    Identify(identify::Args),
    /// Whether the intervals of 'identify' hold the truth: rigs drawn around a preset, a log of each
    #[command(after_help = examples::COVERAGE)]
    Coverage(coverage::Args),
    /// A log through the firmware's own estimator and law
    #[command(after_help = examples::REPLAY)]
    Replay(replay::Args),
    /// Controllers side by side on hundreds of plants that none was tuned on
    #[command(after_help = examples::COMPARE)]
    Compare(compare::Args),
    /// The report of a comparison whose plants several machines have flown, each a part
    #[command(after_help = examples::MERGE)]
    Merge(compare::merge::Args),
    /// The trade-off between settling, disturbance error and voltage variation, each point with its gains
    #[command(after_help = examples::PARETO)]
    Pareto(pareto::Args),
    /// What the cost is around a controller, over two of its numbers, as a picture
    #[command(after_help = examples::MAP)]
    Map(map::Args),
    /// Thrust, lag, inertia and delay that a controller stands, and the slowest pole of its loop
    #[command(after_help = examples::MARGINS)]
    Margins(margins::Args),
    /// The paper's tables, figures and claims beside ours, as a report to open in a browser
    #[command(after_help = examples::REPRODUCE)]
    Reproduce(reproduce::Args),
    /// Methods of search side by side on one problem: medians, spread, rank tests, convergence
    #[command(after_help = examples::BENCH_TUNERS)]
    BenchTuners(bench_tuners::Args),
    /// How fast this machine is: closed-loop steps a second on one core
    #[command(after_help = examples::BENCH)]
    Bench(bench::Args),
    /// Manual pages, and completions for shells
    #[command(after_help = examples::MANUAL)]
    Manual(manual::Args),
}

/// Runs what was typed.
pub fn main() -> ExitCode {
    stop::watch();
    let cli = match parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    tables::choose(cli.plain);
    let outcome = match cli.command {
        Command::Simulate(args) => simulate::run(&args),
        Command::Tune(args) => tune::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Merge(args) => compare::merge::run(&args),
        Command::Margins(args) => margins::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::BenchTuners(args) => bench_tuners::run(&args),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Map(args) => map::run(&args),
        Command::Pareto(args) => pareto::run(&args),
        Command::Identify(args) => identify::run(&args),
        Command::Coverage(args) => coverage::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Flash(args) => flash::run(&args),
        Command::Fly(args) => fly::run(&args),
        Command::Monitor(args) => monitor::run(&args),
        Command::Page(args) => page::run(&args),
        Command::Manual(args) => manual::run(&args, Cli::command()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            tell(&format!("error: {failure}"));
            ExitCode::from(failure.exit_status())
        }
    }
}

/// What was typed. A value may be negative wherever there is one, so that it is told what is allowed, and not
/// taken for a flag that there is not.
fn parse() -> Result<Cli, clap::Error> {
    let negative = |arg: Arg| match arg.get_action() {
        ArgAction::Set | ArgAction::Append if !arg.is_allow_hyphen_values_set() => {
            arg.allow_negative_numbers(true)
        }
        _ => arg,
    };
    let command = Cli::command().mut_subcommands(|command| command.mut_args(negative));
    Cli::from_arg_matches(&command.try_get_matches()?)
}

/// What the standard library says of a number that it cannot read, and what is allowed instead.
const NUMBERS: [(&str, &str); 4] = [
    ("invalid digit found in string", "allowed: a whole number of at least 0"),
    ("number too large to fit in target type", "allowed: a whole number of at most 18446744073709551615"),
    ("cannot parse integer from empty string", "allowed: a whole number of at least 0"),
    ("invalid float literal", "allowed: a number"),
];

/// Help and version are no errors; anything else is told in one line.
fn usage(error: &clap::Error) -> ExitCode {
    if matches!(
        error.kind(),
        ErrorKind::DisplayHelp
            | ErrorKind::DisplayVersion
            | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
    ) {
        let _ = error.print();
        return ExitCode::from(u8::from(error.use_stderr()) * 2);
    }
    let text = error.render().to_string();
    let told = text.split("\n\nUsage").next().unwrap_or_default().split("\n\nFor more").next();
    let line: Vec<&str> = told.unwrap_or_default().split_whitespace().collect();
    let line = NUMBERS.iter().fold(line.join(" "), |line, (theirs, ours)| line.replace(theirs, ours));
    tell(&format!("{line} (--help lists what there is)"));
    ExitCode::from(2)
}

/// Says a line on standard error. If nobody can be told, the exit status still says it.
fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Prints to standard output. A reader that has gone away is no failure of ours.
fn print(text: &str) -> Outcome<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Run(format!("standard output: cannot be written: {e}")))
        }
        _ => Ok(()),
    }
}

/// Prints one JSON document.
fn print_json(document: &impl serde::Serialize) -> Outcome<()> {
    let text = serde_json::to_string_pretty(document).expect("reports are made of plain data");
    print(&format!("{text}\n"))
}
