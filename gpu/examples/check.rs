//! On a card: are the bits this processor's, and how fast is it? `scripts/gpu-check.sh` runs it. Prints the
//! table of docs/gpu.md; ends with a panic where a bit differs.
//!
//!     check [KERNELS.ptx...]
//!
//! With kernels in files, each against those that it was built with: the same scores, and how fast?

use std::sync::Arc;
use std::time::{Duration, Instant};
use twinrotor::axes::PerAxis;
use twinrotor::bench::Hardware;
use twinrotor::controller::ControllerSettings;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{self, Rig};
use twinrotor::real::Real as _;
use twinrotor::reference::Reference;
use twinrotor::{SAMPLE_TIME, defaults, gains};
use twinrotor_gpu::host::Card;
use twinrotor_gpu::host::cuda::{Cuda, Needs};
use twinrotor_gpu::host::driver::Fault;
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
use twinrotor_tune::robust::{Scenes, Trial, draw};
use twinrotor_tune::search::Problem as _;

/// Plants whose every tick is compared, and those that fly every scene.
const PLANTS: usize = 10_000;
const SCENE_PLANTS: usize = 200;
/// The kernels.
const KERNELS: [&str; 5] = ["robust_usual", "robust_any", "robust_trace", "integral_ideal", "integral_rig"];
/// As many flights as a launch has at most.
const MANY: usize = 1_000_000;

fn main() {
    let card = of(Cuda::find());
    let files: Vec<String> = std::env::args().skip(1).collect();
    if !files.is_empty() {
        return side_by_side(&card, &files);
    }
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    println!("{}; beside it {cores} cores ({})\n", card.name(), twinrotor_sim::lanes::instruction_set());
    needs(&card);
    bits(&card);
    speed(&card);
}

fn of(found: Result<Cuda, Fault>) -> Arc<Card<Cuda>> {
    match found {
        Ok(cuda) => Arc::new(Card::new(cuda)),
        Err(fault) => {
            eprintln!("gpu-check: {fault}");
            std::process::exit(1);
        }
    }
}

/// A million flights of three rigs and of the paper's world with the kernels of each file.
fn side_by_side(card: &Arc<Card<Cuda>>, files: &[String]) {
    println!("steps a second in launches of {MANY} flights\n");
    println!("| kernels | paper | aero2 | aero-lab | ideal |");
    println!("|---|---|---|---|---|");
    let mut known = None;
    let mut row = |what: &str, card: &Arc<Card<Cuda>>| {
        let (mut speeds, mut scores) = (Vec::new(), Vec::new());
        for name in ["paper", "aero2", "aero-lab"] {
            let (_, rig) = presets::ALL.into_iter().find(|(known, _)| *known == name).expect("a preset");
            let trial = Trial::new(&rig, MANY, 3, 4.0).on(Some(Arc::clone(card) as Arc<dyn Device>));
            let before = card.busy();
            let flown = trial.scores_until(&defaults::named(name).expect("every preset has one"), NEVER);
            let steps = MANY as f64 * trial.steps() as f64;
            speeds.push(steps / (card.busy() - before).as_secs_f64());
            scores.push(flown);
        }
        let step = Scenario::named("step").expect("a scenario");
        let objective = Objective::new(Criterion::Ise, &presets::PAPER, &step, Fidelity::Ideal, 1);
        let before = card.busy();
        let costs =
            objective.on(Some(Arc::clone(card) as Arc<dyn Device>)).costs_until(&candidates(MANY), NEVER);
        let steps = MANY as f64 * f64::from(step.last_tick() + 1);
        speeds.push(steps / (card.busy() - before).as_secs_f64());
        assert!(costs.is_some() && card.failure().is_none(), "{what}: {:?}", card.failure());
        let [paper, aero2, lab, ideal] = speeds[..] else { unreachable!("four speeds") };
        println!("| {what} | {paper:.2e} | {aero2:.2e} | {lab:.2e} | {ideal:.2e} |");
        let found = (scores, costs);
        assert!(*known.get_or_insert_with(|| found.clone()) == found, "{what}: other scores");
    };
    row("built in", card);
    for file in files {
        let text = std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{file}: {error}"));
        row(file, &of(Cuda::with(&text)));
    }
}

/// The paper's gains, so many times.
fn candidates(count: usize) -> Vec<Candidate> {
    vec![Candidate { position: gains::PAPER.to_paper_order().to_vec(), bound: f64::INFINITY }; count]
}

fn controllers(name: &str, rig: &Rig) -> Vec<ControllerSettings<f64>> {
    let ours = defaults::named(name).expect("every preset has one");
    CATALOGUE.iter().map(|(_, design)| design(rig)).chain([ours]).collect()
}

