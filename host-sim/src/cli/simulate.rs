//! `simulate`: fly one scenario.

use super::choices;
use super::common::{Common, PAPER, drawn, no_effect, pair, refuse_in_ideal_world, truth, tuned_elsewhere};
use super::{print, print_json};
use crate::error::{Failure, Outcome};
use crate::files;
use crate::files::export;
use crate::files::figure;
use crate::files::output::Outputs;
use clap::builder::{PossibleValue, PossibleValuesParser};
use serde::Serialize;
use std::path::PathBuf;
use twinrotor::axes::PerAxis;
use twinrotor::law::LawSettings;
use twinrotor::pipeline::Settings;
use twinrotor::static_reach::StaticReach;
use twinrotor_plot::flight::flight as flight_figure;
use twinrotor_plot::moving::moving;
use twinrotor_sim::error::at_least;
use twinrotor_sim::flight::{self, BoardState, COLUMNS, Extent, Fidelity, LOG_COLUMNS, Moment, Plan, Scalar};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::metrics::Report;
use twinrotor_sim::scenario::{Disturbance, Scenario};
use twinrotor_sim::table::Table;

/// The laws there are, each with what it is.
fn laws() -> PossibleValuesParser {
    let kinds = LawSettings::<f64>::KINDS.iter();
    PossibleValuesParser::new(kinds.map(|kind| PossibleValue::new(kind.name).help(kind.doc)))
}

