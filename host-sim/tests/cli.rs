//! The program as people use it: flags, files, exit status.

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

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

#[test]
fn bad_input_is_one_line_and_exit_status_2_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let gains = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let good = "controller = \"backstepping\"\n[pitch]\nposition = 4.2\nrate = 24.6\n[yaw]\nposition = 2.28\nrate = 10.8\n";
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
        (&["tune", "--checkpoint", "c.bin", "--resume"], "c.bin: cannot be read"),
        (&["tune", "--algorithm", "cma"], "did you mean 'cmaes'"),
        (&["simulate", "--export", "flight.xls"], ".parquet, .mcap, .npz or .csv"),
        (&["bench-tuners", "--algorithms", "fpa-paper,psoo"], "did you mean 'pso'"),
        (&["bench-tuners", "--seeds", "1"], "--seeds is 1; allowed: 2 to 10000"),
        (&["bench-tuners", "--evaluations", "0"], "--evaluations is 0"),
        (&["bench-tuners", "--export", "runs.mcap"], ".parquet, .npz or .csv"),
        (&["compare", "--step", "15,0"], "--step is 15,0"),
        (&["compare", "--allowance", "1e9"], "--allowance is 1000000000"),
        (&["compare", "--export", "flights.mcap"], ".parquet, .npz or .csv"),
        (&["tune", "--objective", "robust", "--fidelity", "rig", "--at-most", "overshoot=2"], "--at-most"),
        (&["pareto", "--population", "2"], "--population is 2; allowed: 4 to"),
        (&["reproduce", "--out", "nan.toml"], "which is a file; a folder is needed"),
        (&["identify"], "<LOG.csv>"),
        (&["identify", "nowhere.csv"], "nowhere.csv: cannot be read"),
        (&["identify", "empty.csv"], "empty.csv: is empty"),
        (&["identify", "missing.toml"], "has no column 't'"),
        (&["identify", "empty.csv", "--columns", "roll=x"], "names no column of ours"),
        (&["identify", "empty.csv", "--fix", "thrust"], "--fix names 'thrust'"),
        (&["identify", "empty.csv", "--window", "0"], "--window is 0"),
        (&["identify", "empty.csv", "--out", "no/such/rig.toml"], "no folder 'no/such'"),
        (&["replay", "empty.csv"], "empty.csv: is empty"),
        (&["fly"], "unrecognized subcommand 'fly'"),
    ];
    let before = fs::read_dir(folder.path()).unwrap().count();
    for (args, expected) in cases {
        let output = host_sim(folder.path(), args);
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {told}");
        assert!(told.contains(expected), "{args:?}: {told}");
        assert_eq!(told.trim_end().lines().count(), 1, "{args:?}: {told}");
        assert!(output.stdout.is_empty());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), before, "{args:?} wrote something");
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
        "run.png",
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
    assert_eq!(&fs::read(folder.path().join("run.png")).unwrap()[1..4], b"PNG");
}

#[test]
fn a_preset_and_a_scenario_of_ones_own() {
    let folder = tempfile::tempdir().unwrap();
    let rig = host_sim::rig::to_toml(&twinrotor::plant::presets::AERO2);
    fs::write(folder.path().join("mine.toml"), rig).unwrap();
    let scenario = "duration = 2.0\n[pitch.steps]\njumps = [[0.5, 5.0]]\n[yaw.sine]\namplitude_deg = 10.0\nfrequency = 1.0\n";
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
    let robust = ["tune", "--objective", "robust", "--fidelity", "rig", "--plants", "4", "--population", "8"];
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

/// A flight recorded by `simulate` goes through `identify` and `replay`, and the preset that comes out flies.
#[test]
fn a_recorded_flight_leads_to_a_preset() {
    let folder = tempfile::tempdir().unwrap();
    let columns = "pitch=theta,yaw=psi,v0=v_main,v1=v_tail";
    let rig = ["--preset", "aero-lab", "--fidelity", "rig", "--csv", "run.csv"];
    assert!(host_sim(folder.path(), &[&["simulate"][..], &rig].concat()).status.success());
    let few =
        ["identify", "run.csv", "--columns", columns, "--preset", "aero-lab", "--json", "--window", "1.5"];
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
        &[
            "replay",
            "run.csv",
            "--columns",
            columns,
            "--preset",
            "preset.toml",
            "--scenario",
            "step",
            "--json",
        ],
    );
    assert!(replayed["rate_error"]["pitch"].is_number() && replayed["volts_difference"]["main"].is_number());
}

/// From a short flight to the suggested one, and with both logs the constant that was known worst is known better.
#[test]
fn a_suggested_flight_narrows_what_was_known_worst() {
    let folder = tempfile::tempdir().unwrap();
    let fly = |more: &[&str]| {
        let rig = ["simulate", "--preset", "aero-lab", "--fidelity", "rig"];
        let flown = host_sim(folder.path(), &[&rig[..], more].concat());
        assert!(flown.status.success(), "{}", String::from_utf8_lossy(&flown.stderr));
    };
    let identify = |logs: &[&str], more: &[&str]| {
        let few = ["--columns", "pitch=theta,yaw=psi,v0=v_main,v1=v_tail", "--preset", "aero-lab", "--json"];
        let fix = ["--fix", "effectiveness,quadratic_effectiveness,rotor_time_constant,rotor_reaction"];
        let quick = ["--window", "1.5", "--iterations", "0", "--population", "2"];
        json(folder.path(), &[&["identify"], logs, &few, &fix, &quick, more].concat())
    };
    fly(&["--csv", "run.csv"]);
    let before = identify(&["run.csv"], &["--suggest", "next.toml"]);
    let constant = before["suggestion"].as_str().unwrap().split(':').next().unwrap().to_owned();
    fly(&["--scenario", "next.toml", "--csv", "next.csv"]);
    let after = identify(&["run.csv", "next.csv"], &[]);
    let width = |found: &Value| {
        let all = found["parameters"].as_array().unwrap();
        let worst = all.iter().find(|p| p["name"] == constant.as_str()).unwrap();
        let end = |k: usize| worst["ci95"][k].as_f64();
        end(1).zip(end(0)).map_or(f64::INFINITY, |(most, least)| most - least)
    };
    assert!(width(&after) < 0.8 * width(&before), "{constant}: {} to {}", width(&before), width(&after));
}
