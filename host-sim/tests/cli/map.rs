//! `map`: the cost over two numbers of a controller.

use super::{host_sim, json};
use std::fs;
use std::path::Path;

fn gains() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains/aero2.toml").display().to_string()
}

/// The paper's law on its own problem: where `tune` ends is on the map's lowest ground, and what flies does
/// not matter.
#[test]
fn the_least_of_a_map_is_where_a_search_ends() {
    let folder = tempfile::tempdir().unwrap();
    let ise = ["map", "--objective", "ise", "--parameters", "yaw.position,yaw.rate", "--cells", "24"];
    let with = |more: &[&str]| {
        let told = json(folder.path(), &[&ise[..], &["--gains", "paper", "--json"], more].concat());
        (told, fs::read(folder.path().join("map.svg")).unwrap())
    };
    let (told, picture) = with(&["--export", "cells.csv"]);
    assert_eq!((told.clone(), picture), with(&["--device", "stand-in:1000"]));
    let cells = fs::read_to_string(folder.path().join("cells.csv")).unwrap();
    assert_eq!(cells.lines().next(), Some("yaw.position,yaw.rate,cost"));
    let costs: Vec<f64> =
        cells.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect();
    assert_eq!(costs.len(), 24 * 24);
    let least = told["best"]["cost"].as_f64().unwrap();
    assert!(costs.iter().all(|cost| *cost >= least), "least of all");
    let given = told["here"]["cost"].as_f64().unwrap();
    let simulated = json(folder.path(), &["simulate", "--json"]);
    let ise: f64 = ["pitch", "yaw"].iter().map(|axis| simulated[axis]["ise"].as_f64().unwrap()).sum();
    assert!((given / ise - 1.0).abs() < 1e-4, "{given} {ise}: the given gains cost what they do alone");
    // With all four gains free there is more to find than with two.
    let tuned = json(folder.path(), &["tune", "--out", "g.toml", "--json"]);
    assert!(tuned["cost"].as_f64().unwrap() < least, "{tuned}");
}

#[test]
fn a_map_that_was_broken_off_goes_on_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let file = gains();
    let map = |more: &[&str]| {
        let args = [
            &["map", "--preset", "aero2", "--gains", &file, "--plants", "3", "--cells", "4"][..],
            &["--parameters", "pitch.rate,estimator.bandwidth.yaw", "--json"],
            more,
        ];
        host_sim(folder.path(), &args.concat())
    };
    let straight = map(&[]);
    assert!(straight.status.success(), "{}", String::from_utf8_lossy(&straight.stderr));
    let picture = fs::read(folder.path().join("map.svg")).unwrap();
    fs::remove_file(folder.path().join("map.svg")).unwrap();
    // A card that is lost at once keeps what was known: nothing yet, and that is said.
    let lost = map(&["--device", "stand-in:0", "--checkpoint", "c.bin"]);
    let why = String::from_utf8_lossy(&lost.stderr).into_owned();
    assert_eq!(lost.status.code(), Some(1), "{why}");
    assert!(why.contains("unplugged; 0 of 16 cells are known; --checkpoint c.bin --resume goes on"), "{why}");
    assert!(!folder.path().join("map.svg").exists(), "no half of a picture");
    let resumed = map(&["--checkpoint", "c.bin", "--resume"]);
    assert_eq!(resumed.stdout, straight.stdout);
    assert_eq!(fs::read(folder.path().join("map.svg")).unwrap(), picture);
    let other = map(&["--checkpoint", "c.bin", "--resume", "--range", "2"]);
    let why = String::from_utf8_lossy(&other.stderr).into_owned();
    assert!(other.status.code() == Some(2) && why.contains("range is 4 there, 2 here"), "{why}");
}

#[test]
fn what_a_map_cannot_be_of_is_said_with_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let file = gains();
    let cases: [(&[&str], &str); 5] = [
        (&["--parameters", "pitch.rate,roll"], "'roll'; allowed: "),
        (&["--parameters", "pitch.rate"], "is pitch.rate; allowed: two different ones of allocation"),
        (&["--parameters", "pitch,yaw.rate"], "is pitch,yaw.rate; allowed: two different ones of"),
        (&["--parameters", "pitch.rate,yaw.rate", "--objective", "ise"], "gains of the paper's law"),
        (&["--parameters", "pitch.rate,yaw.rate", "--cells", "1"], "--cells is 1; allowed: 2 to 2000"),
    ];
    for (more, expected) in cases {
        let args = [&["map", "--preset", "aero2", "--gains", &file][..], more].concat();
        let ended = host_sim(folder.path(), &args);
        let why = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert!(ended.status.code() == Some(2) && why.contains(expected), "{more:?}: {why}");
        assert!(!folder.path().join("map.svg").exists());
    }
}
