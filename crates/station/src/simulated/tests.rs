mod alone;
mod trial;

use super::*;
use crate::{Client, Event, Heard, Question};
use std::time::Duration;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::PerAxis;
use twinrotor::defaults;
use twinrotor::link::ToBoard;
use twinrotor::parameters::Provenance;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::AERO2;
use twinrotor::supervisor::{ArmState, Condition, Request};

fn parameters(checked: bool) -> Parameters {
    let settings = Settings::new(&AERO2, defaults::AERO2, SAMPLE_TIME);
    Parameters { checked, ..Parameters::new(&AERO2, &settings) }
}

/// An operator with a board, a millisecond at a time.
struct Desk {
    board: SimulatedBoard,
    client: Client,
    heard: Heard,
    ticks: u64,
}

impl Desk {
    fn new() -> Self {
        let board = SimulatedBoard::new(&AERO2, parameters(false), RamFlash::default());
        Self { board, client: Client::new(), heard: Heard::default(), ticks: 0 }
    }

    /// Up to `ticks` ticks, until `done`; whether it came to that.
    fn run(&mut self, ticks: u64, mut done: impl FnMut(&Heard, &SimulatedBoard) -> bool) -> bool {
        for _ in 0..ticks {
            let now = Duration::from_millis(self.ticks);
            self.client.poll(now);
            let bytes = self.client.take_outgoing();
            self.board.push(&bytes);
            self.board.tick();
            self.ticks += 1;
            for event in self.client.push(&self.board.take_outgoing(), now) {
                if let Event::Answered(Err(error)) = &event {
                    panic!("{error}");
                }
                self.heard.note(event);
            }
            if done(&self.heard, &self.board) {
                return true;
            }
        }
        false
    }

    fn wait(&mut self, ticks: u64) {
        self.run(ticks, |_, _| false);
    }

    fn await_state(&mut self, ticks: u64, state: ArmState) {
        let came = self.run(ticks, |heard, _| heard.state() == Some(state));
        assert!(came, "{state:?}: {}", self.heard.summary());
    }

    /// The whole road to a rig in the air.
    fn flying() -> Self {
        let mut desk = Self::new();
        desk.client.ask(Question::Write(Box::new(parameters(true))), Duration::ZERO);
        assert!(desk.run(100, |heard, _| heard.saved == 1), "{}", desk.heard.summary());
        desk.wait(2_000);
        desk.client.send(&ToBoard::Zero);
        desk.await_state(100, ArmState::Ready);
        desk.client.request(Request::Arm);
        desk.await_state(100, ArmState::Armed);
        desk.client.aim(PerAxis::new(0.1, 0.2));
        desk.wait(8_000);
        desk
    }
}

/// From an empty flash to a flight and down again, by nothing but messages.
#[test]
fn a_board_is_written_zeroed_armed_flown_and_disarmed_over_its_line() {
    let mut desk = Desk::flying();
    let frame = *desk.heard.frames.last().unwrap();
    assert_eq!(frame.state, ArmState::Armed);
    assert!((frame.angle.pitch - 0.1).abs() < 0.02 && (frame.angle.yaw - 0.2).abs() < 0.02, "{frame:?}");
    desk.client.request(Request::Disarm);
    desk.wait(3);
    assert!(!desk.board.frame().state.motors_may_turn());
    assert_eq!(desk.heard.damaged, 0);
    // A frame every 5 ms, health every second.
    let (frames, health) = (desk.heard.frames.len() as u64, desk.heard.health.len() as u64);
    assert!(frames.abs_diff(desk.ticks / 5) <= 1 && health.abs_diff(desk.ticks / 1_000) <= 1);
}

#[test]
fn the_first_power_check_is_run_over_the_line_and_only_with_the_rigs_parameters() {
    let mut desk = Desk::new();
    desk.client.request(Request::Check);
    desk.wait(100);
    assert_eq!(desk.heard.refusals, [Refusal::NoParameters]);
    desk.client.ask(Question::Write(Box::new(parameters(false))), Duration::from_millis(desk.ticks));
    assert!(desk.run(100, |heard, _| heard.saved == 1));
    desk.client.request(Request::Check);
    assert!(desk.run(400_000, |heard, _| !heard.verdicts.is_empty()), "{}", desk.heard.summary());
    assert_eq!(desk.heard.verdicts, [Verdict::Passed]);
}

/// The bytes of the whole flight, handed out again after a disarming as a ring buffer may: nothing happens.
#[test]
fn old_bytes_of_the_line_move_nothing() {
    let mut desk = Desk::new();
    let mut line = Vec::new();
    desk.client.ask(Question::Write(Box::new(parameters(true))), Duration::ZERO);
    let mut say = |desk: &mut Desk, ticks: u64| {
        for _ in 0..ticks {
            desk.client.poll(Duration::from_millis(desk.ticks));
            let bytes = desk.client.take_outgoing();
            line.extend(&bytes);
            desk.board.push(&bytes);
            desk.wait(1);
        }
    };
    say(&mut desk, 2_000);
    desk.client.send(&ToBoard::Zero);
    say(&mut desk, 50);
    desk.client.request(Request::Arm);
    say(&mut desk, 500);
    assert_eq!(desk.heard.state(), Some(ArmState::Armed), "{}", desk.heard.summary());
    desk.client.request(Request::Disarm);
    say(&mut desk, 50);
    assert_eq!(desk.heard.state(), Some(ArmState::Ready));
    let stale = desk.board.conversation.stale();
    for from in (0..line.len()).step_by(7) {
        desk.board.push(&line[from..]);
        for _ in 0..3 {
            desk.board.tick();
            assert!(!desk.board.frame().state.motors_may_turn());
        }
    }
    assert!(desk.board.conversation.stale() > stale + 100);
}

#[test]
fn a_host_that_falls_silent_ends_the_flight() {
    let mut desk = Desk::flying();
    desk.client.set_attentive(false);
    let fault = ArmState::Fault(Condition::CommandTimeout);
    assert!(desk.run(700, |heard, _| heard.state() == Some(fault)), "{}", desk.heard.summary());
}

#[test]
fn what_was_saved_is_there_after_a_reset_and_a_host_begins_anew() {
    let mut desk = Desk::new();
    desk.client.ask(Question::Write(Box::new(parameters(true))), Duration::ZERO);
    assert!(desk.run(100, |heard, _| heard.saved == 1));
    desk.board = desk.board.reset();
    desk.wait(50);
    let (first, second) = (&desk.heard.identities[0], desk.heard.identities.last().unwrap());
    assert_eq!((first.provenance, second.provenance), (Provenance::Missing, Provenance::Stored));
    assert_ne!(first.nonce, second.nonce);
    desk.client.ask(Question::Read, Duration::from_millis(desk.ticks));
    assert!(desk.run(100, |heard, _| heard.parameters.len() == 2));
    assert_eq!(desk.heard.parameters[1], parameters(true));
}
