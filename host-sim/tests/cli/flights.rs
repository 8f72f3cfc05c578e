//! A flight that is none ends with exit status 3 and says what happened when, in words and in JSON.

use super::host_sim;
use serde_json::Value;
use std::path::Path;

/// Flies a step of `pitch` degrees on `paper` with the paper's gains: exit status, JSON, standard error.
fn step(folder: &Path, pitch: f64, fidelity: &str) -> (Option<i32>, Value, String) {
    let text = format!("duration = 4.0\n[pitch.steps]\njumps = [[0.5, {pitch}]]\n[yaw.steps]\njumps = []\n");
    std::fs::write(folder.join("far.toml"), text).unwrap();
    let args = ["simulate", "--scenario", "far.toml", "--fidelity", fidelity, "--json"];
    let out = host_sim(folder, &args);
    let json = serde_json::from_slice(&out.stdout).expect("one document, whatever became of the flight");
    (out.status.code(), json, String::from_utf8(out.stderr).unwrap())
}

#[test]
fn a_flight_that_leaves_the_envelope_is_exit_status_3_with_its_moment() {
    let folder = tempfile::tempdir().unwrap();
    let (status, json, told) = step(folder.path(), 35.0, "ideal");
    assert_eq!((status, told.as_str()), (Some(0), ""));
    assert_eq!(json["left_envelope"], Value::Null);

    // The paper's law does not overshoot: it is outside from where it passes 40 degrees on.
    let (status, json, told) = step(folder.path(), 45.0, "ideal");
    assert_eq!(status, Some(3));
    let left = &json["left_envelope"];
    let (tick, time) = (left["tick"].as_u64().unwrap(), left["time"].as_f64().unwrap());
    assert!((500..2_000).contains(&tick) && (time - tick as f64 * 1e-3).abs() < 1e-9);
    assert!(
        told.contains(&format!("left its envelope after {time:.3} s")) && told.lines().count() == 1,
        "{told}"
    );
    assert_eq!(json["board"], Value::Null, "no board flies in the paper's world");
}

#[test]
fn a_flight_that_the_board_ends_says_state_condition_and_moment() {
    let folder = tempfile::tempdir().unwrap();
    let (status, json, told) = step(folder.path(), 10.0, "rig");
    assert_eq!((status, told.as_str()), (Some(0), ""));
    assert_eq!(json["board"]["state"], "armed");
    assert_eq!(json["board"]["condition"], Value::Null);

    let (status, json, told) = step(folder.path(), 120.0, "rig");
    assert_eq!(status, Some(3));
    assert_eq!(json["board"]["state"], "fault");
    assert_eq!(json["board"]["condition"], "AngleEnvelope");
    let cut = json["board"]["time"].as_f64().unwrap();
    assert!(cut > json["left_envelope"]["time"].as_f64().unwrap(), "the rig's envelope is the narrower one");
    assert!(told.contains(&format!("cut the motors after {cut:.3} s: AngleEnvelope")), "{told}");

    let out = host_sim(folder.path(), &["simulate", "--scenario", "far.toml", "--fidelity", "rig"]);
    let table = String::from_utf8(out.stdout).unwrap();
    assert!(table.contains(&format!("board: motors cut at {cut:.3} s")), "{table}");
}

#[test]
fn margins_are_told_in_words_and_in_json() {
    let folder = tempfile::tempdir().unwrap();
    let json = super::json(folder.path(), &["margins", "--preset", "paper", "--json"]);
    let (low, high) = (json["thrust"][0].as_f64().unwrap_or(0.0), json["thrust"][1].as_f64().unwrap());
    assert!(low < 1.0 && high > 1.0 && json["slowest_pole"].as_f64().unwrap() > 0.0);
    let out = host_sim(folder.path(), &["margins", "--preset", "paper"]);
    let table = String::from_utf8(out.stdout).unwrap();
    assert!(out.status.success() && table.contains(&format!("x{high:.2}")), "{table}");
}
