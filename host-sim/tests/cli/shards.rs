//! A comparison in parts: byte for byte that of one run.

use super::host_sim;
use std::fs;
use std::path::Path;
use std::process::Command;

fn gains() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains").display().to_string()
}

fn compared(more: &[&str]) -> Vec<String> {
    let gains = gains();
    let args = ["compare", "--preset", "aero2", "--gains", &gains, "--controllers", "pd", "--plants", "23"];
    args.iter().chain(more).map(ToString::to_string).collect()
}

/// What a run prints, which succeeds and says nothing else.
fn told(folder: &Path, args: &[String]) -> String {
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let ended = host_sim(folder, &args);
    assert!(ended.status.success(), "{args:?}: {}", String::from_utf8_lossy(&ended.stderr));
    assert!(ended.stderr.is_empty());
    String::from_utf8(ended.stdout).unwrap()
}

/// What a run is refused for.
fn refused(folder: &Path, args: &[&str]) -> String {
    let ended = host_sim(folder, args);
    let told = String::from_utf8(ended.stderr).unwrap();
    assert_eq!((ended.status.code(), told.lines().count()), (Some(2), 1), "{args:?}: {told}");
    assert!(ended.stdout.is_empty());
    told
}

fn write_parts(folder: &Path, of: usize, more: &[&str]) -> Vec<String> {
    (1..=of)
        .map(|number| {
            let name = format!("part{number}.bin");
            let shard = [format!("--shard={number}/{of}"), format!("--out={name}")];
            assert_eq!(told(folder, &[compared(more), shard.to_vec()].concat()), "");
            name
        })
        .collect()
}

fn merge(parts: &[String], more: &[&str]) -> Vec<String> {
    let more = more.iter().map(ToString::to_string).collect();
    [vec!["merge".to_owned()], parts.to_vec(), more].concat()
}

#[test]
fn parts_merge_to_the_bytes_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(
        at.join("turn.toml"),
        "duration = 1\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = [[0.1, 9]]\n[hardware]\n\
         noise_counts = [2, 2]\n",
    )
    .unwrap();
    for (of, more) in [(5, &["--scenes", "all", "--allowance", "1.5"][..]), (3, &["--scenario", "turn.toml"])]
    {
        let mut parts = write_parts(at, of, more);
        parts.reverse();
        assert_eq!(told(at, &merge(&parts, &[])), told(at, &compared(more)));
        let one = told(at, &compared(&[more, &["--json"]].concat()));
        assert_eq!(told(at, &merge(&parts, &["--json"])), one);
        assert!(one.contains("\"plants\": 23"));
    }
    let step = ["--allowance", "1"];
    let parts = write_parts(at, 2, &step);
    told(at, &merge(&parts, &["--export", "merged.csv"]));
    told(at, &compared(&[&step[..], &["--export", "one.csv"]].concat()));
    let [merged, one] = ["merged.csv", "one.csv"].map(|name| fs::read_to_string(at.join(name)).unwrap());
    assert_eq!(merged, one);
    assert_eq!(one.lines().count(), 1 + 2 * 23);
}

