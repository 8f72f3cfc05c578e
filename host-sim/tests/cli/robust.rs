//! The robust objective from the command line: its scenes, what a board would cut, what is said of a result.

use super::{host_sim, json};
use std::fs;
use std::path::Path;

const LEAST: [&str; 8] = ["--rounds", "1", "--population", "4", "--iterations", "1", "--plants", "3"];

fn gains() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains").display().to_string()
}

#[test]
fn scenes_cost_beside_the_step_whose_j_stays() {
    let folder = tempfile::tempdir().unwrap();
    let compare = |more: &[&str]| {
        let args = ["compare", "--preset", "aero2", "--gains", &gains(), "--controllers", "pd", "--json"];
        json(folder.path(), &[&args[..], &["--plants", "20"], more].concat())
    };
    let (step, all) = (compare(&[]), compare(&["--scenes", "all", "--threads", "1"]));
    assert_eq!(all, compare(&["--scenes", "all", "--threads", "3"]));
    let [ours_step, ours] = [&step, &all].map(|told| &told["controllers"][0]);
    assert_eq!(ours_step["J"], ours["J_step"]);
    assert!(ours["J"].as_f64() > ours_step["J"].as_f64());
    let names: Vec<_> =
        ours["scenes"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["away", "far", "gust", "sine", "hot reversals"]);
    assert_eq!((&ours["failures"], &ours["cuts"]), (&0.into(), &0.into()));
    assert_eq!(step["controllers"][0]["scenes"], serde_json::json!([]));
    // A manufacturer's PD that no search has made better than it is fails, and here on every plant.
    assert_eq!(all["controllers"][1]["failures"], 20);
}

/// A multiple of the lag believed is that lag in seconds.
#[test]
fn lags_that_are_wrong_are_flown_beside_the_drawn_ones() {
    let folder = tempfile::tempdir().unwrap();
    let gains = gains();
    let compare = |more: &[&str]| {
        let args = ["compare", "--preset", "heli", "--plants", "8", "--controllers", "pd", "--json"];
        json(folder.path(), &[&args[..], &["--gains", &gains], more].concat())
    };
    let (drawn, beside) = (compare(&[]), compare(&["--true-lags", ".5,3"]));
    for (k, lag) in [".05", ".3"].into_iter().enumerate() {
        let alone = compare(&["--true-lag", lag]);
        for controller in 0..2 {
            let row = &beside["controllers"][controller];
            assert_eq!(row["J"], drawn["controllers"][controller]["J"]);
            let (there, alone) = (&row["lags"][k], &alone["controllers"][controller]);
            let (j, same) = (there["J"].as_f64().unwrap(), alone["J"].as_f64().unwrap());
            assert!((j / same - 1.0).abs() < 1e-6, "{there} {alone}");
            assert_eq!((&there["failures"], &there["cuts"]), (&alone["failures"], &alone["cuts"]));
        }
    }
    assert!(drawn["controllers"][0].get("lags").is_none());
}

#[test]
fn a_search_through_all_scenes_is_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let tuned = |threads: &str| {
        let args = ["tune", "--objective", "robust", "--preset", "aero2", "--start"];
        let start = format!("{}/aero2.toml", gains());
        let rest = ["--threads", threads, "--out", "g.toml", "--json"];
        let told = json(folder.path(), &[&args[..], &[&start], &LEAST, &rest].concat());
        assert_eq!((&told["scenes"], &told["cuts"]), (&"all".into(), &0.into()));
        assert!(told["proof"]["flights"].as_array().unwrap().iter().all(|f| f["stopped"].is_null()));
        fs::read(folder.path().join("g.toml")).unwrap()
    };
    let one = tuned("1");
    assert_eq!(one, tuned("3"));
    let text = String::from_utf8(one).unwrap();
    assert!(text.contains("robust, 3 plants, all scenes, overshoot_p95.pitch=2.5"), "{text}");
}

