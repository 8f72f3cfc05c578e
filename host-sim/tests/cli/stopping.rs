//! Signals: each of them ends every command soon, with what it says it keeps and no word of anything else.

use super::{host_sim, json};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// From a signal to the end, on a machine that does other things as well.
const SOON: Duration = Duration::from_secs(3);

/// With a hang-up as it is at a terminal, also where these tests run under `nohup`.
fn start(folder: &Path, words: &[&str]) -> Child {
    let mut program = Command::new("env");
    if cfg!(target_os = "linux") {
        program.arg("--default-signal=HUP");
    }
    program.args(words).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::piped());
    program.spawn().unwrap()
}

fn program<'a>(args: &[&'a str]) -> Vec<&'a str> {
    [&[env!("CARGO_BIN_EXE_host-sim")][..], args].concat()
}

fn send(child: &Child, signal: &str) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

/// Lets it work for a while, sends the signal; its exit status and what it said, which must come soon.
fn stopped(mut child: Child, after: Duration, signal: &str) -> (Option<i32>, String) {
    sleep(after);
    assert_eq!(child.try_wait().unwrap(), None, "it was to be at work still");
    let asked = Instant::now();
    send(&child, signal);
    let output = child.wait_with_output().unwrap();
    assert!(asked.elapsed() < SOON, "{:?}", asked.elapsed());
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

const A_WHILE: Duration = Duration::from_millis(1200);

#[test]
fn every_long_command_ends_soon_and_claims_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let hour =
        "duration = 3600.0\n[pitch.sine]\namplitude_deg = 5.0\nfrequency = 1.0\n[yaw.steps]\njumps = []\n";
    fs::write(folder.path().join("hour.toml"), hour).unwrap();
    let cases: [(&[&str], &str, &str); 9] = [
        (
            &["tune", "--objective", "robust", "--preset", "aero2", "--plants", "3000"],
            "-TERM",
            "no candidate had",
        ),
        (&["tune", "--scenario", "hour.toml", "--iterations", "3000"], "-INT", "no candidate had"),
        (&["compare", "--plants", "30000"], "-INT", "error: interrupted\n"),
        (&["pareto", "--plants", "30000"], "-HUP", "nothing is written"),
        (&["reproduce"], "-TERM", "error: interrupted\n"),
        (&["bench-tuners", "--objective", "robust", "--seeds", "200"], "-HUP", "error: interrupted\n"),
        (
            &["simulate", "--scenario", "hour.toml", "--preset", "aero", "--csv", "run.csv"],
            "-INT",
            "error: interrupted\n",
        ),
        (&["bench"], "-TERM", "error: interrupted\n"),
        (&["coverage", "--preset", "aero2"], "-INT", "error: interrupted\n"),
    ];
    for (args, signal, expected) in cases {
        let (status, told) = stopped(start(folder.path(), &program(args)), A_WHILE / 2, signal);
        assert_eq!(status, Some(130), "{args:?}: {told}");
        // One that had not begun to listen yet says the less.
        let right = told.contains(expected) || told == "error: interrupted\n";
        assert!(right && !told.contains(" is in ") && told.lines().count() == 1, "{args:?}: {told}");
    }
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(
        left.iter().all(|name| ["hour.toml", "front", "report"].contains(&name.to_str().unwrap())),
        "{left:?}"
    );
}

/// What was found is where it is said to be, with the evaluations that were done.
#[test]
fn what_is_kept_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for signal in ["-INT", "-TERM", "-HUP"] {
        let args = ["tune", "--iterations", "1000000", "--checkpoint", "c.ck", "--resume"];
        let (status, told) = stopped(start(folder.path(), &program(&args)), A_WHILE, signal);
        assert_eq!(status, Some(130), "{told}");
        assert!(told.contains("is in gains.toml; --checkpoint c.ck --resume goes on"), "{told}");
        let gains = fs::read_to_string(folder.path().join("gains.toml")).unwrap();
        let evaluations = gains.lines().find_map(|line| line.strip_prefix("evaluations = ")).unwrap();
        assert!(told.contains(&format!("the best of {evaluations} evaluations")), "{told}: {evaluations}");
    }
    let args = ["pareto", "--plants", "4", "--population", "8", "--iterations", "90000"];
    let (status, told) = stopped(start(folder.path(), &program(&args)), 3 * A_WHILE, "-TERM");
    assert_eq!(status, Some(130), "{told}");
    let point = fs::read_to_string(folder.path().join("front/01.toml")).unwrap();
    let evaluations = point.lines().find_map(|line| line.strip_prefix("evaluations = ")).unwrap();
    assert!(told.contains(&format!("the front after {evaluations} evaluations is in front")), "{told}");
    assert!(evaluations.parse::<usize>().unwrap() < 8 * 90_000, "those that were done, not those there were");
}

