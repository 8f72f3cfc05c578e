//! Writes a unit: `cargo run -p fmu -- --preset aero2 --what loop --out heli.fmu`.

use clap::Parser;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use twinrotor_fmu::{Design, What, description};
use twinrotor_sim::error::known_name;
use twinrotor_sim::{Error, Outcome};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// A rig, its board, or both, as a functional mock-up unit (FMI 2.0, co-simulation) for Simulink,
/// OpenModelica and the like.
#[derive(Debug, Parser)]
#[command(name = "fmu", version)]
struct Args {
    /// Rig: paper, paper-fixed, aero, aero2, aero-lab, heli, or a FILE.toml of your own
    #[arg(long, default_value = "aero2")]
    preset: String,
    /// Gains: 'paper' (Table 4) or a gains file [default: the preset's own]
    #[arg(long, value_name = "paper|FILE")]
    gains: Option<String>,
    /// The rig (volts in, counts out), the board (setpoints and counts in, volts out), or both
    #[arg(long, default_value = "loop", value_name = "plant|controller|loop")]
    what: String,
    /// Where to write it
    #[arg(long, value_name = "FILE.fmu")]
    out: PathBuf,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(if error.is_input() { 2 } else { 1 })
        }
    }
}

fn run(args: &Args) -> Outcome<()> {
    let what = *known_name("what", &args.what, &What::NAMES)?;
    let read = |path: &str| {
        std::fs::read_to_string(path)
            .map_err(|error| Error::invalid(path, error, "the path of a file that can be read"))
    };
    let design = Design::load(what, &args.preset, args.gains.as_deref(), &read)?;
    let library = std::env::current_exe().map_err(failed)?.with_file_name(LIBRARY);
    let code = std::fs::read(&library).map_err(|error| {
        Error::Failed(format!("{}: {error}; cargo build -p fmu makes it", library.display()))
    })?;
    let unit = pack(&design, &code).map_err(|error| Error::Failed(error.to_string()))?;
    write(&args.out, &unit)
        .map_err(|error| Error::Failed(format!("{}: cannot be written: {error}", args.out.display())))?;
    println!("{}: the {} of {}, {} bytes", args.out.display(), what.name(), design.named.name, unit.len());
    Ok(())
}

fn failed(error: std::io::Error) -> Error {
    Error::Failed(error.to_string())
}

#[cfg(windows)]
const LIBRARY: &str = "twinrotor_fmu.dll";
#[cfg(windows)]
const BINARY: &str = "binaries/win64/twinrotor_fmu.dll";
#[cfg(target_os = "macos")]
const LIBRARY: &str = "libtwinrotor_fmu.dylib";
#[cfg(target_os = "macos")]
const BINARY: &str = "binaries/darwin64/twinrotor_fmu.dylib";
#[cfg(not(any(windows, target_os = "macos")))]
const LIBRARY: &str = "libtwinrotor_fmu.so";
#[cfg(not(any(windows, target_os = "macos")))]
const BINARY: &str = "binaries/linux64/twinrotor_fmu.so";

fn pack(design: &Design, code: &[u8]) -> zip::result::ZipResult<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let plain = SimpleFileOptions::default();
    zip.start_file("modelDescription.xml", plain)?;
    zip.write_all(description(design).as_bytes())?;
    for (name, text) in design.resources() {
        zip.start_file(format!("resources/{name}"), plain)?;
        zip.write_all(text.as_bytes())?;
    }
    zip.start_file(BINARY, plain.unix_permissions(0o755))?;
    zip.write_all(code)?;
    Ok(zip.finish()?.into_inner())
}

/// All of it or nothing.
fn write(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let beside = path.with_extension("fmu.part");
    let written = std::fs::write(&beside, bytes).and_then(|()| std::fs::rename(&beside, path));
    if written.is_err() {
        let _ = std::fs::remove_file(&beside);
    }
    written
}
