//! What was measured, as a table of its own.

use serde::Serialize;
use std::borrow::Cow;

/// A row for each of what was measured, a column for each number of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Grid {
    /// Its file's stem.
    pub name: String,
    /// Above the columns, with units; the first is of the rows' names.
    pub heads: Vec<Cow<'static, str>>,
    /// As many cells as there are heads.
    pub rows: Vec<Vec<String>>,
    /// Beneath it: what the heads mean.
    pub note: String,
}

impl Grid {
    /// As text for spreadsheets.
    pub fn to_csv(&self) -> String {
        let line = |cells: Vec<String>| {
            let quoted: Vec<String> =
                cells.iter().map(|c| format!("\"{}\"", c.replace('"', "\"\""))).collect();
            quoted.join(",") + "\n"
        };
        let heads = line(self.heads.iter().map(|h| h.clone().into_owned()).collect());
        self.rows.iter().fold(heads, |text, row| text + &line(row.clone()))
    }
}
