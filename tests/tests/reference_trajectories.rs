//! The simulator against independent reference trajectories and closed forms.

use tests::{Setup, golden};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::pipeline::Settings;
use twinrotor::plant::State;
use twinrotor::plant::presets::PAPER;
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::trajectory::Trajectory;
use twinrotor::{DEGREE, gains};
use twinrotor_sim::closed_loop::{ClosedLoop, IdealLoop};
use twinrotor_sim::flight::{Fidelity, Scalar, fly};

/// 1e-10 rad over the whole run, in f64, with volts held for a tick.
#[test]
fn f64_follows_the_references() {
    for (name, scenario, duration) in [("step_zoh1kHz", "step", 10.0), ("scenario2_zoh1kHz", "2", 40.0)] {
        let setup = Setup::paper(scenario, duration);
        let flown = fly(&setup.plan(Fidelity::Ideal, 0), Scalar::F64).unwrap();
        let mut worst = 0.0_f64;
        let rows = golden(name);
        for row in &rows {
            let ours = &flown.rows[row.tick];
            let (a, b) = (ours.state, row.state);
            worst = worst.max((a.angle.pitch - b.angle.pitch).abs()).max((a.angle.yaw - b.angle.yaw).abs());
            assert!((a.rate.pitch - b.rate.pitch).abs() < 1e-9 && (a.rate.yaw - b.rate.yaw).abs() < 1e-9);
            assert!((ours.volts.main - row.volts.main).abs() < 1e-8, "{name} at tick {}", row.tick);
            assert!((ours.volts.tail - row.volts.tail).abs() < 1e-8, "{name} at tick {}", row.tick);
        }
        assert_eq!(rows.last().unwrap().tick, flown.rows.len() - 1, "{name} is covered to its end");
        assert!(worst < 1e-10, "{name}: {worst:e} rad");
    }
}

/// Holding the volts for a tick of 1 ms is the only difference from the paper's continuous law: less than .03
/// degrees.
#[test]
fn a_tick_of_1_ms_is_near_the_continuous_law() {
    let setup = Setup::paper("step", 10.0);
    let flown = fly(&setup.plan(Fidelity::Ideal, 0), Scalar::F64).unwrap();
    let difference = |row: &tests::GoldenRow| {
        let (a, b) = (flown.rows[row.tick].state.angle, row.state.angle);
        (a.pitch - b.pitch).abs().max((a.yaw - b.yaw).abs())
    };
    let worst = golden("step_continuous").iter().map(difference).fold(0.0, f64::max);
    assert!((0.02..0.03).contains(&(worst / DEGREE)), "{} degrees", worst / DEGREE);
}

/// 10 s of the step in `R`; angles at every 10 ms.
fn step<R: Real<Scalar = R> + Into<f64>>(ticks_per_ms: u32) -> Vec<PerAxis<f64>> {
    let tick_time = 1e-3 / f64::from(ticks_per_ms);
    let settings = Settings::paper(&PAPER, gains::PAPER, tick_time);
    let start = State::at_rest(PerAxis::zero());
    let mut closed_loop = IdealLoop::<R>::new(&PAPER, &settings.map(R::from_f64), start, tick_time);
    let reference = Trajectory::<R>::paper_step().at(0);
    let ticks_per_row = 10 * ticks_per_ms as usize;
    let run = (0..1000 * ticks_per_row).map(|_| closed_loop.tick(&reference, PerMotor::zero()));
    run.step_by(ticks_per_row).map(|t| t.state.angle.map(Into::into)).collect()
}

/// f32 does not stagnate: 1e-5 degrees from f64 over 10 s, at 1 ms and at .1 ms.
#[test]
fn f32_stays_with_f64() {
    for ticks_per_ms in [1, 10] {
        let (single, double) = (step::<f32>(ticks_per_ms), step::<f64>(ticks_per_ms));
        let apart = |(a, b): (&PerAxis<f64>, &PerAxis<f64>)| {
            (a.pitch - b.pitch).abs().max((a.yaw - b.yaw).abs()) / DEGREE
        };
        let worst = single.iter().zip(&double).map(apart).fold(0.0, f64::max);
        assert!(worst < 1e-5, "{worst:e} degrees at {ticks_per_ms} ticks a ms");
    }
}

