//! The text that the driver gets, read as it gets it: `scripts/build-ptx.sh` has made it.
//!
//! A card computes what this text says. An operation that rounds otherwise than IEEE 754, or two in one,
//! would be other bits than the board's; state in memory would be slow.

mod machine;

use machine::Machine;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use twinrotor::axes::PerAxis;
use twinrotor::bench::Hardware;
use twinrotor::controller::ControllerSettings;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{self, Rig};
use twinrotor::real::Real as _;
use twinrotor::reference::Reference;
use twinrotor::{SAMPLE_TIME, defaults};
use twinrotor_gpu::host::Card;
use twinrotor_gpu::host::stand_in::StandIn;
use twinrotor_sim::device::{Batch, Change, Device};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::judged::Rules;
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::scenario::Scenario;
use twinrotor_tune::design::CATALOGUE;
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::Candidate;
use twinrotor_tune::parallel::NEVER;
use twinrotor_tune::robust::{Scenes, Trial};
use twinrotor_tune::search::Problem as _;

/// Kernels, in the order of their names.
const KERNELS: [&str; 5] = ["integral_ideal", "integral_rig", "robust_any", "robust_trace", "robust_usual"];

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/ptx/twinrotor.ptx")
}

fn text() -> String {
    let path = path();
    std::fs::read_to_string(&path)
        .unwrap_or_else(|e| panic!("{}: {e}: scripts/build-ptx.sh makes it", path.display()))
}

/// Every instruction without its guard, such as `add.rn.f32`.
fn instructions(text: &str) -> impl Iterator<Item = &str> {
    text.lines()
        .map(|line| line.split("//").next().unwrap_or_default().trim())
        .filter(|line| line.ends_with(';') && !line.starts_with('.'))
        .map(
            |line| {
                if line.starts_with('@') { line.split_once(' ').map_or("", |(_, rest)| rest) } else { line }
            },
        )
        .filter_map(|line| line.trim().split([' ', ';']).next())
}

#[test]
fn every_kernel_is_there_under_its_name() {
    let text = text();
    let mut entries: Vec<&str> = text
        .lines()
        .filter_map(|line| line.split_once(".entry ").map(|(_, name)| name.trim_end_matches('(')))
        .collect();
    entries.sort_unstable();
    assert_eq!(entries, KERNELS);
}

/// IEEE 754 alone: no operation is fused, approximated or flushed to zero, and each that rounds says how.
#[test]
fn every_float_operation_rounds_as_the_boards_do() {
    let text = text();
    let all: Vec<&str> = instructions(&text).collect();
    assert!(all.len() > 1000, "the kernels are not empty");
    for instruction in &all {
        let parts: Vec<&str> = instruction.split('.').collect();
        for other in ["fma", "mad", "approx", "ftz", "sat"] {
            let integer = parts[0] == "mad" && !parts.iter().any(|p| p.starts_with('f'));
            assert!(!parts.contains(&other) || (other == "mad" && integer), "{instruction}");
        }
        let rounds = ["add", "sub", "mul", "div", "sqrt", "rcp"].contains(&parts[0]);
        if rounds && parts.iter().any(|p| *p == "f32" || *p == "f64") {
            assert!(parts.contains(&"rn"), "{instruction}");
        }
    }
    for needed in ["div.rn.f32", "mul.rn.f32", "sqrt.rn.f32"] {
        assert!(all.contains(&needed), "{needed}: rigs have friction, laws divide");
    }
    for never in ["sin", "cos", "ex2", "lg2", "tanh", "rsqrt"] {
        assert!(!all.iter().any(|i| i.split('.').next() == Some(never)), "{never} has other bits");
    }
}

/// A function or kernel of the text: its name and its body.
fn functions(text: &str) -> Vec<(&str, &str)> {
    let bodies = text.split("// -- Begin function ").skip(1);
    bodies.filter_map(|part| part.split_once('\n')).map(|(name, body)| (name.trim(), body)).collect()
}