/// In the middle of a generation or between two: a search that was interrupted ends where it would have.
#[test]
fn an_interrupted_search_goes_on_to_the_same_bytes_with_the_same_command() {
    let folder = tempfile::tempdir().unwrap();
    let robust =
        ["tune", "--objective", "robust", "--plants", "24", "--population", "10", "--iterations", "3"];
    let rest = ["--rounds", "2", "--algorithm", "fpa-adaptive", "--json"];
    let args = |out: &'static str| [&robust[..], &rest, &["--out", out]].concat();
    assert!(host_sim(folder.path(), &args("whole.toml")).status.success());
    let resumed = [&args("parts.toml")[..], &["--checkpoint", "c.ck", "--resume"]].concat();
    let mut interruptions = 0;
    loop {
        let mut child = start(folder.path(), &program(&resumed));
        sleep(Duration::from_millis(300 + 170 * interruptions));
        if child.try_wait().unwrap().is_none() {
            send(&child, "-INT");
        }
        match child.wait().unwrap().code() {
            Some(0) => break,
            code => assert_eq!(code, Some(130)),
        }
        interruptions += 1;
        assert!(interruptions < 100);
    }
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(interruptions > 0 && read("whole.toml") == read("parts.toml"), "{interruptions} interruptions");
    let other = host_sim(folder.path(), &[&resumed[..], &["--seed", "2"]].concat());
    let told = String::from_utf8(other.stderr).unwrap();
    assert_eq!(told, "error: c.ck: belongs to another run: seed is 1 there, 2 here\n");
}

/// A study is the same on any number of threads, and goes on where it was interrupted.
#[test]
fn an_interrupted_study_of_intervals_goes_on_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let short = "duration = 9.0\n[pitch.steps]\njumps = [[1, 20], [5, -15]]\n\
         [yaw.steps]\njumps = [[3, 60], [7, -30]]\n";
    fs::write(folder.path().join("short.toml"), short).unwrap();
    let fix = "effectiveness,quadratic_effectiveness,rotor_time_constant,rotor_reaction";
    let study = ["coverage", "--preset", "aero2", "--rigs", "3", "--scenario", "short.toml", "--fix", fix];
    let quick = ["--window", "1.5", "--population", "2", "--iterations", "0", "--json"];
    let args = |more: &[&'static str]| [&study[..], &quick, more].concat();
    let whole = json(folder.path(), &args(&["--threads", "3"]));
    let resumed = args(&["--threads", "1", "--checkpoint", "rigs.ck", "--resume"]);
    let child = start(folder.path(), &program(&resumed));
    while !folder.path().join("rigs.ck").exists() {
        sleep(Duration::from_millis(5));
    }
    let (status, told) = stopped(child, Duration::ZERO, "-INT");
    assert_eq!(status, Some(130), "{told}");
    assert_eq!(told, "error: interrupted\n");
    assert_eq!(json(folder.path(), &resumed), whole);
    let constants = whole["constants"].as_array().unwrap();
    assert_eq!(constants.len(), 5);
    for constant in constants {
        let number = |name: &str| constant[name].as_f64().unwrap();
        assert!(number("held") <= number("intervals") && number("intervals") <= 3.0, "{constant}");
    }
    let other = host_sim(folder.path(), &[&resumed[..], &["--seed", "2"]].concat());
    let told = String::from_utf8(other.stderr).unwrap();
    assert_eq!(told, "error: rigs.ck: belongs to another run: seed is 1 there, 2 here\n");
}

/// Under `nohup`, which is what long searches are started with, a terminal that is closed ends nothing.
#[test]
fn a_hang_up_that_is_ignored_stays_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let script = "trap '' HUP; exec \"$0\" tune --iterations 1000000";
    let mut child = start(folder.path(), &["sh", "-c", script, env!("CARGO_BIN_EXE_host-sim")]);
    sleep(A_WHILE);
    send(&child, "-HUP");
    sleep(A_WHILE);
    assert_eq!(child.try_wait().unwrap(), None);
    assert_eq!(stopped(child, Duration::ZERO, "-TERM").0, Some(130));
}

/// The folder of a front holds one front, and what else somebody keeps there.
#[test]
fn a_second_front_leaves_no_points_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let search = |population: &str, preset: &str| {
        let few = ["--plants", "4", "--iterations", "4", "--population", population, "--preset", preset];
        json(folder.path(), &[&["pareto", "--json"][..], &few].concat())["front"].as_array().unwrap().len()
    };
    search("12", "aero2");
    let at = |name: &str| folder.path().join("front").join(name);
    fs::write(at("99.toml"), "mine = true\n").unwrap();
    fs::copy(at("01.toml"), at("20.toml")).unwrap();
    let second = search("4", "aero");
    assert!(second < 20, "{second}");
    let points = fs::read_dir(folder.path().join("front")).unwrap();
    let mut points: Vec<String> =
        points.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    points.retain(|name| name.ends_with(".toml"));
    points.sort();
    let expected: Vec<String> =
        (1..=second).map(|k| format!("{k:02}.toml")).chain(["99.toml".into()]).collect();
    assert_eq!(points, expected);
    assert!(fs::read_to_string(at("01.toml")).unwrap().contains("preset = \"aero\""));
}
