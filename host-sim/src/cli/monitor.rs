//! `monitor`: a board to watch, tune and fly in a browser.

use crate::error::Outcome;

/// \[frames\] Twenty minutes of every tick.
#[cfg(feature = "monitor")]
const RECORDED: usize = 1_200_000;

/// Flags of `monitor`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Where the board is: 'sim' (simulated with its rig), a serial port, tcp://HOST:PORT, or 'auto' for the
    /// serial port at which one answers
    #[arg(long, default_value = "sim", value_name = "sim|auto|DEVICE|tcp://HOST:PORT")]
    port: String,
    /// Rig of the simulated board: paper, paper-fixed, aero, aero2, aero-lab or heli [default: aero2]
    #[arg(long)]
    preset: Option<String>,
    /// Where to listen: this machine alone unless told otherwise; port 0 is any free one
    #[arg(long, default_value = "127.0.0.1:0", value_name = "ADDRESS:PORT")]
    listen: std::net::SocketAddr,
    /// Write every tick to this file when the program ends, as 'fly' does: .csv, .parquet, .mcap or .npz; the
    /// first twenty minutes are kept
    #[arg(long, value_name = "FILE")]
    record: Option<std::path::PathBuf>,
}

#[cfg(not(feature = "monitor"))]
pub(super) fn run(_: &Args) -> Outcome<()> {
    Err(crate::error::Failure::Input(
        "monitor is not in this build, to keep it small; type: cargo run -p host-sim --features monitor -- \
         monitor"
            .to_owned(),
    ))
}

#[cfg(feature = "monitor")]
pub(super) fn run(args: &Args) -> Outcome<()> {
    use crate::cli::{common, print};
    use crate::error::Failure;
    use crate::files::export;
    use crate::files::output::Outputs;
    use crate::line::{self, NOT_SEEN};
    use crate::monitor::{Board, Ended, Monitor};
    use crate::stop::{self, Second};
    use twinrotor::link::{BAUD, ticks_per_frame};
    use twinrotor_station::recording::{self, Gaps};
    use twinrotor_web::desk::Choice;

    let Args { port, preset, listen, record } = args;
    let mut outputs = Outputs::new();
    if let Some(path) = record {
        export::check("--record", path, true)?;
        outputs.writes("--record", path)?;
    }
    let board = if port == "sim" {
        let own = Choice::default();
        Board::Simulated(Choice { preset: preset.clone().unwrap_or(own.preset), controller: own.controller })
    } else if preset.is_some() {
        return Err(common::no_effect(
            "--preset",
            "with --port",
            "a board's own record says which rig it has",
        ));
    } else {
        let (name, line) = line::open(port)?;
        Board::Line(name, line)
    };
    // From now on, whatever ends this ends it with the motors off.
    let _listening = stop::listen(Second::Asks);
    let monitor = Monitor::new(*listen, board, record.as_ref().map(|_| RECORDED))?;
    if !listen.ip().is_loopback() {
        print(
            "whoever in this network has the address below can turn the motors, and nothing on the way is \
             encrypted: give it to nobody else\n",
        )?;
    }
    print(&format!("{}\n", monitor.url()))?;
    let Ended { seen, frames } = monitor.run()?;
    if let Some(path) = record {
        let every = ticks_per_frame(BAUD);
        outputs.write(path, &export::bytes(&recording::table(&frames, every), path)?);
        let Gaps { gaps, lost_ticks } = recording::gaps(&frames, every);
        print(&format!(
            "{}: {} ticks, {gaps} gaps of {lost_ticks} ticks in all\n{}",
            path.display(),
            frames.len(),
            outputs.unwritten()
        ))?;
        outputs.done()?;
    }
    match seen {
        Some(false) if port != "sim" => Err(Failure::Run(NOT_SEEN.to_owned())),
        Some(_) => Err(Failure::Interrupted("the motors were seen to be off".to_owned())),
        None => Err(Failure::Interrupted("no motor had turned".to_owned())),
    }
}
