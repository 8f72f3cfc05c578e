//! A log beside what the firmware's estimator and law make of it.

use twinrotor::axes::PerMotor;
use twinrotor_identify::replay::Row;
use twinrotor_plot::{Figure, Line, Panel, Stroke};

/// Rates estimated and smoothed, their differences, and volts logged and ours.
pub fn figure(title: &str, rows: &[Row], limit: PerMotor<f64>) -> Figure {
    let line = |name: &str, colour: usize, dashed: bool, of: &dyn Fn(&Row) -> f64| Line {
        name: name.to_owned(),
        points: rows.iter().map(|r| (r.time, of(r))).collect(),
        colour,
        stroke: if dashed { Stroke::Dashed } else { Stroke::Solid },
    };
    let panel = |y_label: &str, lines: Vec<Line>, limits: Vec<f64>| Panel {
        y_label: y_label.to_owned(),
        lines,
        limits,
        ..Panel::default()
    };
    let mut panels = vec![
        panel(
            "pitch rate [°/s]",
            vec![
                line("smoothed", 6, false, &|r| r.smoothed.pitch.to_degrees()),
                line("estimated", 0, true, &|r| r.estimated.pitch.to_degrees()),
            ],
            vec![],
        ),
        panel(
            "yaw rate [°/s]",
            vec![
                line("smoothed", 6, false, &|r| r.smoothed.yaw.to_degrees()),
                line("estimated", 1, true, &|r| r.estimated.yaw.to_degrees()),
            ],
            vec![],
        ),
        panel(
            "rate error [°/s]",
            vec![
                line("pitch", 0, false, &|r| (r.estimated.pitch - r.smoothed.pitch).to_degrees()),
                line("yaw", 1, false, &|r| (r.estimated.yaw - r.smoothed.yaw).to_degrees()),
            ],
            vec![],
        ),
    ];
    let ours = |r: &Row, of: fn(PerMotor<f64>) -> f64| r.ours.map_or(f64::NAN, of);
    for (name, colour, limit, of) in [
        ("main", 0, limit.main, (|v| v.main) as fn(PerMotor<f64>) -> f64),
        ("tail", 1, limit.tail, |v| v.tail),
    ] {
        let mut lines = vec![line("in the log", 6, false, &|r| of(r.volts))];
        if rows.iter().any(|r| r.ours.is_some()) {
            lines.push(line("our law", colour, true, &|r| ours(r, of)));
        }
        panels.push(panel(&format!("{name} motor [V]"), lines, vec![limit, -limit]));
    }
    Figure { title: title.to_owned(), panels, ..Figure::default() }
}
