//! From a recorded flight to a preset, a replay and the next flight.

use super::{host_sim, json};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// `simulate --log` writes what encoders show, whole counts beside the true angle, in names that `identify`
/// and `replay` read; where there are no encoders there is no log.
#[test]
fn a_log_is_what_a_rig_would_tell() {
    let folder = tempfile::tempdir().unwrap();
    let rig = ["--preset", "aero-lab", "--fidelity", "rig", "--duration", "2", "--scenario", "2"];
    let files = ["--log", "log.csv", "--csv", "truth.csv"];
    assert!(host_sim(folder.path(), &[&["simulate"][..], &rig, &files].concat()).status.success());
    let read = |name: &str| -> Vec<Vec<f64>> {
        let text = std::fs::read_to_string(folder.path().join(name)).unwrap();
        text.lines().skip(1).map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect()
    };
    let (log, truth) = (read("log.csv"), read("truth.csv"));
    assert_eq!((log.len(), truth.len()), (2001, 2001));
    let counts = twinrotor::plant::presets::AERO_LAB.encoder_counts;
    let mut moved = 0;
    for (row, true_row) in log.iter().zip(&truth) {
        // Columns: t, pitch, yaw, v0, v1; t, theta, theta_dot, psi, psi_dot, ..., v_main, v_tail.
        for (shown, angle, a_turn) in [(row[1], true_row[1], counts.pitch), (row[2], true_row[3], counts.yaw)]
        {
            let count = std::f64::consts::TAU / f64::from(a_turn);
            let whole = shown / count;
            assert!((whole - whole.round()).abs() < 1e-3, "{whole} counts");
            assert!((shown - angle).abs() < 1.01 * count, "{shown} shown at {angle}");
            moved += i32::from((shown - angle).abs() > 0.01 * count);
        }
        assert_eq!((row[3], row[4]), (true_row[7], true_row[8]), "the amplifiers give what is sent");
    }
    assert!(moved > 3_000, "{moved} angles that are off by a hundredth of a count");
    let replay = ["replay", "log.csv", "--preset", "aero-lab", "--scenario", "2", "--json"];
    assert!(host_sim(folder.path(), &replay).status.success());
    let ideal = host_sim(folder.path(), &["simulate", "--log", "no.csv"]);
    assert_eq!(ideal.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&ideal.stderr).contains("--log has no effect with --fidelity ideal"));
    assert!(!folder.path().join("no.csv").exists());
}

/// A flight recorded by `simulate` goes through `identify` and `replay`, and the preset that comes out flies.
#[test]
fn a_recorded_flight_leads_to_a_preset() {
    let folder = tempfile::tempdir().unwrap();
    let rig = ["--preset", "aero-lab", "--fidelity", "rig", "--log", "run.csv"];
    assert!(host_sim(folder.path(), &[&["simulate"][..], &rig].concat()).status.success());
    let few = ["identify", "run.csv", "--preset", "aero-lab", "--json", "--window", "1.5"];
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
        &["replay", "run.csv", "--preset", "preset.toml", "--scenario", "step", "--json"],
    );
    assert!(replayed["rate_error"]["pitch"].is_number() && replayed["volts_difference"]["main"].is_number());
    let nowhere = ["replay", "run.csv", "--preset", "preset.toml", "--port", "no-such-port"];
    let refused = host_sim(folder.path(), &nowhere);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--port no-such-port cannot be opened"));
}

