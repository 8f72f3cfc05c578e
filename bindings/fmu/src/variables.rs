//! A unit's variables. A value reference is a place in the list.

use crate::design::{Design, What};
use crate::model::Model;
use twinrotor::settings::Field;

/// Which way a variable goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set before a step, held during it.
    Input,
    /// Told after a step.
    Output,
    /// Set before the simulation begins.
    Parameter,
}

/// How a variable is reached.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Place {
    Input(usize),
    Output(fn(&Model) -> f64),
    Setting(&'static Field),
}

/// A real number of a unit.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Structured, with dots.
    pub name: String,
    /// SI; empty for a ratio.
    pub unit: &'static str,
    /// What it is, in one line.
    pub explanation: &'static str,
    /// Which way it goes.
    pub causality: Causality,
    /// Its value at the beginning; none for outputs.
    pub start: Option<f64>,
    /// Its bounds, where it has any.
    pub bounds: [Option<f64>; 2],
    pub(crate) place: Place,
}

/// Name, unit, explanation, and a start or what is told.
type Row<T> = (&'static str, &'static str, &'static str, T);
type Told = Row<fn(&Model) -> f64>;

const SETPOINT: [Row<f64>; 2] = [
    ("setpoint.pitch", "rad", "Where to be, above the horizontal", 0.0),
    ("setpoint.yaw", "rad", "Where to be", 0.0),
];
const DISTURBANCE: [Row<f64>; 2] = [
    ("disturbance.main", "V", "Added to the volts in effect of the main motor", 0.0),
    ("disturbance.tail", "V", "Added to the volts in effect of the tail motor", 0.0),
];
const VOLTS: [Row<f64>; 2] = [
    ("volts.main", "V", "What the main motor's amplifier gives", 0.0),
    ("volts.tail", "V", "What the tail motor's amplifier gives", 0.0),
];
const COUNTS: [Row<f64>; 2] = [
    ("counts.pitch", "", "What the pitch encoder has counted", 0.0),
    ("counts.yaw", "", "What the yaw encoder has counted", 0.0),
];
const TRUE_STATE: [Told; 4] = [
    ("angle.pitch", "rad", "True pitch angle", |m| m.state().angle.pitch.into()),
    ("angle.yaw", "rad", "True yaw angle", |m| m.state().angle.yaw.into()),
    ("rate.pitch", "rad/s", "True pitch rate", |m| m.state().rate.pitch.into()),
    ("rate.yaw", "rad/s", "True yaw rate", |m| m.state().rate.yaw.into()),
];
const ARMED: Told =
    ("armed", "", "1 while the board's supervisor lets the motors turn, else 0", |m| f64::from(m.is_armed()));

/// All of a unit's, in the order of their value references.
pub fn variables(design: &Design) -> Vec<Variable> {
    let supply = ("supply", "V", "Supply of the amplifiers", design.named.rig.supply.nominal);
    let (inputs, outputs): (Vec<Row<f64>>, Vec<Told>) = match design.what {
        What::Plant => {
            let counts: [Told; 3] = [
                (COUNTS[0].0, "", COUNTS[0].2, |m| f64::from(m.counts().pitch)),
                (COUNTS[1].0, "", COUNTS[1].2, |m| f64::from(m.counts().yaw)),
                (supply.0, supply.1, supply.2, Model::supply),
            ];
            ([VOLTS, DISTURBANCE].concat(), counts.into_iter().chain(TRUE_STATE).collect())
        }
        What::Controller => {
            let mut inputs = [SETPOINT, COUNTS].concat();
            inputs.push(supply);
            (inputs, volts().into_iter().chain([ARMED]).collect())
        }
        What::Loop => {
            let outputs = TRUE_STATE.into_iter().chain(volts()).chain([ARMED]);
            ([SETPOINT, DISTURBANCE].concat(), outputs.collect())
        }
    };
    let input = |(k, (name, unit, explanation, start)): (usize, Row<f64>)| Variable {
        name: name.to_owned(),
        unit,
        explanation,
        causality: Causality::Input,
        start: Some(start),
        bounds: [None; 2],
        place: Place::Input(k),
    };
    let output = |(name, unit, explanation, of): Told| Variable {
        name: name.to_owned(),
        unit,
        explanation,
        causality: Causality::Output,
        start: None,
        bounds: [None; 2],
        place: Place::Output(of),
    };
    let mut all: Vec<Variable> = inputs.into_iter().enumerate().map(input).collect();
    all.extend(outputs.into_iter().map(output));
    if design.what != What::Plant {
        design.gains.controller.visit(|field, value| all.push(setting(field, value)));
    }
    all
}

fn volts() -> [Told; 2] {
    [
        (VOLTS[0].0, "V", VOLTS[0].2, |m| m.volts().main.into()),
        (VOLTS[1].0, "V", VOLTS[1].2, |m| m.volts().tail.into()),
    ]
}

fn setting(field: &'static Field, value: f64) -> Variable {
    let finite = |x: f64| x.is_finite().then_some(x);
    Variable {
        name: format!("controller.{}", field.name),
        unit: if field.unit == "-" { "" } else { field.unit },
        explanation: field.doc,
        causality: Causality::Parameter,
        start: Some(value),
        bounds: [field.range.least(), field.range.most()].map(finite),
        place: Place::Setting(field),
    }
}
