//! Logs of real rigs, from files or as arrays.

use crate::parts::raised;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use std::fmt::Write;
use std::fs::File;
use twinrotor::plant::presets::Rig;
use twinrotor_identify::log::{Columns, Log};
use twinrotor_sim::{Error, Outcome};

/// A log as Python gives it: what it is called, and its columns; none: it is the file of that name.
pub(crate) type Given<'py> = (String, Option<Vec<(String, PyReadonlyArray1<'py, f64>)>>);

pub(crate) fn columns_of(columns: &str) -> PyResult<Columns> {
    Columns::parse(columns).map_err(|error| raised(&error))
}

pub(crate) fn read(given: &[Given<'_>], columns: &Columns, rig: &Rig) -> PyResult<Vec<Log>> {
    let log = |(name, arrays): &Given<'_>| match arrays {
        None => {
            let file = File::open(name).map_err(|error| {
                raised(&Error::invalid(name, error, "the path of a log that can be read"))
            })?;
            Log::read(name, file, columns, rig).map_err(|error| raised(&error))
        }
        // Arrays have wrong what files have wrong: they go the same way, every digit with them.
        Some(arrays) => written(name, arrays)
            .and_then(|text| Log::read(name, text.as_bytes(), columns, rig))
            .map_err(|error| raised(&error)),
    };
    given.iter().map(log).collect()
}

/// Columns as CSV text.
fn written(name: &str, arrays: &[(String, PyReadonlyArray1<'_, f64>)]) -> Outcome<String> {
    let views: Vec<_> = arrays.iter().map(|(_, array)| array.as_array()).collect();
    let rows = views.first().map_or(0, |first| first.len());
    if let Some(((column, _), view)) = arrays.iter().zip(&views).find(|(_, view)| view.len() != rows) {
        let allowed = format!("{rows}, as column '{}' has", arrays[0].0);
        return Err(Error::invalid(format!("length of column '{column}'"), view.len(), allowed).within(name));
    }
    if let Some((column, _)) = arrays.iter().find(|(column, _)| column.contains([',', '"', '\n', '\r'])) {
        let allowed = "names without comma, quote and line break";
        return Err(Error::invalid("name of a column", format_args!("{column:?}"), allowed).within(name));
    }
    let names: Vec<&str> = arrays.iter().map(|(column, _)| column.as_str()).collect();
    let mut text = names.join(",");
    text.push('\n');
    for row in 0..rows {
        for (k, view) in views.iter().enumerate() {
            // Writing to a string does not fail.
            let _ = write!(text, "{}{}", if k > 0 { "," } else { "" }, view[row]);
        }
        text.push('\n');
    }
    Ok(text)
}
