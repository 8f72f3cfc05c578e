//! What is wrong with an encoder is found.

use crate::flight::{Cut, Flight};
use crate::flown;
use std::fmt::Write;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::Faults;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;

/// Makes a fault in the cables.
type Spoil = fn(&mut Faults);

const FAULTS: [(&str, Spoil); 8] = [
    ("pitch stuck", |faults| faults.encoder_stuck.pitch = true),
    ("yaw stuck", |faults| faults.encoder_stuck.yaw = true),
    ("pitch reversed", |faults| faults.encoder_reversed.pitch = true),
    ("yaw reversed", |faults| faults.encoder_reversed.yaw = true),
    ("swapped", |faults| faults.encoders_swapped = true),
    ("pitch slipping", |faults| faults.drift.pitch = 1),
    ("yaw slipping", |faults| faults.drift.yaw = 1),
    ("pitch slipped", |faults| faults.slip.pitch = 40),
];

/// When it comes.
#[derive(Debug, Clone, Copy)]
enum Scene {
    /// At level, with a step of 25 and 120 degrees at once.
    FarStep,
    /// At a pose, with a step back by 10 and 20 degrees at once.
    Step,
    /// In the middle of a step of 15 and 40 degrees.
    Moving,
    /// At a pose that is held.
    Holding,
    /// The same, with disturbances of ±1 V held .5 s.
    Disturbed,
}

const SCENES: [Scene; 5] = [Scene::FarStep, Scene::Step, Scene::Moving, Scene::Holding, Scene::Disturbed];

/// The cut, and when it came \[ms\] after the fault.
fn found(rig: &Rig, settings: &Settings<f64>, spoil: Spoil, scene: Scene) -> Option<Cut> {
    let mut flight = Flight::armed(rig, settings, PerAxis::new(0.3, 0.8));
    let quiet = |flight: &mut Flight, ticks: u32| flight.run(ticks, |_, _| ());
    match scene {
        Scene::FarStep => {
            quiet(&mut flight, 3_000);
        }
        Scene::Moving => {
            quiet(&mut flight, 3_000);
            flight.aim(15.0, 40.0);
            quiet(&mut flight, 300);
        }
        Scene::Step | Scene::Holding | Scene::Disturbed => {
            flight.aim(15.0, 40.0);
            quiet(&mut flight, 8_000);
        }
    }
    spoil(&mut flight.bench.faults);
    let mut state = 1_u32;
    let mut push = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    flight.run(20_000, |flight, tick| match scene {
        Scene::FarStep if tick == 0 => flight.aim(25.0, 120.0),
        Scene::Step if tick == 0 => flight.aim(5.0, 20.0),
        Scene::Disturbed if tick % 500 == 0 => flight.bench.disturbance = PerMotor::new(push(), push()),
        _ => {}
    })
}

/// \[ms\] What was found, and when, by the rules that knew of no disturbance, on the same law.
const BEFORE: &str = include_str!("before.csv");

/// \[ms\] What took longer was found by chance: a pose that is held gives nothing to tell a stuck encoder by.
const BY_CHANCE: u32 = 5_000;

/// Whatever was found then is found now, within twice the time. Prints a table of both.
#[test]
fn faults_are_found_as_before() {
    let mut before = BEFORE.lines().skip(1);
    println!("| preset | fault | {} |", SCENES.map(|scene| format!("{scene:?}")).join(" | "));
    println!("|---|---|{}", "---|".repeat(SCENES.len()));
    for (name, rig, settings) in flown() {
        for (what, spoil) in FAULTS {
            let row = before.next().expect("a row for each").split(',').collect::<Vec<_>>();
            let [preset, fault, before @ ..] = row.as_slice() else { panic!("{row:?}") };
            assert_eq!((*preset, *fault), (name, what));
            let mut printed = format!("| {name} | {what} |");
            for (scene, before) in SCENES.into_iter().zip(before) {
                let now = found(&rig, &settings, spoil, scene).map(|(_, tick)| tick);
                let shown = now.map_or("-".to_owned(), |now| now.to_string());
                write!(printed, " {before} → {shown} |").expect("a string");
                let Ok(before) = before.parse::<u32>() else { continue };
                let in_time = before > BY_CHANCE || now.is_some_and(|now| now <= 2 * before.max(1));
                assert!(in_time, "{name}, {what}, {scene:?}: {now:?}, before after {before} ms");
            }
            println!("{printed}");
        }
    }
}