/// What is called is there, and kernels call nothing.
#[test]
fn nothing_is_left_to_be_linked() {
    let text = text();
    let functions = functions(&text);
    assert!(!text.contains(".extern"));
    for (name, body) in &functions {
        // The name called stands before the parameters, behind what comes back.
        let called: Vec<&str> = body
            .lines()
            .filter(|line| line.trim_start().starts_with("call"))
            .filter_map(|line| line.split([' ', ',', ';', '\t']).find(|part| part.starts_with("_R")))
            .collect();
        let calls = instructions(body).filter(|i| i.split('.').next() == Some("call")).count();
        assert_eq!(called.len(), calls, "{name}");
        assert!(calls == 0 || !KERNELS.contains(name), "{name}: {called:?}");
        for other in called {
            assert!(functions.iter().any(|(known, _)| *known == other), "{name} calls {other}");
        }
    }
}

/// \[bytes\] Memory that is a thread's own: none, state is in registers.
#[test]
fn a_thread_has_no_memory_of_its_own() {
    let text = text();
    let own = |body: &str| -> usize {
        let sizes = body.lines().filter(|line| line.contains("__local_depot") && line.contains(".b8"));
        sizes.map(|line| line.split(['[', ']']).nth(1).map_or(0, |n| n.parse().unwrap_or(usize::MAX))).sum()
    };
    for (name, body) in functions(&text) {
        assert_eq!(own(body), 0, "{name}");
    }
    assert!(text.contains(".target sm_75"));
}

/// Flights of the plants of `trial` to the tick `end`.
fn batch<'a>(trial: &'a Trial, settings: &'a [Settings<f32>], course: &'a [Change], end: u32) -> Batch<'a> {
    let (goal, envelope) = (trial.step, trial.rig.envelope);
    let rules = Rules { goal, envelope, disturbance: end / 2, end, hot: false };
    let hardware = Hardware::of(&trial.rig, PerAxis::both(0.5));
    Batch { rules, course, hardware, controllers: settings, plants: &trial.plants }
}

fn settings(rig: &Rig, controller: ControllerSettings<f64>) -> [Settings<f32>; 1] {
    [Settings::new(rig, controller, SAMPLE_TIME).map(f32::from_f64)]
}

fn named(name: &str) -> ControllerSettings<f64> {
    defaults::named(name).expect("every preset has one")
}

/// What the text makes of flights is what the kernels' functions do: a hash of every tick with every preset,
/// and with every kind of controller.
#[test]
fn the_text_has_the_bits_of_the_functions_in_every_tick() {
    let (card, here) = (Card::new(Machine::new(&text())), Card::new(StandIn::default()));
    for (name, rig) in presets::ALL {
        let trial = Trial::new(&rig, 2, 5, 1.0);
        let rivals = CATALOGUE.iter().filter(|_| name == "aero-lab").map(|(_, design)| design(&rig));
        for controller in rivals.chain([named(name)]) {
            let asked = Some(Reference::at_rest(trial.step.cast()));
            let pushed = Change { tick: 150, asked: None, push: Some(1.0) };
            let course = [Change { tick: 0, asked, push: None }, pushed];
            let settings = settings(&rig, controller);
            let batch = batch(&trial, &settings, &course, 300);
            let hashes = here.traces(&batch);
            assert!(hashes.is_some());
            assert_eq!(card.traces(&batch), hashes, "{name}, {controller:?}");
        }
    }
}

/// Were the text another one, that would be seen.
#[test]
fn another_text_has_other_bits() {
    let (_, rig) = presets::ALL[0];
    let trial = Trial::new(&rig, 1, 5, 1.0);
    let settings = settings(&rig, named(presets::ALL[0].0));
    let course = [Change { tick: 0, asked: Some(Reference::at_rest(trial.step.cast())), push: None }];
    let batch = batch(&trial, &settings, &course, 300);
    let text = text();
    let hashes = |text: &str| Card::new(Machine::new(text)).traces(&batch);
    let (begin, kernel) = text.split_once(".entry robust_trace").expect("the kernel");
    // A sixth of a step, by one in its last place.
    let other = kernel.replace("0f392EC33F", "0f392EC340");
    assert_ne!(other, kernel);
    assert_ne!(hashes(&format!("{begin}.entry robust_trace{other}")), hashes(&text));
}

