//! Columns of numbers and words, each with its name: what a file for other tools is made from.

use crate::flight::{Reading, Row};
use std::fmt::Write;

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

impl Column {
    fn rows(&self) -> usize {
        match self {
            Self::Numbers(x) => x.len(),
            Self::Counts(x) => x.len(),
            Self::Words(x) => x.len(),
        }
    }
}

impl Table {
    /// A flight, SI units, in columns such as those of `simulate --csv`.
    #[must_use]
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

    /// How many there are.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| column.rows())
    }

    /// As CSV, in the shortest digits that give the same bits back.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        names.join(",") + "\n" + &self.csv_rows()
    }

    /// The same without the line of names.
    #[must_use]
    pub fn csv_rows(&self) -> String {
        let mut text = String::new();
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
