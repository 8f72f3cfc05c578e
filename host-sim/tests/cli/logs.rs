//! From a recorded flight to a preset, a replay and the next flight.

use super::{host_sim, json};
use serde_json::Value;

/// A flight recorded by `simulate` goes through `identify` and `replay`, and the preset that comes out flies.
#[test]
fn a_recorded_flight_leads_to_a_preset() {
    let folder = tempfile::tempdir().unwrap();
    let columns = "pitch=theta,yaw=psi,v0=v_main,v1=v_tail";
    let rig = ["--preset", "aero-lab", "--fidelity", "rig", "--csv", "run.csv"];
    assert!(host_sim(folder.path(), &[&["simulate"][..], &rig].concat()).status.success());
    let few =
        ["identify", "run.csv", "--columns", columns, "--preset", "aero-lab", "--json", "--window", "1.5"];
    let fix = [
        "--fix",
        "effectiveness,quadratic_effectiveness,rotor_time_constant,rotor_reaction",
        "--iterations",
        "0",
    ];
    let found = json(folder.path(), &[&few[..], &fix, &["--population", "2"]].concat());
    assert_eq!(found["parameters"].as_array().unwrap().len(), 5);
    assert!(found["fits"][0]["pitch"].as_f64().unwrap() > 90.0 && found["fits"][0]["role"] == "train");
    assert!(found["parameters"][0]["ci95"].is_array() && found["parameters"][0]["unit"] == "N m s/rad");
    let flown = json(folder.path(), &["simulate", "--preset", "preset.toml", "--fidelity", "rig", "--json"]);
    assert_eq!(flown["preset"], "preset.toml");
    let replayed = json(
        folder.path(),
        &[
            "replay",
            "run.csv",
            "--columns",
            columns,
            "--preset",
            "preset.toml",
            "--scenario",
            "step",
            "--json",
        ],
    );
    assert!(replayed["rate_error"]["pitch"].is_number() && replayed["volts_difference"]["main"].is_number());
    let nowhere =
        ["replay", "run.csv", "--columns", columns, "--preset", "preset.toml", "--port", "no-such-port"];
    let refused = host_sim(folder.path(), &nowhere);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--port no-such-port cannot be opened"));
}

/// From a short flight to the suggested one, and with both logs the constant that was known worst is known
/// better.
#[test]
fn a_suggested_flight_narrows_what_was_known_worst() {
    let folder = tempfile::tempdir().unwrap();
    let fly = |more: &[&str]| {
        let rig = ["simulate", "--preset", "aero-lab", "--fidelity", "rig"];
        let flown = host_sim(folder.path(), &[&rig[..], more].concat());
        assert!(flown.status.success(), "{}", String::from_utf8_lossy(&flown.stderr));
    };
    let identify = |logs: &[&str], more: &[&str]| {
        let few = ["--columns", "pitch=theta,yaw=psi,v0=v_main,v1=v_tail", "--preset", "aero-lab", "--json"];
        let fix = ["--fix", "effectiveness,quadratic_effectiveness,rotor_time_constant,rotor_reaction"];
        let quick = ["--window", "1.5", "--iterations", "0", "--population", "2"];
        json(folder.path(), &[&["identify"], logs, &few, &fix, &quick, more].concat())
    };
    fly(&["--csv", "run.csv"]);
    let before = identify(&["run.csv"], &["--suggest", "next.toml"]);
    let constant = before["suggestion"].as_str().unwrap().split(':').next().unwrap().to_owned();
    fly(&["--scenario", "next.toml", "--csv", "next.csv"]);
    let after = identify(&["run.csv", "next.csv"], &[]);
    let width = |found: &Value| {
        let all = found["parameters"].as_array().unwrap();
        let worst = all.iter().find(|p| p["name"] == constant.as_str()).unwrap();
        let end = |k: usize| worst["ci95"][k].as_f64();
        end(1).zip(end(0)).map_or(f64::INFINITY, |(most, least)| most - least)
    };
    assert!(width(&after) < 0.8 * width(&before), "{constant}: {} to {}", width(&before), width(&after));
}
