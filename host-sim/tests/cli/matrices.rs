//! A law of matrices on the way that each command gives it: flown beside the others, or refused in a line.

use super::panics::LAST_SEED;
use super::reproduced::reproduced;
use super::{host_sim, json};
use serde_json::Value;
use std::fs;
use std::path::Path;

const AERO2: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../gains/choices/aero2-state-space.toml");

/// For the paper's rig, without states.
const PAPERS: &str = "controller = \"state-space\"

[state-space]
inputs = [\"angle_error.pitch\", \"angle_error.yaw\", \"rate_error.pitch\", \"rate_error.yaw\"]
outputs = [\"volts.main\", \"volts.tail\"]
sample_time = 0.001
A = []
B = []
C = [[], []]
D = [[4, 0, 4, 0], [0, 4, 0, 4]]
";

#[test]
fn it_flies_in_simulate_compare_and_reproduce() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::copy(AERO2, at.join("lqg.toml")).unwrap();
    let simulate = ["simulate", "--preset", "aero2", "--gains", "lqg.toml", "--fidelity", "rig", "--json"];
    let flown = json(at, &simulate);
    for axis in ["pitch", "yaw"] {
        assert!(flown[axis]["settling_time_2"].as_f64().unwrap() < 5.0, "{axis}: {}", flown[axis]);
    }
    assert_eq!(flown["gains"]["state-space"]["A"].as_array().map(Vec::len), Some(8));

    let compare = ["compare", "--preset", "aero2", "--plants", "20", "--controllers", "lqg.toml", "--json"];
    let gains = ["--gains", concat!(env!("CARGO_MANIFEST_DIR"), "/../gains")];
    let rows = json(at, &[&compare[..], &gains].concat());
    let row = &rows["controllers"][1];
    assert_eq!((row["name"].as_str(), row["failures"].as_u64()), (Some("lqg.toml"), Some(0)), "{row}");
    assert_eq!(row["uses"][0], "matrices of 8 states");

    fs::write(at.join("papers.toml"), PAPERS).unwrap();
    let (plain, without) = reproduced();
    let names = "papers.toml,lqi-plus,ours,paper";
    let mine = ["reproduce", "--quick", "--seed", LAST_SEED, "--controllers", names, "--out", "report"];
    let output = host_sim(at, &[&mine[..], &gains].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| fs::read_to_string(at.join("report").join(name)).unwrap();
    let table = read("table-6.csv");
    let own: Vec<&str> = table.lines().filter(|line| line.contains("yours, in no verdict")).collect();
    assert_eq!(own.len(), 4, "{table}");
    for (row, name) in own.iter().zip(names.split(',')) {
        assert!(row.starts_with(&format!("\"{name}\",")), "{row}");
    }
    assert!(read("index.html").contains(&format!("--controllers {names}")));
    let with: Value = serde_json::from_str(&read("report.json")).unwrap();
    assert_eq!(with["summary"], without["summary"], "a row of one's own changes no verdict");
    // Nor a byte of any other table or figure, all of which come from one seed in both runs.
    let mut same = 0;
    for file in fs::read_dir(plain).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()) {
        if !["table-6.csv", "index.html", "report.json"].contains(&file.as_str()) {
            assert!(fs::read_to_string(plain.join(&file)).unwrap() == read(&file), "{file}");
            same += 1;
        }
    }
    assert!(same > 3, "{same} files");
}

/// One line and exit status 2, and nothing written.
fn refused(at: &Path, args: &[&str], expected: &str) {
    let output = host_sim(at, args);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{args:?}: {told}");
    assert!(told.contains(expected) && told.lines().count() == 1, "{args:?}: {told}");
}

#[test]
fn an_unstable_one_is_refused_wherever_it_would_fly() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("bad.toml"), PAPERS.replace("[4, 0, 4, 0]", "[-4, 0, 4, 0]")).unwrap();
    let unstable =
        "bad.toml: the sampled loop of this state-space law on paper is unstable: a small error grows at";
    for args in [
        &["simulate", "--gains", "bad.toml"][..],
        &["simulate", "--gains", "bad.toml", "--fidelity", "rig"],
        &["compare", "--preset", "paper", "--plants", "4", "--controllers", "bad.toml"],
        &["reproduce", "--quick", "--controllers", "bad.toml", "--out", "report"],
        &["flash", "bad.toml", "--preset", "paper", "--image", "x.hex"],
        &["fly", "--port", "sim", "--preset", "paper", "--gains", "bad.toml", "--yes"],
        &["fly", "--port", "sim", "--preset", "paper", "--trial", "bad.toml", "--yes"],
    ] {
        refused(at, args, unstable);
    }
    assert!(!at.join("x.hex").exists() && !at.join("report").exists());
    // What says how it is unstable does not refuse it.
    let margins = ["margins", "--gains", "bad.toml", "--preset", "paper"];
    let output = host_sim(at, &[&margins[..], &["--json"]].concat());
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&told["stable"], output.status.code()), (&false.into(), Some(3)), "{told}");
    assert!(told["slowest_pole"].as_f64().unwrap() < 0.0, "{told}");
    let output = host_sim(at, &margins);
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(told.contains("unstable") && !told.contains("added delay"), "{told}");
    assert_eq!(output.status.code(), Some(3), "{told}");
}

#[test]
fn what_cannot_be_flown_or_searched_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("papers.toml"), PAPERS).unwrap();
    fs::write(at.join("slow.toml"), PAPERS.replace("0.001", "0.002")).unwrap();
    refused(at, &["simulate", "--gains", "slow.toml"], "state-space.sample_time is 0.002; allowed: 0.001 s");
    let tune =
        ["tune", "--preset", "paper", "--objective", "robust", "--start", "papers.toml", "--iterations", "1"];
    refused(at, &tune, "controller is state-space; allowed: one with a number that can be searched");
    let card = ["compare", "--preset", "paper", "--plants", "4", "--controllers", "papers.toml"];
    let output = host_sim(at, &[&card[..], &["--device", "stand-in:1000"]].concat());
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("its kernels fly no state-space law") && told.contains("--device cpu"), "{told}");
}

/// Over the line to a simulated board, into its flash, and flown there: the host's bits.
#[test]
fn a_simulated_board_flies_it_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let fly = ["fly", "--port", "sim", "--preset", "aero2", "--gains", AERO2, "--yes"];
    let output = host_sim(folder.path(), &fly);
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(told.contains("bit for bit equal to the host over"), "{told}");
}
