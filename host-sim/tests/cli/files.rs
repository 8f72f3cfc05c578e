//! Outputs: where they go, what they keep of what was there, and what happens if they cannot be written.

use super::{SMALL, host_sim};
use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

/// A search of a moment, its gains to `out`.
fn tune(folder: &Path, out: &str, more: &[&str]) -> std::process::Output {
    host_sim(folder, &[&["tune", "--horizon", "0.1", "--out", out, "--json"][..], &SMALL, more].concat())
}

/// What a shell makes of `script`, in which `$0` is the program.
fn shell(folder: &Path, script: &str) -> Option<i32> {
    let program = env!("CARGO_BIN_EXE_host-sim");
    Command::new("sh").args(["-c", script, program]).current_dir(folder).status().unwrap().code()
}

#[test]
fn links_are_followed_and_what_belongs_to_a_file_stays() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mode = |name: &str| fs::metadata(at(name)).unwrap().permissions().mode() & 0o777;
    fs::create_dir(at("real")).unwrap();
    fs::write(at("real/old.toml"), "old").unwrap();
    fs::set_permissions(at("real/old.toml"), fs::Permissions::from_mode(0o640)).unwrap();
    fs::write(at("one.toml"), "one").unwrap();
    fs::hard_link(at("one.toml"), at("other.toml")).unwrap();
    symlink("real/old.toml", at("old.toml")).unwrap();
    symlink("real/new.toml", at("new.toml")).unwrap();
    for out in ["old.toml", "new.toml", "one.toml"] {
        assert!(tune(folder.path(), out, &[]).status.success());
    }
    assert!(at("old.toml").is_symlink() && at("new.toml").is_symlink());
    let gains = |name: &str| fs::read_to_string(at(name)).unwrap();
    assert!(
        gains("real/old.toml").contains("[provenance]") && gains("real/new.toml").contains("[provenance]")
    );
    assert_eq!(mode("real/old.toml"), 0o640, "its own permissions");
    assert_eq!(gains("other.toml"), gains("one.toml"), "both names are of one file still");
    assert_eq!(fs::metadata(at("one.toml")).unwrap().nlink(), 2);

    // Only who may give a file away can try this.
    fs::write(at("theirs.toml"), "theirs").unwrap();
    if std::os::unix::fs::chown(at("theirs.toml"), Some(65_534), Some(65_534)).is_ok() {
        assert!(tune(folder.path(), "theirs.toml", &[]).status.success());
        let theirs = fs::metadata(at("theirs.toml")).unwrap();
        assert_eq!((theirs.uid(), theirs.gid()), (65_534, 65_534), "its owner stays");
        assert!(gains("theirs.toml").contains("[provenance]"));
    }

    let small = "tune --horizon 0.1 --population 4 --iterations 0 --json >/dev/null";
    assert_eq!(shell(folder.path(), &format!("umask 077; exec \"$0\" {small} --out private.toml")), Some(0));
    assert_eq!(shell(folder.path(), &format!("umask 002; exec \"$0\" {small} --out shared.toml")), Some(0));
    assert_eq!((mode("private.toml"), mode("shared.toml")), (0o600, 0o664));
}

#[test]
fn descriptors_are_written_to_and_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    symlink("/proc/self/fd/1", at("link.csv")).unwrap();
    for (k, path) in ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1", "link.csv"].iter().enumerate() {
        let script = format!("exec \"$0\" simulate --duration 0.01 --csv {path} > {k}.txt");
        assert_eq!(shell(folder.path(), &script), Some(0), "{path}");
        let told = fs::read_to_string(at(&format!("{k}.txt"))).unwrap();
        assert!(told.starts_with("t,theta") && told.contains("settling"), "{path}: {told}");
    }
    assert!(at("link.csv").is_symlink() && Path::new("/dev/stdout").is_symlink());
    let script = "exec \"$0\" simulate --duration 0.01 --csv /dev/fd/3 3> three.csv > rest.txt";
    assert_eq!(shell(folder.path(), script), Some(0));
    assert_eq!(fs::read_to_string(at("three.csv")).unwrap().lines().count(), 12);
    assert!(!fs::read_to_string(at("rest.txt")).unwrap().contains("t,theta"));
    // A pipe, whose reader goes away before all is written.
    assert_eq!(shell(folder.path(), "\"$0\" simulate --csv /dev/stdout | head -1 > first.txt"), Some(0));
    assert!(fs::read_to_string(at("first.txt")).unwrap().starts_with("t,theta"));
}

/// Where nothing can be written, the search that it would be lost by is not begun: it would take hours.
#[test]
fn an_output_that_cannot_be_written_is_told_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    symlink("round", folder.path().join("round")).unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let long = ["tune", "--iterations", "10000000"];
    let cases: [(&[&str], &str); 8] = [
        (
            &["--out", "/proc/gains.toml", "--plot", "p.svg"],
            "--out is '/proc/gains.toml', which cannot be written",
        ),
        (&["--plot", "/proc/gains.svg"], "--plot is '/proc/gains.svg', which cannot be written"),
        (&["--checkpoint", "/proc/state"], "--checkpoint is '/proc/state', which cannot be written"),
        (&["--checkpoint", "no/state"], "no folder"),
        (&["--out", "file/gains.toml"], "--out is 'file/gains.toml'"),
        (&["--out", "round"], "links go in a circle"),
        (&["--out", "."], "which is a folder"),
        (&["--out", "new/"], "which is a folder"),
    ];
    for (more, expected) in cases {
        let output = host_sim(folder.path(), &[&long[..], more].concat());
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{more:?}: {told}");
        assert!(told.contains(expected) && told.trim_end().lines().count() == 1, "{more:?}: {told}");
    }
    for command in ["pareto", "reproduce"] {
        let output = host_sim(folder.path(), &[command, "--out", "/proc/front"]);
        assert_eq!(output.status.code(), Some(2), "{command}");
    }
}

