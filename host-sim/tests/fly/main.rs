//! `fly` as people use it: the same flight at a simulated board, over TCP and at a pseudo-terminal, and what
//! comes of bad luck: a sentence, an exit status, and never a motor left turning.

mod befalls;
#[cfg(feature = "formats")]
mod records;
mod served;
#[cfg(target_os = "linux")]
mod terminal;

use serde_json::Value;
use served::{Mishap, Served};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn fly(folder: &Path, args: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_host-sim");
    Command::new(program).arg("fly").args(args).current_dir(folder).output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", told(output)))
}

/// On each line the same steps, and the host's own flight of the ticks that the frames name, bit for bit.
#[test]
fn the_same_flight_is_flown_at_a_simulated_board_over_tcp_and_at_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let mut boards = vec![(Served::over_tcp(true, Mishap::None), "tcp://")];
    #[cfg(unix)]
    boards.push((Served::at_a_terminal(), "/dev/"));
    let reference = json(&fly(folder.path(), &["--json"]));
    let steps = |document: &Value| -> Vec<String> {
        let steps = document["steps"].as_array().unwrap().iter();
        steps.map(|step| step["step"].as_str().unwrap().to_owned()).collect()
    };
    assert!(reference["verified_ticks"].as_u64().unwrap() > 6_000, "{reference}");
    for (board, kind) in boards {
        assert!(board.port.starts_with(kind), "{}", board.port);
        let output = fly(folder.path(), &["--port", &board.port, "--yes", "--verify", "--json"]);
        assert!(output.status.success(), "{kind}: {}", told(&output));
        let document = json(&output);
        assert_eq!(steps(&document), steps(&reference), "{kind}");
        assert!(document["verified_ticks"].as_u64().unwrap() > 6_000, "{kind}: {document}");
        assert_eq!(document["lost_ticks"], 0, "{kind}");
        let ise = |document: &Value| document["flown"]["pitch"]["ise"].as_f64().unwrap();
        assert!((ise(&document) / ise(&reference) - 1.0).abs() < 0.02, "{kind}");
        assert!(!board.turns(), "{kind}");
    }
}

