//! `bench`: closed-loop steps a second on one core.

use super::common::Common;
use super::{print, print_json, tables};
use crate::error::Outcome;
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::gains;
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor_sim::closed_loop::{BoardLoop, ClosedLoop, Hardware, IdealLoop, RigLoop};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::lanes::{Kernel as Lanewise, LANES, in_lanes, instruction_set};
use twinrotor_sim::metrics::{Criterion, Integral};
use twinrotor_sim::operation_count::{Counted, operations};
use twinrotor_sim::rig::NamedRig;
use twinrotor_sim::scenario::{SAMPLE_TIME, Scenario};
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::Candidate;
use twinrotor_tune::search::Problem;

/// Flags of `bench`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Serialize)]
struct Document {
    machine: String,
    /// Of one core: independent additions and multiplications in lanes, and nothing else.
    peak_operations_per_second: f64,
    kernels: Vec<Kernel>,
}

#[derive(Debug, Serialize)]
struct Kernel {
    name: &'static str,
    /// Median of the rounds.
    steps_per_second: f64,
    /// Floating-point operations of one step of one loop, as [`operations`] counts them.
    operations_per_step: u64,
    /// Operations a second to what the core could do in lanes.
    share_of_peak: f64,
}

/// Kernels are measured in turn, several times over, so that a change of the machine's speed hits all of
/// them.
const ROUNDS: usize = 7;

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    let document = measure(&named)?;
    if args.common.json {
        return print_json(&document);
    }
    let slowest = document.kernels[0].steps_per_second;
    let mut table =
        tables::table(&["kernel", "steps/s, one core", "ratio", "operations/step", "of the peak"]);
    for k in &document.kernels {
        tables::add(
            &mut table,
            [
                k.name.to_owned(),
                format!("{:.3e}", k.steps_per_second),
                format!("{:.1}", k.steps_per_second / slowest),
                k.operations_per_step.to_string(),
                format!("{:.1} %", 100.0 * k.share_of_peak),
            ],
        );
    }
    let peak = document.peak_operations_per_second;
    print(&format!(
        "{}\n{table}\npeak: {peak:.2e} independent additions and multiplications a second in lanes\n",
        document.machine
    ))
}

/// Flies once or more; the number of steps.
type Run<'a> = Box<dyn Fn() -> usize + 'a>;

fn measure(named: &NamedRig) -> Outcome<Document> {
    let scenario = Scenario::named("step")?;
    let lanes = |fidelity| Objective::new(Criterion::Ise, &named.rig, &scenario, fidelity, 1);
    let (ideal, rig) = (lanes(Fidelity::Ideal), lanes(Fidelity::Rig));
    let (single, double) = (scenario.references::<f32>(), scenario.references::<f64>());
    let (ideal_operations, rig_operations) = (count(ideal_loop(named)), count(rig_loop(named)));
    let runs: [(&'static str, u64, Run<'_>); 6] = [
        ("f64-ideal", ideal_operations, Box::new(|| fly(&double, ideal_loop::<f64>(named)))),
        ("f32-ideal", ideal_operations, Box::new(|| fly(&single, ideal_loop::<f32>(named)))),
        ("lanes-ideal", ideal_operations, Box::new(|| fly_lanes(&ideal, single.len()))),
        ("f32-rig", rig_operations, Box::new(|| fly(&single, board_loop(named)))),
        ("lanes-rig", rig_operations, Box::new(|| fly_lanes(&rig, single.len()))),
        ("peak", 1, Box::new(|| in_lanes(Peak))),
    ];
    let mut rates = vec![Vec::new(); runs.len()];
    for _ in 0..ROUNDS {
        for (rates, (_, _, run)) in rates.iter_mut().zip(&runs) {
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
    let peak = median(rates.pop().expect("a rate for each run"));
    let kernels = runs.iter().zip(rates).map(|((name, operations, _), rates)| {
        let steps_per_second = median(rates);
        let share_of_peak = steps_per_second * *operations as f64 / peak;
        Kernel { name, steps_per_second, operations_per_step: *operations, share_of_peak }
    });
    let kernels = kernels.collect();
    Ok(Document { machine: machine(), peak_operations_per_second: peak, kernels })
}

/// Independent additions and multiplications, as many at a time as a core can have under way.
struct Peak;

impl Lanewise for Peak {
    /// Operations done.
    type Output = usize;
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) -> usize {
        const ROUNDS: usize = 100_000;
        let (factor, term) = (R::splat(black_box(1.000_000_1)), R::splat(black_box(1e-7)));
        let mut x = [R::one(); 6];
        for _ in 0..ROUNDS {
            x = [x[0] * factor, x[1] * factor, x[2] * factor, x[3] + term, x[4] + term, x[5] + term];
        }
        black_box(x);
        ROUNDS * x.len() * LANES
    }
}

/// Operations of a tick and its share of the cost, in flight.
fn count(mut closed_loop: impl ClosedLoop<Counted>) -> u64 {
    let goal = Reference::at_rest(PerAxis::both(Counted::from_f64(0.3)));
    let mut integral = Integral::new(Criterion::Ise);
    closed_loop.tick(&goal, PerMotor::zero());
    operations(|| {
        let happened = closed_loop.tick(&goal, PerMotor::zero());
        integral.add(1, 5_000, happened.error());
    })
}

fn ideal_loop<R: Real>(named: &NamedRig) -> IdealLoop<R> {
    let settings = GainsFile::paper().settings(&named.rig).map(R::from_f64);
    IdealLoop::new(&named.rig, &settings, State::at_rest(PerAxis::zero()), SAMPLE_TIME)
}

fn rig_loop<R: Real>(named: &NamedRig) -> RigLoop<R> {
    let settings = GainsFile::paper().settings(&named.rig).map(R::from_f64);
    let plant = RealPlant::new(&named.rig.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
    RigLoop::new(plant, &Hardware::of(&named.rig, PerAxis::both(0.5)), &settings)
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