#[test]
fn what_is_no_whole_is_refused_with_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_parts(at, 3, &["--allowance", "1"]);
    let merge = |parts: &[&str]| refused(at, &[&["merge"], parts].concat());
    assert!(merge(&["part1.bin", "part3.bin"]).contains("there are 2 parts of 3; allowed: all; missing: 2"));
    assert!(merge(&["part1.bin", "part1.bin", "part2.bin"]).contains("are both part 1"));
    let other =
        [compared(&["--allowance", "1", "--seed", "2"]), vec!["--shard=2/3".into(), "--out=o.bin".into()]];
    told(at, &other.concat());
    let told_of = merge(&["part1.bin", "o.bin", "part3.bin"]);
    assert!(told_of.contains("o.bin: belongs to another run: seed is 2 there, 1 here"), "{told_of}");
    let mut bytes = fs::read(at.join("part2.bin")).unwrap();
    bytes[200] ^= 1;
    fs::write(at.join("bad.bin"), bytes).unwrap();
    assert!(merge(&["part1.bin", "bad.bin", "part3.bin"]).contains("bad.bin: is damaged"));
    assert!(merge(&["none.bin"]).contains("none.bin"));
    let wrong: [(&[&str], &str); 4] = [
        (&["--shard", "4/3", "--out", "x.bin"], "allowed: 1/N to N/N"),
        (&["--shard", "1/3"], "--out"),
        (&["--out", "x.bin"], "--shard"),
        (&["--shard", "1/3", "--out", "x.bin", "--json"], "--json"),
    ];
    for (more, what) in wrong {
        let args = compared(more);
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        assert!(refused(at, &args).contains(what), "{more:?}");
    }
    assert!(!at.join("x.bin").exists());
}

/// As docs/cluster.md has it, where Open MPI is installed.
#[test]
fn each_process_of_mpirun_flies_its_part() {
    let installed = Command::new("mpirun").arg("--version").output();
    if !installed.is_ok_and(|told| String::from_utf8_lossy(&told.stdout).contains("Open MPI")) {
        eprintln!("Open MPI is not installed: left out");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let script = format!(
        "exec {} {} --shard $((OMPI_COMM_WORLD_RANK + 1))/$OMPI_COMM_WORLD_SIZE \
         --out part$OMPI_COMM_WORLD_RANK.bin",
        env!("CARGO_BIN_EXE_host-sim"),
        compared(&["--allowance", "1", "--threads", "1"]).join(" ")
    );
    let ended = Command::new("mpirun")
        .args(["--oversubscribe", "-n", "4", "sh", "-c", &script])
        .envs([("OMPI_ALLOW_RUN_AS_ROOT", "1"), ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")])
        .current_dir(at)
        .output()
        .unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let parts: Vec<String> = (0..4).map(|rank| format!("part{rank}.bin")).collect();
    assert_eq!(told(at, &merge(&parts, &[])), told(at, &compared(&["--allowance", "1"])));
}

/// The figure and the page of a comparison are those of its parts, too; a scenario's flights have neither.
#[test]
fn the_page_of_all_parts_is_that_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    told(folder.path(), &compared(&["--plot", "one.svg", "--report", "one"]));
    let parts = write_parts(folder.path(), 2, &[]);
    let merge = |more: &[&str]| {
        let words =
            std::iter::once("merge").chain(parts.iter().map(String::as_str)).chain(more.iter().copied());
        words.map(str::to_owned).collect::<Vec<_>>()
    };
    told(folder.path(), &merge(&["--plot", "all.svg", "--report", "all"]));
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read("one.svg"), read("all.svg"));
    for file in ["index.html", "controllers.csv", "costs.csv", "uses.csv"] {
        assert_eq!(read(&format!("one/{file}")), read(&format!("all/{file}")), "{file}");
    }
    let page = read("one/index.html");
    assert!(page.contains("<h1>Controllers on aero2</h1>") && page.contains("href=costs.csv"));
    assert_eq!(read("one/controllers.csv").lines().count(), 3, "ours, pd and the names above");
    assert!(!page.contains("Scenes beside the step"), "none was flown");
    told(folder.path(), &compared(&["--scenes", "all", "--report", "scenes"]));
    assert!(
        read("scenes/scenes.csv").contains("hot reversals")
            && read("scenes/index.html").contains("--scenes all")
    );
    write_parts(folder.path(), 2, &["--scenario", "step"]);
    let args = merge(&["--plot", "none.svg"]);
    let refusal = refused(folder.path(), &args.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(refusal.contains("--plot") && refusal.contains("its flights have no scores"), "{refusal}");
    assert!(!folder.path().join("none.svg").exists());
}