#[test]
fn a_board_from_the_bag_is_written_checked_and_flown_and_its_record_is_read_without_columns() {
    let folder = tempfile::tempdir().unwrap();
    let board = Served::over_tcp(false, Mishap::None);
    let args = ["--port", &board.port, "--yes", "--record", "first.csv", "--plot", "first.svg"];
    let refused = fly(folder.path(), &args);
    assert_eq!(refused.status.code(), Some(1), "{}", told(&refused));
    assert!(told(&refused).contains("does not have the parameters that are asked for"));
    assert!(!board.turns());
    let board = Served::over_tcp(false, Mishap::None);
    let args = ["--port", &board.port, "--yes", "--write", "--record", "first.csv", "--plot", "first.svg"];
    let output = fly(folder.path(), &args);
    assert!(output.status.success(), "{}", told(&output));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        text.contains("both motors turn the rig as they should") && text.contains("flown less"),
        "{text}"
    );
    assert!(fs::read_to_string(folder.path().join("first.svg")).unwrap().contains("<svg"));
    assert!(!board.turns());
    let program = env!("CARGO_BIN_EXE_host-sim");
    let replay = Command::new(program)
        .args(["replay", "first.csv", "--preset", "aero2", "--json"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(replay.status.success(), "{}", told(&replay));
    assert!(json(&replay)["rate_error"]["pitch"].as_f64().unwrap() < 0.05);
}

/// How much differs comes first, then a few values, all of them with `--verbose` or in JSON.
#[test]
fn what_a_board_has_otherwise_is_summed_up() {
    let folder = tempfile::tempdir().unwrap();
    let run = |more: &[&str]| {
        let board = Served::over_tcp(true, Mishap::None);
        let args = ["--port", &board.port, "--yes", "--preset", "heli"];
        let output = fly(folder.path(), &[&args[..], more].concat());
        assert_eq!(output.status.code(), Some(1), "{}", told(&output));
        assert!(!board.turns());
        output
    };
    let document = json(&run(&["--json"]));
    let all = document["differs"].as_array().unwrap().len();
    assert!(all > 30, "{document}");
    let lines = |output: Output| -> Vec<String> {
        let text = String::from_utf8(output.stdout).unwrap();
        text.lines().filter_map(|line| Some(line.split_once("differs")?.1.trim().to_owned())).collect()
    };
    let few = lines(run(&[]));
    assert!(
        few[0].starts_with(&format!("{all} of ")) && few[0].contains(" of settings.controller"),
        "{few:?}"
    );
    assert_eq!(few.len(), 8, "{few:?}");
    assert_eq!(few[6], format!("and {} more, which --verbose and --json tell", all - 5));
    assert!(few[7].starts_with("--write puts what is asked for"), "{few:?}");
    assert_eq!(lines(run(&["--verbose"])).len(), all + 2);
}

/// What is told to be typed next is of the port, preset, gains and board that were given.
#[test]
fn the_next_step_after_flash_is_at_the_same_port() {
    let folder = tempfile::tempdir().unwrap();
    let own = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains").join(name);
    fs::copy(own("aero2.toml"), folder.path().join("my gains.toml")).unwrap();
    let board = Served::over_tcp(true, Mishap::None);
    let port = board.port.clone();
    let program = env!("CARGO_BIN_EXE_host-sim");
    let flash = Command::new(program)
        .args(["flash", "my gains.toml", "--port", &board.port, "--board", "nucleo-f446"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(flash.status.success() && !board.turns(), "{}", told(&flash));
    let text = String::from_utf8(flash.stdout).unwrap();
    let next = text.lines().find_map(|line| line.strip_prefix("next: ")).unwrap();
    let rest = "--preset aero2 --gains 'my gains.toml' --board nucleo-f446";
    assert_eq!(next, format!("{program} fly --port {port} {rest}"));
}

/// Each with its exit status and its sentence.
#[test]
fn bad_luck_is_told_and_leaves_no_motor_turning() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        (Mishap::Silent, 1, "did not answer within 3 s"),
        (Mishap::Echo, 1, "hands back what is sent to it"),
        (Mishap::Old, 1, "update the board's firmware"),
        (Mishap::Flood, 1, "that are no messages"),
        (Mishap::Drown, 1, "has fallen silent; Disarm was sent again and again, and the board was NOT seen"),
        (Mishap::Mute, 1, "has fallen silent; Disarm was sent again and again, and the board was NOT seen"),
        (Mishap::Cut, 1, "was NOT seen to switch its motors off"),
        (Mishap::Reset, 3, "the board was reset"),
        (Mishap::HangUp, 1, "the line to the board failed"),
    ];
    for (mishap, status, sentence) in cases {
        let board = Served::over_tcp(true, mishap);
        let output = fly(folder.path(), &["--port", &board.port, "--yes", "--json"]);
        assert_eq!(output.status.code(), Some(status), "{mishap:?}: {}", told(&output));
        assert!(told(&output).contains(sentence), "{mishap:?}: {}", told(&output));
        assert!(!board.turns(), "{mishap:?}");
    }
    let halves = Served::over_tcp(true, Mishap::Halves);
    let output = fly(folder.path(), &["--port", &halves.port, "--yes", "--json"]);
    assert!(output.status.success(), "{}", told(&output));
    assert!(json(&output)["lost_ticks"].as_u64().unwrap() > 100);
    assert!(!halves.turns());
}

#[test]
fn what_cannot_be_flown_is_refused_before_anything_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = |name: &str, pitch: &str| {
        let text = format!("duration = 3.0\n{pitch}\n[yaw.steps]\njumps = [[1.0, 20.0]]\n");
        fs::write(folder.path().join(name), text).unwrap();
    };
    scenario("far.toml", "[pitch.steps]\njumps = [[1.0, 80.0]]");
    scenario("fast.toml", "[pitch.sine]\namplitude_deg = 20.0\nfrequency = 40.0");
    let nowhere = "tcp://127.0.0.1:9";
    let cases: &[(&[&str], &str)] = &[
        (&["--scenario", "far.toml"], "after 1.000 s setpoint.angle.pitch is 1.39"),
        (&["--scenario", "fast.toml"], "setpoint.rate.pitch is 13.9"),
        (&["--port", nowhere], "--yes is missing"),
        (&["--port", nowhere, "--yes", "--real-time"], "--real-time has no effect"),
        (&["--accept"], "--trial <FILE>"),
        (&["--save"], "--accept"),
        (&["--trial", "nowhere.toml"], "--trial is 'nowhere.toml'"),
        (&["--record", "flight.xls"], "allowed: a name that ends in .parquet, .mcap, .npz or .csv"),
        (&["--preset", "areo"], "did you mean 'aero'"),
    ];
    for (args, sentence) in cases {
        let output = fly(folder.path(), args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", told(&output));
        assert!(told(&output).contains(sentence), "{args:?}: {}", told(&output));
    }
    let output = fly(folder.path(), &["--port", nowhere, "--yes"]);
    assert_eq!(output.status.code(), Some(1), "{}", told(&output));
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::io::{BufRead, BufReader, Read};
    use std::process::Stdio;

    #[test]
    fn a_full_disk_is_told_after_the_motors_are_off() {
        let folder = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink("/dev/full", folder.path().join("full.csv")).unwrap();
        let board = Served::over_tcp(true, Mishap::None);
        let output = fly(folder.path(), &["--port", &board.port, "--yes", "--record", "full.csv"]);
        assert_eq!(output.status.code(), Some(1));
        assert!(told(&output).contains("full.csv: cannot be written"), "{}", told(&output));
        assert!(String::from_utf8_lossy(&output.stdout).contains("flown less simulated"), "all else is told");
        assert!(!board.turns());
    }

    /// The first program has the port; the second one is told so, and the flight goes on.
    #[test]
    fn a_port_that_another_program_has_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let long = "duration = 20.0\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = []\n";
        fs::write(folder.path().join("long.toml"), long).unwrap();
        let board = Served::at_a_terminal();
        let mut first = Command::new(env!("CARGO_BIN_EXE_host-sim"))
            .args(["fly", "--port", &board.port, "--yes", "--scenario", "long.toml"])
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(first.stdout.take().unwrap());
        let mut shown = String::new();
        while !shown.contains("flying") {
            assert!(lines.read_line(&mut shown).unwrap() > 0, "{shown}");
        }
        let second = fly(folder.path(), &["--port", &board.port, "--yes"]);
        assert_eq!(second.status.code(), Some(1), "{}", told(&second));
        assert!(told(&second).contains("cannot be opened"), "{}", told(&second));
        lines.read_to_string(&mut shown).unwrap();
        assert!(first.wait().unwrap().success(), "{shown}");
        assert!(shown.contains("flown less simulated") && !board.turns(), "{shown}");
    }

    /// Twice, so that the second one does not skip the disarming.
    #[test]
    fn a_signal_ends_the_flight_with_the_motors_off() {
        let folder = tempfile::tempdir().unwrap();
        let long = "duration = 500.0\n[pitch.sine]\namplitude_deg = 5.0\nfrequency = 1.0\n[yaw.steps]\n\
                    jumps = []\n";
        fs::write(folder.path().join("long.toml"), long).unwrap();
        for signal in ["-INT", "-TERM", "-HUP"] {
            let board = Served::over_tcp(true, Mishap::None);
            let mut program = Command::new("env");
            // A hang-up as at a terminal, also where these tests run under `nohup`.
            if cfg!(target_os = "linux") {
                program.arg("--default-signal=HUP");
            }
            let mut program = program
                .args([
                    env!("CARGO_BIN_EXE_host-sim"),
                    "fly",
                    "--port",
                    &board.port,
                    "--yes",
                    "--scenario",
                    "long.toml",
                ])
                .args(["--record", "cut.csv"])
                .current_dir(folder.path())
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
            let mut lines = BufReader::new(program.stdout.take().unwrap());
            let mut shown = String::new();
            while !shown.contains("flying") {
                if lines.read_line(&mut shown).unwrap() == 0 {
                    panic!("{signal}: it ended\n{shown}{}", told(&program.wait_with_output().unwrap()));
                }
            }
            for _ in 0..2 {
                let process = program.id().to_string();
                assert!(Command::new("kill").args([signal, &process]).status().unwrap().success());
            }
            let mut rest = String::new();
            lines.read_to_string(&mut rest).unwrap();
            let output = program.wait_with_output().unwrap();
            assert_eq!(output.status.code(), Some(130), "{signal}: {}", told(&output));
            assert!(told(&output).contains("interrupted"), "{signal}: {}", told(&output));
            // What was flown is kept.
            let kept = fs::read_to_string(folder.path().join("cut.csv")).unwrap();
            assert!(kept.lines().count() > 1_000, "{signal}: {}", kept.lines().count());
            assert!(!board.turns(), "{signal}");
        }
    }
}

