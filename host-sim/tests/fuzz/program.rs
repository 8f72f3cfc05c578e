//! The program as a whole: command lines and files that are nearly right. Whatever it is given, it ends with
//! one of its exit statuses, and soon; a run that is long because it was asked to be ends when it is told to.

use super::cases;
use super::mutate::{NASTY, mutated, one_of};
use rand::{Rng, RngExt};
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use twinrotor::plant::presets::AERO_LAB;
use twinrotor_sim::rig;
use twinrotor_tune::optimise::Draws;
use twinrotor_tune::parallel;

/// Runs of each test in an ordinary test run: four hundred in all. Ten thousand each found nothing
/// (`TWINROTOR_FUZZ`), so that these look for what a change breaks, which is broken for many of them.
const USUAL: usize = 50;
/// A run that takes longer is told to end.
const LONG: Duration = Duration::from_secs(3);
/// One that does not end by then hangs.
const HANGS: Duration = Duration::from_secs(10);

/// Command lines that are right; words in capitals stand for files that are made for each run.
const SEEDS: [&str; 13] = [
    "simulate --preset RIG --gains GAINS --scenario SCENARIO --duration 0.05 --fidelity rig --csv o.csv",
    "simulate --duration 0.02 --initial 1,2 --disturbance 2 --hold 0.01 --window 0,0.01 --export o.csv",
    "tune --iterations 1 --population 4 --horizon 0.05 --bounds 1,25 --seed 7 --out o.toml --plot o.svg",
    "tune --iterations 1 --population 4 --horizon 0.05 --out o.toml --checkpoint c.ck --resume --json",
    "tune --objective robust --iterations 1 --population 4 --plants 2 --rounds 1 --out o.toml --preset RIG",
    "compare --plants 2 --controllers pid,GAINS --allowance 1 --step 10,20 --seed 3 --gains . --export c.csv",
    "compare --plants 2 --controllers pid --scenario SCENARIO --hot --spread 0.1 --lag-spread 0.2 --gains .",
    "bench-tuners --algorithms random,fpa-paper --seeds 2 --evaluations 4 --export b.csv --plot b.svg",
    "pareto --plants 4 --population 4 --iterations 4 --range 2 --controller pid --out front --preset RIG",
    "identify LOG --preset RIG --iterations 0 --population 2 --window 0.5 --fix mass --out i.toml",
    "replay LOG --preset RIG --gains GAINS --columns pitch=pitch --scenario SCENARIO --plot r.svg",
    "flash GAINS --preset RIG --image o.hex --checked --json",
    "reproduce --seed 18446744073709551615x --out report",
];

/// A file of each kind.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let gains = "controller = \"backstepping\"\n[pitch]\nposition = 4.2\nrate = 24.6\n[yaw]\n\
         position = 2.28\nrate = 10.8\n";
    let scenario = "duration = 0.5\n[pitch.steps]\njumps = [[0.1, 5.0]]\n[yaw.sine]\namplitude_deg = 10.0\n\
         frequency = 1.0\n[disturbance]\nvolts = 1.0\nhold = 0.1\nwindow = [0.1, 0.3]\n[[events.gust]]\n\
         torque = [0.01, 0]\nwindow = [0.1, 0.4]\n[start]\nangle_deg = [1, 2]\n";
    let mut log = String::from("t,pitch,yaw,v0,v1\n");
    for k in 0..150 {
        let t = 0.01 * f64::from(k);
        let volts = if k % 60 < 30 { 6.0 } else { 9.0 };
        let _ = writeln!(log, "{t:.2},{:.5},{:.5},{volts},3", 0.1 * (3.0 * t).sin(), 0.2 * t);
    }
    vec![
        ("GAINS", gains.into()),
        ("SCENARIO", scenario.into()),
        ("RIG", rig::to_toml(&AERO_LAB).into()),
        ("LOG", log.into()),
    ]
}

/// Words that are put into command lines.
const WORDS: [&str; 22] = [
    "--json",
    "--seed",
    "--plot",
    "--out",
    "--csv",
    "-",
    "--",
    "/dev/null",
    "/dev/full",
    "/dev/stdout",
    ".",
    "nowhere/x.svg",
    "o.svg",
    "-h",
    "--threads",
    "1",
    "--resume",
    "--checkpoint",
    "front",
    "--preset",
    "aero",
    "",
];

/// A command line that is nearly right, and the files that it names.
fn spoilt(rng: &mut impl Rng, folder: &Path) -> Vec<String> {
    let line = *one_of(rng, &SEEDS);
    let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
    for _ in 0..rng.random_range(0..3) {
        let at = rng.random_range(1..words.len());
        match rng.random_range(0..5) {
            0 => words[at] = (*one_of(rng, &NASTY)).replace('\0', "%"),
            1 => words[at] = String::from_utf8_lossy(&mutated(rng, words[at].as_bytes())).replace('\0', "%"),
            2 => words.insert(at, (*one_of(rng, &WORDS)).to_owned()),
            3 => drop(words.remove(at)),
            _ => words[at] = (*one_of(rng, &WORDS)).to_owned(),
        }
        if words.len() < 2 {
            break;
        }
    }
    for (name, good) in files() {
        let file = format!("{}.{}", name.to_lowercase(), if name == "LOG" { "csv" } else { "toml" });
        let bytes = if rng.random_range(0..3) == 0 { mutated(rng, &good) } else { good };
        fs::write(folder.join(&file), bytes).unwrap();
        words.iter_mut().for_each(|word| *word = word.replace(name, &file));
    }
    words
}

/// Its exit status; ended by a signal if it takes long.
fn ended(mut child: Child) -> Option<i32> {
    let begun = Instant::now();
    let mut told = false;
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        if !told && begun.elapsed() > LONG {
            told = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success();
        }
        if begun.elapsed() > HANGS {
            child.kill().unwrap();
            child.wait().unwrap();
            return None;
        }
        sleep(Duration::from_millis(4));
    }
}

fn runs(part: usize) {
    let wrong: Vec<String> = parallel::by_index(cases(USUAL), |k| {
        let mut rng = Draws::new(part as u64).of_move(k);
        let folder = tempfile::tempdir().unwrap();
        let words = spoilt(&mut rng, folder.path());
        let errors = folder.path().join("errors");
        let mut program = Command::new(env!("CARGO_BIN_EXE_host-sim"));
        program.args(&words).current_dir(folder.path()).env("TMPDIR", folder.path());
        program.stdin(Stdio::null()).stdout(Stdio::null()).stderr(fs::File::create(&errors).unwrap());
        let status = ended(program.spawn().unwrap());
        let told =
            fs::read(&errors).map(|told| String::from_utf8_lossy(&told).into_owned()).unwrap_or_default();
        let right = matches!(status, Some(0..=3 | 130)) && !told.contains("panicked");
        (!right).then(|| format!("part {part}, case {k}: {words:?}: {status:?}: {told}"))
    })
    .into_iter()
    .flatten()
    .collect();
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), cases(USUAL), wrong.join("\n"));
}

/// A test for each part, so that they run side by side.
macro_rules! parts {
    ($($(#[$mark:meta])? $name:ident $part:literal),*) => {
        $(#[test] $(#[$mark])? fn $name() { runs($part); })*
    };
}

parts!(program_1 1, program_2 2, program_3 3);
parts!(
    #[ignore = "long: more of the same"] program_4 4,
    #[ignore = "long: more of the same"] program_5 5,
    #[ignore = "long: more of the same"] program_6 6,
    #[ignore = "long: more of the same"] program_7 7,
    #[ignore = "long: more of the same"] program_8 8
);
