//! The program as people use it: flags, files, exit status.

mod comparisons;
mod device;
mod files;
mod flights;
mod lies;
mod logs;
mod manual;
mod map;
mod matrices;
#[cfg(unix)]
mod next;
mod panics;
mod recording;
mod reproduced;
mod robust;
mod searches;
mod shards;
mod stopping;
mod worst;

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn host_sim(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_host-sim")).args(args).current_dir(folder).output().unwrap()
}

fn json(folder: &Path, args: &[&str]) -> Value {
    let output = host_sim(folder, args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "progress goes to terminals only");
    serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else")
}

const SMALL: [&str; 4] = ["--population", "12", "--iterations", "3"];

/// Help is for people: no marks of the source, and what an exit status says.
#[test]
fn every_command_has_help_without_marks_of_the_source() {
    let folder = tempfile::tempdir().unwrap();
    let help = |args: &[&str]| String::from_utf8(host_sim(folder.path(), args).stdout).unwrap();
    let all = help(&["--help"]);
    assert!(all.contains("Exit status: 0 done"), "{all}");
    let commands: Vec<&str> =
        all.lines().filter_map(|line| line.strip_prefix("  ")?.split(' ').next()).collect();
    assert!(commands.len() > 12, "{commands:?}");
    for command in
        commands.into_iter().filter(|name| !name.is_empty() && !name.starts_with('-') && *name != "help")
    {
        let told = help(&[command, "--help"]);
        assert!(!told.contains('\\') && told.len() > 100, "{command}: {told}");
    }
}

#[test]
fn bad_input_is_one_line_and_exit_status_2_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let gains = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let good = "controller = \"backstepping\"\n[pitch]\nposition = 4.2\nrate = 24.6\n[yaw]\nposition = \
        2.28\nrate = 10.8\n";
    gains("missing.toml", &good.replace("rate = 10.8\n", ""));
    gains("misspelt.toml", &good.replace("rate = 10.8", "rat = 10.8"));
    gains("negative.toml", &good.replace("10.8", "-10.8"));
    gains("nan.toml", &good.replace("10.8", "nan"));
    gains("empty.csv", "");
    let cases: &[(&[&str], &str)] = &[
        (&["simulate", "--preset", "areo"], "did you mean 'aero'"),
        (&["simulate", "--scenario", "stop"], "did you mean 'step'"),
        (&["tune", "--algorithm", "fpa-papr"], "did you mean 'fpa-paper'"),
        (&["simulate", "--gains", "missing.toml"], "missing field `rate`"),
        (&["simulate", "--gains", "misspelt.toml"], "unknown field `rat`"),
        (&["simulate", "--gains", "negative.toml"], "yaw.rate is -10.8"),
        (&["simulate", "--gains", "nan.toml"], "yaw.rate is NaN"),
        (&["simulate", "--gains", "nowhere.toml"], "no such file"),
        (&["simulate", "--preset", "nowhere.toml"], "nowhere.toml: cannot be read"),
        (&["simulate", "--duration", "-1"], "--duration is -1"),
        (&["simulate", "--duration", "NaN"], "--duration is NaN"),
        (&["simulate", "--duration", "1e9"], "duration is 1000000000"),
        (&["simulate", "--duration", "soon"], "invalid value 'soon'"),
        (&["simulate", "--initial", "1;2"], "--initial is '1;2'"),
        (&["simulate", "--window", "5,1", "--disturbance", "1"], "window's end is 1"),
        (&["simulate", "--hold", "0", "--disturbance", "1"], "--hold is 0"),
        (&["simulate", "--csv", "no/such/folder.csv"], "no folder 'no/such'"),
        (&["simulate", "--plot", "picture.gif"], "ends in .svg or .png"),
        (&["simulate", "--threads", "0"], "--threads is 0"),
        (&["simulate", "--rotor-lag", "inf"], "--rotor-lag is inf"),
        (&["tune", "--population", "0"], "--population is 0"),
        (&["tune", "--bounds", "25,1"], "is 1; allowed: a finite number above 25"),
        (&["tune", "--bounds", "-1,25"], "is -1; allowed: a finite number above 0"),
        (&["tune", "--out", "no/such/gains.toml"], "no folder 'no/such'"),
        (&["tune", "--horizon", "0"], "--horizon is 0"),
        (&["tune", "--time-limit", "-3"], "--time-limit is -3"),
        (&["tune", "--resume"], "--checkpoint"),
        (
            &["tune", "--iterations", "18446744073709551615"],
            "--iterations is 18446744073709551615; allowed: 0 to",
        ),
        (&["tune", "--population", "100", "--iterations", "10000000"], "allowed: 0 to 9999999"),
        (&["tune", "--algorithm", "cma"], "did you mean 'cmaes'"),
        (&["simulate", "--export", "flight.xls"], ".parquet, .mcap, .npz or .csv"),
        (&["bench-tuners", "--algorithms", "fpa-paper,psoo"], "did you mean 'pso'"),
        (&["bench-tuners", "--seeds", "1"], "--seeds is 1; allowed: 2 to 10000"),
        (&["bench-tuners", "--evaluations", "0"], "--evaluations is 0"),
        (&["bench-tuners", "--export", "runs.mcap"], ".parquet, .npz or .csv"),
        (&["compare", "--step", "15,0"], "--step is 15,0"),
        (&["compare", "--allowance", "1e9"], "--allowance is 1000000000"),
        (&["compare", "--spread", "1.5"], "--spread is 1.5; allowed: 0 to 0.9"),
        (&["pareto", "--lag-spread", "-1"], "--lag-spread is -1; allowed: 0 to 0.95"),
        (&["compare", "--scenario", "nowhere"], "unknown scenario 'nowhere'"),
        (&["compare", "--export", "flights.mcap"], ".parquet, .npz or .csv"),
        (&["tune", "--objective", "robust", "--at-most", "overshoot=2"], "unknown --at-most 'overshoot'"),
        (
            &["tune", "--objective", "robust", "--at-most", "failures=-1"],
            "--at-most failures is -1; allowed:",
        ),
        (&["tune", "--objective", "robust", "--parameters", "roll"], "--parameters is 'roll'; allowed:"),
        (&["pareto", "--population", "2"], "--population is 2; allowed: 4 to"),
        (&["simulate", "--csv", "-"], "standard output is /dev/stdout"),
        (&["simulate", "--csv", "new/"], "which is a folder"),
        (&["reproduce", "--out", "nan.toml"], "which is a file; a folder is needed"),
        (&["identify"], "<LOG.csv>"),
        (&["identify", "nowhere.csv"], "nowhere.csv: cannot be read"),
        (&["identify", "empty.csv"], "empty.csv: is empty"),
        (&["identify", "missing.toml"], "has no column 't'"),
        (&["identify", "empty.csv", "--columns", "roll=x"], "names no column of ours"),
        (&["identify", "empty.csv", "--fix", "thrust"], "--fix is 'thrust'; allowed: mass"),
        (&["identify", "empty.csv", "--window", "0"], "--window is 0"),
        (&["identify", "empty.csv", "--out", "no/such/rig.toml"], "no folder 'no/such'"),
        (&["replay", "empty.csv"], "empty.csv: is empty"),
        (&["flie"], "unrecognized subcommand 'flie'"),
    ];
    assert_refused(folder.path(), cases);
}

