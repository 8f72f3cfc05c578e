//! Numbers, rig files and logs that say other than what is so: refused in one line, or told.

use super::host_sim;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Status and standard error, which is one line where something is refused.
fn refused(folder: &Path, args: &[&str]) -> String {
    let output = host_sim(folder, args);
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{args:?}: {told}");
    assert_eq!(told.trim_end().lines().count(), 1, "{args:?}: {told}");
    told
}

#[test]
fn numbers_that_a_board_cannot_hold_are_refused_where_they_enter() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let still = "[yaw.steps]\njumps = []\n";
    file("huge.toml", &format!("duration = 10\n[pitch.steps]\njumps = [[1, 1e300]]\n{still}"));
    file("three.toml", &format!("duration = 10\n[pitch.steps]\njumps = [[1, 10, 99]]\n{still}"));
    file(
        "hidden.toml",
        &format!("duration = 10\n[pitch.steps]\njumps = [[1, 10], [8, 2]]\nperiod = 4\n{still}"),
    );
    let windows = "[disturbance]\nvolts = 1\nhold = 0.1\nwindow = [1, 2, 6, 7]\n";
    file("windows.toml", &format!("duration = 10\n[pitch.steps]\njumps = []\n{still}{windows}"));
    let gains = |size: &str| {
        format!(
            "controller = \"backstepping\"\n[pitch]\nposition = {size}\nrate = 2\n[yaw]\nposition = 2\nrate \
             = 9\n"
        )
    };
    file("gains.toml", &gains("1e200"));
    file("large.toml", &gains("1e30"));
    let cases: &[(&[&str], &str)] = &[
        (
            &["simulate", "--scenario", "huge.toml"],
            "pitch.jumps: an angle is 1e300; allowed: at most 1e9 in size",
        ),
        (&["simulate", "--scenario", "three.toml"], "jumps[0] is [1, 10, 99]; allowed: a list of 2 numbers"),
        (&["simulate", "--scenario", "windows.toml"], "window is [1, 2, 6, 7]; allowed: a list of 2 numbers"),
        (&["simulate", "--scenario", "hidden.toml"], "pitch.period is 4; allowed: 0 for never, or above 8 s"),
        (&["simulate", "--gains", "gains.toml"], "pitch.position is 1e200; allowed: at most 1e9 in size"),
        (&["simulate", "--gains", "large.toml"], "pitch.position is 1e30; allowed: at most 1e9 in size"),
        (&["tune", "--bounds", "1e20,1e30"], "--bounds is '1e20,1e30'; allowed: two finite numbers"),
        (&["simulate", "--rotor-lag", "1e300"], "--rotor-lag is 1e300; allowed: at most 1e9 in size"),
        (&["simulate", "--rotor-lag", "-1"], "--rotor-lag is -1; allowed: a finite number of at least 0"),
        (&["compare", "--true-lags", "1,0"], "true-lags is 0; allowed: 0.05 to 10 times what is believed"),
        (&["compare", "--true-lag", "-1"], "--true-lag is -1; allowed: a finite number"),
        (&["simulate", "--seed", "-1"], "'--seed <SEED>': allowed: a whole number of at least 0"),
        (&["simulate", "--seed", "99999999999999999999"], "at most 18446744073709551615"),
        (&["tune", "--population", "-5"], "allowed: a whole number of at least 0"),
    ];
    for (args, expected) in cases {
        let told = refused(folder.path(), args);
        assert!(told.contains(expected), "{args:?}: {told}");
    }
}

#[test]
fn a_rig_file_in_another_unit_reaches_no_board() {
    let folder = tempfile::tempdir().unwrap();
    let good = twinrotor_sim::rig::to_toml(&twinrotor::plant::presets::AERO2);
    let cases = [
        ("[envelope.rate]\npitch = 10.0", "[envelope.rate]\npitch = 573.0", "degrees a second"),
        ("[rest_angle]\npitch = 0.0", "[rest_angle]\npitch = -40.5", "degrees"),
        ("[plant.rotor_time_constant]\nmain = 0.16", "[plant.rotor_time_constant]\nmain = 160", "ms"),
        ("[volts_limit]\nmain = 18.0", "[volts_limit]\nmain = 18000.0", "mV"),
        ("nominal_volts = 0.0", "nominal_volts = 10000.0", "mV"),
        ("nominal_volts = 0.0", "nominal_volts = 30.0", "at most volts_limit"),
        ("[rest_angle]\npitch = 0.0", "[rest_angle]\npitch = 0.9", "within ±envelope.pitch"),
    ];
    for (right, wrong, unit) in cases {
        assert!(good.contains(right), "{right} in {good}");
        fs::write(folder.path().join("rig.toml"), good.replace(right, wrong)).unwrap();
        let told =
            refused(folder.path(), &["flash", "paper", "--preset", "rig.toml", "--image", "board.bin"]);
        assert!(told.starts_with("error: rig.toml: ") && told.contains(unit), "{told}");
        assert!(!folder.path().join("board.bin").exists());
    }
}

/// The advice of each refusal, followed, leads to the log as it is: on both axes.
#[test]
fn advice_that_is_followed_leads_to_the_right_scale() {
    let folder = tempfile::tempdir().unwrap();
    let mut counts = String::from("t,pitch,yaw,v0,v1\n");
    let turn = std::f64::consts::TAU;
    for k in 0..300 {
        let t = 0.01 * f64::from(k);
        let (pitch, yaw) = (0.2 * (2.0 * t).sin(), 0.4 * t);
        let volts = if k < 150 { 5.0 } else { 8.0 };
        let (pitch, yaw) = ((pitch * 2048.0 / turn).round(), (yaw * 4096.0 / turn).round());
        let _ = writeln!(counts, "{t},{pitch},{yaw},{volts},2");
    }
    fs::write(folder.path().join("counts.csv"), counts).unwrap();
    let replay = |columns: &str| {
        let args = ["replay", "counts.csv", "--preset", "aero-lab", "--json", "--columns", columns];
        let output = host_sim(folder.path(), &args);
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (status, told) = replay("");
    assert!(status == Some(2) && told.contains("pitch=NAME:counts2048"), "{told}");
    let (status, told) = replay("pitch=pitch:counts2048");
    assert!(status == Some(2) && told.contains("yaw=NAME:counts4096"), "{told}");
    let (status, told) = replay("pitch=pitch:counts2048,yaw=yaw:counts4096");
    assert!(status == Some(0), "{told}");
}
