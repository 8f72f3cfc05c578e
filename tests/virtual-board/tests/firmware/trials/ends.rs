//! What becomes of a controller that is tried: accepted and saved, taken back, or too bad to fly.

use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::law::{LawSettings, StateFeedbackGains};
use twinrotor::link::{Nonce, Refusal, ToBoard};
use twinrotor::supervisor::{ArmState, Request};
use twinrotor::telemetry::{InForce, Kept, TrialPhase};
use twinrotor::trial::Attempt;
use virtual_board::record;

use super::super::parameters::read;
use super::super::{board_with, flying_with, make_ready};
use super::{await_phase, scaled, try_out, with};
use twinrotor::controller::ControllerSettings;

/// What is read back is what flies, bit for bit, at every step of the way to flash.
#[test]
fn a_controller_is_tried_accepted_and_saved_and_read_back_all_along() {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    let tried = with(&parameters, scaled(&parameters, 0.9));
    let mut station = flying_with(&rig, &parameters);
    try_out(&mut station, Attempt::new(tried.settings.controller));
    await_phase(&mut station, 50, TrialPhase::Shadow);
    assert_eq!(read(&mut station), parameters);
    // One at a time; and nothing to accept yet.
    try_out(&mut station, Attempt::new(parameters.settings.controller));
    station.send(&ToBoard::Accept(Nonce::default()));
    await_phase(&mut station, 600, TrialPhase::Flying);
    assert_eq!(station.heard.refusals, [Refusal::TrialUnderWay, Refusal::NothingToAccept]);
    assert_eq!(read(&mut station), tried);
    station.send(&ToBoard::Accept(Nonce::default()));
    await_phase(&mut station, 50, TrialPhase::None);
    let unsaved = InForce { accepted: Kept::Unsaved, ..InForce::default() };
    assert_eq!(station.heard.frames.last().expect("frames").controller, unsaved);
    assert_eq!(read(&mut station), tried);
    station.send(&ToBoard::Save(Nonce::default()));
    station.run(20);
    assert_eq!(station.heard.refusals.last(), Some(&Refusal::MotorsMayTurn));
    assert_eq!(station.heard.state(), Some(ArmState::Armed));
    station.request(Request::Disarm);
    station.run(50);
    station.send(&ToBoard::Save(Nonce::default()));
    assert!(station.run_until(2_000, |heard| heard.saved == 1), "{}", station.heard.summary());
    station.run(20);
    assert_eq!(station.heard.frames.last().expect("frames").controller, InForce::default());
    assert_eq!(read(&mut station), tried);
    station.machine.with(|board| board.cut_power());
    station.run(100);
    assert_eq!(read(&mut station), tried, "after a power cycle");
}

/// A law with its signs wrong: what it is off by, it makes more of.
#[test]
fn an_unstable_controller_is_taken_back_inside_the_envelope() {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    let mut station = flying_with(&rig, &parameters);
    station.run(4_000);
    let axis = |pitch, yaw| PerAxis::new(pitch, yaw);
    let none = PerMotor::both(PerAxis::zero());
    let law = LawSettings::StateFeedback(StateFeedbackGains {
        angle: PerMotor { main: axis(-100.0, 0.0), tail: axis(0.0, -100.0) },
        rate: none,
        integral: none,
        integral_limit: 0.0,
        feed_forward: false,
    });
    let controller = ControllerSettings { law, ..parameters.settings.controller };
    let from = station.heard.frames.len();
    try_out(&mut station, Attempt { revert_ms: 600_000, ..Attempt::new(controller) });
    station.aim(PerAxis::new(0.15, 0.4));
    station.run(10_000);
    let frames = &station.heard.frames[from..];
    assert!(frames.iter().any(|frame| frame.controller.trial == TrialPhase::FadingOut));
    assert!(frames.iter().all(|frame| frame.state == ArmState::Armed), "{}", station.heard.summary());
    let last = frames.last().expect("frames");
    assert_eq!(last.controller, InForce::default());
    assert!((last.angle.pitch - 0.15).abs() < 0.02 && (last.angle.yaw - 0.4).abs() < 0.02, "{last:?}");
}

#[test]
fn nothing_is_tried_on_the_ground_or_out_of_range() {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    let mut station = board_with(&rig, &parameters);
    make_ready(&mut station);
    try_out(&mut station, Attempt::new(parameters.settings.controller));
    station.run(20);
    assert_eq!(station.heard.refusals, [Refusal::NotArmed]);
    let mut station = flying_with(&rig, &parameters);
    try_out(&mut station, Attempt { fade_ms: 0, ..Attempt::new(parameters.settings.controller) });
    station.run(20);
    assert!(
        matches!(&station.heard.refusals[..], [Refusal::Range { field, .. }] if field == "trial.fade_ms"),
        "{:?}",
        station.heard.refusals
    );
}