/// Flags of `simulate`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    /// Gains: 'paper' (Table 4) or a gains file [default: paper]
    #[arg(long, value_name = "paper|FILE")]
    gains: Option<String>,
    /// Refuse gains that are of another controller
    #[arg(long, value_parser = laws())]
    controller: Option<String>,
    /// What to fly: step, 1, 2, 3, 3-square, or a FILE.toml of your own
    #[arg(long, default_value = "step")]
    scenario: String,
    /// The paper's world or the rig's
    #[arg(long, default_value = "ideal")]
    fidelity: choices::Fidelity,
    /// Arithmetic: as the board computes (f32), or to verify (f64)
    #[arg(long, default_value = "f32")]
    scalar: choices::Scalar,
    /// How long to fly, in s, instead of the scenario's duration
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Where to start, instead of where the scenario does
    #[arg(long, value_name = "PITCH_DEG,YAW_DEG", allow_hyphen_values = true)]
    initial: Option<String>,
    /// Rig that is flown in truth, all of it: plant, encoders, supply, limits, envelope; the controller
    /// believes --preset
    #[arg(long, value_name = "RIG", help_heading = "Rig")]
    true_rig: Option<String>,
    /// True lag of both rotors, in s, whatever the controller believes
    #[arg(long, value_name = "S", help_heading = "Rig")]
    true_lag: Option<f64>,
    /// Amplitude of random volts added to each motor
    #[arg(long, value_name = "VOLTS", allow_negative_numbers = true)]
    disturbance: Option<f64>,
    /// How long each random value holds, in s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    hold: Option<f64>,
    /// From when to when the disturbance acts, in s
    #[arg(long, value_name = "FROM,TO", allow_hyphen_values = true)]
    window: Option<String>,
    /// Write the true state of every tick to a CSV file, SI units
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    csv: Option<PathBuf>,
    /// Write what a rig would have logged, for 'identify' and 'replay': angles by whole counts, volts as
    /// sent (.csv, or a format of --export)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    log: Option<PathBuf>,
    /// Write every tick, SI units, for other tools: .parquet, .mcap (PlotJuggler, Foxglove, Rerun), .npz or
    /// .csv
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    export: Option<PathBuf>,
    /// Draw the flight as .svg or .png
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
    /// Show the flight as a moving picture that browsers play, as long as the flight (.svg)
    #[arg(long, value_name = "FILE")]
    animate: Option<PathBuf>,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    preset: &'a str,
    /// What was flown, where that was not the preset.
    true_rig: Option<&'a str>,
    true_lag: Option<f64>,
    scenario: &'a str,
    fidelity: Fidelity,
    scalar: Scalar,
    seed: u64,
    duration_s: f64,
    gains: &'a GainsFile,
    #[serde(flatten)]
    report: Report,
    board: Option<BoardState>,
    envelope: Extent,
    left_envelope: Option<Moment>,
    cannot_hold: Option<String>,
    tuned_elsewhere: Option<String>,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    let gains_name = args.gains.as_deref().unwrap_or(PAPER);
    if args.fidelity == choices::Fidelity::Ideal {
        let lags = [("--rotor-lag", args.common.rotor_lag), ("--true-lag", args.true_lag)];
        if let Some((flag, _)) = lags.iter().find(|(_, lag)| lag.is_some()) {
            let why = "rotors of the paper's world have none";
            return Err(no_effect(flag, "with --fidelity ideal", why));
        }
    }
    let truth = truth(args.true_rig.as_deref(), args.true_lag, &named)?;
    let scenario = scenario(args)?;
    refuse_in_ideal_world(&scenario, args.fidelity.into())?;
    let gains = files::gains("--gains", gains_name)?;
    gains.require(args.controller.as_deref()).map_err(Failure::of_flag)?;
    gains
        .require_stable_in(args.fidelity.into(), &named.name, &named.rig)
        .map_err(|error| error.within(gains_name))?;
    let initial = match &args.initial {
        Some(text) => {
            let [pitch, yaw] = pair("--initial", text)?.map(f64::to_radians);
            PerAxis::new(pitch, yaw)
        }
        None => scenario.start.angle(),
    };
    let mut outputs = outputs(args)?;

    let settings = gains.settings(&named.rig);
    let plan = Plan {
        rig: &named.rig,
        truth: &truth,
        settings: &settings,
        scenario: &scenario,
        initial,
        fidelity: args.fidelity.into(),
        seed: args.common.seed,
    };
    let flown = flight::fly(&plan, args.scalar.into())?;

    if let Some(path) = &args.csv {
        outputs.write(path, Table::of_flight(&flown.rows, &COLUMNS).to_csv().as_bytes());
    }
    if let Some(path) = &args.log {
        outputs.write(path, &export::bytes(&Table::of_flight(&flown.rows, &LOG_COLUMNS), path)?);
    }
    if let Some(path) = &args.export {
        outputs.write(path, &export::bytes(&Table::of_flight(&flown.rows, &COLUMNS), path)?);
    }
    let flown_on = args.true_rig.as_ref().map_or_else(String::new, |rig| format!("{rig} taken for "));
    let title = format!("{flown_on}{}, scenario {}, {gains_name} gains", named.name, scenario.name);
    if let Some(path) = &args.plot {
        let figure = flight_figure(&title, &flown, settings.volts_limit);
        outputs.write(path, &figure::bytes(&figure, path)?);
    }
    if let Some(path) = &args.animate {
        outputs.write(path, moving(&title, &flown.rows).as_bytes());
    }
    let envelope = flown.extent(&truth.envelope);
    let cannot_hold = cannot_hold(&settings, &scenario);
    let tuned_elsewhere = tuned_elsewhere(&named.name, &gains);
    if args.common.json {
        print_json(&Document {
            preset: &named.name,
            true_rig: args.true_rig.as_deref(),
            true_lag: args.true_lag,
            scenario: &scenario.name,
            fidelity: args.fidelity.into(),
            scalar: args.scalar.into(),
            seed: args.common.seed,
            duration_s: scenario.duration,
            gains: &gains,
            report: flown.report,
            board: flown.board,
            envelope,
            left_envelope: flown.left_envelope,
            cannot_hold,
            tuned_elsewhere,
        })?;
    } else {
        let warnings = [cannot_hold, tuned_elsewhere].into_iter().flatten();
        let note: String = warnings.map(|told| format!("warning: {told}\n")).collect();
        let told = envelope.text(flown.left_envelope);
        let unsaid = args.common.unsaid(Some(&args.gains));
        print(&format!("{title}\n{unsaid}{}{told}{}{note}", flown.report, board(flown.board)))?;
    }
    outputs.done()?;
    flown.stopped().map_or(Ok(()), |why| Err(Failure::Flight(why)))
}

