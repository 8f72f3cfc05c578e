//! What is read from disk and written to it.

pub mod checkpoint;
pub mod export;
pub mod figure;
pub mod output;
mod target;

use crate::error::{Failure, Outcome};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use twinrotor::plant::presets::Rig;
use twinrotor_identify::log::{Columns, Log};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::rig::{self, NamedRig};
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::{Error, Outcome as Text};

/// What a file's name ends in, in small letters.
pub fn ending(path: &Path) -> Option<String> {
    path.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase)
}

/// What says that this program was built without the format of a file, and how to build it with.
#[cfg(not(feature = "formats"))]
fn not_built(flag: &str, path: &Path) -> Failure {
    Failure::Input(format!(
        "{flag} is '{}', a format that this program was built without; type: \
         cargo run -p host-sim --features formats -- and the same command",
        path.display()
    ))
}

/// A file to read. A device may never end.
fn open(path: &Path) -> io::Result<File> {
    let file = File::open(path)?;
    #[cfg(unix)]
    if std::os::unix::fs::FileTypeExt::is_char_device(&file.metadata()?.file_type()) {
        return Err(io::Error::other("it is a device"));
    }
    Ok(file)
}

/// The text of a file that the user named.
///
/// # Errors
///
/// If it cannot be read.
pub fn text(path: &str) -> Text<String> {
    let mut text = String::new();
    let read = open(Path::new(path)).and_then(|mut file| file.read_to_string(&mut text));
    read.map_err(|e| Error::Unusable(format!("cannot be read: {e}")).within(path))?;
    Ok(text)
}

/// A preset, or a rig from a TOML file.
///
/// # Errors
///
/// If there is none of that name, or the file is not one of a rig.
pub fn rig(name: &str) -> Outcome<NamedRig> {
    Ok(rig::load(name, &text)?)
}

/// One of the paper's scenarios, or one from a TOML file.
///
/// # Errors
///
/// If there is none of that name, or the file is not one of a scenario.
pub fn scenario(name: &str) -> Outcome<Scenario> {
    Ok(Scenario::load(name, &text)?)
}

/// The same for a board, which may simulate its rig and have something injected.
///
/// # Errors
///
/// If there is none of that name, or the file is not one of a scenario.
pub fn scenario_to_inject(name: &str) -> Outcome<Scenario> {
    Ok(Scenario::load_to_inject(name, &text)?)
}

/// `paper`, or gains from a file; `flag` is what named it.
///
/// # Errors
///
/// If there is no such file, or it is not one of gains.
pub fn gains(flag: &str, name: &str) -> Outcome<GainsFile> {
    if name != "paper" && !Path::new(name).exists() {
        return Err(Failure::Input(format!(
            "{flag} is '{name}'; allowed: 'paper' (Table 4) or the path of a gains file, and there is no \
             such file"
        )));
    }
    Ok(GainsFile::load(name, &text)?)
}

/// A log of `rig` from a CSV file.
///
/// # Errors
///
/// If it cannot be read, or nothing can be learnt from it.
pub fn log(path: &Path, columns: &Columns, rig: &Rig) -> Outcome<Log> {
    let file = open(path).map_err(|e| Failure::reading(path, &e))?;
    Ok(Log::read(&path.display().to_string(), file, columns, rig)?)
}