/// The disk is full when the work is done: what came out is printed and kept, and the rest is written.
#[test]
fn what_cannot_be_written_in_the_end_is_printed_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    symlink("/dev/full", at("full.toml")).unwrap();
    fs::create_dir(at("elsewhere")).unwrap();
    let run = |args: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_host-sim"));
        let args = [&["tune", "--horizon", "0.1", "--plot", "p.svg"][..], &SMALL, args].concat();
        program.args(args).current_dir(folder.path()).env("TMPDIR", at("elsewhere")).output().unwrap()
    };
    let output = run(&["--out", "full.toml"]);
    let (printed, told) =
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.starts_with("error: full.toml: cannot be written: No space left"), "{told}");
    assert!(printed.contains("[provenance]") && at("p.svg").exists(), "{printed}");
    let kept = told.split("it is kept in ").nth(1).expect("a place is named").trim();
    assert!(fs::read_to_string(kept).unwrap().contains("[provenance]"));
    assert!(kept.ends_with(".toml") && Path::new(kept).starts_with(at("elsewhere")), "{kept}");
    let flown = host_sim(folder.path(), &["simulate", "--gains", kept]);
    assert!(flown.status.success());

    // A checkpoint that cannot be written costs no gains; a folder for temporary files that is not there
    // neither.
    symlink("/dev/full", at("full.ck")).unwrap();
    let output = run(&["--out", "g.toml", "--checkpoint", "full.ck", "--resume"]);
    assert_eq!(output.status.code(), Some(2), "a device is no checkpoint to go on from");
    fs::remove_dir_all(at("elsewhere")).unwrap();
    let output = run(&["--out", "full.toml"]);
    let told = String::from_utf8(output.stderr).unwrap();
    let kept = told.split("it is kept in ").nth(1).expect("a place is named").trim();
    assert!(at(kept).exists(), "{told}");
}

#[test]
fn an_output_is_no_input_and_no_other_output() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let gains = twinrotor_sim::gains_file::GainsFile::paper().to_toml();
    let rig = twinrotor_sim::rig::to_toml(&twinrotor::plant::presets::AERO);
    let scenario = "duration = 1.0\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = []\n";
    fs::create_dir(at("front")).unwrap();
    fs::create_dir_all(at("gains/compared/aero")).unwrap();
    let inputs = [
        ("g.toml", gains.as_str()),
        ("r.toml", &rig),
        ("s.toml", scenario),
        ("log.csv", "t,pitch,yaw,v0,v1\n"),
        ("front/07.toml", &gains),
        ("g.hex", &gains),
        ("g.csv", &gains),
        ("r.svg", &rig),
    ];
    for (name, text) in inputs {
        fs::write(at(name), text).unwrap();
    }
    symlink("g.toml", at("link.toml")).unwrap();
    fs::hard_link(at("g.toml"), at("hard.toml")).unwrap();
    let cases: [&[&str]; 18] = [
        &["simulate", "--gains", "g.toml", "--csv", "g.toml"],
        &["simulate", "--gains", "g.toml", "--csv", "./front/../g.toml"],
        &["simulate", "--gains", "link.toml", "--csv", "g.toml"],
        &["simulate", "--gains", "g.toml", "--csv", "hard.toml"],
        &["simulate", "--scenario", "s.toml", "--csv", "s.toml"],
        &["simulate", "--preset", "r.toml", "--csv", "r.toml"],
        &["simulate", "--gains", "g.csv", "--export", "g.csv"],
        &["simulate", "--csv", "new.csv", "--export", "new.csv"],
        &["simulate", "--csv", "new.svg", "--plot", "./new.svg"],
        &["tune", "--out", "x.svg"],
        &["tune", "--out", "z.toml", "--checkpoint", "z.toml"],
        &["tune", "--objective", "robust", "--start", "g.toml", "--out", "g.toml"],
        &["identify", "log.csv", "--preset", "r.toml", "--out", "r.toml"],
        &["identify", "log.csv", "--out", "log.csv"],
        &["identify", "other.csv", "--validate", "log.csv", "--suggest", "log.csv"],
        &["flash", "g.hex", "--preset", "aero", "--image", "g.hex"],
        &["pareto", "--start", "front/07.toml"],
        &["compare", "--controllers", "g.csv,g.toml", "--export", "g.csv"],
    ];
    for args in cases {
        let output = host_sim(folder.path(), args);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {told}");
        let said =
            ["is read as", "is written as", "unknown --controllers"].iter().any(|said| told.contains(said));
        assert!(said && told.trim_end().lines().count() == 1, "{args:?}: {told}");
    }
    for (name, text) in inputs {
        assert_eq!(fs::read_to_string(at(name)).unwrap(), text, "{name}");
    }
    // What many may write to is not refused.
    let twice = ["simulate", "--duration", "0.01", "--csv", "/dev/null", "--json"];
    assert!(host_sim(folder.path(), &twice).status.success());
}

/// Capitals are letters too.
#[test]
fn endings_are_known_in_capitals() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| assert_eq!(host_sim(folder.path(), args).status.code(), Some(0), "{args:?}");
    run(&["simulate", "--duration", "0.01", "--export", "a.CSV", "--plot", "a.SVG"]);
    run(&["flash", "paper", "--preset", "aero", "--image", "a.HEX"]);
    let rig = twinrotor_sim::rig::to_toml(&twinrotor::plant::presets::AERO);
    fs::write(folder.path().join("MINE.TOML"), rig).unwrap();
    run(&["simulate", "--duration", "0.01", "--preset", "MINE.TOML"]);
}
