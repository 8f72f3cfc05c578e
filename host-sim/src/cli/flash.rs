//! `flash`: gains onto a board.

use super::common::{board, tuned_elsewhere};
use super::next::next;
use super::{print, print_json, tell};
use crate::error::{Failure, Outcome};
use crate::files;
use crate::files::output::{self, Outputs};
use crate::line::{self, Board};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::Command;
use twinrotor::board::Board as Hardware;
use twinrotor::parameters::Parameters;
use twinrotor::parameters::store::AREA_ADDRESS;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_station::image;

/// Flags of `flash`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Gains: 'paper' (Table 4) or a gains file
    #[arg(value_name = "GAINS")]
    gains: String,
    /// Rig: a preset's name or a FILE.toml of your own [default: the one the gains were tuned on]
    #[arg(long, help_heading = "Rig")]
    preset: Option<String>,
    /// Board: f405, feather-f405, f407, black-pill, nucleo-f411, nucleo-f446 or nucleo-g474
    #[arg(long, value_name = "NAME", default_value = "f405", value_parser = board, help_heading = "Rig")]
    board: Hardware,
    /// The wiring has passed the first-power check on this board before: do not ask for it again
    #[arg(long)]
    checked: bool,
    /// Write the image of the parameter sectors to a .bin or .hex file
    #[arg(long, value_name = "FILE", conflicts_with = "port")]
    image: Option<PathBuf>,
    /// Send the parameters over this serial port, or tcp://HOST:PORT, or 'auto' for the port that answers
    #[arg(long, value_name = "DEVICE")]
    port: Option<String>,
    /// The board's chip, as probe-rs calls it, for a debug probe
    #[arg(long, default_value = "STM32F405RGTx", conflicts_with_all = ["image", "port"])]
    chip: String,
    /// Print one JSON document and nothing else
    #[arg(long, help_heading = "Output")]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Document {
    preset: String,
    gains: GainsFile,
    address: u32,
    bytes: usize,
    done: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    warning: Option<String>,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let gains = files::gains("GAINS", &args.gains)?;
    let mut named = files::rig(preset(args, &gains)?)?;
    named.rig.board = args.board;
    gains.require_stable(&named.name, &named.rig).map_err(|error| error.within(&args.gains))?;
    let mut parameters = Parameters::new(&named.rig, &gains.settings(&named.rig));
    parameters.checked = args.checked;
    let image = image::image(&parameters)?;
    if let Some(path) = &args.image {
        check_image(args, &named.name, path)?;
    }
    let warning = not_a_rig(&named.name, &gains);
    if let Some(warning) = &warning {
        tell(&format!("warning: {warning}"));
    }
    let done = match (&args.image, &args.port) {
        (Some(path), _) => write_image(path, &image)?,
        (None, Some(port)) => send(port, &parameters)?,
        (None, None) => program(args, &named.name, &image)?,
    };
    if args.json {
        let bytes = image.len();
        print_json(&Document { preset: named.name, gains, address: AREA_ADDRESS, bytes, done, warning })
    } else {
        let first = if args.image.is_some() { "program it, then: " } else { "" };
        let fly = next("fly").with("--port", args.port.as_deref().unwrap_or("auto"));
        let fly = fly.with("--preset", &named.name).with("--gains", &args.gains);
        let fly = fly.board(args.board);
        print(&format!("{done}\nnext: {first}{fly}\n(docs/firmware.md has the first power-up)\n"))
    }
}

/// The preset to take the rig from.
fn preset<'a>(args: &'a Args, gains: &'a GainsFile) -> Outcome<&'a str> {
    match (&args.preset, &gains.provenance) {
        (Some(name), _) => Ok(name),
        (None, Some(provenance)) => Ok(&provenance.preset),
        (None, None) => Err(Failure::Input(format!(
            "--preset is missing, and {} does not say which rig it was tuned on; name the rig, such as \
             --preset aero2",
            args.gains
        ))),
    }
}

/// Gains of a rig that nobody has.
fn not_a_rig(preset: &str, gains: &GainsFile) -> Option<String> {
    let tuned = gains.provenance.as_ref().map_or(preset, |provenance| &provenance.preset);
    let on_paper = |name: &str| matches!(name, "paper" | "paper-fixed");
    if on_paper(tuned) || on_paper(preset) {
        let name = if on_paper(tuned) { tuned } else { preset };
        return Some(format!(
            "these gains are for preset '{name}', whose plant is the paper's and not that of any rig: tune \
             on aero, aero2, aero-lab, heli or a preset of your own rig before you fly"
        ));
    }
    tuned_elsewhere(preset, gains)
}

fn check_image(args: &Args, preset: &str, path: &Path) -> Outcome<()> {
    if !matches!(files::ending(path).as_deref(), Some("bin" | "hex")) {
        return Err(Failure::Input(format!(
            "--image is '{}'; allowed: a file that ends in .bin or .hex",
            path.display()
        )));
    }
    let mut outputs = Outputs::new();
    outputs.reads("GAINS", &args.gains);
    outputs.reads("--preset", preset);
    outputs.writes("--image", path)
}

fn write_image(path: &Path, image: &[u8]) -> Outcome<String> {
    let bytes = match files::ending(path).as_deref() {
        Some("hex") => image::intel_hex(image).into_bytes(),
        _ => image.to_vec(),
    };
    output::write(path, &bytes)?;
    Ok(format!("wrote {} ({} bytes for {AREA_ADDRESS:#x})", path.display(), image.len()))
}

fn send(name: &str, parameters: &Parameters) -> Outcome<String> {
    let mut board = Board::new(line::open(name)?.1);
    let identity = board.identify()?;
    board.write(parameters)?;
    Ok(format!(
        "{} with firmware {} keeps the parameters; they read back the same",
        identity.chip, identity.firmware
    ))
}

/// By the probe, if there is one.
fn program(args: &Args, preset: &str, image: &[u8]) -> Outcome<String> {
    let listed = Command::new("probe-rs").arg("list").output();
    let reason = match &listed {
        Err(_) => Some("the program probe-rs is not there"),
        Ok(output) if !String::from_utf8_lossy(&output.stdout).contains("[0]") => {
            Some("no debug probe is connected")
        }
        Ok(_) => None,
    };
    if let Some(reason) = reason {
        let again = next("flash").of(&args.gains).with("--preset", preset).flag_if("--checked", args.checked);
        let again = again.board(args.board);
        return Err(Failure::Run(format!(
            "{reason}. To program by a probe elsewhere: `{image}`, then `probe-rs download --chip {chip} \
             --binary-format bin --base-address {AREA_ADDRESS:#x} parameters.bin`. Over the serial link: \
             `{link}`",
            image = again.clone().with("--image", "parameters.bin"),
            link = again.with("--port", "auto"),
            chip = args.chip,
        )));
    }
    let failed = |error: std::io::Error| Failure::Run(format!("probe-rs cannot be run: {error}"));
    let file = tempfile::Builder::new().suffix(".bin").tempfile().map_err(failed)?;
    std::fs::write(file.path(), image).map_err(failed)?;
    let status = Command::new("probe-rs")
        .args(["download", "--chip", &args.chip, "--binary-format", "bin", "--base-address"])
        .arg(format!("{AREA_ADDRESS:#x}"))
        .arg(file.path())
        .stdout(std::process::Stdio::null())
        .status()
        .map_err(failed)?;
    if status.success() {
        Ok(format!("programmed {} bytes at {AREA_ADDRESS:#x} of the {}", image.len(), args.chip))
    } else {
        Err(Failure::Run(format!("probe-rs ended with {status}")))
    }
}
