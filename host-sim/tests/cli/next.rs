//! What a command tells to type next can be typed, and names what the one before was given.

use super::host_sim;
use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
fn the_next_step_that_is_told_goes() {
    let folder = tempfile::tempdir().unwrap();
    let rig = twinrotor_sim::rig::to_toml(&twinrotor::plant::presets::AERO2);
    fs::write(folder.path().join("my rig.toml"), rig).unwrap();
    let scenario = "duration = 2.0\n[pitch.steps]\njumps = [[0.5, 5.0]]\n[yaw.steps]\njumps = []\n";
    fs::write(folder.path().join("small.toml"), scenario).unwrap();
    let next = |args: &[&str], mark: &str, names: &[&str]| {
        let output = host_sim(folder.path(), args);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let line = text.lines().find_map(|line| line.strip_prefix(mark)).unwrap_or_else(|| panic!("{text}"));
        let missing = names.iter().find(|name| !line.contains(**name));
        assert_eq!(missing, None, "{line}");
        let typed = Command::new("sh").args(["-c", line]).current_dir(folder.path()).output().unwrap();
        let told = String::from_utf8_lossy(&typed.stderr).into_owned();
        assert!(typed.status.success(), "{line}: {told}");
    };
    let small = ["--population", "4", "--iterations", "0", "--out", "my gains.toml"];
    let tune = ["tune", "--preset", "my rig.toml", "--scenario", "small.toml", "--fidelity", "rig"];
    let names = ["'my rig.toml'", "'my gains.toml'", "small.toml", "--fidelity rig", "--duration 1"];
    next(&[&tune[..], &["--horizon", "1"], &small].concat(), "fly it:  ", &names);
    let tune = ["tune", "--preset", "my rig.toml", "--objective", "robust", "--plants", "2", "--rounds", "1"];
    let start = Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains/aero2.toml").display().to_string();
    let tuned = [&tune[..], &["--start", &start, "--range", "1.01", "--at-most", "none"], &small].concat();
    next(&tuned, "fly it: ", &["'my rig.toml'", "'my gains.toml'"]);
}
