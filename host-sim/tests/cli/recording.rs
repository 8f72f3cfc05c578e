//! docs/recording.md: what it says of a log that the maker's software wrote is what the reader reads.

use super::{host_sim, json};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

/// The header and the `--columns` of each example of the document, in their order.
fn examples() -> Vec<(String, String)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/recording.md");
    let document = fs::read_to_string(path).unwrap();
    let headers = document.split("```csv\n").skip(1).map(|rest| rest.lines().next().unwrap().to_owned());
    let columns = document.split("--columns ").skip(1).map(|rest| rest.lines().next().unwrap().to_owned());
    headers.zip(columns).collect()
}

/// What a file says where the rig does `si`: by the file's own name, sign and unit.
fn said(si: f64, sign: f64, unit: Option<&str>) -> String {
    let scale = match unit {
        None => 1.0,
        Some("ms") => 1e3,
        Some("deg") => 360.0 / TAU,
        Some(counts) => {
            let turn: f64 = counts.strip_prefix("counts").expect(counts).parse().unwrap();
            return format!("{:.0}", sign * si * turn / TAU);
        }
    };
    format!("{}", sign * si * scale)
}

/// A flight's log, written as the document's examples have it, is the log that it was.
#[test]
fn a_log_of_the_makers_software_is_read_as_the_document_says() {
    let folder = tempfile::tempdir().unwrap();
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains/aero2.toml").display().to_string();
    let common = ["--preset", "aero2", "--gains", &own];
    let fly = ["simulate", "--fidelity", "rig", "--scenario", "step", "--log", "ours.csv"];
    assert!(host_sim(folder.path(), &[&fly[..], &common].concat()).status.success());
    let ours = fs::read_to_string(folder.path().join("ours.csv")).unwrap();
    let names: Vec<&str> = ours.lines().next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> =
        ours.lines().skip(1).map(|row| row.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    let replay = |log: &str, columns: &str| -> Value {
        let args = ["replay", log, "--scenario", "step", "--columns", columns, "--json"];
        json(folder.path(), &[&args[..], &common].concat())
    };
    let expected = replay("ours.csv", "");
    assert_eq!(expected["notes"], serde_json::json!([]));

    let examples = examples();
    assert_eq!(examples.len(), 2);
    for (header, columns) in examples {
        let source = |theirs: &str| {
            let parts = columns.split(',').map(|part| part.split_once('=').unwrap());
            let named = parts.map(|(ours, theirs)| {
                let (name, unit) = theirs.split_once(':').map_or((theirs, None), |(n, unit)| (n, Some(unit)));
                let bare = name.strip_prefix('-');
                (ours, bare.unwrap_or(name), if bare.is_some() { -1.0 } else { 1.0 }, unit)
            });
            let found = named.into_iter().find(|(_, name, ..)| *name == theirs);
            let (ours, _, sign, unit) = found.unwrap_or_else(|| panic!("{columns} does not name {theirs}"));
            (names.iter().position(|name| *name == ours).unwrap(), sign, unit)
        };
        let sources: Vec<_> = header.split(',').map(source).collect();
        let line = |row: &Vec<f64>| {
            let cells = sources.iter().map(|(at, sign, unit)| said(row[*at], *sign, *unit));
            cells.collect::<Vec<_>>().join(",")
        };
        let text = std::iter::once(header.clone()).chain(rows.iter().map(line)).collect::<Vec<_>>();
        fs::write(folder.path().join("theirs.csv"), text.join("\n")).unwrap();
        let read = replay("theirs.csv", &columns);
        assert_eq!(read["notes"], serde_json::json!([]), "{columns}");
        for (field, part) in [("rate_error", "pitch"), ("rate_error", "yaw"), ("volts_difference", "tail")] {
            let [ours, theirs] = [&expected, &read].map(|told| told[field][part].as_f64().unwrap());
            assert!((ours - theirs).abs() < 1e-6, "{columns}: {field}.{part} {ours} {theirs}");
        }
        // Without what is said of them these columns are not read, let alone taken for something else.
        let unsaid = host_sim(folder.path(), &["replay", "theirs.csv", "--preset", "aero2"]);
        assert_eq!(unsaid.status.code(), Some(2));
    }
}
