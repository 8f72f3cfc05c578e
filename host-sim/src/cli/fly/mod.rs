//! `fly`: a board, from connecting to disarmed.

mod ask;
mod desk;
mod differs;
mod inject;
mod owner;
mod report;
mod task;

use super::common::{board, drawn, no_effect};
use super::{print, print_json};
use crate::error::{Failure, Outcome};
use crate::figures;
use crate::files::export;
use crate::files::figure;
use crate::files::output::Outputs;
use crate::line::{self, Line, NOT_SEEN, Simulated};
use crate::stop::{self, Second};
use desk::Desk;
use report::{Differences, Document};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Duration;
use task::{Task, plan, task};
use twinrotor::axes::PerAxis;
use twinrotor::board::Board;
use twinrotor::rig_port::RigPort;
use twinrotor_sim::flight::{self, Fidelity, Flight, Plan as Simulation, Scalar};
use twinrotor_sim::scenario::Inject;
use twinrotor_station::again::again;
use twinrotor_station::flown::flown;
use twinrotor_station::image;
use twinrotor_station::recording::{self, Gaps};
use twinrotor_station::session::{End, Ending, Motors, Session};

/// Flags of `fly`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Where the board is: 'sim' (simulated with its rig), a serial port, tcp://HOST:PORT, or 'auto' for the
    /// serial port at which one answers
    #[arg(long, default_value = "sim", value_name = "sim|auto|DEVICE|tcp://HOST:PORT")]
    port: String,
    /// Rig: paper, paper-fixed, aero, aero2, aero-lab, heli, or a FILE.toml of your own
    #[arg(long, default_value = "aero2", help_heading = "Rig")]
    preset: String,
    /// Board: f405, feather-f405, f407, black-pill, nucleo-f411, nucleo-f446 or nucleo-g474
    #[arg(long, value_name = "NAME", default_value = "f405", value_parser = board, help_heading = "Rig")]
    board: Board,
    /// Gains: 'paper' (Table 4) or a gains file [default: the preset's own]
    #[arg(long, value_name = "paper|FILE")]
    gains: Option<String>,
    /// What to fly: step, 1, 2, 3, 3-square, or a FILE.toml of your own
    #[arg(long, default_value = "step")]
    scenario: String,
    /// Try these gains in flight: the scenario is flown with --gains, then with them, and both are shown
    #[arg(long, value_name = "FILE")]
    trial: Option<String>,
    /// Keep the gains of --trial in force, unless the board has taken them back
    #[arg(long, requires = "trial")]
    accept: bool,
    /// Keep them in the board's flash, too
    #[arg(long, requires = "accept")]
    save: bool,
    /// Keep every frame from zeroing on: .csv, as identify and replay read it, .parquet or .mcap
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    record: Option<PathBuf>,
    /// Draw what was flown over what was expected, as .svg or .png
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
    /// Write what is asked for to a board that has something else, without asking
    #[arg(long)]
    write: bool,
    /// Do not ask before the motors turn
    #[arg(long)]
    yes: bool,
    /// The simulated board in real time instead of as fast as it goes
    #[arg(long)]
    real_time: bool,
    /// The rig of the board at --port is simulated outside of it: compute the flight once more and compare to
    /// the bit, as is done with any board that simulates its rig itself
    #[arg(long)]
    verify: bool,
    /// Let this befall a rig that the board simulates, so long after the scenario's begin: stuck-pitch@2,
    /// reversed-yaw@2, slip-yaw=-400@2, supply=9@2, disturbance=2:-1@2, weight=0.02:0.1@2, fault@2, stop@2,
    /// stall=3@2 and others
    #[arg(long, value_name = "KIND@SECONDS")]
    inject: Vec<Inject>,
    /// Fly every scenario of this folder, too, compare all of it to the bit, and write what came of it and
    /// which board it was as JSON: what an owner of a board sends back to this project
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["trial", "inject"], help_heading = "Output")]
    report: Option<PathBuf>,
    /// The folder of --report
    #[arg(long, value_name = "FOLDER", default_value = "scenarios", requires = "report")]
    scenarios: PathBuf,
    /// Of everything random in the simulation
    #[arg(long, default_value_t = 1, help_heading = "Computing")]
    seed: u64,
    /// Tell every setting that the board has otherwise than is asked for, not a few
    #[arg(long, help_heading = "Output")]
    verbose: bool,
    /// Print one JSON document and nothing else
    #[arg(long, help_heading = "Output")]
    json: bool,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let simulated = args.port == "sim";
    let task = task(args, simulated)?;
    if args.real_time && !simulated {
        return Err(no_effect(
            "--real-time",
            "with --port",
            "only a simulated board can be faster than time",
        ));
    }
    if !simulated && !args.yes && !std::io::stdin().is_terminal() {
        return Err(Failure::Input(
            "--yes is missing, and nobody is at a terminal to be asked before the motors turn".to_owned(),
        ));
    }
    let outputs = outputs(args)?;
    // Before the line is opened: from then on, whatever ends this ends it with the motors off.
    let _listening = stop::listen(Second::Asks);
    let (port, line): (String, Box<dyn Line>) = if simulated {
        let line = Simulated::new(args.board, &task.parameters, args.real_time).map_err(image::unusable)?;
        ("sim".to_owned(), Box::new(line.befallen_by(&task.scenario, args.seed)))
    } else {
        line::open(&args.port)?
    };
    let plan = plan(args, &task, simulated)?;
    let frame_every = plan.frame_every;
    let differing = (if args.verbose { usize::MAX } else { differs::FEW }, plan.write);
    let mut desk = Desk::new(line, Session::new(plan, Duration::ZERO), task.parameters, differing);
    let end = desk.run(|step| if args.json { Ok(()) } else { print(&report::line(step)) });
    conclude(args, &task, &port, &desk, &end, frame_every, outputs)
}

