//! `--record` in the formats of other tools: the same rows as in the CSV.

use super::fly;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// A table as text: names, then rows.
type Rows = Vec<Vec<String>>;

/// The shortest digits of a number, as the CSV has them.
fn digits(number: f64) -> String {
    number.to_string()
}

fn from_csv(path: &Path) -> Rows {
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn from_parquet(path: &Path) -> Rows {
    let reader = SerializedFileReader::new(fs::File::open(path).unwrap()).unwrap();
    let names =
        reader.metadata().file_metadata().schema_descr().columns().iter().map(|c| c.name().to_owned());
    let cell = |field: &Field| match field {
        Field::Double(number) => digits(*number),
        Field::Str(word) => word.clone(),
        other => panic!("{other:?}"),
    };
    let rows = reader
        .get_row_iter(None)
        .unwrap()
        .map(|row| row.unwrap().get_column_iter().map(|(_, field)| cell(field)).collect());
    std::iter::once(names.collect()).chain(rows).collect()
}

/// JSON has no order: the columns are `names`.
fn from_mcap(path: &Path, names: &[String]) -> Rows {
    let bytes = fs::read(path).unwrap();
    let rows = mcap::MessageStream::new(&bytes).unwrap().map(|message| {
        let message = message.unwrap();
        let told: serde_json::Map<String, Value> = serde_json::from_slice(&message.data).unwrap();
        assert_eq!(told.len(), names.len(), "{told:?}");
        let time = told["t"].as_f64().unwrap();
        assert!((message.log_time as f64 * 1e-9 - time).abs() < 1e-9, "{time} s is {} ns", message.log_time);
        let cell = |name: &String| match &told[name] {
            Value::String(word) => word.clone(),
            number => digits(number.as_f64().unwrap()),
        };
        names.iter().map(cell).collect()
    });
    std::iter::once(names.to_vec()).chain(rows).collect()
}

/// A simulated board's flight is the same each time.
#[test]
fn a_record_has_the_same_rows_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let record = |name: &str| {
        let output = fly(folder.path(), &["--record", name, "--json"]);
        assert!(output.status.success(), "{}", super::told(&output));
        folder.path().join(name)
    };
    let expected = from_csv(&record("flight.csv"));
    assert!(expected.len() > 6_000, "{} rows", expected.len());
    let column = |name: &str| expected[0].iter().position(|column| column == name).unwrap();
    let state = column("state");
    assert!(expected.iter().any(|row| row[state] == "armed"));
    for (name, found) in [
        ("Parquet", from_parquet(&record("flight.parquet"))),
        ("MCAP", from_mcap(&record("flight.mcap"), &expected[0])),
    ] {
        assert_eq!(found.len(), expected.len(), "{name}");
        for (found, expected) in found.iter().zip(&expected) {
            assert_eq!(found, expected, "{name}");
        }
    }
}
