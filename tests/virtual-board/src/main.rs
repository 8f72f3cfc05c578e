//! Runs the released firmware on the virtual board, for people: switches it on, zeroes, checks the wiring,
//! arms, flies a scenario, and shows what its telemetry said.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use serde::Serialize;
use twinrotor::SAMPLE_TIME;
use twinrotor::link::ToBoard;
use twinrotor::parameters::Parameters;
use twinrotor::parameters::ram_flash::AREA_SIZE;
use twinrotor::plant::presets::Rig;
use twinrotor::supervisor::ArmState;
use twinrotor::telemetry::Frame;
use twinrotor_identify::log::{Columns, Log};
use twinrotor_identify::replay;
use twinrotor_plot::Layout;
use twinrotor_sim::flight::Flight;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::metrics::Report;
use twinrotor_sim::rig;
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::{Error, Outcome};
use twinrotor_station::image;
use virtual_board::firmware::Firmware;
use virtual_board::flight;
use virtual_board::helicopter::Helicopter;
use virtual_board::listen::Server;
use virtual_board::machine::{Machine, Setup};
use virtual_board::record;
use virtual_board::station::Station;
use virtual_board::wiring::Amplifiers;

/// The released firmware on an emulated STM32F405 that is wired to a simulated helicopter.
#[derive(Debug, Parser)]
struct Args {
    /// The firmware's ELF; by default where `cargo fw` puts it, or where TWINROTOR_ELF says
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
    /// The amplifiers are connected for a firmware with the feature `sign-magnitude`
    #[arg(long)]
    sign_magnitude: bool,
    /// What is in the board's flash: 'paper' (Table 4), a gains file, or an image that `host-sim flash
    /// --image` made
    #[arg(long, default_value = "paper", value_name = "paper|FILE.toml|FILE.bin")]
    gains: String,
    /// The helicopter: a preset or a FILE.toml of your own
    #[arg(long, default_value = "paper")]
    preset: String,
    /// What to fly: step, 1, 2, 3, 3-square, or a FILE.toml of your own [default: step]
    #[arg(long)]
    scenario: Option<String>,
    /// Fly nothing: put this log through the board's own estimator and law, and compare with the host's, to
    /// the bit
    #[arg(long, value_name = "LOG.csv", conflicts_with_all = ["plot", "json"])]
    replay: Option<PathBuf>,
    /// Other names, signs and units of the log's columns, as `host-sim replay` has them
    #[arg(long, value_name = "LIST", default_value = "", allow_hyphen_values = true, requires = "replay")]
    columns: String,
    /// Fly nothing: put the board's serial line at this TCP address, in real time, until it is ended
    #[arg(long, value_name = "HOST:PORT", conflicts_with_all = ["plot", "json", "scenario", "replay"])]
    listen: Option<String>,
    /// As fast as it goes, where whoever is at the line keeps up
    #[arg(long, requires = "listen")]
    fast: bool,
    /// The wiring has passed the first-power check before: do not ask for it
    #[arg(long)]
    checked: bool,
    /// Of the disturbance, and of what chance decides on the board
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Draw the flight, as the telemetry told it, as .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Print one JSON document and nothing else
    #[arg(long)]
    json: bool,
}

/// \[ms\] Enough to boot, or to answer.
const BOOT: u64 = 100;

/// What a run comes to.
#[derive(Debug, Serialize)]
struct Document<'a> {
    preset: &'a str,
    scenario: &'a str,
    gains: &'a str,
    seed: u64,
    firmware: String,
    chip: String,
    frames: usize,
    frames_dropped: u32,
    /// \[instructions\] Of the tick's interrupt since boot.
    tick_median: u64,
    tick_max: u64,
    /// \[%\] Of the instructions that the core had time for, those that it slept through in flight.
    idle_percent: f64,
    stack_used: u32,
    stack_size: u32,
    /// How many times as fast as a clock: the flight, and all since power-on, which first translates the
    /// firmware.
    speed: f64,
    speed_since_power_on: f64,
    #[serde(flatten)]
    report: Report,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(if failure.is_input() { 2 } else { 1 })
        }
    }
}

