//! Known constants, simulated logs, and whether the constants come back.

use super::*;
use crate::log::Log;
use constants::chosen;
use problem::Guess;
use rand::{Rng, RngExt};
use search::{Effort, Search};
use std::ops::ControlFlow;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::encoder::angle_per_count;
use twinrotor::plant::presets::AERO_LAB;
use twinrotor::plant::{RealPlant, State};
use twinrotor_tune::checkpoint::Identity;
use twinrotor_tune::optimise::Draws;
use twinrotor_tune::parallel;

/// \[s\] From row to row.
const SAMPLE_TIME: f64 = 0.002;

/// What is sent to the motors at a time \[s\].
type Input<'a> = &'a dyn Fn(f64) -> PerMotor<f64>;

/// An open-loop run of a plant with encoders, each at a place of its own between two counts.
fn record(plant: &PlantParameters<f64>, input: Input<'_>, duration: f64, rng: &mut impl Rng) -> Run {
    let mut body = RealPlant::<f64>::new(plant, State::default(), SAMPLE_TIME);
    let per_count: PerAxis<f64> = AERO_LAB.encoder_counts.map(angle_per_count);
    let phase = PerAxis::new(rng.random::<f64>(), rng.random::<f64>());
    let rows: Vec<_> = (0..(duration / SAMPLE_TIME) as usize)
        .map(|k| {
            let volts = input(k as f64 * SAMPLE_TIME);
            let counts = body.state().angle.zip(per_count, |a, c| a / c).zip(phase, |a, p| (a + p).floor());
            body.advance(volts, PerMotor::zero());
            (counts.zip(per_count, |n, c| n * c), volts)
        })
        .collect();
    Run::new(Log::from_rows("simulated", SAMPLE_TIME, &rows))
}

/// Steps at several levels on both motors, either sign, one after the other and together.
fn levels(t: f64, seed: f64) -> PerMotor<f64> {
    let pulse = |from: f64, to: f64, volts: f64| if (from..to).contains(&t) { volts } else { 0.0 };
    let main = pulse(0.5, 4.0, 10.0 + seed)
        + pulse(8.0, 9.0, -16.0)
        + pulse(14.0, 18.0, 5.0)
        + pulse(20.0, 21.5, 18.0 - seed);
    let tail = pulse(4.0, 7.0, 10.0 - seed)
        + pulse(11.0, 12.0, -18.0)
        + pulse(16.0, 19.0, 7.0)
        + pulse(21.0, 23.0, 14.0 + seed);
    PerMotor { main, tail }
}

/// aero-lab with every fitted constant moved by up to 20 %.
fn drawn(rng: &mut impl Rng, free: &[usize]) -> PlantParameters<f64> {
    let mut values = to_array(&AERO_LAB.plant);
    for k in free {
        values[*k] *= rng.random_range(0.8..1.2);
    }
    from_array(&values)
}

fn runs(plant: &PlantParameters<f64>, rng: &mut impl Rng) -> Vec<Run> {
    (0..3).map(|k| record(plant, &|t| levels(t, 1.5 * f64::from(k)), 25.0, rng)).collect()
}

/// Without friction torque's linear partner at rest and without what aero-lab does not have.
fn free() -> Vec<usize> {
    chosen(&[], &["effectiveness.main_on_yaw".to_owned()]).unwrap()
}

fn to_the_end(search: &mut Search, problem: &Problem<'_>, window: f64) {
    let end: ControlFlow<()> =
        search.run(problem, window, NEVER, |_, _, _| ControlFlow::Continue(())).unwrap();
    assert!(end.is_continue());
}

/// Which true constants lie inside their intervals, of those said to be identifiable.
fn recovered(seed: usize) -> Vec<(&'static str, bool)> {
    let mut rng = Draws::new(2026).of_move(seed);
    let free = free();
    let truth = drawn(&mut rng, &free);
    let runs = runs(&truth, &mut rng);
    let windows = training_windows(&runs, WINDOW).unwrap();
    let problem = Problem::new(&runs, windows, &AERO_LAB.plant, &free, THRESHOLD);
    let effort = Effort { population: 2, iterations: 0, seed: 1 };
    let mut search = Search::new(Identity::new(), &problem, &AERO_LAB.plant, effort);
    to_the_end(&mut search, &problem, WINDOW);
    let (found, _) = search.best().unwrap().clone();
    let (parameters, _) = parameters(&problem, &found);
    let truth = to_array(&truth);
    free.iter()
        .zip(&parameters)
        .filter(|(_, p)| p.identifiable)
        .filter_map(|(k, p)| p.ci95.map(|[least, most]| (p.name, (least..=most).contains(&truth[*k]))))
        .collect()
}

#[test]
fn known_constants_come_back_within_their_intervals() {
    assert_recovered(1);
}

#[test]
#[ignore = "long: of three rigs instead of one"]
fn known_constants_of_more_rigs_come_back_within_their_intervals() {
    assert_recovered(3);
}

