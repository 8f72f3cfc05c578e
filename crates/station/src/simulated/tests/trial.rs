//! Controllers that are tried in flight, by nothing but messages.

use super::*;
use twinrotor::controller::ControllerSettings;
use twinrotor::telemetry::{InForce, Kept, TrialPhase};
use twinrotor::trial::Attempt;

/// The same law with gains that differ.
fn softer() -> ControllerSettings<f32> {
    let own = parameters(true).settings.controller;
    ControllerSettings { law: own.law.map(|gain| 0.9 * gain), ..own }
}

fn with(controller: ControllerSettings<f32>) -> Parameters {
    let mut with = parameters(true);
    with.settings.controller = controller;
    with
}

impl Desk {
    fn try_out(&mut self, attempt: Attempt) {
        self.client.send(&ToBoard::Trial(Nonce::default(), attempt));
    }

    #[track_caller]
    fn await_trial(&mut self, ticks: u64, phase: TrialPhase) {
        let came = self.run(ticks, |heard, _| heard.frames.last().unwrap().controller.trial == phase);
        assert!(came, "{phase:?}: {:?} {}", self.heard.frames.last(), self.heard.summary());
    }

    /// What the board reads back.
    fn read(&mut self) -> Parameters {
        let before = self.heard.parameters.len();
        self.client.ask(Question::Read, Duration::from_millis(self.ticks));
        assert!(self.run(100, |heard, _| heard.parameters.len() > before));
        *self.heard.parameters.last().unwrap()
    }
}

#[test]
fn a_controller_is_tried_accepted_saved_and_there_after_a_reset() {
    let mut desk = Desk::flying();
    desk.try_out(Attempt::new(softer()));
    desk.await_trial(10, TrialPhase::Shadow);
    assert_eq!(desk.read(), parameters(true));
    desk.await_trial(1_000, TrialPhase::Flying);
    assert_eq!(desk.read(), with(softer()));
    desk.client.send(&ToBoard::Accept(Nonce::default()));
    desk.await_trial(20, TrialPhase::None);
    let unsaved = InForce { accepted: Kept::Unsaved, ..InForce::default() };
    assert_eq!(desk.board.frame().controller, unsaved);
    assert_eq!(desk.read(), with(softer()));
    // Not in flight.
    desk.client.send(&ToBoard::Save(Nonce::default()));
    desk.wait(10);
    assert_eq!(desk.heard.refusals, [Refusal::MotorsMayTurn]);
    assert_eq!(desk.board.frame().state, ArmState::Armed);
    desk.client.request(Request::Disarm);
    desk.await_state(20, ArmState::Ready);
    assert_eq!(desk.board.frame().controller, unsaved);
    let before = desk.heard.saved;
    desk.client.ask(Question::Save, Duration::from_millis(desk.ticks));
    assert!(desk.run(100, |heard, _| heard.saved > before));
    desk.wait(20);
    assert_eq!(desk.board.frame().controller, InForce::default());
    desk.board = desk.board.reset();
    desk.wait(50);
    assert_eq!(desk.read(), with(softer()));
}

/// One that nobody saved is lost with the power.
#[test]
fn a_reset_boots_with_the_stored_controller() {
    let mut desk = Desk::flying();
    desk.try_out(Attempt { fade_ms: 10, ..Attempt::new(softer()) });
    desk.await_trial(1_000, TrialPhase::Flying);
    desk.client.send(&ToBoard::Accept(Nonce::default()));
    desk.await_trial(20, TrialPhase::None);
    desk.board = desk.board.reset();
    desk.wait(50);
    assert_eq!(desk.read(), parameters(true));
}

#[test]
fn a_trial_is_over_by_itself_or_when_taken_back() {
    let mut desk = Desk::flying();
    for revert in [false, true] {
        desk.try_out(Attempt { revert_ms: 1_000, ..Attempt::new(softer()) });
        desk.await_trial(1_000, TrialPhase::Flying);
        let flew_from = desk.ticks;
        if revert {
            desk.wait(200);
            desk.client.send(&ToBoard::Revert);
        }
        desk.await_trial(1_100, TrialPhase::FadingOut);
        let flew = desk.ticks - flew_from;
        assert!(if revert { flew < 220 } else { flew.abs_diff(1_000) < 20 }, "{flew} ms");
        desk.await_trial(200, TrialPhase::None);
        assert_eq!(desk.read(), parameters(true));
    }
    assert_eq!(desk.board.frame().state, ArmState::Armed);
}

/// A burst of [trial, trial, accept] before the loop has taken anything: the first is tried, the rest
/// refused.
#[test]
fn one_controller_is_tried_at_a_time() {
    let mut desk = Desk::flying();
    desk.try_out(Attempt::new(softer()));
    desk.try_out(Attempt::new(parameters(true).settings.controller));
    desk.client.send(&ToBoard::Accept(Nonce::default()));
    desk.await_trial(1_000, TrialPhase::Flying);
    assert_eq!(desk.heard.refusals, [Refusal::TrialUnderWay, Refusal::NothingToAccept]);
    assert_eq!(desk.read(), with(softer()));
}

#[test]
fn nothing_is_tried_on_the_ground() {
    let mut desk = Desk::new();
    desk.try_out(Attempt::new(softer()));
    desk.wait(20);
    assert_eq!(desk.heard.refusals, [Refusal::NotArmed]);
    // Nor are built-in parameters saved as the rig's.
    desk.client.send(&ToBoard::Save(Nonce::default()));
    desk.wait(20);
    assert_eq!(desk.heard.refusals, [Refusal::NotArmed, Refusal::NoParameters]);
    assert_eq!(desk.heard.saved, 0);
}