/// What each kernel takes of this card, as this driver has translated it.
fn needs(card: &Card<Cuda>) {
    println!("| kernel | registers | local memory, bytes | shared memory of a block | warps at a time |");
    println!("|---|---|---|---|---|");
    for kernel in KERNELS {
        let needs = card.driver().needs(kernel).expect("the kernels are there");
        let Needs { registers, local, shared, warps } = needs;
        println!("| {kernel} | {registers} | {local} | {shared} | {warps} |");
    }
    println!();
}

fn bits(card: &Arc<Card<Cuda>>) {
    let here = Card::new(StandIn::default());
    let mut flights = 0;
    for (name, rig) in presets::ALL {
        let controllers = controllers(name, &rig);
        let plants = draw(&rig, PLANTS, 5);
        for controller in &controllers {
            let settings = Settings::new(&rig, *controller, SAMPLE_TIME).map(f32::from_f64);
            let goal = PerAxis::new(15.0, 40.0).map(f64::to_radians);
            let asked = Some(Reference::at_rest(goal.cast()));
            let batch = Batch {
                rules: Rules { goal, envelope: rig.envelope, disturbance: 1000, end: 2000, hot: false },
                course: &[
                    Change { tick: 0, asked, push: None },
                    Change { tick: 1000, asked: None, push: Some(1.0) },
                ],
                hardware: Hardware::of(&rig, PerAxis::both(0.5)),
                controllers: &[settings],
                plants: &plants,
            };
            let there = card.traces(&batch);
            assert!(there.is_some(), "{:?}", card.failure());
            assert!(there == here.traces(&batch), "{name}: a tick differs with {controller:?}");
            flights += PLANTS;
        }
        let trial = Trial::new(&rig, SCENE_PLANTS, 9, 1.5).flying(Scenes::All);
        let device = trial.clone().on(Some(Arc::clone(card) as Arc<dyn Device>));
        for controller in &controllers {
            let scores = trial.scores_until(controller, NEVER);
            assert!(device.scores_until(controller, NEVER) == scores, "{name}: {controller:?}");
        }
    }
    println!("every tick of {flights} flights has the bits of this processor, all presets and controllers;");
    println!("so have scores and cuts of {SCENE_PLANTS} plants each on all scenes\n");
}

/// A line of the table.
fn line(what: &str, flights: usize, steps: f64, whole: Duration, busy: Duration) {
    let of = |time: Duration| steps / time.as_secs_f64();
    println!("| {what} | {flights} | {:.3} | {:.2e} | {:.2e} |", whole.as_secs_f64(), of(busy), of(whole));
}

fn speed(card: &Arc<Card<Cuda>>) {
    println!("| what | flights | seconds | steps/s in launches | steps/s in all |");
    println!("|---|---|---|---|---|");
    let device = || Some(Arc::clone(card) as Arc<dyn Device>);
    for name in ["paper", "aero2", "aero-lab"] {
        let (_, rig) = presets::ALL.into_iter().find(|(known, _)| *known == name).expect("a preset");
        let ours = defaults::named(name).expect("every preset has one");
        for plants in [1_000, 10_000, 100_000, MANY] {
            let trial = Trial::new(&rig, plants, 3, 4.0).on(device());
            let (begun, before) = (Instant::now(), card.busy());
            assert!(trial.scores_until(&ours, NEVER).is_some(), "{:?}", card.failure());
            let steps = plants as f64 * trial.steps() as f64;
            line(&format!("rig, {name}"), plants, steps, begun.elapsed(), card.busy() - before);
        }
        let trial = Trial::new(&rig, 10_000, 3, 4.0);
        let begun = Instant::now();
        trial.scores(&ours);
        let (steps, time) = (1e4 * trial.steps() as f64, begun.elapsed());
        line(&format!("rig, {name}, this processor"), 10_000, steps, time, time);
    }
    let step = Scenario::named("step").expect("a scenario");
    let objective = || Objective::new(Criterion::Ise, &presets::PAPER, &step, Fidelity::Ideal, 1);
    for count in [50, 10_000, MANY] {
        let all = candidates(count);
        let steps = count as f64 * f64::from(step.last_tick() + 1);
        let (begun, before) = (Instant::now(), card.busy());
        assert!(objective().on(device()).costs_until(&all, NEVER).is_some(), "{:?}", card.failure());
        line("ideal, paper", count, steps, begun.elapsed(), card.busy() - before);
        if count == 10_000 {
            let begun = Instant::now();
            objective().costs(&all);
            line("ideal, paper, this processor", count, steps, begun.elapsed(), begun.elapsed());
        }
    }
    let ours = defaults::AERO2;
    let trial = Trial::new(&presets::AERO2, 4096, 3, 4.0).on(device());
    let generation = vec![(ours, f64::INFINITY); 1551];
    let (begun, before) = (Instant::now(), card.busy());
    assert!(trial.all_below(&generation, NEVER).is_some(), "{:?}", card.failure());
    let flights = 1551 * 4096;
    let steps = flights as f64 * trial.steps() as f64;
    line("1,551 candidates x 4,096 plants, aero2", flights, steps, begun.elapsed(), card.busy() - before);
}
