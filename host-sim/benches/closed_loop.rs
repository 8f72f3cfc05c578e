//! Closed-loop steps: `cargo bench -p host-sim`. The unit of throughput is one step of one loop.

use criterion::{Criterion as Bench, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::gains;
use twinrotor::plant::presets::PAPER;
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor_sim::closed_loop::{BoardLoop, ClosedLoop, Hardware, IdealLoop};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::lanes::LANES;
use twinrotor_sim::metrics::{Criterion, Integral};
use twinrotor_sim::scenario::{SAMPLE_TIME, Scenario};
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::Candidate;
use twinrotor_tune::search::Problem;

fn scenario() -> Scenario {
    let mut scenario = Scenario::named("step").expect("a scenario of the paper's");
    scenario.duration = 1.0;
    scenario
}

fn fly<R: Real<Scalar = R> + Into<f64>>(mut closed_loop: impl ClosedLoop<R>) -> PerAxis<f64> {
    let references = scenario().references::<R>();
    let mut integral = Integral::new(Criterion::Ise);
    for (tick, reference) in (0..).zip(&references) {
        let happened = closed_loop.tick(black_box(reference), PerMotor::zero());
        integral.add(tick, 1_000, happened.error());
    }
    integral.value(0, SAMPLE_TIME)
}

fn ideal<R: Real>() -> IdealLoop<R> {
    let settings = GainsFile::paper().settings(&PAPER).map(R::from_f64);
    IdealLoop::new(&PAPER, &settings, State::at_rest(PerAxis::zero()), SAMPLE_TIME)
}

fn board() -> BoardLoop {
    let settings = GainsFile::paper().settings(&PAPER).map(f32::from_f64);
    let plant = RealPlant::new(&PAPER.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
    BoardLoop::new(plant, &Hardware::of(&PAPER, PerAxis::both(0.5)), &settings)
}

fn benches(bench: &mut Bench) {
    let mut group = bench.benchmark_group("closed loop");
    group.throughput(Throughput::Elements(1_001));
    group.bench_function("f64-ideal", |b| b.iter(|| fly(ideal::<f64>())));
    group.bench_function("f32-ideal", |b| b.iter(|| fly(ideal::<f32>())));
    group.bench_function("f32-rig", |b| b.iter(|| fly(board())));

    group.throughput(Throughput::Elements(1_001 * LANES as u64));
    let position = gains::PAPER.to_paper_order().to_vec();
    let candidates = vec![Candidate { position, bound: f64::INFINITY }; LANES];
    for (name, fidelity) in [("lanes-ideal", Fidelity::Ideal), ("lanes-rig", Fidelity::Rig)] {
        let objective = Objective::new(Criterion::Ise, &PAPER, &scenario(), fidelity, 1);
        group.bench_function(name, |b| b.iter(|| objective.costs(black_box(&candidates))));
    }
    group.finish();
}

criterion_group!(closed_loop, benches);
criterion_main!(closed_loop);
