//! Tables in the formats that other tools read: Parquet (pandas, Polars, DuckDB), MCAP (PlotJuggler,
//! Foxglove, Rerun), NumPy's `.npz`, CSV; by the file's extension.

#[cfg(feature = "formats")]
mod formats;

use crate::error::{Failure, Outcome};
use std::path::Path;
use twinrotor_sim::table::Table;

/// What a path's extension may be.
const EXTENSIONS: [&str; 4] = ["parquet", "mcap", "npz", "csv"];

fn extension(path: &Path) -> Option<&'static str> {
    let ending = super::ending(path)?;
    EXTENSIONS.into_iter().find(|known| *known == ending)
}

/// Refuses, before any work is done, a path whose extension says nothing. Only what has a time can be a
/// `.mcap`.
///
/// # Errors
///
/// If its suffix names none of the formats, or one that was left out of the build.
pub fn check(flag: &str, path: &Path, timed: bool) -> Outcome<()> {
    match extension(path) {
        Some("mcap") if !timed => {}
        #[cfg(not(feature = "formats"))]
        Some("parquet" | "mcap" | "npz") => return Err(super::not_built(flag, path)),
        Some(_) => return Ok(()),
        None => {}
    }
    let allowed = if timed { ".parquet, .mcap, .npz or .csv" } else { ".parquet, .npz or .csv" };
    Err(Failure::Input(format!("{flag} is '{}'; allowed: a name that ends in {allowed}", path.display())))
}

#[cfg(feature = "formats")]
fn failed(path: &Path, error: impl std::fmt::Display) -> Failure {
    Failure::Run(format!("{}: cannot be written: {error}", path.display()))
}

/// A table in the format that the path's extension names, which [`check`] has approved.
///
/// # Errors
///
/// If the format has no place for it.
pub fn bytes(table: &Table, path: &Path) -> Outcome<Vec<u8>> {
    Ok(match extension(path) {
        #[cfg(feature = "formats")]
        Some("parquet") => formats::to_parquet(table).map_err(|e| failed(path, e))?,
        #[cfg(feature = "formats")]
        Some("mcap") => formats::to_mcap(table).map_err(|e| failed(path, e))?,
        #[cfg(feature = "formats")]
        Some("npz") => formats::to_npz(table).map_err(|e| failed(path, e))?,
        _ => table.to_csv().into_bytes(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_format_that_is_not_there_is_named() {
        let told = check("--export", Path::new("x.xlsx"), true).unwrap_err().to_string();
        assert!(told.contains("x.xlsx") && told.contains(".mcap"), "{told}");
        assert!(check("--export", Path::new("x.mcap"), false).is_err());
    }
}