/// Of so many rigs.
#[track_caller]
fn assert_recovered(rigs: usize) {
    let found: Vec<(&str, bool)> = (0..rigs).flat_map(recovered).collect();
    let hit = found.iter().filter(|(_, inside)| *inside).count();
    assert!(found.len() >= rigs * 14, "only {} constants are identifiable", found.len());
    assert!(hit as f64 >= 0.85 * found.len() as f64, "{hit} of {}: {found:?}", found.len());
}

/// Which true constants lie inside their intervals, of a rig whose lags, linear thrust and thrust across are
/// known: few enough constants and a log short enough for a hundred repetitions.
fn recovered_from_a_short_log(seed: usize) -> Vec<(&'static str, bool)> {
    let mut rng = Draws::new(90).of_move(seed);
    let known = [
        "effectiveness",
        "quadratic_effectiveness.main_on_yaw",
        "quadratic_effectiveness.tail_on_pitch",
        "rotor_time_constant",
    ];
    let free = chosen(&[], &known.map(str::to_owned)).unwrap();
    let truth = drawn(&mut rng, &free);
    let runs = [record(&truth, &|t| levels(t, 0.0), 24.0, &mut rng)];
    let windows = training_windows(&runs, 3.0).unwrap();
    let problem = Problem::new(&runs, windows, &AERO_LAB.plant, &free, THRESHOLD);
    let values = free.iter().map(|k| to_array(&AERO_LAB.plant)[*k]).collect();
    let (found, _) = descent::descend(&problem, &Guess { values, offsets: vec![0.0] }, NEVER).unwrap();
    let truth = to_array(&truth);
    let inside = |(k, p): (&usize, Parameter)| {
        p.ci95.filter(|_| p.identifiable).map(|[least, most]| (p.name, (least..=most).contains(&truth[*k])))
    };
    free.iter().zip(parameters(&problem, &found).0).filter_map(inside).collect()
}

/// Each identifiable constant lies inside its interval in at least 90 of 100 rigs, every one up to 20 % off
/// its preset. A rig with all constants is in `known_constants_come_back_within_their_intervals`.
#[test]
#[ignore = "long: a hundred fits, 25 s of a processor"]
fn intervals_hold_the_truth_in_ninety_of_a_hundred_rigs() {
    let found: Vec<Vec<(&str, bool)>> = parallel::by_index(100, recovered_from_a_short_log);
    let mut tally = std::collections::BTreeMap::<&str, [usize; 2]>::new();
    for (name, inside) in found.into_iter().flatten() {
        let [hits, all] = tally.entry(name).or_default();
        *hits += usize::from(inside);
        *all += 1;
    }
    println!("{tally:?}");
    assert!(tally.len() >= 8 && tally.values().all(|[_, all]| *all >= 50), "{tally:?}");
    assert!(tally.values().all(|[hits, all]| 10 * hits >= 9 * all), "[inside, identifiable]: {tally:?}");
}

/// Where the rotors settle, not where they start: a window that begins with a jump would explain the kick by
/// its initial rate.
#[test]
fn windows_to_fit_begin_where_the_rotors_are_calm() {
    let mut rng = Draws::new(11).of_move(0);
    let step_at_five = |t: f64| PerMotor { main: if t < 5.0 { 0.0 } else { 10.0 }, tail: 0.0 };
    let run = record(&AERO_LAB.plant, &step_at_five, 17.0, &mut rng);
    let windows = run.calm_windows(0, 5.0);
    assert_eq!(windows.iter().map(|w| w.rows).sum::<usize>(), run.log.angle.len());
    for pair in windows.windows(2) {
        assert_eq!(pair[0].first + pair[0].rows, pair[1].first);
        let begins = pair[1].first as f64 * SAMPLE_TIME;
        assert!((begins - 5.0).abs() > 1.0, "{begins}");
    }
    assert!(windows.iter().all(|w| (1250..=3750).contains(&w.rows)), "{windows:?}");
}

#[test]
fn the_true_plant_explains_its_own_log() {
    let mut rng = Draws::new(7).of_move(0);
    let run = record(&AERO_LAB.plant, &|t| levels(t, 0.0), 25.0, &mut rng);
    for fit in fits(&run, &AERO_LAB.plant, offset_of(&run, &AERO_LAB.plant, WINDOW)) {
        assert!(fit.pitch.unwrap() > 98.5 && fit.yaw.unwrap() > 99.5, "{fit:?}");
    }
    let mut other = AERO_LAB.plant;
    other.stiffness *= 1.5;
    assert!(fit(&run, &other, 0.0, 5.0).pitch.unwrap() < 90.0);
}

#[test]
fn a_motor_that_never_runs_says_nothing_of_its_constants() {
    let mut rng = Draws::new(8).of_move(0);
    let main_alone = |t: f64| PerMotor { tail: 0.0, ..levels(t, 0.0) };
    let runs = [record(&AERO_LAB.plant, &main_alone, 25.0, &mut rng)];
    let windows = training_windows(&runs, WINDOW).unwrap();
    let free = free();
    let problem = Problem::new(&runs, windows, &AERO_LAB.plant, &free, THRESHOLD);
    let values = free.iter().map(|k| to_array(&AERO_LAB.plant)[*k]).collect();
    let (parameters, _) = parameters(&problem, &Guess { values, offsets: vec![0.0] });
    for p in &parameters {
        if p.name.contains("tail") {
            assert!(!p.identifiable, "{}", p.name);
        }
    }
    assert!(parameters.iter().any(|p| p.name == "stiffness" && p.identifiable));
}