/// Each constant stands beside what was believed before, in a table that a screen of 80 columns holds whole.
#[test]
fn what_was_found_stands_beside_the_preset() {
    let folder = tempfile::tempdir().unwrap();
    let rig = ["--preset", "aero-lab", "--fidelity", "rig", "--log", "run.csv"];
    assert!(host_sim(folder.path(), &[&["simulate"][..], &rig].concat()).status.success());
    let identify = |more: &[&str]| {
        let few = ["identify", "run.csv", "--preset", "aero", "--window", "1.5", "--iterations", "0"];
        let fix =
            ["--population", "2", "--fix", "damping,rotor_time_constant,rotor_reaction,coulomb_friction"];
        host_sim(folder.path(), &[&few[..], &fix, more].concat())
    };
    let told: Value = serde_json::from_slice(&identify(&["--json"]).stdout).unwrap();
    let plant = &twinrotor::plant::presets::AERO.plant;
    let of = |name: &str| {
        let all = told["parameters"].as_array().unwrap();
        all.iter().find(|p| p["name"] == name).unwrap().clone()
    };
    assert_eq!(of("stiffness")["preset"].as_f64(), Some(plant.stiffness));
    assert_eq!(of("effectiveness.main_on_pitch")["preset"].as_f64(), Some(plant.effectiveness.main_on_pitch));
    assert_eq!(of("quadratic_effectiveness.main_on_pitch")["preset"], 0.0);

    let told = String::from_utf8(identify(&[]).stdout).unwrap();
    let mut rows = told.lines().filter(|line| line.starts_with('│'));
    assert!(rows.all(|line| line.chars().count() <= 80), "{told}");
    let row = |name: &str| -> Vec<String> {
        let line = told.lines().find(|line| line.trim_start_matches(['│', ' ']).starts_with(name)).unwrap();
        line.replace('│', "").split_whitespace().map(str::to_owned).collect()
    };
    assert_eq!(row("constant"), ["constant", "value", "preset", "change"]);
    let stiffness = row("stiffness");
    let found = of("stiffness")["value"].as_f64().unwrap();
    let change = format!("{:+.1}", 100.0 * (found / plant.stiffness - 1.0));
    assert_eq!(stiffness[2..], [format!("{:.4e}", plant.stiffness), change, "%".to_owned()]);
    assert_eq!(row("quadratic_effectiveness.main_on_pitch")[2..], ["0.0000e0", "from", "0"]);
    // Both parts of a thrust in one number.
    let torque = 10.0 * plant.effectiveness.main_on_pitch;
    assert_eq!(row("main on pitch")[4], format!("{torque:.4e}"));
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
        let few = ["--preset", "aero-lab", "--json"];
        let fix = ["--fix", "effectiveness,quadratic_effectiveness,rotor_time_constant,rotor_reaction"];
        let quick = ["--window", "1.5", "--iterations", "0", "--population", "2"];
        json(folder.path(), &[&["identify"], logs, &few, &fix, &quick, more].concat())
    };
    fly(&["--log", "run.csv"]);
    let before = identify(&["run.csv"], &["--suggest", "next.toml"]);
    let constant = before["suggestion"].as_str().unwrap().split(':').next().unwrap().to_owned();
    fly(&["--scenario", "next.toml", "--log", "next.csv"]);
    let after = identify(&["run.csv", "next.csv"], &[]);
    let width = |found: &Value| {
        let all = found["parameters"].as_array().unwrap();
        let worst = all.iter().find(|p| p["name"] == constant.as_str()).unwrap();
        let end = |k: usize| worst["ci95"][k].as_f64();
        end(1).zip(end(0)).map_or(f64::INFINITY, |(most, least)| most - least)
    };
    assert!(width(&after) < 0.8 * width(&before), "{constant}: {} to {}", width(&before), width(&after));
}