/// What is read and what will be written.
fn outputs(args: &Args) -> Outcome<Outputs> {
    let mut outputs = Outputs::new();
    outputs.reads("--preset", &args.preset);
    outputs.reads("--scenario", &args.scenario);
    for (flag, name) in [("--gains", &args.gains), ("--trial", &args.trial)] {
        if let Some(name) = name {
            outputs.reads(flag, name);
        }
    }
    if let Some(path) = &args.record {
        export::check("--record", path, true)?;
        outputs.writes("--record", path)?;
    }
    drawn(args.plot.as_deref(), &mut outputs)?;
    if let Some(path) = &args.report {
        outputs.writes("--report", path)?;
    }
    Ok(outputs)
}

/// Files and report, once the motors are off, and the exit status.
fn conclude(
    args: &Args,
    task: &Task,
    port: &str,
    desk: &Desk,
    end: &End,
    frame_every: u16,
    mut outputs: Outputs,
) -> Outcome<()> {
    let Desk { flown: flown_, session, .. } = desk;
    let frames = &flown_.frames;
    let rig = &task.named.rig;
    let since_zero = flown_.zeroed.and_then(|zeroed| frames.iter().position(|f| f.tick == zeroed));
    let recorded = since_zero.map_or(&[][..], |from| &frames[from..]);
    let gaps = recording::gaps(recorded, frame_every);
    let record = if let Some(path) = &args.record {
        outputs.write(path, &export::bytes(&recording::table(recorded, frame_every), path)?);
        let Gaps { gaps, .. } = gaps;
        Some(format!("{}: {} ticks, {gaps} gaps", path.display(), recorded.len()))
    } else {
        None
    };
    let nth = |k: usize| flown_.begins.get(k).map(|begin| flown(frames, *begin, rig, &task.scenario));
    // The first flight is one with cold motors, as the simulation's; it warms them for those of a trial.
    let flight = nth(0);
    let (accepted, tried) = if task.trial.is_some() { (nth(1), nth(2)) } else { (None, None) };
    let simulated = flight.as_ref().map(|_| simulate(args, task)).transpose()?;
    if let (Some(path), Some(flight), Some(simulated)) = (&args.plot, &flight, &simulated) {
        let title =
            format!("{}, scenario {}, {} gains", task.named.name, task.scenario.name, task.gains_name);
        let flights = match (&accepted, &tried) {
            (Some(accepted), Some(tried)) => [("accepted", accepted), ("tried", tried)],
            _ => [("simulated", simulated), ("flown", flight)],
        };
        let figure = figures::comparison(&title, flights, rig.volts_limit);
        outputs.write(path, &figure::bytes(&figure, path)?);
    }
    let simulates = session.identity().is_some_and(|identity| identity.port == RigPort::Simulated);
    let flown_or_injected = match &end.ending {
        Ending::Flown => true,
        Ending::Stopped(_) => !args.inject.is_empty() || !task.scenario.inject.is_empty(),
        _ => false,
    };
    // What befalls a rig by its scenario is not computed once more.
    let calm = task.scenario.is_undisturbed();
    let verified = if flown_or_injected && calm && (args.verify || simulates) {
        let own = simulates.then(|| task.parameters.rig(rig.board));
        let rig = own.as_ref().unwrap_or(rig);
        Some(again(rig, &task.parameters, frames, session.said(), session.tried()))
    } else {
        None
    };
    if let Some(path) = &args.report {
        outputs.write(path, &owner::report(task, desk, end, verified.as_ref())?);
    }
    let document = Document {
        preset: &task.named.name,
        scenario: &task.scenario.name,
        gains: &task.gains_name,
        port,
        duration_s: task.scenario.duration,
        ended: ended(&end.ending),
        motors: motors(end.motors),
        why: why(end),
        steps: &flown_.steps,
        differs: flown_.differences.iter().map(ToString::to_string).collect(),
        frames: frames.len(),
        gaps,
        frames_dropped: flown_.health.map(|health| health.frames_dropped),
        flown: flight.as_ref().map(|flight| flight.report),
        simulated: simulated.as_ref().map(|flight| flight.report),
        accepted: accepted.map(|flight| flight.report),
        tried: tried.map(|flight| flight.report),
        difference: flight.as_ref().zip(simulated.as_ref()).map(|(a, b)| Differences::new(a, b)),
        verified_ticks: verified.as_ref().and_then(|verified| verified.as_ref().ok()).copied(),
        record,
        notes: task.notes.clone(),
    };
    let printed = if args.json { print_json(&document) } else { print(&document.text()) };
    status(end)?;
    outputs.done()?;
    if let Some(Err(error)) = verified {
        return Err(Failure::Run(error.to_string()));
    }
    printed
}

