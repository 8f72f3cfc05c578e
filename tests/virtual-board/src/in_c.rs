//! The paper's law in plain C, compiled for the board and run on it: what the firmware's has to stand beside.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::firmware::Firmware;
use crate::machine::{AtRest, Machine, Setup};

/// The compiler: Debian's package `gcc-arm-none-eabi`.
const COMPILER: &str = "arm-none-eabi-gcc";
/// Where the sources are.
const SOURCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/c");
/// For the part's core.
const MACHINE: [&str; 4] = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"];
/// Alone on the board.
const ALONE: [&str; 3] = ["-ffreestanding", "-nostdlib", "-Wl,--no-warnings"];

/// What the law takes in C, compiled with some options.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InC {
    /// The compiler's options.
    pub options: &'static str,
    /// From the entry of the function to its return: the median.
    pub instructions: u64,
}

/// Options with which the compiler gives the bits of the host.
pub const SAME_BITS: [&str; 2] = ["-O2 -ffp-contract=off", "-O3 -ffp-contract=off"];
/// Options with which it fuses multiplications into additions: fewer instructions, and other bits.
pub const FUSED: [&str; 2] = ["-O2", "-O3"];
/// \[instructions\] What it took with either of [`SAME_BITS`] and version 12.2.1, for where there is no such
/// compiler.
pub const KEPT: u64 = 141;

/// The compiler's name and version, or `None` where there is none.
pub fn compiler() -> Option<String> {
    let answer = Command::new(COMPILER).arg("--version").output().ok()?;
    Some(String::from_utf8_lossy(&answer.stdout).lines().next()?.to_owned())
}

/// Compiles the law with `options`, and runs it on the board.
///
/// # Errors
///
/// If it does not compile.
///
/// # Panics
///
/// If it reaches something that is not modelled.
pub fn measure(options: &'static str) -> Result<InC, String> {
    let place = tempfile::tempdir().map_err(|why| why.to_string())?;
    let elf = place.path().join("law.elf");
    compile(options, &elf)?;
    let firmware = Firmware::read(&elf).map_err(|why| why.to_string())?;
    let setup = Setup { tick: "law", ..Setup::new(firmware) };
    let mut machine = Machine::start(setup, AtRest::default());
    machine.run(5);
    let mut counts: Vec<u64> = machine.trace().1.iter().map(|call| call.instructions).collect();
    counts.sort_unstable();
    let instructions = counts.get(counts.len() / 2).copied().ok_or("the law was never called")?;
    Ok(InC { options, instructions })
}

fn compile(options: &str, elf: &Path) -> Result<(), String> {
    let source = |name: &str| PathBuf::from(SOURCES).join(name);
    let compiled = Command::new(COMPILER)
        .args(options.split_whitespace())
        .args(["-g", "-Wall", "-Wextra", "-Werror", "-std=gnu11"])
        .args(MACHINE)
        .args(ALONE)
        .arg("-T")
        .args([source("board.ld"), source("law.c"), source("start.c")])
        .arg("-o")
        .arg(elf)
        .arg("-lgcc")
        .output()
        .map_err(|why| format!("{COMPILER}: {why}; Debian's package is gcc-arm-none-eabi"))?;
    if compiled.status.success() {
        Ok(())
    } else {
        Err(format!("{COMPILER} {options}: {}", String::from_utf8_lossy(&compiled.stderr)))
    }
}
