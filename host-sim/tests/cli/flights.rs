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
    assert!(json["stable"] == true && table.contains("\nstable; slowest pole"), "{table}");
}

/// The plant's matrices have a name and a unit for every row and column, and both forms of them fit.
#[test]
fn margins_give_the_plant_as_matrices() {
    let folder = tempfile::tempdir().unwrap();
    let told = super::json(folder.path(), &["margins", "--preset", "aero2", "--json"]);
    let plant = &told["plant"];
    let size = |of: &serde_json::Value| {
        let rows = of.as_array().unwrap();
        (rows.len(), rows[0].as_array().unwrap().len())
    };
    let names =
        |of: &str| plant[of].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap().to_owned());
    let states: Vec<String> = names("states").collect();
    assert_eq!(states, ["theta", "psi", "theta_dot", "psi_dot", "rotor_main", "rotor_tail"]);
    assert_eq!(plant["states"][3]["unit"], "rad/s");
    assert_eq!(names("inputs").collect::<Vec<_>>(), ["v_main", "v_tail"]);
    assert_eq!(names("outputs").collect::<Vec<_>>(), ["theta", "psi"]);
    assert_eq!(plant["sampled"]["sample_time"], 0.001);
    for (matrix, shape) in [("A", (6, 6)), ("B", (6, 2)), ("C", (2, 6)), ("D", (2, 2))] {
        assert_eq!(size(&plant[matrix]), shape, "{matrix}");
    }
    assert_eq!((size(&plant["sampled"]["A"]), size(&plant["sampled"]["B"])), ((6, 6), (6, 2)));
    // A lag of .16 s: -1/lag, and exp(-.001/.16).
    let (lag, decay) = (&plant["A"][4][4], &plant["sampled"]["A"][4][4]);
    assert!((lag.as_f64().unwrap() + 6.25).abs() < 1e-9, "{lag}");
    assert!((decay.as_f64().unwrap() - (-0.00625_f64).exp()).abs() < 1e-12, "{decay}");
}

/// A hover on `aero2` in the rig's world with its own gains and what `more` says.
fn hover(folder: &Path, more: &str, flags: &[&str]) -> std::process::Output {
    let text = format!("duration = 6.0\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = [[0.5, 40]]\n{more}");
    std::fs::write(folder.join("hover.toml"), text).unwrap();
    let gains = Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains/aero2.toml");
    let given =
        ["simulate", "--preset", "aero2", "--gains", gains.to_str().unwrap(), "--scenario", "hover.toml"];
    host_sim(folder, &[&given, flags].concat())
}

#[test]
fn truth_and_belief_are_two() {
    let folder = tempfile::tempdir().unwrap();
    let rig = twinrotor::plant::presets::AERO2;
    let counts = rig.encoder_counts.map(|counts| 2 * counts);
    let envelope = twinrotor::plant::presets::Envelope { pitch: 0.01, ..rig.envelope };
    let truth = twinrotor::plant::presets::Rig { encoder_counts: counts, envelope, ..rig };
    std::fs::write(folder.path().join("truth.toml"), twinrotor_sim::rig::to_toml(&truth)).unwrap();
    let flags = ["--fidelity", "rig", "--json", "--true-rig", "truth.toml"];
    let out = hover(folder.path(), "", &flags);
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    // Half of the angle, by the encoder's real counts, and a narrower envelope than the board's.
    let error = json["yaw"]["final_error_deg"].as_f64().unwrap();
    assert!((error - 20.0).abs() < 0.3, "{error}");
    assert_eq!(json["true_rig"], "truth.toml");
    assert_eq!(json["envelope"]["allowed_pitch_deg"], Value::from(0.01_f64.to_degrees()));
    assert_eq!(out.status.code(), Some(if json["left_envelope"].is_null() { 0 } else { 3 }));

    let slow = hover(folder.path(), "", &["--fidelity", "rig", "--json", "--true-lag", "0.8"]);
    let quick = hover(folder.path(), "", &["--fidelity", "rig", "--json"]);
    let error = |out: &std::process::Output| {
        serde_json::from_slice::<Value>(&out.stdout).unwrap()["yaw"]["iae"].as_f64().unwrap()
    };
    assert!(error(&slow) > 1.02 * error(&quick), "rotors that lag by more than is believed cost time");
    let out = hover(folder.path(), "", &["--true-lag", "0.4"]);
    let told = String::from_utf8(out.stderr).unwrap();
    assert!(
        out.status.code() == Some(2) && told.contains("--true-lag has no effect with --fidelity ideal"),
        "{told}"
    );
}

