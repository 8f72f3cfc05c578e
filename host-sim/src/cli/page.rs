//! `page`: the simulated board, the tuner and what shows them, as one file for a browser.

use super::{print, print_json};
use crate::error::{Failure, Outcome};
use crate::files::output::Outputs;
use crate::page;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Flags of `page`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Where to write the page
    #[arg(long, value_name = "FILE", default_value = "heli.html", help_heading = "Output")]
    out: PathBuf,
    /// The WebAssembly module that computes, as scripts/build-page.sh builds and packs it beside what plots
    #[arg(long, value_name = "FILE", default_value = page::MODULE)]
    module: PathBuf,
    /// Print one JSON document and nothing else
    #[arg(long, help_heading = "Output")]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    out: &'a Path,
    bytes: usize,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let Args { out, module, json } = args;
    let mut outputs = Outputs::new();
    outputs.reads("--module", module);
    let plot = module.with_file_name(page::PACKED_PLOT);
    outputs.reads("--module", &plot);
    let (bytes, plot) = (read(module)?, read(&plot)?);
    outputs.writes("--out", out)?;
    let page = page::page(&bytes, &plot);
    outputs.write(out, page.as_bytes());
    if *json {
        print_json(&Document { out, bytes: page.len() })?;
    } else {
        print(&format!(
            "{}: {} kB; open it in a browser, no network is needed\n{}",
            out.display(),
            page.len().div_ceil(1000),
            outputs.unwritten()
        ))?;
    }
    outputs.done()
}

/// What is packed, or which command builds it.
fn read(module: &Path) -> Outcome<Vec<u8>> {
    let bytes = std::fs::read(module).map_err(|error| {
        Failure::Input(format!(
            "--module {} cannot be read: {error}; scripts/build-page.sh builds {}",
            module.display(),
            page::MODULE
        ))
    })?;
    if page::is_packed(&bytes) {
        return Ok(bytes);
    }
    Err(Failure::Input(format!(
        "--module {} is not packed with gzip; scripts/build-page.sh builds {}",
        module.display(),
        page::MODULE
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_its_module_the_command_that_builds_it_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("twinrotor.wasm.gz");
        let told = read(&missing).unwrap_err().to_string();
        assert!(told.contains("scripts/build-page.sh builds target/page/twinrotor.wasm.gz"), "{told}");
        std::fs::write(&missing, b"\0asm").unwrap();
        let told = read(&missing).unwrap_err().to_string();
        assert!(told.contains("not packed with gzip; scripts/build-page.sh"), "{told}");
        std::fs::write(&missing, [0x1f, 0x8b, 8]).unwrap();
        assert_eq!(read(&missing).unwrap(), [0x1f, 0x8b, 8]);
    }
}
