//! Numbers at the edge of what there is, threads that are refused, readers that are not there.

use super::{SMALL, host_sim};
use std::fs;
use std::path::Path;
use std::process::Command;

/// One below, at and above what a seed and the number of seeds make together.
const LAST_SEEDS: [&str; 3] = ["18446744073709551613", "18446744073709551614", LAST_SEED];

/// The last one, which `reproduce` is run from.
pub(crate) const LAST_SEED: &str = "18446744073709551615";

#[test]
fn the_last_seeds_are_seeds_like_others() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| {
        let output = host_sim(folder.path(), args);
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    };
    for seed in LAST_SEEDS {
        let few = ["--algorithms", "random,fpa-paper", "--seeds", "3", "--evaluations", "8"];
        run(&[&["bench-tuners", "--seed", seed, "--export", "runs.csv"][..], &few].concat());
        let rows = fs::read_to_string(folder.path().join("runs.csv")).unwrap();
        let seeds: Vec<u64> =
            rows.lines().skip(1).map(|row| row.split(',').nth(1).unwrap().parse().unwrap()).collect();
        let first: u64 = seed.parse().unwrap();
        let expected: Vec<u64> = (0..3).map(|k| first.wrapping_add(k)).collect();
        assert_eq!(
            seeds,
            [&expected[..], &expected].concat(),
            "to the last digit, and as many as were asked"
        );
        run(&["compare", "--seed", seed, "--plants", "2", "--allowance", "1", "--controllers", "pid"]);
        run(&["simulate", "--seed", seed, "--duration", "0.1", "--disturbance", "1"]);
        run(&[&["tune", "--seed", seed, "--horizon", "0.1"][..], &SMALL].concat());
    }
}

#[test]
fn a_standard_error_that_takes_nothing_changes_no_status() {
    let folder = tempfile::tempdir().unwrap();
    let status = |args: &[&str]| {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_host-sim"));
        program.args(args).current_dir(folder.path()).stderr(full).output().unwrap().status.code()
    };
    assert_eq!(status(&["simulate", "--preset", "nope"]), Some(2));
    assert_eq!(status(&["simulate", "--no-such-flag"]), Some(2));
    assert_eq!(status(&[]), Some(2));
    assert_eq!(status(&["simulate", "--csv", "/dev/full"]), Some(1));
    assert_eq!(status(&["flash", "paper", "--preset", "paper", "--image", "w.bin"]), Some(0));
    assert!(folder.path().join("w.bin").exists(), "a warning stops nothing");
}

/// A system that allows few threads gets fewer, and the same bytes. Its administrator is allowed everything,
/// so the run is somebody else's where we are that.
#[test]
fn few_threads_are_enough() {
    let folder = tempfile::tempdir().unwrap();
    fs::set_permissions(folder.path(), std::os::unix::fs::PermissionsExt::from_mode(0o777)).unwrap();
    let administrator = std::os::unix::fs::MetadataExt::uid(&fs::metadata("/proc/self").unwrap()) == 0;
    let program = folder.path().join("program");
    fs::copy(env!("CARGO_BIN_EXE_host-sim"), &program).unwrap();
    let run = |limit: Option<&str>, out: &str| {
        let nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"];
        let mut words = if administrator { nobody.to_vec() } else { vec!["env"] };
        words.extend(limit.map(|limit| ["prlimit", limit, "--"]).into_iter().flatten());
        let tune = ["tune", "--horizon", "0.1", "--json", "--threads", "64", "--out", out];
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).arg(&program).args(tune).args(SMALL).current_dir(folder.path());
        let output = command.output().expect("prlimit and setpriv of util-linux");
        assert_eq!(output.status.code(), Some(0), "{limit:?}: {}", String::from_utf8_lossy(&output.stderr));
        fs::read(folder.path().join(out)).unwrap()
    };
    let whole = run(None, "whole.toml");
    for (limit, out) in [("--nproc=1", "1.toml"), ("--nproc=2", "2.toml"), ("--nproc=3", "3.toml")] {
        assert!(run(Some(limit), out) == whole, "{limit}");
    }
    assert!(Path::new(&program).exists());
}