/// Gains that leave the envelope beyond the objective's step are written, and told in a line with status 3.
#[test]
fn what_a_board_would_not_fly_to_its_end_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let args =
        ["tune", "--objective", "robust", "--preset", "heli", "--controller", "pd", "--at-most", "none"];
    let ended = host_sim(folder.path(), &[&args[..], &LEAST, &["--scenes", "step"]].concat());
    let [out, told] = [ended.stdout, ended.stderr].map(|text| String::from_utf8(text).unwrap());
    assert_eq!(ended.status.code(), Some(3), "{out}{told}");
    assert!(told.contains("gains.toml are not to be flown as they are: far step: the rig left"), "{told}");
    assert!(out.contains("reversals with warm motors"), "{out}");
    assert!(folder.path().join("gains.toml").exists());
}

/// A quarter of the counts, and gains tuned for all of them: it says which encoders it takes.
#[test]
fn encoders_that_are_too_coarse_are_told_with_what_it_takes() {
    let folder = tempfile::tempdir().unwrap();
    let mut rig = twinrotor::plant::presets::AERO2;
    rig.encoder_counts = rig.encoder_counts.map(|counts| counts / 4);
    fs::write(folder.path().join("coarse.toml"), twinrotor_sim::rig::to_toml(&rig)).unwrap();
    let start = format!("{}/aero2.toml", gains());
    let flown = |preset: &str| {
        let args = ["tune", "--objective", "robust", "--preset", preset, "--start", &start];
        // Nothing but the start is tried, and is best.
        let least = ["--range", "1.000001", "--out", "same.toml"];
        let ended = host_sim(folder.path(), &[&args[..], &LEAST, &least].concat());
        assert_ne!(ended.status.code(), Some(2), "{}", String::from_utf8_lossy(&ended.stderr));
        String::from_utf8(ended.stdout).unwrap()
    };
    let coarse = flown("coarse.toml");
    assert!(coarse.contains("warning: a loop that holds swings by more than two counts"), "{coarse}");
    assert!(coarse.contains("it takes encoders of 2880 and 4096 counts a turn"), "{coarse}");
    let fine = flown("aero2");
    assert!(!fine.contains("warning: a loop"), "{fine}");
}

/// What was there before the search is told on the same objective, and what the file holds where nothing is
/// better.
#[test]
fn gains_that_were_there_before_are_told_beside_what_was_found() {
    let folder = tempfile::tempdir().unwrap();
    let tune = ["tune", "--objective", "robust", "--preset", "aero2", "--out", "g.toml"];
    let own = format!("{}/aero2.toml", gains());
    let run = |more: &[&str]| {
        let args = [&tune[..], &LEAST, more].concat();
        let output = host_sim(folder.path(), &args);
        (String::from_utf8(output.stdout).unwrap(), fs::read_to_string(folder.path().join("g.toml")).unwrap())
    };
    let (told, file) = run(&["--start", &own, "--range", "1.0000000001"]);
    assert!(told.contains("is better than the start: the file holds the start itself"), "{told}");
    assert!(told.contains(&format!("the start: {own}, the preset's own gains")), "{told}");
    let numbers = |text: &str| text.split("[provenance]").next().unwrap().to_owned();
    assert_eq!(numbers(&file), numbers(&fs::read_to_string(&own).unwrap()));

    // Another start, and the preset's own are better than it.
    let (told, _) = run(&["--controller", "integral"]);
    assert!(told.contains("the preset's own gains: gains/aero2.toml"), "{told}");
    assert!(
        told.contains("is better than the preset's own gains: the file holds the best of these"),
        "{told}"
    );
    let (told, _) = run(&["--controller", "integral", "--json"]);
    let told: serde_json::Value = serde_json::from_str(&told).unwrap();
    let [start, own] = [0, 1].map(|k| &told["compared"][k]);
    assert_eq!((&start["what"], &own["what"]), (&"start".into(), &"own".into()));
    assert_eq!((&own["found_is_better"], &own["gains"]), (&false.into(), &"gains/aero2.toml".into()));
    assert!(own["cost"].as_f64() < told["cost"].as_f64() && told["cost"].as_f64() <= start["cost"].as_f64());
}