#[test]
fn what_befalls_a_rig_is_flown_or_refused_with_its_number() {
    let folder = tempfile::tempdir().unwrap();
    let gust = "[[events.gust]]\nvolts = [0, 3]\nwindow = [3, 5]\n";
    let words = |more: &str| {
        let out = hover(folder.path(), more, &["--fidelity", "rig"]);
        assert_eq!(out.status.code(), Some(0));
        String::from_utf8(out.stdout).unwrap()
    };
    let (calm, gusty) = (words(""), words(gust));
    assert!(
        calm.contains("envelope: kept; pitch up to ") && calm.contains("voltage variation [V/s]"),
        "{calm}"
    );
    assert_ne!(calm, gusty);
    for (more, fidelity, expected) in [
        (
            "[[events.gust]]\nvolts = [70, 0]\nwindow = [3, 5]\n",
            "rig",
            "events.gust[0].volts[0] is 70; allowed: -60 to 60 V",
        ),
        (
            "[hardware]\ndelay = 0.004\n",
            "ideal",
            "hardware of scenario hover.toml has no effect with --fidelity ideal",
        ),
        ("[start]\nhot = true\n", "ideal", "start.hot of scenario"),
    ] {
        let out = hover(folder.path(), more, &["--fidelity", fidelity]);
        let told = String::from_utf8(out.stderr).unwrap();
        assert!(
            out.status.code() == Some(2) && told.contains(expected) && told.lines().count() == 1,
            "{told}"
        );
    }
}

/// Any scenario on drawn plants: what a push costs, what warm motors cost, and that less spread spreads less.
#[test]
fn controllers_are_compared_on_any_scenario_cold_and_hot() {
    let folder = tempfile::tempdir().unwrap();
    let text = "duration = 8\n[pitch.steps]\njumps = [[0.5, 10]]\n[yaw.steps]\njumps = [[0.5, 40]]\n";
    std::fs::write(folder.path().join("far.toml"), text).unwrap();
    let gains = Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains");
    let given = ["compare", "--preset", "aero2", "--gains", gains.to_str().unwrap(), "--plants", "8"];
    let with = |more: &[&str]| super::json(folder.path(), &[&given, more, &["--json"]].concat());
    let flags = ["--scenario", "far.toml", "--controllers", "pid"];
    let (cold, hot) = (with(&flags), with(&[&flags[..], &["--hot"]].concat()));
    let median = |json: &Value, k: usize| json["controllers"][k]["error"]["median"].as_f64().unwrap();
    assert_eq!(cold["controllers"][1]["name"], "pid");
    assert_eq!(cold["controllers"][0]["failures"], 0);
    assert!(median(&hot, 0) > 1.1 * median(&cold, 0), "{hot} {cold}");

    let wide = |spread: &str, lag: &str| {
        let json = with(&[
            "--scenario",
            "far.toml",
            "--controllers",
            "ours",
            "--spread",
            spread,
            "--lag-spread",
            lag,
        ]);
        let error = &json["controllers"][0]["error"];
        error["p95"].as_f64().unwrap() - error["p5"].as_f64().unwrap()
    };
    assert!(wide("0.02", "0.05") < 0.3 * wide("0.3", "0.7"));
}

/// A loop that swings about level says by how much, not only that it does.
#[test]
fn an_unsteady_rig_is_told_with_how_far_off_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let fly = ["fly", "--port", "sim", "--preset", "paper", "--scenario", "step", "--yes"];
    let told = String::from_utf8(host_sim(folder.path(), &fly).stdout).unwrap();
    let line = told.lines().find(|line| line.contains("unsteady")).unwrap_or_else(|| panic!("{told}"));
    assert!(
        line.contains("in 20 s no second within 1.1° of level and 2.9°/s") && line.contains("last "),
        "{line}"
    );
}
