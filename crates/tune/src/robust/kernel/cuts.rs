//! In which tick and for what a board cuts a flight: the lanes against the board's own loop, flight by
//! flight.

use super::super::{Scatter, Scenes};
use super::*;
use std::collections::HashMap;
use twinrotor::controller::ControllerSettings;
use twinrotor::plant::{PlantParameters, presets};
use twinrotor::reference::Reference;
use twinrotor::supervisor::{ArmState, Condition};
use twinrotor::{defaults, plant::Effectiveness};
use twinrotor_sim::closed_loop::{BoardLoop, ClosedLoop as _};
use twinrotor_sim::judged::{Ended, HOT};

/// The flight of `draw` by the board's own loop with its supervisor, and where that ends it.
fn by_the_board(trial: &Trial, settings: &Settings<f32>, course: &Course, draw: &Draw) -> Option<Cut> {
    let plant = RealPlant::new(&draw.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
    let hardware = Hardware::of(&trial.truth, draw.encoder_phase).taken_for(&trial.rig, &trial.truth);
    let mut board = BoardLoop::new(plant, &hardware, settings);
    let (rules, disturbance) = (course.rules(trial.truth.envelope), draw.disturbance.cast());
    let mut asked = Reference::default();
    for tick in 0..rules.end {
        asked = course.asked(tick).unwrap_or(asked);
        if rules.hot && tick == 1 {
            board.warm(f32::from_f64(HOT));
        }
        let push = course.push(tick).map_or(PerMotor::zero(), |part| disturbance.scaled(part));
        board.tick(&asked, push);
        if let Some(ArmState::Fault(condition)) = board.arm_state() {
            return Some(Cut::of(course, Ended { tick, condition }));
        }
    }
    None
}

/// How many of the trial's flights a board ends for each condition, if lanes and board agree on all of them.
fn agreed(name: &str, trial: &Trial, controller: &ControllerSettings<f64>) -> HashMap<u8, usize> {
    let settings = trial.settings(controller);
    let mut found = HashMap::new();
    for course in &Course::all(trial) {
        for group in trial.plants.chunks(twinrotor_sim::lanes::LANES) {
            let flown = in_lanes(Flights::new(trial, course, &settings, group)).expect("nothing stops it");
            for (k, (draw, flown)) in group.iter().zip(flown).enumerate() {
                let (lane, board) = (cut(&flown, course), by_the_board(trial, &settings, course, draw));
                assert_eq!(lane, board, "{name}, {}, lane {k}: {:?}", course.name, draw.plant);
                if let Some(cut) = board {
                    *found.entry(cut.condition as u8).or_default() += 1;
                }
            }
        }
    }
    found
}

/// Drawn plants on every preset, with what boards boot with: the step and every scene, and no cut.
#[test]
fn drawn_flights_end_where_a_board_ends_them_which_is_nowhere() {
    for (name, rig) in presets::ALL {
        let trial = Trial::new(&rig, 64, 77, 3.0).flying(Scenes::All);
        let controller = defaults::named(name).expect("a controller for every preset");
        assert_eq!(agreed(name, &trial, &controller), HashMap::new(), "{name}");
    }
}

type Mishap = fn(&mut PlantParameters<f64>);

/// What makes a plant another than its controller believes, beyond all that is drawn.
const MISHAPS: [Mishap; 12] = [
    |p| thrust(p, |k| Effectiveness { tail_on_yaw: -k.tail_on_yaw, tail_on_pitch: -k.tail_on_pitch, ..k }),
    |p| thrust(p, |k| Effectiveness { main_on_yaw: -k.main_on_yaw, main_on_pitch: -k.main_on_pitch, ..k }),
    |p| {
        thrust(p, |k| Effectiveness {
            main_on_pitch: k.tail_on_pitch,
            tail_on_pitch: k.main_on_pitch,
            main_on_yaw: k.tail_on_yaw,
            tail_on_yaw: k.main_on_yaw,
        })
    },
    |p| thrust(p, |k| k.map(|x| 40.0 * x)),
    |p| thrust(p, |k| k.map(|x| 5.0 * x)),
    |p| thrust(p, |k| k.map(|x| 0.3 * x)),
    |p| thrust(p, |k| Effectiveness { tail_on_yaw: 0.0, ..k }),
    |p| p.rotor_time_constant = p.rotor_time_constant.scaled(6.0),
    |p| p.damping = p.damping.scaled(-40.0),
    |p| p.inertia = p.inertia.scaled(30.0),
    |p| p.inertia = p.inertia.scaled(0.1),
    |p| p.mass *= 2.0,
];

fn thrust(plant: &mut PlantParameters<f64>, becomes: impl Fn(Effectiveness<f64>) -> Effectiveness<f64>) {
    plant.effectiveness = becomes(plant.effectiveness);
    plant.quadratic_effectiveness = becomes(plant.quadratic_effectiveness);
}

/// Rigs on which things go wrong in every way there is, each beside others in the lanes: the same tick and
/// the same condition, and each condition that a flight can bring about does occur.
#[test]
fn a_flight_that_goes_wrong_ends_in_the_boards_tick_for_the_boards_reason() {
    let mut found: HashMap<u8, usize> = HashMap::new();
    let mut add =
        |more: HashMap<u8, usize>| more.into_iter().for_each(|(k, n)| *found.entry(k).or_default() += n);
    for (name, rig) in presets::ALL {
        let controller = defaults::named(name).expect("a controller for every preset");
        let wide = Scatter { constants: 0.6, lag: 0.9 };
        let mut trial = Trial::within(&rig, 48, 78, 2.0, &wide).flying(Scenes::All);
        for (draw, mishap) in trial.plants.iter_mut().zip(MISHAPS.iter().cycle()) {
            mishap(&mut draw.plant);
        }
        add(agreed(name, &trial, &controller));
        // Sound plants whose encoders count otherwise than the board believes.
        for factor in [1.0 / 64.0, 400.0] {
            let mut trial = Trial::new(&rig, 8, 79, 2.0).flying(Scenes::All);
            trial.truth.encoder_counts = rig.encoder_counts.map(|counts| (f64::from(counts) * factor) as u32);
            add(agreed(name, &trial, &controller));
        }
        // Gains that no number holds.
        let mut controller = controller;
        controller.law = controller.law.map(|gain| gain * 1e36);
        add(agreed(name, &Trial::new(&rig, 4, 80, 1.0), &controller));
    }
    for condition in [
        Condition::PitchJump,
        Condition::YawJump,
        Condition::PitchMotion,
        Condition::YawMotion,
        Condition::AngleEnvelope,
        Condition::RateEnvelope,
        Condition::NonFinite,
    ] {
        assert!(found.remove(&(condition as u8)).is_some(), "no {condition:?}");
    }
    assert_eq!(found, HashMap::new());
}
