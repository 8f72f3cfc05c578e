//! Random trials at random ticks: nothing is written, nothing trips, no motor is jerked, and the host
//! computes the same bits. Forty swaps, and in the long tests a hundred in 60,000 ticks, or as many as
//! `TWINROTOR_TRIALS` says.

use std::sync::OnceLock;

use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::controller::ControllerSettings;
use twinrotor::link::{Nonce, ToBoard};
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets::Rig;
use twinrotor::supervisor::{ArmState, Request};
use twinrotor::telemetry::{Frame, InForce, Kept, TrialPhase};
use twinrotor::trial::Attempt;
use virtual_board::machine::{Machine, Setup};
use virtual_board::record::{self, ADDRESS, image};
use virtual_board::station::Station;

use super::super::{firmware, make_ready, start};
use super::twin::{Flown, bytes, of_a_trial};
use super::{await_phase, phase, scaled, try_out, with};

/// SplitMix64.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    fn between(&mut self, low: u64, high: u64) -> u64 {
        low + self.next() % (high - low)
    }

    #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "a share")]
    fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.next() >> 40) as f64 / f64::from(1 << 24)) as f32
    }
}

/// \[-\] The most that a gain of a candidate is of the built-in one.
const MOST: f32 = 1.2;
/// \[ms\] The shortest fade.
const FADE: u64 = 50;

/// A controller near `own`.
fn near(own: &ControllerSettings<f32>, chance: &mut Chance) -> ControllerSettings<f32> {
    let mut controller = *own;
    let factor = chance.within(2.0 - MOST, MOST);
    controller.law = own.law.map(|gain| factor * gain);
    if chance.between(0, 2) == 0 {
        controller.estimator = own.estimator.map(|number| chance.within(0.9, 1.0) * number);
    }
    if chance.between(0, 2) == 0 {
        controller.cancellation = own.cancellation.map(|share| share.map(|a| chance.within(0.5, 1.0) * a));
    }
    controller
}

struct Trials {
    flown: Flown,
    swaps: u32,
    accepted: u32,
    /// Of the flash, while it flew.
    operations: usize,
    resets: usize,
}

fn wanted(usual: u32) -> u32 {
    std::env::var("TWINROTOR_TRIALS").map_or(usual, |n| n.parse().expect("a number"))
}

/// Of the built-in controller.
fn trials() -> &'static Trials {
    static FLOWN: OnceLock<Trials> = OnceLock::new();
    FLOWN.get_or_init(|| {
        let (rig, parameters) = record::tuned(record::BUILT_IN);
        fly(rig, parameters, wanted(100), 60_000)
    })
}

/// Fewer, of the same without a push against the rotors' lag, with which every count of an encoder is a jerk.
fn few() -> &'static Trials {
    static FLOWN: OnceLock<Trials> = OnceLock::new();
    FLOWN.get_or_init(|| {
        let (rig, mut parameters) = record::tuned(record::BUILT_IN);
        parameters.settings.controller.lead = None;
        fly(rig, parameters, wanted(40), 0)
    })
}

/// So many trials and more in a row, in at least so many ticks of flight.
fn fly(rig: Rig, parameters: Parameters, wanted: u32, ticks: usize) -> Trials {
    let mut station = start(Setup::new(firmware()).with_image(ADDRESS, image(&[parameters])), &rig);
    station.run(10);
    station.send(&ToBoard::Telemetry { every: 1 });
    make_ready(&mut station);
    station.request(Request::Arm);
    station.await_state(100, ArmState::Armed);
    station.run(4_000);
    let (from, before) = (station.heard.frames.len(), operations(&mut station.machine));
    let mut chance = Chance(18);
    let (mut swaps, mut accepted) = (0, 0);
    while swaps < wanted || station.heard.frames.len() < from + ticks {
        if chance.between(0, 2) == 0 {
            station.aim(PerAxis::new(chance.within(-0.15, 0.15), chance.within(-0.5, 0.5)));
        }
        station.run(chance.between(1, 160));
        let controller = near(&parameters.settings.controller, &mut chance);
        let [fade_ms, revert_ms] = [chance.between(FADE, 100), chance.between(20, 200)]
            .map(|ms| u32::try_from(ms).expect("a few hundred"));
        try_out(&mut station, Attempt { controller, fade_ms, revert_ms });
        await_phase(&mut station, 30, TrialPhase::Shadow);
        let ended = |station: &Station| phase(station) == TrialPhase::None;
        if chance.between(0, 10) == 0 {
            // Before it flies alone.
            station.run(chance.between(1, 300 + u64::from(fade_ms)));
            station.send(&ToBoard::Revert);
        } else if station.run_until(600, |heard| {
            heard
                .frames
                .last()
                .is_some_and(|f| matches!(f.controller.trial, TrialPhase::Flying | TrialPhase::None))
        }) {
            swaps += u32::from(!ended(&station));
            match chance.between(0, 3) {
                0 => {
                    station.send(&ToBoard::Accept(Nonce::default()));
                    accepted += 1;
                }
                1 => {
                    station.run(chance.between(1, 60));
                    station.send(&ToBoard::Revert);
                }
                _ => {}
            }
        }
        await_phase(&mut station, 600, TrialPhase::None);
    }
    let operations = operations(&mut station.machine) - before;
    let resets = station.machine.resets().len();
    let Station { heard, said, .. } = station;
    Trials {
        flown: Flown { rig, parameters, said, frames: heard.frames },
        swaps,
        accepted,
        operations,
        resets,
    }
}

