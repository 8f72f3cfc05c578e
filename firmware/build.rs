//! Hands the memory map to the linker, and compiles the default parameters into a record, with the core's own
//! code.

use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};
use twinrotor::SAMPLE_TIME;
use twinrotor::parameters::{Parameters, store};
use twinrotor::pipeline::Settings;
use twinrotor::{defaults, plant::presets};

/// The rig of a board in which nothing is stored yet, with the controller tuned for it: this one, or the
/// preset that `TWINROTOR_PRESET` names when the firmware is built. Such a board does not arm before somebody
/// stores parameters on purpose.
const DEFAULT_PRESET: &str = "aero2";
const PRESET_VARIABLE: &str = "TWINROTOR_PRESET";

fn main() -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(env::var("OUT_DIR")?);
    fs::write(out.join("defaults.bin"), default_record()?)?;
    if env::var("CARGO_CFG_TARGET_OS")? == "none" {
        fs::copy("../memory.x", out.join("memory.x"))?;
        println!("cargo:rustc-link-search={}", out.display());
        println!("cargo:rustc-link-arg-bins=--nmagic");
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
    println!("cargo:rerun-if-changed=../memory.x");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed={PRESET_VARIABLE}");
    Ok(())
}

fn default_record() -> Result<Vec<u8>, Box<dyn Error>> {
    let name = env::var(PRESET_VARIABLE).unwrap_or_else(|_| DEFAULT_PRESET.to_owned());
    let known = presets::ALL.map(|(name, _)| name).join(", ");
    let unknown = || format!("{PRESET_VARIABLE} is '{name}'; allowed: {known}");
    let (_, rig) = presets::ALL.into_iter().find(|(known, _)| *known == name).ok_or_else(unknown)?;
    let (_, controller) = defaults::ALL.into_iter().find(|(known, _)| *known == name).ok_or_else(unknown)?;
    let parameters = Parameters::new(&rig, &Settings::new(&rig, controller, SAMPLE_TIME));
    parameters.validate().map_err(|error| format!("default parameters: {error:?}"))?;
    let mut buffer = [0; store::MAX_PAYLOAD];
    let bytes = parameters.encode(&mut buffer).map_err(|error| format!("default parameters: {error:?}"))?;
    Ok(bytes.to_vec())
}
