//! The table of settings, as the core declares it.

use crate::parts::json;
use pyo3::prelude::*;
use serde::Serialize;
use twinrotor::controller::{CHOICES, PARTS};
use twinrotor::settings::Field;

/// A setting; bounds and defaults that are none are `null`.
#[derive(Serialize)]
struct Row {
    name: &'static str,
    part: &'static str,
    kind: Option<&'static str>,
    unit: &'static str,
    allowed: &'static str,
    least: Option<f64>,
    most: Option<f64>,
    typical: [f64; 2],
    default: Option<f64>,
    explanation: &'static str,
}

impl Row {
    fn new(part: &'static str, kind: Option<&'static str>, field: &Field) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        Self {
            name: field.name,
            part,
            kind,
            unit: field.unit,
            allowed: field.range.allowed(),
            least: finite(field.range.least()),
            most: finite(field.range.most()),
            typical: field.typical,
            default: finite(field.default),
            explanation: field.doc,
        }
    }
}

/// Every number of a controller that a person may choose.
#[pyfunction]
pub(crate) fn settings() -> PyResult<String> {
    let of_kinds = CHOICES.iter().flat_map(|(part, kinds)| {
        kinds.iter().flat_map(|kind| kind.fields.iter().map(|field| Row::new(part, Some(kind.name), field)))
    });
    let of_parts =
        PARTS.iter().flat_map(|(part, fields)| fields.iter().map(|field| Row::new(part, None, field)));
    json(&of_kinds.chain(of_parts).collect::<Vec<_>>())
}
