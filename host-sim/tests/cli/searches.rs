//! Searches that are stopped, killed and resumed.

use super::{host_sim, json};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A search that would take minutes, at work.
fn long_search(folder: &Path, extra: &[&str]) -> std::process::Child {
    let args = ["tune", "--iterations", "100000", "--population", "50", "--json", "--out", "g.toml"];
    Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(args)
        .args(extra)
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

#[test]
fn ctrl_c_ends_promptly_with_the_best_so_far() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = long_search(folder.path(), &[]);
    sleep(Duration::from_millis(1500));
    let asked = Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(asked.elapsed() < Duration::from_secs(10));
    let flown = json(folder.path(), &["simulate", "--gains", "g.toml", "--json"]);
    let ise = flown["pitch"]["ise"].as_f64().unwrap() + flown["yaw"]["ise"].as_f64().unwrap();
    assert!(ise < 0.0811, "{ise}");
}

#[test]
fn a_time_limit_ends_with_the_best_so_far() {
    let folder = tempfile::tempdir().unwrap();
    assert!(long_search(folder.path(), &["--time-limit", "0.5"]).wait().unwrap().success());
    assert!(folder.path().join("g.toml").exists());
}

#[test]
fn a_killed_search_resumes_to_the_bytes_of_an_uninterrupted_one() {
    let folder = tempfile::tempdir().unwrap();
    let run = |extra: &[&str]| {
        let args = ["tune", "--iterations", "400", "--population", "30", "--horizon", "1", "--seed", "9"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
        command.args(args).args(extra).current_dir(folder.path());
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().unwrap()
    };
    assert!(run(&["--out", "whole.toml"]).wait().unwrap().success());

    let checkpointed = ["--out", "parts.toml", "--checkpoint", "state.bin"];
    // However far a run gets before it is cut off, and on however many threads the next one goes on.
    assert!(run(&[&checkpointed[..], &["--time-limit", "0.2"]].concat()).wait().unwrap().success());
    for (threads, wait) in [("1", 150), ("16", 400)] {
        let mut killed = run(&[&checkpointed[..], &["--resume", "--threads", threads]].concat());
        sleep(Duration::from_millis(wait));
        let _ = killed.kill();
        killed.wait().unwrap();
    }
    assert!(run(&[&checkpointed[..], &["--resume"]].concat()).wait().unwrap().success());
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("whole.toml"), read("parts.toml"));

    // What exists is not written over unasked; what is foreign or damaged is refused.
    assert_eq!(run(&checkpointed).wait().unwrap().code(), Some(2));
    let foreign = [&checkpointed[..], &["--resume", "--bounds", "1,24"]].concat();
    assert_eq!(run(&foreign).wait().unwrap().code(), Some(2));
    let mut bytes = read("state.bin");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(folder.path().join("state.bin"), bytes).unwrap();
    assert_eq!(run(&[&checkpointed[..], &["--resume"]].concat()).wait().unwrap().code(), Some(2));
}

#[test]
fn any_method_tunes_and_a_killed_robust_search_resumes_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for algorithm in ["cmaes", "nelder-mead", "fpa-adaptive", "sobol"] {
        let args = ["tune", "--json", "--algorithm", algorithm, "--iterations", "1", "--horizon", "1"];
        let told = json(folder.path(), &args);
        assert_eq!(
            (told["evaluations"].as_u64(), told["diverged"].as_u64()),
            (Some(100), Some(0)),
            "{algorithm}"
        );
    }
    let robust = ["tune", "--objective", "robust", "--scenes", "step", "--plants", "4", "--population", "8"];
    let run = |extra: &[&str]| {
        let args = [&robust[..], &["--iterations", "4", "--rounds", "2", "--seed", "3"], extra].concat();
        host_sim(folder.path(), &args).status.code()
    };
    assert_eq!(run(&["--out", "whole.toml"]), Some(0));
    let parts = ["--out", "parts.toml", "--checkpoint", "state.bin"];
    assert_eq!(run(&[&parts[..], &["--time-limit", "0.05"]].concat()), Some(0));
    assert_eq!(run(&[&parts[..], &["--resume", "--threads", "1"]].concat()), Some(0));
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("whole.toml"), read("parts.toml"));
    assert_eq!(run(&[&parts[..], &["--resume", "--range", "3"]].concat()), Some(2));
}