/// The same of scores and cuts on all scenes.
#[test]
fn the_text_gives_the_scores_of_this_processor() {
    let mut cut = 0;
    for (name, rig) in presets::ALL {
        let mut trial = Trial::new(&rig, 3, 7, 1.1).flying(Scenes::All);
        // Whose tail motor turns the wrong way, a board cuts.
        let thrust = &mut trial.plants[1].plant.effectiveness;
        (thrust.tail_on_yaw, thrust.tail_on_pitch) = (-thrust.tail_on_yaw, -thrust.tail_on_pitch);
        let card = Arc::new(Card::new(Machine::new(&text())));
        let device = trial.clone().on(Some(Arc::clone(&card) as Arc<dyn Device>));
        let rivals = CATALOGUE.iter().filter(|_| name == "aero-lab").map(|(_, design)| design(&rig));
        for controller in rivals.chain([named(name)]) {
            let here = trial.scores(&controller);
            cut += here.iter().filter(|score| score.cut.is_some()).count();
            assert_eq!(device.scores_until(&controller, NEVER), Some(here), "{name}, {controller:?}");
        }
        assert_eq!(card.failure(), None);
    }
    assert!(cut >= 3, "{cut} were cut");
}

/// And of the paper's integral in both worlds, and of where candidates have lost.
#[test]
fn the_text_gives_the_integrals_of_this_processor() {
    for fidelity in [Fidelity::Ideal, Fidelity::Rig] {
        let mut scenario = Scenario::named("1").expect("a scenario");
        scenario.duration = 1.5;
        let objective = || Objective::new(Criterion::Itae, &presets::PAPER, &scenario, fidelity, 3);
        let position = |k: u32| (1..=4).map(|n| 1.0 + f64::from(k * 7 * n % 24)).collect::<Vec<_>>();
        let all =
            |bound: f64| (0..16).map(|k| Candidate { position: position(k), bound }).collect::<Vec<_>>();
        let costs = objective().costs(&all(f64::INFINITY));
        let bounded = all(0.5 * costs.iter().copied().fold(f64::INFINITY, f64::min));
        let card: Arc<dyn Device> = Arc::new(Card::new(Machine::new(&text())));
        let (here, device) = (objective(), objective().on(Some(card)));
        assert_eq!(device.costs(&all(f64::INFINITY)), here.costs(&all(f64::INFINITY)));
        assert_eq!(device.costs(&bounded), here.costs(&bounded));
        assert_eq!(device.effort(), here.effort());
        assert!(here.effort().skipped > 0);
    }
}

/// How many instructions of the text a tick takes, by their lines and names, on average over the second half
/// of a second's flight with a preset's own controller.
fn instructions_of_a_tick(name: &str) -> BTreeMap<(usize, String), f64> {
    let (_, rig) = presets::ALL.into_iter().find(|(known, _)| *known == name).expect("a preset");
    let trial = Trial::new(&rig, 8, 5, 1.0);
    let settings = settings(&rig, named(name));
    let course = [Change { tick: 0, asked: Some(Reference::at_rest(trial.step.cast())), push: None }];
    let flown = |end: u32| {
        let card = Card::new(Machine::new(&text()));
        let mut batch = batch(&trial, &settings, &course, end);
        batch.rules.disturbance = 2000;
        assert!(card.fly(&batch, NEVER).is_some());
        card.driver().executed()
    };
    let (half, mut whole) = (flown(500), flown(1000));
    whole.iter_mut().for_each(|(place, times)| *times -= half[place]);
    whole.into_iter().map(|(place, times)| (place, times as f64 / (8.0 * 500.0))).collect()
}

/// `cargo test -p twinrotor-gpu --features ptx-tests --test ptx a_tick -- --nocapture` prints how many, and
/// leaves beside the text how often each line is executed: `scripts/machine-code.py` reads that.
#[test]
fn a_tick_takes_no_more_instructions_than_it_did() {
    for (name, most, divisions) in [("paper", 1030, 10), ("aero2", 1100, 10), ("aero-lab", 1180, 20)] {
        let executed = instructions_of_a_tick(name);
        let all: f64 = executed.values().sum();
        println!("{name}: {all:.0} instructions of the text a tick");
        let lines: String =
            executed.iter().map(|((line, name), times)| format!("{line} {name} {times}\n")).collect();
        std::fs::write(path().with_file_name(format!("tick.{name}")), lines).expect("beside the text");
        assert!(all <= f64::from(most), "{name}: {all:.1}");
        // A card takes some ten for a division, and many more for one by zero.
        let of = executed.iter().filter(|((_, name), _)| name == "div.rn.f32");
        let divided: f64 = of.map(|(_, times)| times).sum();
        assert!(divided <= f64::from(divisions), "{name}: {divided:.1} divisions");
    }
}
