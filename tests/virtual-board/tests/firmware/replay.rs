//! A record through the board's own estimator and law, over the link: the host's bits.

use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::link::{Nonce, Refusal, ToBoard};
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets::{self, Rig};
use twinrotor::plant::{RealPlant, State};
use twinrotor::supervisor::ArmState;
use twinrotor_identify::log::Log;
use twinrotor_identify::replay::{replay, samples};
use twinrotor_sim::scenario::Scenario;
use virtual_board::record;

use super::{board_with, make_ready, paper_parameters};

/// Rows, 2 ms apart.
const ROWS: u32 = 1_000;

/// A run of a rig whose motors get pulses, as somebody would have logged it.
fn log(rig: &Rig) -> Log {
    let mut plant = RealPlant::<f64>::new(&rig.plant, State::at_rest(rig.rest_angle), 1e-3);
    let row = |k: u32| {
        let volts =
            PerMotor::new(if k % 400 < 200 { 9.0 } else { -2.0 }, if k % 300 < 150 { -5.0 } else { 7.0 });
        let angle = plant.state().angle;
        (0..2).for_each(|_| plant.advance(volts, PerMotor::zero()));
        (angle, volts)
    };
    Log::from_rows("pulses", 2e-3, &(0..ROWS).map(row).collect::<Vec<_>>())
}

fn assert_same(rig: &Rig, parameters: &Parameters, scenario: Option<&Scenario>) {
    let samples = samples(&log(rig), rig, scenario);
    assert_eq!(samples.len(), 2 * ROWS as usize - 1);
    let here = replay(parameters, &samples);
    let mut station = board_with(rig, parameters);
    make_ready(&mut station);
    let there = station.replay(&samples).unwrap_or_else(|why| panic!("{why}"));
    for (here, there) in here.iter().zip(&there) {
        assert!(here.same_bits(there), "here {here:?}, on the board {there:?}");
    }
    assert_eq!(here.len(), there.len());
    assert_eq!(here[0].volts.is_some(), scenario.is_some());
    assert!(here.iter().any(|each| each.rate != PerAxis::zero()));
    assert_eq!(station.heard.state(), Some(ArmState::Ready), "a replay changes nothing on the rig");
    assert!(!station.machine.outputs().live());
}

#[test]
fn a_record_replayed_on_the_board_gives_the_bits_of_the_host() {
    let step = Scenario::named("step").expect("built in");
    assert_same(&presets::AERO, &paper_parameters(&presets::AERO), Some(&step));
    for name in ["aero-lab", "heli"] {
        let (rig, parameters) = record::tuned(name);
        assert_same(&rig, &parameters, Some(&step));
        assert_same(&rig, &parameters, None);
    }
}

#[test]
fn a_record_that_does_not_begin_is_refused() {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    let samples = samples(&log(&rig), &rig, None);
    let mut station = board_with(&rig, &parameters);
    station.run(100);
    station.send(&ToBoard::Replay(samples[7]));
    station.run(20);
    assert_eq!(station.heard.refusals, [Refusal::NoReplay]);
    assert!(station.heard.replayed.is_empty());
}

#[test]
fn other_parameters_end_a_record() {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    let samples = samples(&log(&rig), &rig, None);
    let mut station = board_with(&rig, &parameters);
    station.run(100);
    assert_eq!(station.replay(&samples[..4]).map(|answers| answers.len()), Ok(4));
    station.send(&ToBoard::WriteParameters(Nonce::default(), parameters));
    assert!(station.run_until(2_000, |heard| heard.saved == 1));
    station.send(&ToBoard::Replay(samples[4]));
    station.run(20);
    assert_eq!(station.heard.refusals, [Refusal::NoReplay]);
}