/// What would not be heeded is refused, and the reason is said.
#[test]
fn a_flag_without_effect_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let robust = |flag: &'static str, value: &'static str| ["tune", "--objective", "robust", flag, value];
    let ise = |flag: &'static str, value: &'static str| ["tune", flag, value];
    let mut cases: Vec<(Vec<&str>, &str)> = Vec::new();
    for (flag, value) in [
        ("--scenario", "3"),
        ("--horizon", "1"),
        ("--bounds", "1,2"),
        ("--plot", "f.svg"),
        ("--fidelity", "ideal"),
    ] {
        cases.push((robust(flag, value).to_vec(), "has no effect with --objective robust"));
    }
    for (flag, value) in [
        ("--controller", "lqr"),
        ("--start", "nowhere.toml"),
        ("--parameters", "yaw"),
        ("--at-most", "overshoot_p95.yaw=0"),
        ("--scenes", "step"),
        ("--plants", "7"),
        ("--spread", ".1"),
        ("--lag-spread", ".1"),
        ("--true-lags", "3"),
        ("--rounds", "2"),
        ("--range", "3"),
    ] {
        cases.push((ise(flag, value).to_vec(), "has no effect without --objective robust"));
    }
    let others: [(&[&str], &str); 12] = [
        (&["simulate", "--hold", "5"], "--hold has no effect without a disturbance"),
        (&["simulate", "--window", "5,2"], "--window has no effect without a disturbance"),
        (&["simulate", "--rotor-lag", ".1"], "--rotor-lag has no effect with --fidelity ideal"),
        (&["bench-tuners", "--plants", "3"], "--plants has no effect with --objective ise"),
        (&["bench-tuners", "--controller", "pid"], "--controller has no effect with --objective ise"),
        (&["simulate", "--true-lag", ".1"], "--true-lag has no effect with --fidelity ideal"),
        (
            &["compare", "--true-lag", ".1", "--lag-spread", ".1"],
            "--lag-spread has no effect with --true-lag",
        ),
        (&["compare", "--true-rig", "aero", "--spread", ".1"], "--spread has no effect with --true-rig"),
        (&["compare", "--hot"], "--scenario <SCENARIO>"),
        (&["pareto", "--start", "g.toml", "--controller", "pid"], "cannot be used with"),
        (&["identify", "log.csv", "--gains", "g.toml"], "--suggest"),
        (&["flash", "paper", "--image", "p.bin", "--chip", "x"], "cannot be used with"),
    ];
    cases.extend(others.map(|(args, expected)| (args.to_vec(), expected)));
    let cases: Vec<(&[&str], &str)> = cases.iter().map(|(args, expected)| (&args[..], *expected)).collect();
    assert_refused(folder.path(), &cases);
}