/// Without saturation the errors of an axis are two exponentials; fitted to the simulated ones, their rates
/// are the poles of s² + (μa + μb) s + 1 + μa μb.
#[test]
fn the_poles_are_those_of_the_closed_form() {
    // A small step, so that no voltage clips; the held tick moves a fast pole by far less than .1 % at 10 us.
    let tick_time = 1e-5;
    let settings = Settings::paper(&PAPER, gains::PAPER, tick_time);
    let start = State::at_rest(PerAxis::both(-0.05));
    let mut closed_loop = IdealLoop::<f64>::new(&PAPER, &settings, start, tick_time);
    let reference = Reference::at_rest(PerAxis::zero());
    let every = 1_000;
    let errors: Vec<PerAxis<f64>> = (0..40 * every)
        .map(|_| closed_loop.tick(&reference, PerMotor::zero()).error())
        .step_by(every)
        .collect();
    let time = tick_time * every as f64;
    let pitch = prony(errors.iter().map(|e| e.pitch), time);
    let yaw = prony(errors.iter().map(|e| e.yaw), time);
    for (found, expected) in pitch.into_iter().chain(yaw).zip([-4.25, -24.55, -2.40, -10.68]) {
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }
}

/// Rates of the two exponentials that make a sampled curve: e(k+2) = a e(k+1) + b e(k) by least squares
/// (Prony).
fn prony(samples: impl Iterator<Item = f64>, time: f64) -> [f64; 2] {
    let e: Vec<f64> = samples.collect();
    let sum = |i: usize, j: usize| (0..e.len() - 2).map(|k| e[k + i] * e[k + j]).sum::<f64>();
    let (s11, s01, s00, s12, s02) = (sum(1, 1), sum(0, 1), sum(0, 0), sum(1, 2), sum(0, 2));
    let determinant = s11 * s00 - s01 * s01;
    let (a, b) = ((s12 * s00 - s02 * s01) / determinant, (s02 * s11 - s12 * s01) / determinant);
    let root = (a * a / 4.0 + b).sqrt();
    [a / 2.0 + root, a / 2.0 - root].map(|z| z.ln() / time)
}

/// Section 5 of the paper with its own numbers, as this simulator reproduces them.
#[test]
fn the_step_with_table_4() {
    for scalar in [Scalar::F32, Scalar::F64] {
        let setup = Setup::paper("step", 10.0);
        let report = fly(&setup.plan(Fidelity::Ideal, 0), scalar).unwrap().report;
        let (p, y) = (&report.pitch, &report.yaw);
        // To a tick: the expected ones are of the continuous law.
        let near = |value: Option<f64>, expected: f64| (value.unwrap() - expected).abs() < 1e-3;
        assert!(near(p.settling_time_2, 0.979) && near(y.settling_time_2, 1.739), "{report:?}");
        assert!(near(p.settling_time_5, 0.764) && near(y.settling_time_5, 1.357), "{report:?}");
        assert!(p.overshoot_percent.unwrap() < 1e-4 && y.overshoot_percent.unwrap() < 1e-4);
        assert!((report.ise() - 0.1553).abs() < 5e-5);
        assert!((report.tail.saturation_time - 0.0385).abs() < 1.1e-3);
        assert!(report.main.saturation_time <= 0.0);
        assert!(
            (report.main.peak_demand - 14.6).abs() < 0.05 && (report.tail.peak_demand - 42.07).abs() < 0.05
        );
    }
}

/// A rotor lag of .16 s, Aero 2 constants and ±18 V: the paper's gains ring by about 46 and 40 %.
#[test]
fn the_papers_gains_ring_on_a_real_rigs_lag() {
    use twinrotor::plant::presets::AERO2;
    use twinrotor_sim::gains_file::GainsFile;
    let setup = Setup::new(&AERO2, &GainsFile::paper(), "step", 10.0);
    let report = fly(&setup.plan(Fidelity::Rig, 1), Scalar::F32).unwrap().report;
    assert!(report.pitch.overshoot_percent.unwrap() > 30.0, "{report:?}");
    assert!(report.yaw.overshoot_percent.unwrap() > 25.0, "{report:?}");
}
