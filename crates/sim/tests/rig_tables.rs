//! docs/rigs.md is the core's table of what a rig file may hold, with its presets.
//! `TWINROTOR_RENEW=1 cargo test -p twinrotor-sim --test rig_tables` writes it anew.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use twinrotor::plant::plausible::{PLANT, Plausible, RIG};
use twinrotor::plant::presets::{AERO2, Rig};

const HEAD: &str = "# Rig files\n
A rig is a preset (`paper`, `paper-fixed`, `aero`, `aero2`, `aero-lab`, `heli`; every constant with its source
in `core/src/plant/presets.rs`) or a TOML file, wherever a command takes `--preset`. `rigs/` has rigs that
somebody has published; `identify` writes one from the logs of yours. A number out of its range is refused
with its name, the range, and the unit that it was probably written in.\n
A dot is a table in the file: `envelope.rate.yaw` is `yaw` in `envelope = { rate = { yaw = ... } }`.\n
This file is written by `TWINROTOR_RENEW=1 cargo test -p twinrotor-sim --test rig_tables`.\n";

fn table<T>(text: &mut String, numbers: &[Plausible<T>], example: impl Fn(&Plausible<T>) -> Option<f64>) {
    text.push_str("\n| name | allowed | of an Aero 2 | what it is |\n|---|---|---|---|\n");
    for number in numbers {
        let value = example(number).map_or_else(|| "–".to_owned(), |value| value.to_string());
        writeln!(text, "| `{}` | {} | {value} | {} |", number.field, number.allowed, number.doc).unwrap();
    }
}

fn document(rig: &Rig) -> String {
    let mut text = HEAD.to_owned();
    text.push_str("\n## The machine around the plant\n");
    table(&mut text, RIG, |number| number.value(rig));
    text.push_str("\n## `[plant]`\n\nEqs (1)-(2) of the paper, and what real rigs show beside them.\n");
    table(&mut text, PLANT, |number| number.value(&rig.plant));
    text
}

#[test]
fn the_documentations_table_of_rigs_is_the_cores() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/rigs.md");
    let text = document(&AERO2);
    if std::env::var_os("TWINROTOR_RENEW").is_some() {
        fs::write(&path, &text).unwrap();
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(written == text, "docs/rigs.md is out of date: run this test with TWINROTOR_RENEW=1");
}

/// Every number of a rig's file has a row: none is without a range, a unit and a word.
#[test]
fn every_number_of_a_rig_has_a_row() {
    fn leaves(prefix: &str, value: &toml::Value, found: &mut Vec<String>) {
        match value {
            toml::Value::Table(table) => {
                for (key, value) in table {
                    leaves(
                        &if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") },
                        value,
                        found,
                    );
                }
            }
            _ => found.push(prefix.to_owned()),
        }
    }
    let mut found = Vec::new();
    leaves("", &toml::Value::Table(twinrotor_sim::rig::to_toml(&AERO2).parse().unwrap()), &mut found);
    let rows = RIG.iter().map(|n| n.field.to_owned());
    let mut rows: Vec<String> = rows.chain(PLANT.iter().map(|n| format!("plant.{}", n.field))).collect();
    found.sort();
    rows.sort();
    assert_eq!(found, rows);
}
