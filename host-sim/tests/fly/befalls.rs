//! What befalls a rig in a scenario: at a simulated board it does, at a real one nothing is done to it.

use super::served::{Mishap, Served};
use super::{fly, json, told};
use serde_json::Value;
use std::fs;
use std::process::Command;
/// What a scenario's file injects is what `--inject` does, to the tick; nobody else takes such a file.
#[test]
fn a_scenario_injects_what_the_flag_does() {
    let folder = tempfile::tempdir().unwrap();
    let calm = "duration = 5.0\n[pitch.steps]\njumps = [[0.5, 8], [2.5, -8]]\n[yaw.steps]\njumps = []\n";
    fs::write(folder.path().join("calm.toml"), calm).unwrap();
    fs::write(folder.path().join("stuck.toml"), format!("inject = [\"stuck-pitch@2\"]\n{calm}")).unwrap();
    let by_file = fly(folder.path(), &["--scenario", "stuck.toml", "--json"]);
    let by_flag = fly(folder.path(), &["--scenario", "calm.toml", "--inject", "stuck-pitch@2", "--json"]);
    for output in [&by_file, &by_flag] {
        assert_eq!(output.status.code(), Some(3), "{}", told(output));
        assert!(told(output).contains("the pitch encoder does not show the motion"), "{}", told(output));
    }
    let (by_file, by_flag) = (json(&by_file), json(&by_flag));
    for field in ["frames", "verified_ticks", "flown", "why"] {
        assert_eq!(by_file[field], by_flag[field], "{field}");
    }
    assert!(by_file["verified_ticks"].as_u64().unwrap() > 3_000, "{by_file}");
    for (text, sentence) in [
        ("[\"stuck-roll@2\"]", "allowed: stuck-AXIS"),
        ("[\"stop@5\"]", "inject is 5; allowed: before the scenario's end at 5 s"),
    ] {
        fs::write(folder.path().join("bad.toml"), format!("inject = {text}\n{calm}")).unwrap();
        let output = fly(folder.path(), &["--scenario", "bad.toml"]);
        assert!(output.status.code() == Some(2) && told(&output).contains(sentence), "{}", told(&output));
    }
    let simulate = Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(["simulate", "--scenario", "stuck.toml", "--fidelity", "rig"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(simulate.status.code() == Some(2) && told(&simulate).contains("no board flies here"));
}

/// What is injected lasts until something else is: a scenario that says nothing of it does not end it.
#[test]
fn what_is_injected_stays() {
    let folder = tempfile::tempdir().unwrap();
    let output = fly(folder.path(), &["--inject", "supply=5@2"]);
    assert_eq!(output.status.code(), Some(3), "{}", told(&output));
    assert!(told(&output).contains("supply"), "{}", told(&output));
    let pushed = fly(folder.path(), &["--inject", "disturbance=6:0@2", "--record", "pushed.csv"]);
    assert!(matches!(pushed.status.code(), Some(0 | 1)), "{}", told(&pushed));
    let record = fs::read_to_string(folder.path().join("pushed.csv")).unwrap();
    let mut lines = record.lines();
    let column = lines.next().unwrap().split(',').position(|name| name == "disturbance_pitch").unwrap();
    let seen: Vec<f64> = lines.map(|line| line.split(',').nth(column).unwrap().parse().unwrap()).collect();
    // The observer finds it, and goes on finding it: rad/s² of 6 V at an Aero 2's main rotor.
    let mean = |part: &[f64]| part.iter().sum::<f64>() / 1_000.0;
    let (before, after) = (mean(&seen[1_000..2_000]), mean(&seen[seen.len() - 2_500..seen.len() - 1_500]));
    assert!(before.abs() < 0.01 && after > 0.06, "{before} {after}");
}

/// The simulated board's rig is pushed while the scenario runs, a real one never.
#[test]
fn a_scenario_befalls_the_simulated_rig_and_leaves_a_real_one_alone() {
    let folder = tempfile::tempdir().unwrap();
    let calm = "duration = 5.0\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = [[0.5, 20]]\n";
    let pushed = format!("{calm}[[events.gust]]\ntorque = [0.006, 0]\nwindow = [3, 4]\n");
    fs::write(folder.path().join("calm.toml"), calm).unwrap();
    fs::write(folder.path().join("pushed.toml"), pushed).unwrap();
    let iae = |document: &Value, which: &str| document[which]["pitch"]["iae"].as_f64().unwrap();
    let fly = |scenario: &str, more: &[&str]| {
        fly(folder.path(), &[&["--scenario", scenario, "--json"], more].concat())
    };
    let (calm, pushed) = (json(&fly("calm.toml", &[])), json(&fly("pushed.toml", &[])));
    for which in ["flown", "simulated"] {
        assert!(iae(&pushed, which) > 1.5 * iae(&calm, which), "{which}: {pushed}");
    }
    assert!(pushed["verified_ticks"].is_null() && calm["verified_ticks"].as_u64().is_some());
    let refused = fly("pushed.toml", &["--verify"]);
    assert!(
        refused.status.code() == Some(2) && told(&refused).contains("--verify cannot be with"),
        "{}",
        told(&refused)
    );

    let board = Served::over_tcp(true, Mishap::None);
    let alone = json(&fly("pushed.toml", &["--port", &board.port, "--yes"]));
    assert!(iae(&alone, "flown") < 1.2 * iae(&calm, "flown"), "{alone}");
    let notes = alone["notes"].to_string();
    assert!(notes.contains("disturbances, events and hardware are left out"), "{notes}");
}
