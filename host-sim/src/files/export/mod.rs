//! Tables in the formats that other tools read: Parquet (pandas, Polars, DuckDB), MCAP (PlotJuggler,
//! Foxglove, Rerun), NumPy's `.npz`, CSV; by the file's extension.

#[cfg(feature = "formats")]
mod formats;

use crate::error::{Failure, Outcome};
use std::fmt::Write;
use std::path::Path;
use twinrotor_sim::flight::{Reading, Row};

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// Of numbers.
    Numbers(Vec<f64>),
    /// Of whole numbers, every one of them exact.
    Counts(Vec<u64>),
    /// Of words.
    Words(Vec<String>),
}

/// Columns of the same length with their names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// In order.
    pub columns: Vec<(String, Column)>,
}

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

impl Table {
    /// A flight, SI units, in columns such as those of `simulate --csv`.
    pub fn of_flight(rows: &[Row], columns: &[(&str, Reading)]) -> Self {
        let mut table = Self::default();
        for (name, of) in columns {
            table.push(name, Column::Numbers(rows.iter().map(*of).collect()));
        }
        table
    }

    /// Adds a column, as long as those before it.
    pub fn push(&mut self, name: &str, column: Column) {
        self.columns.push((name.to_owned(), column));
    }

    fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| match column {
            Column::Numbers(x) => x.len(),
            Column::Counts(x) => x.len(),
            Column::Words(x) => x.len(),
        })
    }

    /// It in the format that the path's extension names, which [`check`] has approved.
    ///
    /// # Errors
    ///
    /// If the format has no place for it.
    pub fn bytes(&self, path: &Path) -> Outcome<Vec<u8>> {
        Ok(match extension(path) {
            #[cfg(feature = "formats")]
            Some("parquet") => self.to_parquet().map_err(|e| failed(path, e))?,
            #[cfg(feature = "formats")]
            Some("mcap") => self.to_mcap().map_err(|e| failed(path, e))?,
            #[cfg(feature = "formats")]
            Some("npz") => self.to_npz().map_err(|e| failed(path, e))?,
            _ => self.to_csv().into_bytes(),
        })
    }

    /// Shortest digits that give the same bits back.
    pub fn to_csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..self.rows() {
            for (k, (_, column)) in self.columns.iter().enumerate() {
                let comma = if k == 0 { "" } else { "," };
                let _ = match column {
                    Column::Numbers(x) => write!(text, "{comma}{}", x[row]),
                    Column::Counts(x) => write!(text, "{comma}{}", x[row]),
                    Column::Words(x) => write!(text, "{comma}{}", x[row]),
                };
            }
            text.push('\n');
        }
        text
    }
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