fn run(args: &Args) -> Outcome<()> {
    let named = rig::load(&args.preset, &text)?;
    let scenario = args.scenario.as_deref().map(|name| Scenario::load(name, &text)).transpose()?;
    if let Some(path) = &args.plot {
        let extension = path.extension().and_then(|e| e.to_str());
        if !matches!(extension, Some("svg" | "png")) {
            return Err(Error::invalid("--plot", path.display(), "a name that ends in .svg or .png"));
        }
    }
    let (amplifiers, built) = if args.sign_magnitude {
        (Amplifiers::SignMagnitude, Firmware::sign_magnitude as fn() -> _)
    } else {
        (Amplifiers::LockedAntiphase, Firmware::released as fn() -> _)
    };
    let firmware = args.elf.as_ref().map_or_else(built, |path| Firmware::read(path));
    let firmware = firmware.map_err(|why| Error::Unusable(why.to_string()))?;
    let image = image(args, &named.rig)?;
    let setup = Setup { amplifiers, ..Setup::new(firmware) };
    let setup = setup.with_seed(args.seed).with_image(record::ADDRESS, image);
    let supply = named.rig.volts_limit.main.max(named.rig.volts_limit.tail);
    let began = Instant::now();
    let machine = Machine::start(setup, Helicopter::new(&named.rig, supply));
    if let Some(address) = &args.listen {
        return listen(address, machine, !args.fast);
    }
    let mut station = Station::new(machine);
    let json = args.json;
    let mut told = |frame: &Frame| {
        if !json {
            println!("{}", event(frame));
        }
    };
    if let Some(path) = &args.replay {
        return replay_on_board(args, path, &named.rig, scenario.as_ref(), &mut station);
    }
    let scenario = scenario.map_or_else(|| Scenario::named("step"), Ok)?;
    flight::take_off(&mut station, &mut told).map_err(failed)?;
    let core_hz = station.machine.with(|live| live.board().chip().part().core_hz());
    let (before, executed) = station.machine.now();
    let off = Instant::now();
    let flown = flight::fly(&mut station, &named.rig, &scenario, args.seed, &mut told).map_err(failed)?;
    let (now, all) = station.machine.now();
    let seconds = |nanoseconds: u64| std::time::Duration::from_nanos(nanoseconds).as_secs_f64();
    #[expect(clippy::cast_precision_loss, reason = "a share")]
    let busy = (all - executed) as f64 / (core_hz as f64 * seconds(now.0 - before.0));
    let speeds = [
        seconds(now.0 - before.0) / off.elapsed().as_secs_f64(),
        seconds(now.0) / began.elapsed().as_secs_f64(),
    ];
    let document = document(args, &mut station, &flown, 100.0 * (1.0 - busy), speeds)?;
    if let Some(path) = &args.plot {
        let title =
            format!("{}, scenario {}, {} gains, on the virtual board", named.name, scenario.name, args.gains);
        draw(&title, &flown, &named.rig, path)?;
    }
    if args.json {
        println!(
            "{}",
            serde_json::to_string_pretty(&document).map_err(|why| Error::Failed(why.to_string()))?
        );
    } else {
        print!("{}", document.report);
        println!(
            "firmware {} on {}: {} frames of telemetry, {} dropped; {} of {} bytes of stack used\n\
             a tick takes {} instructions by the median, {} at most; the core sleeps {:.1} % of the time\n\
             {:.0} times as fast as a clock in flight, {:.0} times since power-on",
            document.firmware,
            document.chip,
            document.frames,
            document.frames_dropped,
            document.stack_used,
            document.stack_size,
            document.tick_median,
            document.tick_max,
            document.idle_percent,
            document.speed,
            document.speed_since_power_on
        );
    }
    Ok(())
}

/// Until it is ended, or the firmware reaches what is not modelled.
fn listen(address: &str, machine: Machine, real: bool) -> Outcome<()> {
    let mut server = Server::new(address, machine, real).map_err(failed)?;
    let address = server.address().map_err(|why| Error::Failed(why.to_string()))?;
    println!("listening at tcp://{address}");
    server.serve(|| true).map_err(failed)
}

