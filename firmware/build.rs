//! Hands the memory map to the linker, and compiles the default parameters into a record, with the core's own code.

use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};
use twinrotor::parameters::{Parameters, SAMPLE_TIME, store};
use twinrotor::pipeline::Settings;
use twinrotor::{gains, plant::presets};

/// The rig of a board in which nothing is stored yet. Such a board does not arm.
const DEFAULT_PRESET: &str = "aero2";

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
    Ok(())
}

fn default_record() -> Result<Vec<u8>, Box<dyn Error>> {
    let rig = presets::ALL.iter().find(|(name, _)| *name == DEFAULT_PRESET).ok_or("no such preset")?.1;
    let parameters = Parameters::new(&rig, &Settings::paper(&rig, gains::PAPER, SAMPLE_TIME));
    parameters.validate().map_err(|error| format!("default parameters: {error:?}"))?;
    let mut buffer = [0; store::MAX_PAYLOAD];
    let bytes = parameters.encode(&mut buffer).map_err(|error| format!("default parameters: {error:?}"))?;
    Ok(bytes.to_vec())
}
