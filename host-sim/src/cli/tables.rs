//! Tables on a terminal.

use crate::metrics::{AxisReport, MotorReport, Report};
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

/// What a flight came to: a table of the axes and one of the motors.
pub fn report(report: &Report) -> String {
    let mut axes = table(&["", "pitch", "yaw"]);
    let settling =
        |a: &AxisReport, time| if a.overshoot_percent.is_some() { seconds(time) } else { percent(None) };
    let mut row = |name: &str, of: &dyn Fn(&AxisReport) -> String| {
        add(&mut axes, [name.to_owned(), of(&report.pitch), of(&report.yaw)]);
    };
    row("settling 2 % [s]", &|a| settling(a, a.settling_time_2));
    row("settling 5 % [s]", &|a| settling(a, a.settling_time_5));
    row("overshoot [%]", &|a| percent(a.overshoot_percent));
    row("final error [°]", &|a| format!("{:.5}", a.final_error_deg + 0.0));
    row("ISE [rad² s]", &|a| format!("{:.6}", a.ise));
    row("IAE [rad s]", &|a| format!("{:.6}", a.iae));
    row("ITAE [rad s²]", &|a| format!("{:.6}", a.itae));
    let mut motors = table(&["", "main motor", "tail motor"]);
    let mut row = |name: &str, of: &dyn Fn(&MotorReport) -> String| {
        add(&mut motors, [name.to_owned(), of(&report.main), of(&report.tail)]);
    };
    row("asked beyond its limit [ms]", &|m| format!("{:.0}", 1e3 * m.saturation_time));
    row("peak demand [V]", &|m| format!("{:.2}", m.peak_demand));
    row("peak volts [V]", &|m| format!("{:.2}", m.peak_volts));
    format!("{axes}\n{motors}\n")
}