fn operations(machine: &mut Machine) -> usize {
    machine.with(|board| board.flash().log.len())
}

/// The frames from the first in the air on.
fn in_the_air(frames: &[Frame]) -> &[Frame] {
    let armed = frames.iter().position(|frame| frame.state == ArmState::Armed).expect("it flew");
    &frames[armed..]
}

#[test]
fn random_trials_write_nothing_and_trip_nothing() {
    assert_harmless(few(), 5);
}

#[test]
#[ignore = "long: a minute in the air, which `board_and_host_agree_for_a_minute` shares"]
fn a_hundred_random_trials_write_nothing_and_trip_nothing() {
    assert_harmless(trials(), 10);
}

/// More than so many of them were accepted.
#[track_caller]
fn assert_harmless(trials: &Trials, accepted: u32) {
    println!(
        "{} swaps, {} accepted, {} frames in the air",
        trials.swaps,
        trials.accepted,
        in_the_air(&trials.flown.frames).len()
    );
    assert_eq!((trials.operations, trials.resets), (0, 0));
    assert!(in_the_air(&trials.flown.frames).iter().all(|frame| frame.state == ArmState::Armed));
    assert!(trials.accepted > accepted && trials.swaps >= 2 * trials.accepted);
    let unsaved = trials.flown.frames.last().expect("frames").controller.accepted;
    assert_eq!(unsaved, Kept::Unsaved);
}

#[test]
fn board_and_host_agree_through_random_swaps() {
    assert_equal(&few().flown, 20_000);
}

#[test]
#[ignore = "long: a minute in the air"]
fn board_and_host_agree_for_a_minute() {
    assert_equal(&trials().flown, 60_000);
}

/// In so many ticks and more.
#[track_caller]
fn assert_equal(flown: &Flown, ticks: usize) {
    let twin = flown.twin(|_| false);
    let mut compared = 0;
    for frame in in_the_air(&flown.frames) {
        let here = &twin[frame.tick as usize];
        assert_eq!(bytes(frame), bytes(here), "tick {}: {frame:?} {here:?}", frame.tick);
        compared += 1;
    }
    assert!(compared >= ticks, "{compared} ticks");
}

/// \[V\] The most that the volts change from one tick to the next.
fn jerk(frames: &[Frame]) -> PerMotor<f32> {
    frames.windows(2).filter(|pair| pair[1].tick == pair[0].tick + 1).fold(PerMotor::zero(), |most, pair| {
        let change = pair[1].volts.zip(pair[0].volts, |new, old| (new - old).abs());
        most.zip(change, f32::max)
    })
}

/// The same setpoints without trials, with the controller and with those at both ends of what was tried, tell
/// how fast volts change; a fade adds at most its share of all the volts there are.
#[test]
fn no_motor_is_jerked_by_a_trial() {
    let trials = few();
    assert_eq!((trials.operations, trials.resets), (0, 0));
    let flown = &trials.flown;
    let limit = flown.parameters.settings.volts_limit;
    let jerks = [1.0, 2.0 - MOST, MOST].map(|factor| {
        let other = with(&flown.parameters, scaled(&flown.parameters, factor));
        let plain =
            Flown { parameters: other, said: flown.said.clone(), frames: flown.frames.clone(), ..*flown };
        jerk(in_the_air(&plain.twin(of_a_trial)))
    });
    let found = jerk(in_the_air(&flown.frames));
    let plain = jerks.into_iter().fold(PerMotor::zero(), |most: PerMotor<f32>, one| most.zip(one, f32::max));
    println!("{found:?} V, without trials {plain:?}");
    #[expect(clippy::cast_precision_loss, reason = "50")]
    let allowed = plain.zip(limit, |plain, limit| plain + 2.0 * limit / FADE as f32);
    assert!(found.main <= allowed.main && found.tail <= allowed.tail, "{found:?}, allowed {allowed:?}");
}

/// Every bit but what tells of the trial itself, accepted, taken back and left alone.
#[test]
fn a_controller_that_is_its_own_trial_changes_no_bit() {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    let mut station = start(Setup::new(firmware()).with_image(ADDRESS, image(&[parameters])), &rig);
    station.run(10);
    station.send(&ToBoard::Telemetry { every: 1 });
    make_ready(&mut station);
    station.request(Request::Arm);
    station.await_state(100, ArmState::Armed);
    for said in [None, Some(ToBoard::Revert), Some(ToBoard::Accept(Nonce::default()))] {
        station.aim(PerAxis::new(0.1, 0.3));
        station.run(1_500);
        try_out(&mut station, Attempt { revert_ms: 500, ..Attempt::new(parameters.settings.controller) });
        station.aim(PerAxis::new(-0.1, 0.0));
        await_phase(&mut station, 600, TrialPhase::Flying);
        if let Some(said) = said {
            station.send(&said);
        }
        await_phase(&mut station, 700, TrialPhase::None);
    }
    let Station { heard, said, .. } = station;
    let flown = Flown { rig, parameters, said, frames: heard.frames };
    let plain = flown.twin(of_a_trial);
    let tried = in_the_air(&flown.frames);
    assert!(tried.len() > 6_000 && tried.iter().any(|frame| frame.controller.trial == TrialPhase::FadingOut));
    for frame in tried {
        let plain = plain[frame.tick as usize];
        let alike = Frame { controller: InForce::default(), taken: plain.taken, ..*frame };
        assert_eq!(bytes(&alike), bytes(&plain), "{frame:?} {plain:?}");
    }
}