/// A program without the formats says which line brings them.
#[cfg(not(feature = "formats"))]
#[test]
fn a_format_that_was_left_out_is_named_with_the_line_to_type() {
    let folder = tempfile::tempdir().unwrap();
    assert_refused(
        folder.path(),
        &[
            (&["simulate", "--export", "run.parquet"], "cargo run -p host-sim --features formats"),
            (&["simulate", "--plot", "run.png"], "cargo run -p host-sim --features formats"),
        ],
    );
}

fn assert_refused(folder: &Path, cases: &[(&[&str], &str)]) {
    let before = fs::read_dir(folder).unwrap().count();
    for (args, expected) in cases {
        let output = host_sim(folder, args);
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {told}");
        assert!(told.contains(expected), "{args:?}: {told}");
        assert_eq!(told.trim_end().lines().count(), 1, "{args:?}: {told}");
        assert!(output.stdout.is_empty());
        assert_eq!(fs::read_dir(folder).unwrap().count(), before, "{args:?} wrote something");
    }
}

#[test]
fn a_full_disk_is_exit_status_1() {
    let folder = tempfile::tempdir().unwrap();
    let output = host_sim(folder.path(), &["simulate", "--csv", "/dev/full"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("error: /dev/full: cannot be written"));
}

#[test]
fn tune_writes_gains_that_simulate_flies_to_the_same_cost() {
    let folder = tempfile::tempdir().unwrap();
    let told = json(folder.path(), &[&["tune", "--json", "--out", "mine.toml"][..], &SMALL].concat());
    assert_eq!(told["evaluations"], 48);
    assert!(told["steps_simulated"].as_u64().unwrap() + told["steps_skipped"].as_u64().unwrap() >= 48 * 5001);
    let history = told["history"].as_array().unwrap();
    assert!(history.windows(2).all(|w| w[1][1].as_f64() < w[0][1].as_f64()), "it only ever gets better");
    assert_eq!(history.last().unwrap()[1], told["cost"]);
    let figure = fs::read_to_string(folder.path().join("mine.svg")).unwrap();
    assert!(figure.starts_with("<svg") && figure.contains("pitch θ"));

    let flown = json(folder.path(), &["simulate", "--gains", "mine.toml", "--json"]);
    let ise = flown["pitch"]["ise"].as_f64().unwrap() + flown["yaw"]["ise"].as_f64().unwrap();
    assert_eq!(Some(ise), told["cost"].as_f64());
    // Beside it, what was there before: the paper's gains and the preset's own, each as `simulate` flies it.
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains/paper.toml").display().to_string();
    for (k, gains) in ["paper", &own].into_iter().enumerate() {
        let flown = json(folder.path(), &["simulate", "--gains", gains, "--json"]);
        let ise = flown["pitch"]["ise"].as_f64().unwrap() + flown["yaw"]["ise"].as_f64().unwrap();
        assert_eq!(Some(ise), told["compared"][k]["cost"].as_f64(), "{gains}");
    }
    assert_eq!(told["verdict"], "the tuned gains are the best of these");
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    for algorithm in ["fpa-paper", "fpa-yang", "fpa-demo"] {
        let files: Vec<Vec<u8>> = ["1", "2", "16"]
            .iter()
            .map(|threads| {
                let args = [
                    "tune",
                    "--algorithm",
                    algorithm,
                    "--seed",
                    "5",
                    "--threads",
                    threads,
                    "--out",
                    "g.toml",
                ];
                assert!(host_sim(folder.path(), &[&args[..], &SMALL].concat()).status.success());
                fs::read(folder.path().join("g.toml")).unwrap()
            })
            .collect();
        assert!(files.iter().all(|f| *f == files[0]));
    }
}

#[test]
fn simulate_writes_a_row_a_tick_and_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let args = [
        "simulate",
        "--duration",
        "0.5",
        "--csv",
        "run.csv",
        "--plot",
        if cfg!(feature = "formats") { "run.png" } else { "run.svg" },
        "--scenario",
        "3",
        "--json",
    ];
    let told = json(folder.path(), &args);
    let csv = fs::read_to_string(folder.path().join("run.csv")).unwrap();
    let mut lines = csv.lines();
    assert_eq!(
        lines.next(),
        Some("t,theta,theta_dot,psi,psi_dot,theta_ref,psi_ref,v_main,v_tail,dist_main,dist_tail")
    );
    let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 501);
    assert_eq!((rows[0][0], rows[500][0]), (0.0, 0.5));
    let peak = rows.iter().map(|r| r[7].abs()).fold(0.0, f64::max);
    assert_eq!(Some(peak), told["main"]["peak_volts"].as_f64());
    assert!(rows.iter().all(|r| r.len() == 11 && r[9].abs() <= 2.0));
    if cfg!(feature = "formats") {
        assert_eq!(&fs::read(folder.path().join("run.png")).unwrap()[1..4], b"PNG");
    } else {
        assert!(fs::read_to_string(folder.path().join("run.svg")).unwrap().starts_with("<svg"));
    }
}

