//! A flight, drawn.

use crate::{Figure, Line, Panel, Stroke};
use twinrotor::axes::PerMotor;
use twinrotor_sim::flight::{Flight, Row};

/// A line over time of what is read off each row.
pub fn line(name: &str, colour: usize, rows: &[Row], value: impl Fn(&Row) -> f64) -> Line {
    Line {
        name: name.to_owned(),
        points: rows.iter().map(|r| (r.time, value(r))).collect(),
        colour,
        stroke: Stroke::Solid,
    }
}

/// The same in dashes.
#[must_use]
pub fn dashed(line: Line) -> Line {
    Line { stroke: Stroke::Dashed, ..line }
}

/// A flight: angles with references, volts with limits, squared errors (the paper's Fig. 5).
pub fn flight(title: &str, flight: &Flight, limit: PerMotor<f64>) -> Figure {
    let rows = &flight.rows;
    let squared = |e: f64| e * e;
    Figure {
        title: title.to_owned(),
        x_label: String::new(),
        panels: vec![
            Panel {
                y_label: "angle [°]".to_owned(),
                lines: vec![
                    dashed(line("pitch reference θd", 0, rows, |r| r.reference.pitch.to_degrees())),
                    dashed(line("yaw reference ψd", 1, rows, |r| r.reference.yaw.to_degrees())),
                    line("pitch θ", 0, rows, |r| r.state.angle.pitch.to_degrees()),
                    line("yaw ψ", 1, rows, |r| r.state.angle.yaw.to_degrees()),
                ],
                ..Panel::default()
            },
            Panel {
                y_label: "motor volts [V]".to_owned(),
                lines: vec![
                    line("main Vp", 0, rows, |r| r.volts.main),
                    line("tail Vy", 1, rows, |r| r.volts.tail),
                ],
                limits: vec![limit.main, -limit.main, limit.tail, -limit.tail],
                ..Panel::default()
            },
            Panel {
                y_label: "squared error [rad²]".to_owned(),
                lines: vec![
                    line("pitch ξp²", 0, rows, |r| squared(r.reference.pitch - r.state.angle.pitch)),
                    line("yaw ξy²", 1, rows, |r| squared(r.reference.yaw - r.state.angle.yaw)),
                ],
                ..Panel::default()
            },
        ],
    }
}
