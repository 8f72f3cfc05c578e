//! Other controllers, tried in flight.

use super::*;
use crate::controller::ControllerSettings;
use crate::law::LawSettings;
use crate::telemetry::{InForce, Kept, TrialPhase};
use crate::trial::{Attempt, LEAST_ERROR, SHADOW_TICKS};

/// An Aero 2 with its tuned controller, hovering level.
fn hovering() -> Flight {
    hovering_that(LostLink::Off)
}

/// The same with what a lost link means.
fn hovering_that(lost_link: LostLink) -> Flight {
    let tuned = Settings::new(&presets::AERO2, crate::defaults::AERO2, SAMPLE_TIME);
    let mut flight = Flight::with(&presets::AERO2, &tuned, true);
    flight.parameters.limits.lost_link = lost_link;
    flight.control.adopt(&flight.parameters);
    let mut flight = flight.arm();
    assert_eq!(flight.run(6_000, setpoint(0.0, 0.0)), None);
    flight
}

fn own(flight: &Flight) -> ControllerSettings<f32> {
    flight.parameters.settings.controller
}

fn candidate(
    flight: &Flight,
    controller: ControllerSettings<f32>,
    fade_ms: u32,
    revert_ms: u32,
) -> Candidate {
    let attempt = Attempt { controller, fade_ms, revert_ms };
    Candidate::new(&flight.parameters, &attempt, Sequence(9)).unwrap()
}

/// The same law with gains that differ.
fn softer(flight: &Flight) -> ControllerSettings<f32> {
    let controller = own(flight);
    ControllerSettings { law: controller.law.map(|gain| 0.9 * gain), ..controller }
}

/// The steps of a flight with a trial from tick 500 on and what is said in tick 1,500.
fn frames(mut flight: Flight, trial: Option<Candidate>, said: Option<OperatorCommand>) -> Vec<Frame> {
    let frame = |tick: u32| {
        if tick == 500 {
            flight.candidate = trial;
        }
        let command = match tick {
            100 => setpoint(0.1, 0.3),
            1_500 => said,
            2_000 => setpoint(-0.1, 0.0),
            _ => None,
        };
        flight.frame(command)
    };
    (0..4_000).map(frame).collect()
}

/// Every bit of every tick, but for what telemetry says of the trial itself.
#[test]
fn a_controller_that_is_its_own_trial_changes_no_bit() {
    for said in [None, Some(OperatorCommand::Accept), Some(OperatorCommand::Revert)] {
        let flight = hovering();
        let twin = candidate(&flight, own(&flight), 100, 1_800);
        let (tried, plain) = (frames(hovering(), Some(twin), said), frames(flight, None, None));
        assert!(tried.iter().any(|frame| frame.controller.trial == TrialPhase::Flying));
        for (tried, plain) in tried.iter().zip(&plain) {
            // The message itself is told too.
            let alike = Frame { controller: InForce::default(), taken: plain.taken, ..*tried };
            assert_eq!(std::format!("{alike:?}"), std::format!("{plain:?}"));
        }
    }
}

#[test]
fn shadow_fade_flight_and_back_take_their_stated_ticks() {
    let mut flight = hovering();
    flight.candidate = Some(candidate(&flight, softer(&flight), 100, 1_000));
    flight.tick(None);
    let mut seen: Vec<(TrialPhase, u32)> = Vec::new();
    for _ in 0..2_000 {
        let now = flight.control.frame().controller;
        assert_eq!(now.accepted, Kept::Stored);
        match seen.last_mut() {
            Some((phase, ticks)) if *phase == now.trial => *ticks += 1,
            _ => seen.push((now.trial, 1)),
        }
        flight.tick(None);
    }
    let phases: Vec<TrialPhase> = seen.iter().map(|(phase, _)| *phase).collect();
    use TrialPhase::{FadingIn, FadingOut, Flying, Shadow};
    assert_eq!(phases, [Shadow, FadingIn, Flying, FadingOut, TrialPhase::None]);
    assert_eq!((seen[0].1, seen[1].1, seen[2].1), (SHADOW_TICKS, 100, 1_000));
    assert!(seen[3].1.abs_diff(100) <= 1);
}

#[test]
fn an_accepted_controller_flies_on_until_parameters_are_adopted() {
    let mut flight = hovering();
    let tried = softer(&flight);
    flight.candidate = Some(candidate(&flight, tried, 50, 5_000));
    flight.tick(None);
    // Too early: it does not fly alone yet.
    flight.tick(Some(OperatorCommand::Accept));
    assert_eq!(flight.run(1_000, None), None);
    assert_eq!(flight.control.frame().controller.trial, TrialPhase::Flying);
    flight.tick(Some(OperatorCommand::Accept));
    let accepted = InForce { accepted: Kept::Unsaved, ..InForce::default() };
    assert_eq!(flight.control.frame().controller, accepted);
    assert_eq!(flight.control.accepted.controller, tried);
    assert_eq!(flight.run(8_000, setpoint(0.1, 0.1)), None);
    flight.disarm = true;
    flight.tick(None);
    assert_eq!(flight.control.frame().controller, accepted, "it is what the next arming uses");
    flight.control.adopt(&flight.parameters);
    assert_eq!(flight.control.frame().controller, InForce::default());
}

/// Gains that no rotor of this lag can follow: back within the envelope, and armed.
#[test]
fn a_controller_that_swings_up_is_taken_back() {
    let mut flight = hovering();
    let wild = |gain: f32| AxisGains { position: gain, rate: gain };
    let law = LawSettings::Backstepping(Gains { pitch: wild(40.0), yaw: wild(40.0) });
    let controller = ControllerSettings { law, ..own(&flight) };
    flight.candidate = Some(candidate(&flight, controller, 100, 60_000));
    flight.tick(None);
    assert_eq!(flight.run(10_000, setpoint(0.1, 0.1)), None);
    let frame = flight.control.frame();
    assert_eq!((frame.state, frame.controller), (ArmState::Armed, InForce::default()));
    assert!((frame.angle.pitch - 0.1).abs() < LEAST_ERROR && (frame.angle.yaw - 0.1).abs() < LEAST_ERROR);
}

#[test]
fn disarming_a_hazard_and_a_lost_link_end_a_trial() {
    type Event = fn(&mut Flight);
    let ends: [(Event, u32); 3] = [
        (|flight| flight.disarm = true, 1),
        (|flight| flight.current_limit = true, CURRENT_TICKS),
        (|flight| flight.heard = false, 700),
    ];
    for (event, within) in ends {
        let mut flight = hovering_that(LostLink::Hold { ticks: 60_000 });
        flight.candidate = Some(candidate(&flight, softer(&flight), 100, 60_000));
        flight.run(1_000, None);
        assert_eq!(flight.control.frame().controller.trial, TrialPhase::Flying);
        event(&mut flight);
        flight.run(within, None);
        assert_eq!(flight.control.frame().controller, InForce::default());
    }
}

#[test]
fn what_cannot_be_tried_is_named() {
    let flight = hovering();
    let refused = |controller, fade_ms, revert_ms| {
        Attempt { controller, fade_ms, revert_ms }.validate().unwrap_err().field
    };
    assert_eq!(refused(own(&flight), 0, 1_000), "trial.fade_ms");
    assert_eq!(refused(own(&flight), 100, 600_001), "trial.revert_ms");
    let controller = ControllerSettings { law: own(&flight).law.map(|_| f32::NAN), ..own(&flight) };
    assert_eq!(refused(controller, 100, 1_000), "trial.controller");
}
