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

/// A flight with a trial that is in `phase`, and would last for a minute.
fn trying(lost_link: LostLink, phase: TrialPhase) -> Flight {
    let mut flight = hovering_that(lost_link);
    flight.candidate = Some(candidate(&flight, softer(&flight), 200, 60_000));
    let came = (0..1_000).any(|_| flight.frame(None).controller.trial == phase);
    assert!(came, "{phase:?}");
    flight
}

const UNDER_WAY: [TrialPhase; 3] = [TrialPhase::Shadow, TrialPhase::FadingIn, TrialPhase::Flying];

#[test]
fn a_revert_fades_out_from_every_phase() {
    for (phase, within) in UNDER_WAY.into_iter().zip([2, 4, 203]) {
        let mut flight = trying(LostLink::Off, phase);
        flight.tick(Some(OperatorCommand::Revert));
        assert_eq!(flight.run(within, None), None);
        let frame = flight.control.frame();
        assert_eq!((frame.state, frame.controller), (ArmState::Armed, InForce::default()), "{phase:?}");
    }
}

/// Every condition that ends a flight ends a trial in the same tick, whatever it is doing.
#[test]
fn every_hazard_ends_a_trial_at_once() {
    for phase in UNDER_WAY {
        for cause in Conditions::HAZARDS.iter() {
            let mut flight = trying(LostLink::Off, phase);
            flight.senses = Conditions::NONE.with(cause, true);
            let frame = flight.frame(None);
            assert_eq!((frame.state, frame.controller), (ArmState::Fault(cause), InForce::default()));
            assert_eq!(frame.volts, PerMotor::zero());
        }
    }
}

#[test]
fn a_disarming_and_a_lost_link_end_a_trial() {
    for phase in UNDER_WAY {
        let mut flight = trying(LostLink::Off, phase);
        flight.disarm = true;
        let frame = flight.frame(None);
        assert!(!frame.state.motors_may_turn());
        assert_eq!(frame.controller, InForce::default());
    }
    for (lost_link, armed) in
        // It lies level, where it is to land.
        [(LostLink::Off, false), (LostLink::Hold { ticks: 60_000 }, true), (LostLink::Land, false)]
    {
        let mut flight = trying(lost_link, TrialPhase::Flying);
        flight.heard = false;
        flight.run(flight.parameters.limits.command_timeout + 210, None);
        let frame = flight.control.frame();
        assert_eq!(frame.controller, InForce::default(), "{lost_link:?}");
        assert_eq!(frame.state == ArmState::Armed, armed, "{lost_link:?}");
    }
}

/// After a rule of its own has seen it for long enough.
#[test]
fn a_current_limit_ends_a_trial() {
    let mut flight = trying(LostLink::Off, TrialPhase::Flying);
    flight.current_limit = true;
    assert!(flight.run(CURRENT_TICKS + 1, None).is_some());
    assert_eq!(flight.control.frame().controller, InForce::default());
}

/// One that lets the nose sink is taken back when that is worse than a degree and twice what the accepted one
/// let happen of late: before, with a quieter flight; later, after the accepted one was pushed about.
#[test]
fn the_error_that_ends_a_trial_is_twice_the_accepted_ones_recent_worst_and_at_least_a_degree() {
    let error = |flight: &Flight| {
        let frame = flight.control.frame();
        frame.reference.minus(frame.angle).map(f32::abs)
    };
    for push in [0.0, 7.0] {
        let mut flight = hovering();
        let mut worst = PerAxis::zero();
        flight.bench.disturbance = PerMotor::new(push, 0.0);
        for tick in 0..3_000 {
            if tick == 1_000 {
                flight.bench.disturbance = PerMotor::zero();
            }
            flight.tick(None);
            worst = worst.zip(error(&flight), f32::max);
        }
        let bound = worst.map(|worst| f32::max(2.0 * worst, LEAST_ERROR));
        assert_eq!(push == 0.0, bound.pitch == LEAST_ERROR, "{worst:?}");
        // Nothing of the disturbance is cancelled, and the law is weak: a push moves it.
        let weak = ControllerSettings {
            law: own(&flight).law.map(|gain| 0.3 * gain),
            cancellation: Some(PerAxis::zero()),
            ..own(&flight)
        };
        flight.candidate = Some(candidate(&flight, weak, 10, 60_000));
        assert_eq!(flight.run(400, None), None);
        assert_eq!(flight.control.frame().controller.trial, TrialPhase::Flying);
        flight.bench.disturbance = PerMotor::new(-9.0, 0.0);
        let mut before = PerAxis::zero();
        let ended = (0..5_000).find(|_| {
            before = error(&flight);
            flight.frame(None).controller.trial == TrialPhase::FadingOut
        });
        assert!(ended.is_some(), "{push} V: {before:?} is within {bound:?}");
        // What the accepted one let happen was looked at every fourth tick only: within a tenth.
        let share = before.zip(bound, |error, bound| error / bound);
        let worst = f32::max(share.pitch, share.yaw);
        assert!((0.9..1.1).contains(&worst), "{push} V: {before:?} for {bound:?}");
    }
}

/// What it goes back to is what was accepted last, not what is stored.
#[test]
fn a_trial_after_an_accepted_one_goes_back_to_that() {
    let mut flight = trying(LostLink::Off, TrialPhase::Flying);
    let accepted = softer(&flight);
    flight.tick(Some(OperatorCommand::Accept));
    let unsaved = InForce { accepted: Kept::Unsaved, ..InForce::default() };
    assert_eq!(flight.control.frame().controller, unsaved);
    assert_eq!(flight.control.status().accepted, Some(Sequence(9)));
    flight.candidate = Some(candidate(&flight, own(&flight), 50, 500));
    assert_eq!(flight.run(2_000, None), None);
    assert_eq!(flight.control.frame().controller, unsaved);
    assert_eq!(flight.control.accepted.controller, accepted);
}

/// A candidate whose message another one has overtaken, or that finds a trial or no flight, is left alone.
#[test]
fn a_candidate_is_tried_only_where_its_own_command_asks_for_it() {
    let mut flight = hovering();
    let ours = candidate(&flight, softer(&flight), 100, 1_000);
    let ask = |flight: &mut Flight, sequence| {
        let command = Numbered { sequence: Sequence(sequence), message: OperatorCommand::Try };
        flight.tick_with(Some(&ours), Some(&command));
        flight.control.frame().controller.trial
    };
    assert_eq!(ask(&mut flight, 8), TrialPhase::None);
    assert_eq!(ask(&mut flight, 9), TrialPhase::Shadow);
    flight.run(100, None);
    let before = flight.control.trial;
    ask(&mut flight, 9);
    assert_eq!(flight.control.trial.map(|t| t.phase()), before.map(|t| t.phase()), "it goes on");
    flight.disarm = true;
    flight.tick(None);
    assert_eq!(ask(&mut flight, 9), TrialPhase::None);
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