/// What is read and written.
fn outputs(args: &Args) -> Outcome<Outputs> {
    let mut outputs = args.common.outputs();
    outputs.reads("--gains", args.gains.as_deref().unwrap_or_default());
    outputs.reads("--scenario", &args.scenario);
    outputs.reads("--true-rig", args.true_rig.as_deref().unwrap_or_default());
    if let Some(path) = &args.csv {
        outputs.writes("--csv", path)?;
    }
    if let Some(path) = &args.log {
        if args.fidelity == choices::Fidelity::Ideal {
            let why = "the paper's world has no encoders, --fidelity rig has them";
            return Err(no_effect("--log", "with --fidelity ideal", why));
        }
        export::check("--log", path, true)?;
        outputs.writes("--log", path)?;
    }
    if let Some(path) = &args.export {
        export::check("--export", path, true)?;
        outputs.writes("--export", path)?;
    }
    drawn(args.plot.as_deref(), &mut outputs)?;
    if let Some(path) = &args.animate {
        if files::ending(path).as_deref() != Some("svg") {
            return Err(Failure::Input(format!(
                "--animate is '{}'; allowed: a name that ends in .svg",
                path.display()
            )));
        }
        outputs.writes("--animate", path)?;
    }
    Ok(outputs)
}

/// The board's state in a line; nothing where no board flew.
fn board(state: Option<BoardState>) -> String {
    match state {
        None => String::new(),
        Some(BoardState { condition: Some(condition), since: Some(since), .. }) => {
            format!("board: motors cut at {:.3} s (tick {}): {condition:?}\n", since.time, since.tick)
        }
        Some(BoardState { state, .. }) => format!("board: {state} to the end\n"),
    }
}

/// What a scenario asks for that the motors cannot hold, in words.
pub(super) fn cannot_hold(settings: &Settings<f64>, scenario: &Scenario) -> Option<String> {
    let reach = StaticReach::new(settings);
    let pitches = scenario.references::<f64>().into_iter().map(|reference| reference.angle.pitch);
    let (low, high) = pitches.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    [low, high].into_iter().find_map(|pitch| reach.can_hold(pitch).err()).map(|told| told.to_string())
}

fn scenario(args: &Args) -> Outcome<Scenario> {
    let mut scenario = files::scenario(&args.scenario)?;
    if let Some(duration) = args.duration {
        scenario.duration = at_least("--duration", duration, 0.0, true)?;
    }
    let none = Disturbance { volts: 0.0, hold: 0.1, window: [0.0, scenario.duration] };
    let mut disturbance = scenario.disturbance.unwrap_or(none);
    if let Some(volts) = args.disturbance {
        disturbance.volts = at_least("--disturbance", volts, 0.0, false)?;
    }
    if let Some(hold) = args.hold {
        disturbance.hold = at_least("--hold", hold, 0.0, true)?;
    }
    if let Some(window) = &args.window {
        disturbance.window = pair("--window", window)?;
    }
    scenario.disturbance = (disturbance.volts > 0.0).then_some(disturbance);
    if scenario.disturbance.is_none() {
        for (flag, given) in [("--hold", args.hold.is_some()), ("--window", args.window.is_some())] {
            if given {
                return Err(no_effect(
                    flag,
                    "without a disturbance",
                    "add --disturbance VOLTS or fly scenario 3",
                ));
            }
        }
    }
    scenario.validate()?;
    Ok(scenario)
}