/// docs/identify.md's first log is open loop: whatever the rig does, the volts are the same.
#[test]
fn the_first_log_of_a_rig_without_gains_is_open_loop() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let document = fs::read_to_string(format!("{root}/docs/identify.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for name in ["open-loop.toml", "first-log.toml"] {
        let (_, text) = document.split_once(&format!("cat > {name} <<'END'\n")).expect("it is there");
        fs::write(folder.path().join(name), text.split_once("END\n").unwrap().0).unwrap();
    }
    let columns = |rig: &str| {
        let args = ["simulate", "--preset", "aero2", "--true-rig", rig, "--fidelity", "rig", "--gains"];
        let files = ["open-loop.toml", "--scenario", "first-log.toml", "--csv", "flown.csv"];
        let output = host_sim(folder.path(), &[&args[..], &files[..]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let flown = fs::read_to_string(folder.path().join("flown.csv")).unwrap();
        let mut lines = flown.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let place = ["theta", "psi", "v_main", "v_tail"].map(|name| names.iter().position(|n| *n == name));
        let row =
            |line: &str| place.map(|k| line.split(',').nth(k.unwrap()).unwrap().parse::<f64>().unwrap());
        lines.map(row).collect::<Vec<_>>()
    };
    let (one, other) = (columns("aero2"), columns(&format!("{root}/rigs/student-aero2.toml")));
    assert!(one.iter().zip(&other).all(|(a, b)| a[2..] == b[2..]), "the volts");
    let apart = |k: usize| one.iter().zip(&other).map(|(a, b)| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    assert!(apart(0) > 0.02 && apart(1) > 0.1, "two rigs: {} {}", apart(0), apart(1));
    let most = |k: usize| one.iter().map(|row| row[k].abs()).fold(0.0, f64::max);
    assert!(most(2) < 8.0 && most(3) < 10.0 && most(2) > 4.0, "{} {}", most(2), most(3));
}

/// What a body that is no point adds is found in a log that moves enough, and none of it in that of a body
/// that is one: the truth lies in each interval, and the intervals keep the two apart (docs/rig-law.md, "A
/// body that is no point"). All that such a body shares with others is held, for a test's time.
#[test]
fn a_log_tells_the_terms_of_a_body_that_is_no_point() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).display().to_string();
    let wide = "duration = 20.0\n[pitch.steps]\njumps = [[1, 25], [7, -25], [13, 20], [19, -20]]\n\
                [yaw.steps]\njumps = [[2, 90], [6, -90], [10, 60], [14, -60], [18, 120]]\n";
    fs::write(folder.path().join("wide.toml"), wide).unwrap();
    let tilting = file("rigs/aero2-tilting.toml");
    let terms = [("tilting_inertia", 0.023_188_5), ("rotor_momentum", 7.1e-4)];
    let rest = "damping,stiffness,effectiveness,quadratic_effectiveness,rotor_time_constant,rotor_reaction,\
                coulomb_friction";
    // Believed is the same rig without the two, and with the cosine on its thrust, or without it.
    let text = fs::read_to_string(&tilting).unwrap();
    let lacks = |line: &&str| !terms.iter().any(|(name, _)| line.starts_with(name));
    let believed: Vec<&str> = text.lines().filter(lacks).collect();
    fs::write(folder.path().join("believed.toml"), believed.join("\n")).unwrap();
    for (rig, believed, part) in [(tilting.as_str(), "believed.toml", 1.0), ("aero2", "aero2", 0.0)] {
        let gains = file("gains/aero2.toml");
        let flight = ["simulate", "--preset", "aero2", "--true-rig", rig, "--fidelity", "rig"];
        let more = ["--gains", &gains, "--scenario", "wide.toml", "--log", "wide.csv", "--json"];
        json(folder.path(), &[&flight[..], &more].concat());
        let identify = ["identify", "wide.csv", "--preset", believed, "--fix", rest, "--json"];
        let effort = ["--free", "tilting_inertia,rotor_momentum", "--population", "2", "--iterations", "0"];
        let found = json(folder.path(), &[&identify[..], &effort].concat());
        for (name, whole) in terms {
            let all = found["parameters"].as_array().unwrap();
            let one = all.iter().find(|one| one["name"] == name).unwrap();
            let [low, high] = [0, 1].map(|end| one["ci95"][end].as_f64().unwrap());
            assert!(low <= part * whole && part * whole <= high, "{rig}: {one}");
            assert!(high - low < 0.5 * whole, "{rig}: {one}");
        }
    }
}

/// What nobody has chosen is told in a line, with what chooses it; what was chosen is not.
#[test]
fn the_preset_and_gains_that_are_taken_by_default_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains/aero2.toml").display().to_string();
    let fly = ["simulate", "--preset", "aero2", "--gains", &own, "--fidelity", "rig", "--log", "run.csv"];
    assert!(host_sim(folder.path(), &fly).status.success());
    let told = |args: &[&str]| {
        let output = host_sim(folder.path(), args);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        (text.lines().nth(1).unwrap().to_owned(), text)
    };
    for command in [&["simulate"][..], &["replay", "run.csv"], &["margins"]] {
        let with = |more: &[&str]| told(&[command, more].concat()).0;
        assert_eq!(
            with(&[]),
            "by default: preset paper, the paper's gains; --preset and --gains choose others"
        );
        assert_eq!(
            with(&["--preset", "aero2"]),
            "by default: the paper's gains; --gains chooses others (gains/aero2.toml: its own)"
        );
        assert_eq!(with(&["--gains", "paper"]), "by default: preset paper; --preset chooses another");
        let (_, chosen) = told(&[command, &["--preset", "aero2", "--gains", &own]].concat());
        assert!(!chosen.contains("by default"), "{chosen}");
    }
    let (_, other) = told(&["replay", "run.csv", "--preset", "aero", "--gains", &own]);
    assert!(other.contains("note: these gains were tuned on 'aero2', not on 'aero'"), "{other}");
}
