//! The report of the paper.

use super::json;
use super::panics::LAST_SEED;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// What `reproduce` makes from the last seed there is, which takes long enough to be made once for all tests:
/// the folder, and what it printed.
pub(super) fn reproduced() -> &'static (PathBuf, Value) {
    static REPORT: OnceLock<(PathBuf, Value)> = OnceLock::new();
    REPORT.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reproduced");
        let out = folder.to_str().expect("a path in UTF-8");
        let _ = fs::remove_dir_all(&folder);
        let report = json(
            Path::new(env!("CARGO_TARGET_TMPDIR")),
            &["reproduce", "--quick", "--json", "--seed", LAST_SEED, "--out", out],
        );
        (folder, report)
    })
}

/// The report is whole: a page that shows every section, and a number for every figure's points. That the
/// same seed gives the same bytes is in `matrices`, which runs it once more.
#[test]
fn the_paper_is_reproduced_as_a_page_and_its_numbers() {
    let (folder, report) = reproduced();
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(report["seed"].as_u64(), LAST_SEED.parse().ok());
    let page = read("index.html");
    for section in report["sections"].as_array().unwrap() {
        assert!(page.contains(section["title"].as_str().unwrap()), "{}", section["title"]);
        for entry in section["entries"].as_array().unwrap() {
            let verdict = entry["verdict"].as_str().unwrap();
            let ours = entry["ours"].as_str().unwrap();
            // What was never reached is said to be, not called infinite.
            assert!(!ours.contains("inf ") && !ours.contains("NaN"), "{ours}");
            assert!(
                ["reproduced", "within-ambiguity", "not-reproduced", "undecided", "contradictory", "given"]
                    .contains(&verdict),
                "{verdict}"
            );
        }
    }
    for sentence in report["summary"].as_array().unwrap() {
        assert!(page.contains(sentence.as_str().unwrap()), "{sentence}");
    }
    // What was measured is a table of its own, on the page and as a file.
    let rivals = read("table-6.csv");
    assert!(page.contains("id=table-6") && rivals.lines().count() == 6, "{rivals}");
    let columns = |row: &str| row.matches("\",\"").count();
    assert!(rivals.lines().all(|row| columns(row) == 7), "{rivals}");
    let drawn = read("fig-4a-responses.csv");
    assert!(drawn.lines().count() > 1_000 && drawn.lines().skip(1).all(|row| row.split(',').count() > 2));
    let written: Value = serde_json::from_str(&read("report.json")).unwrap();
    assert_eq!(&written, report);
}
