//! Tables on a terminal: within its width, in boxes or plain.

use comfy_table::{Cell, CellAlignment, presets};
use std::fmt;
use std::sync::OnceLock;

/// How tables are laid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Style {
    /// In boxes at most so many columns of characters wide.
    Boxed(usize),
    /// A line a row, columns apart by tabs.
    Plain,
}

/// \[characters\] Where nobody says how wide the screen is.
const USUAL_WIDTH: usize = 80;
/// \[characters\] Below this no table is worth folding.
const LEAST_WIDTH: usize = 40;

static STYLE: OnceLock<Style> = OnceLock::new();

/// Decides, once, how every table of this run is laid: as wide as the terminal, or as `COLUMNS` says.
pub(super) fn choose(plain: bool) {
    let told = || std::env::var("COLUMNS").ok()?.parse().ok();
    let terminal = || terminal_size::terminal_size().map(|(width, _)| usize::from(width.0));
    let width = told().or_else(terminal).unwrap_or(USUAL_WIDTH).max(LEAST_WIDTH);
    // The first to choose is `main`; a second choice would be the same.
    let _ = STYLE.set(if plain { Style::Plain } else { Style::Boxed(width) });
}

/// Headings and rows; the first column is words, the others numbers.
#[derive(Debug, Clone)]
pub(super) struct Table {
    headings: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// An empty table with these headings.
pub(super) fn table(headings: &[&str]) -> Table {
    Table { headings: headings.iter().map(|h| (*h).to_owned()).collect(), rows: Vec::new() }
}

/// Adds a row.
pub(super) fn add(table: &mut Table, cells: impl IntoIterator<Item = String>) {
    table.rows.push(cells.into_iter().collect());
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.laid(*STYLE.get().unwrap_or(&Style::Boxed(USUAL_WIDTH))))
    }
}

impl Table {
    fn laid(&self, style: Style) -> String {
        let width = match style {
            Style::Boxed(width) => width,
            Style::Plain => {
                let lines = std::iter::once(&self.headings).chain(&self.rows);
                return lines.map(|cells| cells.join("\t")).collect::<Vec<_>>().join("\n");
            }
        };
        let blocks = self.blocks(width);
        blocks.iter().map(|columns| self.boxed(columns)).collect::<Vec<_>>().join("\n")
    }

    /// Which columns stand in one box: as many as its width allows, each box with the first column.
    fn blocks(&self, width: usize) -> Vec<Vec<usize>> {
        let cells = |column: usize| {
            let rows = self.rows.iter().filter_map(move |row| row.get(column));
            std::iter::once(&self.headings[column]).chain(rows)
        };
        // Two characters of air around each and one between two, and the box's two edges.
        let takes = |column: usize| cells(column).map(|c| c.chars().count()).max().unwrap_or(0) + 3;
        let first = 1 + takes(0);
        let mut blocks = vec![vec![0]];
        let mut used = first;
        for column in 1..self.headings.len() {
            if used + takes(column) > width && used > first {
                blocks.push(vec![0]);
                used = first;
            }
            used += takes(column);
            if let Some(block) = blocks.last_mut() {
                block.push(column);
            }
        }
        blocks
    }

    fn boxed(&self, columns: &[usize]) -> String {
        let cells = |row: &[String]| -> Vec<Cell> {
            let empty = String::new();
            let text = columns.iter().map(|&k| (k, row.get(k).unwrap_or(&empty)));
            text.map(|(k, text)| Cell::new(text).set_alignment(alignment(k))).collect()
        };
        let mut table = comfy_table::Table::new();
        table.load_style(presets::UTF8_BORDERS_ONLY).set_header(cells(&self.headings));
        for row in &self.rows {
            table.add_row(cells(row));
        }
        table.to_string()
    }
}

fn alignment(column: usize) -> CellAlignment {
    if column == 0 { CellAlignment::Left } else { CellAlignment::Right }
}

/// `head` and a list after it, in lines that fit the screen; those after the first stand further in.
pub(super) fn listed(head: &str, items: &[impl std::fmt::Display]) -> String {
    const INDENT: &str = "      ";
    let width = match STYLE.get() {
        Some(Style::Boxed(width)) => *width,
        Some(Style::Plain) | None => USUAL_WIDTH,
    };
    let mut lines = vec![head.to_owned()];
    for (k, item) in items.iter().enumerate() {
        let item = format!(" {item}{}", if k + 1 < items.len() { "," } else { "" });
        match lines.last_mut() {
            Some(line) if line.chars().count() + item.chars().count() <= width => line.push_str(&item),
            _ => lines.push(format!("{INDENT}{item}")),
        }
    }
    lines.join("\n")
}

/// Seconds, or why there are none.
pub(super) fn seconds(time: Option<f64>) -> String {
    time.map_or_else(|| "never".to_owned(), |t| format!("{t:.3}"))
}

/// A percentage, or a dash where there is no step to take it of.
pub(super) fn percent(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |p| format!("{p:.2}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wide() -> Table {
        let mut table = table(&["controller", "J", "settling [s]", "overshoot [%]", "hold RMS [°]"]);
        add(&mut table, ["ours", "8.871", "1.78/1.10", "48.0/37.1", "0.073/0.041"].map(str::to_owned));
        add(&mut table, ["pid-plus", "9.856", "1.12/1.78", "1.4/0.2", "0.065/0.040"].map(str::to_owned));
        table
    }

    #[test]
    fn no_line_is_wider_than_the_screen_and_nothing_is_lost() {
        let whole = wide().laid(Style::Boxed(200)).lines().map(|line| line.chars().count()).max().unwrap();
        for width in LEAST_WIDTH..=200 {
            let text = wide().laid(Style::Boxed(width));
            assert!(text.lines().all(|line| line.chars().count() <= width), "{width}:\n{text}");
            for cell in wide().rows.concat().iter().chain(&wide().headings) {
                assert!(text.contains(cell.as_str()), "{width}: {cell}");
            }
            let boxes = text.matches('┌').count();
            assert_eq!(text.matches("pid-plus").count(), boxes, "each box names its rows");
            assert_eq!(boxes == 1, width >= whole, "{boxes} boxes in {width}");
        }
    }

    #[test]
    fn a_list_goes_on_in_the_next_line() {
        let parts = ["extended state observer", "integral, conditional", "command filter", "lead"];
        let text = listed("  ours:", &[&parts[..], &parts].concat());
        assert!(text.lines().count() == 2 && text.lines().all(|line| line.chars().count() <= USUAL_WIDTH));
        assert!(text.starts_with("  ours: extended state observer, integral") && text.ends_with(" lead"));
    }

    #[test]
    fn plain_is_a_line_a_row_with_tabs() {
        let text = wide().laid(Style::Plain);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3);
        assert_eq!(lines[1], "ours\t8.871\t1.78/1.10\t48.0/37.1\t0.073/0.041");
    }
}