#[test]
fn a_preset_and_a_scenario_of_ones_own() {
    let folder = tempfile::tempdir().unwrap();
    let rig = twinrotor_sim::rig::to_toml(&twinrotor::plant::presets::AERO2);
    fs::write(folder.path().join("mine.toml"), rig).unwrap();
    let scenario = "duration = 2.0\n[pitch.steps]\njumps = [[0.5, 5.0]]\n[yaw.sine]\namplitude_deg = \
        10.0\nfrequency = 1.0\n";
    fs::write(folder.path().join("gentle.toml"), scenario).unwrap();
    let told = json(
        folder.path(),
        &["simulate", "--preset", "mine.toml", "--scenario", "gentle.toml", "--fidelity", "rig", "--json"],
    );
    let same = json(
        folder.path(),
        &["simulate", "--preset", "aero2", "--scenario", "gentle.toml", "--fidelity", "rig", "--json"],
    );
    assert_eq!(told["pitch"], same["pitch"]);
    assert!(told["yaw"]["settling_time_2"].is_null(), "a sine has no step to settle on");
}

#[test]
fn methods_are_compared_in_numbers_rows_and_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["bench-tuners", "--algorithms", "fpa-paper,random", "--seeds", "4", "--evaluations", "120"];
    let told =
        json(folder.path(), &[&args[..], &["--json", "--export", "runs.csv", "--plot", "c.svg"]].concat());
    let standings = told["standings"].as_array().unwrap();
    assert_eq!(standings.len(), 2);
    assert!(standings[0]["p_value"].is_null() && standings[1]["p_value"].as_f64().unwrap() <= 1.0);
    assert!(standings.iter().all(|s| s["best"].as_f64() >= told["best_known"].as_f64()));
    let rows = fs::read_to_string(folder.path().join("runs.csv")).unwrap();
    assert!(rows.starts_with("algorithm,seed,cost,x1,x2,x3,x4\nfpa-paper,1,") && rows.lines().count() == 9);
    assert!(fs::read_to_string(folder.path().join("c.svg")).unwrap().contains("evaluations"));
}

/// A step beyond what it was tuned on, a row for each flight, and the numbers of the table from those rows.
#[test]
fn a_comparison_tells_every_flight() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["compare", "--controllers", "pid", "--plants", "5", "--step", "25,60", "--allowance", "2"];
    let told = json(folder.path(), &[&args[..], &["--export", "flights.csv", "--json"]].concat());
    let rows = fs::read_to_string(folder.path().join("flights.csv")).unwrap();
    let rows: Vec<Vec<&str>> = rows.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 1 + 2 * 5);
    let column = rows[0].iter().position(|name| *name == "overshoot_percent_yaw").unwrap();
    for controller in told["controllers"].as_array().unwrap() {
        let own = rows.iter().filter(|row| controller["name"] == row[0]);
        let most = own.map(|row| row[column].parse().unwrap()).fold(0.0_f64, f64::max);
        assert!(controller["overshoot_p95"]["yaw"].as_f64().unwrap() <= most);
    }
}

#[test]
fn a_front_comes_with_the_gains_of_every_point() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["pareto", "--plants", "4", "--population", "8", "--iterations", "4", "--json"];
    let told = json(folder.path(), &args);
    let front = told["front"].as_array().unwrap();
    let chosen = format!("front/{:02}.toml", told["chosen"].as_u64().unwrap());
    assert!(folder.path().join(format!("front/{:02}.toml", front.len())).exists());
    json(folder.path(), &["simulate", "--fidelity", "rig", "--gains", &chosen, "--json"]);
    assert!(fs::read_to_string(folder.path().join("front/front.svg")).unwrap().contains("chosen"));
}