#[test]
fn swapped_signs_are_found() {
    let mut rng = Draws::new(9).of_move(0);
    let good = [record(&AERO_LAB.plant, &|t| levels(t, 0.0), 24.0, &mut rng)];
    let check = |change: &dyn Fn(&mut Log)| {
        let mut logs: Vec<Log> = good.iter().map(|r| r.log.clone()).collect();
        logs.iter_mut().for_each(change);
        let runs: Vec<Run> = logs.into_iter().map(Run::new).collect();
        doubts::doubts(&runs, &AERO_LAB.plant)
    };
    assert_eq!(check(&|_| ()), Vec::<String>::new());
    let one = |found: Vec<String>, column: &str| {
        assert!(found.len() == 1 && found[0].ends_with(&format!("columns {column}")), "{column}: {found:?}");
    };
    one(check(&|log| log.volts.iter_mut().for_each(|v| v.main = -v.main)), "v0=-NAME");
    one(check(&|log| log.volts.iter_mut().for_each(|v| v.tail = -v.tail)), "v1=-NAME");
    one(check(&|log| log.angle.iter_mut().for_each(|a| a.pitch = -a.pitch)), "pitch=-NAME");
    one(check(&|log| log.angle.iter_mut().for_each(|a| a.yaw = -a.yaw)), "yaw=-NAME");
    let swap_motors = |v: &mut PerMotor<f64>| *v = PerMotor { main: v.tail, tail: v.main };
    one(check(&|log| log.volts.iter_mut().for_each(swap_motors)), "v0=NAME-OF-v1,v1=NAME-OF-v0");
    let swap_axes = |a: &mut PerAxis<f64>| *a = PerAxis { pitch: a.yaw, yaw: a.pitch };
    one(check(&|log| log.angle.iter_mut().for_each(swap_axes)), "pitch=NAME-OF-yaw,yaw=NAME-OF-pitch");
    // Both motors or both axes: the same motion, so both are named.
    let both = check(&|log| log.volts.iter_mut().for_each(|v| *v = v.scaled(-1.0)));
    assert!(both[0].contains("v0=-NAME,v1=-NAME") && both[0].contains("pitch=-NAME,yaw=-NAME"), "{both:?}");
}

#[test]
fn other_units_of_volts_and_angles_are_told() {
    let mut rng = Draws::new(9).of_move(0);
    let good = [record(&AERO_LAB.plant, &|t| levels(t, 0.0), 24.0, &mut rng)];
    let check = |change: &dyn Fn(&mut Log), told: &str| {
        let mut logs: Vec<Log> = good.iter().map(|r| r.log.clone()).collect();
        logs.iter_mut().for_each(change);
        let runs: Vec<Run> = logs.into_iter().map(Run::new).collect();
        let found = doubts::doubts(&runs, &AERO_LAB.plant);
        assert!(found.iter().any(|line| line.contains(told)), "{told}: {found:?}");
    };
    check(&|log| log.volts.iter_mut().for_each(|v| *v = v.scaled(1.0 / 24.0)), "a duty cycle for V");
    check(&|log| log.angle.iter_mut().for_each(|a| a.yaw = a.yaw.to_degrees()), "yaw: a volt turns it");
    check(&|log| log.angle.iter_mut().for_each(|a| a.yaw /= std::f64::consts::TAU), "turns for rad");
}

#[test]
fn a_search_that_was_interrupted_ends_as_if_it_was_not() {
    let mut rng = Draws::new(10).of_move(0);
    let runs = [record(&AERO_LAB.plant, &|t| levels(t, 0.0), 8.0, &mut rng)];
    let free = chosen(
        &[],
        &["effectiveness".to_owned(), "rotor_time_constant".to_owned(), "rotor_reaction".to_owned()],
    )
    .unwrap();
    let problem =
        Problem::new(&runs, training_windows(&runs, 3.0).unwrap(), &AERO_LAB.plant, &free, THRESHOLD);
    let effort = Effort { population: 4, iterations: 2, seed: 3 };
    let named =
        |name: &str| Search::new(Identity::new().with("log", name), &problem, &AERO_LAB.plant, effort);
    let new = || named("this");
    let mut whole = new();
    to_the_end(&mut whole, &problem, 2.0);
    let mut part = new();
    let mut ends = 0;
    while let ControlFlow::Break(bytes) =
        part.run(&problem, 2.0, NEVER, |search, _, _| ControlFlow::Break(search.checkpoint())).unwrap()
    {
        let told = named("that").resume(&bytes, &problem).unwrap_err().to_string();
        assert_eq!(told, "belongs to another run: log is this there, that here");
        part = new().resume(&bytes, &problem).unwrap();
        ends += 1;
        assert!(ends < 50);
    }
    assert!(ends > 3);
    assert_eq!(part.best(), whole.best());
}