/// Another controller, tried between two flights, accepted and saved; taken back where it is not accepted.
#[test]
fn gains_are_tried_in_flight_shown_side_by_side_and_kept_if_that_is_wanted() {
    let folder = tempfile::tempdir().unwrap();
    let gains = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("gains/aero2.toml");
    let text = fs::read_to_string(gains).unwrap();
    let changed = text.lines().map(|line| match line.strip_prefix("position = ") {
        Some(gain) => format!("position = {}", 0.9 * gain.parse::<f64>().unwrap()),
        None => line.to_owned(),
    });
    fs::write(folder.path().join("other.toml"), changed.collect::<Vec<_>>().join("\n")).unwrap();
    let document = json(&fly(folder.path(), &["--trial", "other.toml", "--accept", "--save", "--json"]));
    let steps = document["steps"].as_array().unwrap();
    let told = |name: &str| steps.iter().any(|step| step["step"] == name);
    assert!(told("tried") && told("accepted") && told("saved"), "{document}");
    assert!(document["tried"]["pitch"]["ise"].as_f64() != document["accepted"]["pitch"]["ise"].as_f64());
    assert!(document["verified_ticks"].as_u64().unwrap() > 12_000);
    let text = fly(folder.path(), &["--trial", "other.toml"]).stdout;
    let text = String::from_utf8_lossy(&text);
    assert!(text.contains("reverted") && text.contains("accepted      tried"), "{text}");
    assert!(!text.contains("saved"));
}

