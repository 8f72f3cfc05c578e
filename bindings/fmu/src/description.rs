//! `modelDescription.xml`, as section 2.2 and 4.3 of FMI 2.0.4 have it.

use crate::design::Design;
use crate::variables::{Causality, Variable, variables};
use std::collections::BTreeSet;
use std::fmt::Write;

/// What the unit's library is called, without its ending.
const IDENTIFIER: &str = "twinrotor_fmu";

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A unit's base units, for those that are known to be made of them.
fn base(unit: &str) -> Option<&'static str> {
    Some(match unit {
        "rad" => r#"rad="1""#,
        "rad/s" => r#"rad="1" s="-1""#,
        "rad/s²" => r#"rad="1" s="-2""#,
        "s" => r#"s="1""#,
        "1/s" => r#"s="-1""#,
        "1/s²" => r#"s="-2""#,
        "1/s³" => r#"s="-3""#,
        "V" => r#"kg="1" m="2" s="-3" A="-1""#,
        "A" => r#"A="1""#,
        _ => return None,
    })
}

/// The XML of a unit.
pub fn description(design: &Design) -> String {
    let all = variables(design);
    let mut xml = String::new();
    let name = format!("Twinrotor {} of {}", design.what.name(), design.named.name);
    let _ = write!(
        xml,
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{}" guid="{}" version="{}"
  generationTool="Twinrotor {}" variableNamingConvention="structured" numberOfEventIndicators="0"
  description="A two-rotor laboratory helicopter; a step is a multiple of 1 ms, inputs are held during it">
  <CoSimulation modelIdentifier="{IDENTIFIER}" canHandleVariableCommunicationStepSize="true"
    canGetAndSetFMUstate="true" canSerializeFMUstate="true"/>
  <UnitDefinitions>
"#,
        escaped(&name),
        design.guid(),
        env!("CARGO_PKG_VERSION"),
        env!("CARGO_PKG_VERSION"),
    );
    for unit in all.iter().map(|v| v.unit).filter(|unit| !unit.is_empty()).collect::<BTreeSet<_>>() {
        let _ = match base(unit) {
            Some(base) => writeln!(xml, r#"    <Unit name="{unit}"><BaseUnit {base}/></Unit>"#),
            None => writeln!(xml, r#"    <Unit name="{unit}"/>"#),
        };
    }
    xml.push_str(
        "  </UnitDefinitions>\n  <LogCategories><Category name=\"error\"/></LogCategories>\n  \
         <DefaultExperiment startTime=\"0\" stopTime=\"5\" stepSize=\"0.001\"/>\n  <ModelVariables>\n",
    );
    for (reference, variable) in all.iter().enumerate() {
        scalar(&mut xml, reference, variable);
    }
    xml.push_str("  </ModelVariables>\n  <ModelStructure>\n");
    for part in ["Outputs", "InitialUnknowns"] {
        let _ = writeln!(xml, "    <{part}>");
        let outputs = all.iter().enumerate().filter(|(_, v)| v.causality == Causality::Output);
        for (k, _) in outputs {
            // What is told is known before the inputs of the step: nothing goes through at once.
            let _ = writeln!(xml, r#"      <Unknown index="{}" dependencies=""/>"#, k + 1);
        }
        let _ = writeln!(xml, "    </{part}>");
    }
    xml.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
    xml
}

fn scalar(xml: &mut String, reference: usize, variable: &Variable) {
    let Variable { name, unit, explanation, causality, start, bounds, .. } = variable;
    let (causality, variability, initial) = match causality {
        Causality::Input => ("input", "continuous", ""),
        Causality::Output => ("output", "continuous", r#" initial="calculated""#),
        Causality::Parameter => ("parameter", "tunable", r#" initial="exact""#),
    };
    let _ = write!(
        xml,
        "    <ScalarVariable name=\"{}\" valueReference=\"{reference}\" causality=\"{causality}\" \
         variability=\"{variability}\"{initial}\n      description=\"{}\"><Real",
        escaped(name),
        escaped(explanation)
    );
    if !unit.is_empty() {
        let _ = write!(xml, r#" unit="{unit}""#);
    }
    for (attribute, value) in [("min", bounds[0]), ("max", bounds[1]), ("start", *start)] {
        if let Some(value) = value {
            let _ = write!(xml, r#" {attribute}="{value:?}""#);
        }
    }
    xml.push_str("/></ScalarVariable>\n");
}
