//! Tables on a terminal.

use comfy_table::{Cell, CellAlignment, Table, presets};

/// An empty table with these headings; the first column is words, the others numbers.
pub(super) fn table(headings: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_BORDERS_ONLY).set_header(headings.iter().enumerate().map(cell));
    table
}

fn cell<T: ToString>((column, text): (usize, T)) -> Cell {
    let alignment = if column == 0 { CellAlignment::Left } else { CellAlignment::Right };
    Cell::new(text.to_string()).set_alignment(alignment)
}

/// Adds a row.
pub(super) fn add(table: &mut Table, cells: impl IntoIterator<Item = String>) {
    table.add_row(cells.into_iter().enumerate().map(cell));
}

/// Seconds, or why there are none.
pub(super) fn seconds(time: Option<f64>) -> String {
    time.map_or_else(|| "never".to_owned(), |t| format!("{t:.3}"))
}

/// A percentage, or a dash where there is no step to take it of.
pub(super) fn percent(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |p| format!("{p:.2}"))
}