/// A board of 100 MHz has fewer steps of the PWM: another flight, and the host's own all the same.
#[test]
fn each_board_flies_with_its_own_pwm() {
    let folder = tempfile::tempdir().unwrap();
    let fly_at = |board: &str| json(&fly(folder.path(), &["--board", board, "--json"]));
    let (f405, feather, f411) = (fly_at("f405"), fly_at("feather-f405"), fly_at("nucleo-f411"));
    assert!([&f405, &feather, &f411].iter().all(|f| f["verified_ticks"].as_u64().unwrap() > 6_000));
    assert_eq!(f405["flown"], feather["flown"]);
    assert_ne!(f405["flown"], f411["flown"]);
    assert_ne!(f405["simulated"], f411["simulated"]);
    let refused = fly(folder.path(), &["--board", "f103"]);
    assert!(
        refused.status.code() == Some(2)
            && told(&refused).contains("f405, feather-f405, f407, black-pill, nucleo-f411,")
    );
}

/// Side by side is told alike: the same gains tried beside themselves come out as they went in. And gains of
/// another rig are told, whichever of the two they are.
#[test]
fn gains_tried_beside_themselves_are_as_good_and_those_of_another_rig_are_told() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let flown = |rig: &str| {
        let gains = "gains/aero2.toml";
        json(&fly(top, &["--preset", rig, "--gains", gains, "--trial", gains, "--json"]))
    };
    let document = flown("aero2");
    for axis in ["pitch", "yaw"] {
        let ise = |which: &str| document[which][axis]["ise"].as_f64().unwrap();
        assert!((ise("tried") / ise("accepted") - 1.0).abs() < 0.05, "{axis}: {document}");
    }
    assert!(!document["notes"].to_string().contains("tuned on"), "{document}");
    let told = flown("rigs/student-aero2.toml")["notes"].to_string();
    let note = "gains/aero2.toml: these gains were tuned on 'aero2', not on 'rigs/student-aero2.toml'";
    assert_eq!(told.matches(note).count(), 2, "{told}");
}

/// A figure shows all that was asked for, also what comes long after the first step has settled.
#[test]
fn a_figure_goes_on_to_the_last_jump() {
    let folder = tempfile::tempdir().unwrap();
    let jumps = "duration = 14.0\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = [[0.5, 10], [11, 0]]\n";
    fs::write(folder.path().join("jumps.toml"), jumps).unwrap();
    let output = fly(folder.path(), &["--scenario", "jumps.toml", "--plot", "jumps.svg"]);
    assert!(output.status.success(), "{}", told(&output));
    let drawn = fs::read_to_string(folder.path().join("jumps.svg")).unwrap();
    assert!(drawn.lines().any(|line| ["12.0", "14.0"].contains(&line.trim())), "the last jump is not drawn");
}
