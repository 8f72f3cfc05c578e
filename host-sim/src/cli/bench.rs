//! `bench`: closed-loop steps a second on one core.

use super::common::Common;
use super::{print, print_json, tables};
use crate::closed_loop::{BoardLoop, ClosedLoop, Hardware, IdealLoop};
use crate::error::Outcome;
use crate::flight::Fidelity;
use crate::gains_file::GainsFile;
use crate::lanes::{LANES, instruction_set};
use crate::metrics::{Criterion, Integral};
use crate::objective::Objective;
use crate::optimise::Candidate;
use crate::rig::NamedRig;
use crate::scenario::{SAMPLE_TIME, Scenario};
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::gains;
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor::reference::Reference;

/// Flags of `bench`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Serialize)]
struct Document {
    machine: String,
    kernels: Vec<Kernel>,
}

#[derive(Debug, Serialize)]
struct Kernel {
    name: &'static str,
    /// Median of the rounds.
    steps_per_second: f64,
}

/// Kernels are measured in turn, several times over, so that a change of the machine's speed hits all of them.
const ROUNDS: usize = 7;

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    let kernels = measure(&named)?;
    let document = Document { machine: machine(), kernels };
    if args.common.json {
        return print_json(&document);
    }
    let slowest = document.kernels[0].steps_per_second;
    let mut table = tables::table(&["kernel", "steps/s, one core", "ratio"]);
    for k in &document.kernels {
        tables::add(
            &mut table,
            [
                k.name.to_owned(),
                format!("{:.3e}", k.steps_per_second),
                format!("{:.1}", k.steps_per_second / slowest),
            ],
        );
    }
    print(&format!("{}\n{table}\n", document.machine))
}

/// Flies once or more; the number of steps.
type Run<'a> = Box<dyn Fn() -> usize + 'a>;

fn measure(named: &NamedRig) -> Outcome<Vec<Kernel>> {
    let scenario = Scenario::load("step")?;
    let lanes = |fidelity| Objective::new(Criterion::Ise, &named.rig, &scenario, fidelity, 1);
    let (ideal, rig) = (lanes(Fidelity::Ideal), lanes(Fidelity::Rig));
    let (single, double) = (scenario.references::<f32>(), scenario.references::<f64>());
    let runs: [(&'static str, Run<'_>); 5] = [
        ("f64-ideal", Box::new(|| fly(&double, ideal_loop::<f64>(named)))),
        ("f32-ideal", Box::new(|| fly(&single, ideal_loop::<f32>(named)))),
        ("lanes-ideal", Box::new(|| fly_lanes(&ideal, single.len()))),
        ("f32-rig", Box::new(|| fly(&single, board_loop(named)))),
        ("lanes-rig", Box::new(|| fly_lanes(&rig, single.len()))),
    ];
    let mut rates = vec![Vec::new(); runs.len()];
    for _ in 0..ROUNDS {
        for (rates, (_, run)) in rates.iter_mut().zip(&runs) {
            let begun = Instant::now();
            let mut steps = 0;
            while begun.elapsed().as_millis() < 60 {
                steps += run();
            }
            rates.push(steps as f64 / begun.elapsed().as_secs_f64());
        }
    }
    let median = |mut rates: Vec<f64>| {
        rates.sort_by(f64::total_cmp);
        rates[ROUNDS / 2]
    };
    Ok(runs.iter().zip(rates).map(|((name, _), r)| Kernel { name, steps_per_second: median(r) }).collect())
}

fn ideal_loop<R: Real>(named: &NamedRig) -> IdealLoop<R> {
    let settings = GainsFile::paper().settings(&named.rig).map(R::from_f64);
    IdealLoop::new(&named.rig, &settings, State::at_rest(PerAxis::zero()), SAMPLE_TIME)
}

fn board_loop(named: &NamedRig) -> BoardLoop {
    let settings = GainsFile::paper().settings(&named.rig).map(f32::from_f64);
    let plant = RealPlant::new(&named.rig.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
    BoardLoop::new(plant, &Hardware::of(&named.rig, PerAxis::both(0.5)), &settings)
}

/// Flies once with the sum that the tuner keeps; the number of steps.
fn fly<R: Real<Scalar = R> + Into<f64>>(
    references: &[Reference<R>],
    mut closed_loop: impl ClosedLoop<R>,
) -> usize {
    let last = u32::try_from(references.len() - 1).unwrap_or(u32::MAX);
    let mut integral = Integral::new(Criterion::Ise);
    for (tick, reference) in (0..).zip(references) {
        let happened = closed_loop.tick(black_box(reference), PerMotor::zero());
        integral.add(tick, last, happened.error());
    }
    black_box(integral.value(0, SAMPLE_TIME));
    references.len()
}

/// Flies a group of candidates to the end; the number of steps.
fn fly_lanes(objective: &Objective, ticks: usize) -> usize {
    let position = gains::PAPER.to_paper_order().to_vec();
    let candidates = vec![Candidate { position, bound: f64::INFINITY }; LANES];
    black_box(objective.costs(black_box(&candidates)));
    ticks * LANES
}

/// What computes, in words.
fn machine() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|l| l.strip_prefix("model name")).unwrap_or("");
    let model = model.trim_start_matches([' ', '\t', ':']);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let model = if model.is_empty() { "unknown processor" } else { model };
    format!("{model}, {cores} cores, {}, {}", std::env::consts::ARCH, instruction_set())
}
