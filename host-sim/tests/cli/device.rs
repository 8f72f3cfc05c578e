//! `--device`: the same bytes whatever flies, and what is told and kept where a device fails. In place of a
//! card flies what stands in for its driver (`stand-in:LAUNCHES`), with the kernels' own functions.

use super::host_sim;
use serde_json::Value;
use std::fs;
use std::path::Path;

const STAND_IN: &str = "stand-in:1000000";
const TUNE: [&str; 16] = [
    "tune",
    "--objective",
    "robust",
    "--preset",
    "aero2",
    "--scenes",
    "step",
    "--plants",
    "3",
    "--rounds",
    "1",
    "--population",
    "4",
    "--iterations",
    "3",
    "--json",
];

fn gains() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains").display().to_string()
}

/// What came out, without the time that it took.
fn told(folder: &Path, args: &[&str]) -> Value {
    let mut told = super::json(folder, args);
    if let Some(object) = told.as_object_mut() {
        object.remove("wall_s");
    }
    told
}

#[test]
fn compare_gives_the_same_bytes_whatever_flies() {
    let folder = tempfile::tempdir().unwrap();
    let compare = |device: &str, more: &[&str]| {
        let args = ["compare", "--preset", "aero-lab", "--gains", &gains(), "--plants", "6", "--json"];
        let ended = host_sim(folder.path(), &[&args[..], &["--device", device], more].concat());
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
        ended.stdout
    };
    for more in [&["--controllers", "pd,cancelling"][..], &["--controllers", "lqi", "--scenes", "all"]] {
        assert_eq!(compare("cpu", more), compare(STAND_IN, more));
    }
}

/// Also where one of them begins and the other one ends.
#[test]
fn a_search_gives_the_same_gains_whatever_flies_each_half_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let tune = |device: &str, out: &str, more: &[&str]| {
        let told = told(folder.path(), &[&TUNE[..], &["--device", device, "--out", out], more].concat());
        (told, fs::read(folder.path().join(out)).unwrap())
    };
    let here = tune("cpu", "cpu.toml", &[]);
    assert_eq!(tune(STAND_IN, "device.toml", &[]), here);
    // Two generations on the device, which is lost then; this processor goes on.
    let begun =
        [&TUNE[..], &["--device", "stand-in:2", "--out", "half.toml", "--checkpoint", "c.bin"]].concat();
    let lost = host_sim(folder.path(), &begun);
    let why = String::from_utf8(lost.stderr).unwrap();
    assert_eq!(lost.status.code(), Some(1), "{why}");
    assert!(
        why.contains("the CUDA device failed: unplugged; the best of ") && why.contains("--resume"),
        "{why}"
    );
    assert!(folder.path().join("half.toml").exists(), "the best so far is kept");
    let resumed = tune("cpu", "whole.toml", &["--checkpoint", "c.bin", "--resume"]);
    assert_eq!(resumed.1, here.1);
}

#[test]
fn a_device_that_is_not_there_or_is_lost_is_one_line_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let gains = gains();
    let compare = ["compare", "--gains", &gains, "--plants", "4", "--controllers", "pd", "--export", "f.csv"];
    let lost = "the CUDA device failed: unplugged; nothing is written; --device cpu gives the same bytes";
    let cases = [
        ("stand-in:0", 1, lost),
        ("cuda", 1, "--device cuda: "),
        ("gpu", 2, "invalid value 'gpu' for '--device <NAME>': allowed: cpu, cuda"),
    ];
    for (device, status, expected) in cases {
        let ended = host_sim(folder.path(), &[&compare[..], &["--device", device]].concat());
        let why = String::from_utf8(ended.stderr).unwrap();
        // Where there is a card, it flies.
        if device == "cuda" && ended.status.success() {
            fs::remove_file(folder.path().join("f.csv")).unwrap();
            continue;
        }
        assert_eq!(ended.status.code(), Some(status), "{device}: {why}");
        assert!(why.contains(expected) && ended.stdout.is_empty(), "{device}: {why}");
        assert!(!folder.path().join("f.csv").exists());
    }
}

/// The paper's search, and one whose flights push the rig about.
#[test]
fn an_integral_is_searched_for_with_the_same_bytes_whatever_flies() {
    let folder = tempfile::tempdir().unwrap();
    for more in
        [&["--algorithm", "fpa-paper"][..], &["--fidelity", "rig", "--scenario", "1", "--horizon", "2"]]
    {
        let tune = |device: &str, out: &str| {
            let args = ["tune", "--population", "20", "--iterations", "3", "--json", "--out", out];
            let told = told(folder.path(), &[&args[..], &["--device", device], more].concat());
            (told, fs::read(folder.path().join(out)).unwrap())
        };
        assert_eq!(tune(STAND_IN, "device.toml"), tune("cpu", "cpu.toml"));
    }
}

#[test]
fn a_front_is_the_same_whatever_flies_and_kept_where_a_device_fails() {
    let folder = tempfile::tempdir().unwrap();
    let pareto = |device: &str, out: &str| {
        let args =
            ["pareto", "--plants", "4", "--population", "6", "--iterations", "4", "--json", "--out", out];
        host_sim(folder.path(), &[&args[..], &["--device", device]].concat())
    };
    let here = pareto("cpu", "here");
    assert!(here.status.success(), "{}", String::from_utf8_lossy(&here.stderr));
    assert_eq!(pareto(STAND_IN, "there").stdout, here.stdout);
    let lost = pareto("stand-in:1", "lost");
    let why = String::from_utf8(lost.stderr).unwrap();
    assert_eq!(lost.status.code(), Some(1), "{why}");
    assert!(why.contains("unplugged; the front after 6 evaluations is in lost"), "{why}");
    assert!(folder.path().join("lost/front.csv").exists());
}

/// Nobody waits for a card where the processor is faster without being told so.
#[test]
fn too_few_flights_for_a_device_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let compare = |device: &str| {
        let gains = gains();
        let args = ["compare", "--gains", &gains, "--plants", "4", "--controllers", "pd", "--device", device];
        String::from_utf8(host_sim(folder.path(), &args).stdout).unwrap()
    };
    let (here, there) = (compare("cpu"), compare(STAND_IN));
    let note = there.strip_prefix(&here).expect("beside the note it is the same");
    assert!(note.starts_with("note: 4 flights go to the card at once; with fewer than about "), "{note}");
}