fn document<'a>(
    args: &'a Args,
    station: &mut Station,
    flown: &Flight,
    idle_percent: f64,
    [speed, speed_since_power_on]: [f64; 2],
) -> Outcome<Document<'a>> {
    let mut ticks: Vec<u64> = station.machine.trace().1.iter().map(|tick| tick.instructions).collect();
    ticks.sort_unstable();
    let heard = &station.heard;
    let silent = || Error::Failed("the board did not say who it is, or how".to_owned());
    let identity = heard.identities.last().ok_or_else(silent)?;
    let health = heard.health.last().ok_or_else(silent)?;
    Ok(Document {
        preset: &args.preset,
        scenario: args.scenario.as_deref().unwrap_or("step"),
        gains: &args.gains,
        seed: args.seed,
        firmware: identity.firmware.to_string(),
        chip: identity.chip.to_string(),
        frames: heard.frames.len(),
        frames_dropped: health.frames_dropped,
        tick_median: ticks.get(ticks.len() / 2).copied().unwrap_or_default(),
        tick_max: ticks.last().copied().unwrap_or_default(),
        idle_percent,
        stack_used: health.stack_used,
        stack_size: health.stack_size,
        speed,
        speed_since_power_on,
        report: flown.report,
    })
}

/// A log through the board, which says itself with which parameters, and through the host with the same.
fn replay_on_board(
    args: &Args,
    path: &Path,
    rig: &Rig,
    scenario: Option<&Scenario>,
    station: &mut Station,
) -> Outcome<()> {
    let log = read(path, &Columns::parse(&args.columns)?, rig)?;
    let samples = replay::samples(&log, rig, scenario);
    station.try_run(BOOT).map_err(failed)?;
    station.send(&ToBoard::ReadParameters);
    station.try_run(BOOT).map_err(failed)?;
    let silent = || Error::Failed("the board does not say its parameters".to_owned());
    let parameters = station.heard.parameters.pop().ok_or_else(silent)?;
    let there = station.replay(&samples).map_err(failed)?;
    let here = replay::replay(&parameters, &samples);
    if let Some((here, there)) = here.iter().zip(&there).find(|(here, there)| !here.same_bits(there)) {
        return Err(Error::Failed(format!("on the host {here:?}, on the board {there:?}")));
    }
    println!("{}: the same bits in all {} ticks", log.name, samples.len());
    Ok(())
}

fn failed(why: virtual_board::machine::Failure) -> Error {
    Error::Failed(why.to_string())
}

/// The parameter sectors.
fn image(args: &Args, rig: &Rig) -> Outcome<Vec<u8>> {
    if Path::new(&args.gains).extension().is_some_and(|extension| extension == "bin") {
        let bytes = std::fs::read(&args.gains).map_err(|why| unreadable(&args.gains, &why))?;
        return if bytes.len() == AREA_SIZE {
            Ok(bytes)
        } else {
            let (name, length) = (&args.gains, bytes.len());
            let allowed = format!("{AREA_SIZE}, all three sectors");
            Err(Error::invalid(format!("--gains {name}"), format!("{length} bytes long"), allowed))
        };
    }
    let gains = GainsFile::load(&args.gains, &text)?;
    image::image(&Parameters { checked: args.checked, ..Parameters::new(rig, &gains.settings(rig)) })
}

fn text(path: &str) -> Outcome<String> {
    std::fs::read_to_string(path).map_err(|why| unreadable(path, &why))
}

fn unreadable(path: &str, why: &std::io::Error) -> Error {
    Error::Unusable(format!("cannot be read: {why}")).within(path)
}

fn read(path: &Path, columns: &Columns, rig: &Rig) -> Outcome<Log> {
    let name = path.display().to_string();
    let file = std::fs::File::open(path).map_err(|why| unreadable(&name, &why))?;
    Log::read(&name, file, columns, rig)
}

fn draw(title: &str, flown: &Flight, rig: &Rig, path: &Path) -> Outcome<()> {
    let figure = twinrotor_plot::flight::flight(title, flown, rig.volts_limit);
    let bytes = if path.extension().is_some_and(|e| e == "png") {
        figure.to_png()?
    } else {
        figure.to_svg(Layout::Wide)?.into_bytes()
    };
    std::fs::write(path, bytes).map_err(|why| Error::Failed(format!("{}: {why}", path.display())))
}

fn event(frame: &Frame) -> String {
    let seconds = f64::from(frame.tick) * SAMPLE_TIME;
    let reasons: Vec<String> = frame.conditions.iter().map(|each| format!("{each:?}")).collect();
    let state = match frame.state {
        ArmState::Fault(cause) => format!("Fault: {cause:?}"),
        state => format!("{state:?}"),
    };
    let why = if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join(", ")) };
    format!("{seconds:9.3} s  {state}{why}")
}
