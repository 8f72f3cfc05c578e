//! What the board's supervisor costs in lanes: `cargo bench -p host-sim --bench supervisor`. Each preset's
//! controller, as boards boot with it, flies a second of the step without it and with it.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::defaults;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{self, Rig};
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor_sim::closed_loop::{ClosedLoop, Hardware, RigLoop, Tick};
use twinrotor_sim::guard::Guard;
use twinrotor_sim::lanes::{Kernel, LANES, in_lanes};
use twinrotor_sim::scenario::{SAMPLE_TIME, Scenario};

/// That controller's flights in lanes, as the robust objective flies them.
#[derive(Clone, Copy)]
struct Own<'a> {
    rig: &'a Rig,
    settings: &'a Settings<f32>,
    references: &'a [Reference<f32>],
    watched: bool,
}

impl Kernel for Own<'_> {
    /// Steps flown.
    type Output = usize;
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) -> usize {
        let settings = self.settings.map(R::splat);
        let hardware = Hardware::of(self.rig, PerAxis::both(0.5));
        let mut guard = Guard::new(&settings, &hardware);
        if self.watched {
            self.fly(
                &settings,
                &hardware,
                #[inline(always)]
                |tick, happened| guard.see(tick, happened),
            );
            assert_eq!(guard.ended(0), None, "a preset's controller on its own rig");
        } else {
            self.fly(
                &settings,
                &hardware,
                #[inline(always)]
                |_, _| {},
            );
        }
        self.references.len() * LANES
    }
}

impl Own<'_> {
    #[inline(always)]
    fn fly<R: Real<Scalar = f32>>(
        &self,
        settings: &Settings<R>,
        hardware: &Hardware,
        mut see: impl FnMut(u32, &Tick<R>),
    ) {
        let plant = RealPlant::new(&self.rig.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
        let mut closed_loop = RigLoop::new(plant, hardware, settings);
        let mut squares = PerAxis::zero();
        for (tick, reference) in (0..).zip(self.references) {
            let happened = black_box(&mut closed_loop).tick(&Reference::splat(reference), PerMotor::zero());
            see(tick, &happened);
            let error = happened.error();
            squares = squares.plus(error.zip(error, |a, b| a * b));
        }
        black_box(squares);
    }
}

fn benches(bench: &mut Criterion) {
    let mut scenario = Scenario::named("step").expect("a scenario of the paper's");
    scenario.duration = 1.0;
    let references = scenario.references::<f32>();
    for (name, rig) in presets::ALL {
        let controller = defaults::named(name).expect("every preset has one");
        let settings = Settings::new(&rig, controller, SAMPLE_TIME).map(f32::from_f64);
        let mut group = bench.benchmark_group(name);
        group.throughput(Throughput::Elements((references.len() * LANES) as u64));
        for (told, watched) in [("alone", false), ("watched", true)] {
            let own = Own { rig: &rig, settings: &settings, references: &references, watched };
            group.bench_function(told, |b| b.iter(|| in_lanes(own)));
        }
        group.finish();
    }
}

criterion_group!(supervisor, benches);
criterion_main!(supervisor);