/// What was to be expected: the same scenario in the rig's world.
fn simulate(args: &Args, task: &Task) -> Outcome<Flight> {
    let settings = task.gains.settings(&task.named.rig);
    let plan = Simulation {
        rig: &task.named.rig,
        truth: &task.named.rig,
        settings: &settings,
        scenario: &task.scenario,
        initial: PerAxis::zero(),
        fidelity: Fidelity::Rig,
        seed: args.seed,
    };
    Ok(flight::fly(&plan, Scalar::F32)?)
}

const fn ended(ending: &Ending) -> &'static str {
    match ending {
        Ending::Flown => "flown",
        Ending::Trouble(_) => "trouble",
        Ending::Stopped(_) => "stopped",
        Ending::Interrupted => "interrupted",
    }
}

const fn motors(motors: Motors) -> &'static str {
    match motors {
        Motors::NeverTurned => "never-turned",
        Motors::SeenOff => "seen-off",
        Motors::NotSeenOff => "not-seen-off",
    }
}

/// Why it did not end as it should, in a line.
fn why(end: &End) -> Option<String> {
    let why = match &end.ending {
        Ending::Flown => None,
        Ending::Trouble(why) | Ending::Stopped(why) => Some(why.clone()),
        Ending::Interrupted => Some("interrupted".to_owned()),
    };
    match end.motors {
        Motors::NotSeenOff => {
            Some(format!("{}; {NOT_SEEN}", why.unwrap_or_else(|| "the flight is over".to_owned())))
        }
        Motors::SeenOff => why.map(|why| format!("{why}; the motors were seen to be off")),
        Motors::NeverTurned => why,
    }
}

/// What a session's end means for whoever started it.
fn status(end: &End) -> Outcome<()> {
    let Some(why) = why(end) else { return Ok(()) };
    Err(match (&end.ending, end.motors) {
        (Ending::Interrupted, Motors::SeenOff) => {
            Failure::Interrupted("the motors were seen to be off".to_owned())
        }
        (Ending::Interrupted, Motors::NeverTurned) => Failure::Interrupted("no motor had turned".to_owned()),
        (Ending::Stopped(_), _) => Failure::Flight(why),
        _ => Failure::Run(why),
    })
}
