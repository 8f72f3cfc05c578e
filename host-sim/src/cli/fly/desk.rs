//! A session at its line, until it is over, whatever happens.

use super::ask::Question;
use super::differs;
use crate::line::{self, Line};
use crate::stop;
use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::PerAxis;
use twinrotor::link::Health;
use twinrotor::parameters::Parameters;
use twinrotor::telemetry::Frame;
use twinrotor_station::differences::{Difference, settings};
use twinrotor_station::session::{End, Ending, Event, Session, Write};
use twinrotor_station::words;

/// \[ticks\] From one line of progress to the next.
const PROGRESS_EVERY: u32 = 100;

/// A step that was taken.
#[derive(Debug, Clone, serde::Serialize)]
pub(super) struct Step {
    /// \[s\] Since the line was opened.
    pub(super) time: f64,
    pub(super) step: &'static str,
    pub(super) told: String,
}

/// What came of a session.
#[derive(Debug, Default)]
pub(super) struct Flown {
    pub(super) steps: Vec<Step>,
    pub(super) frames: Vec<Frame>,
    pub(super) health: Option<Health>,
    /// The board's tick in which each leg began.
    pub(super) begins: Vec<u32>,
    pub(super) differences: Vec<Difference>,
    /// \[ticks\] At which zero was set: what came before was measured from another.
    pub(super) zeroed: Option<u32>,
}

/// A session and its line. Dropped before its time, as by a panic, it still switches the motors off.
pub(super) struct Desk {
    line: Box<dyn Line>,
    pub(super) session: Session,
    parameters: Parameters,
    question: Option<Question>,
    bar: ProgressBar,
    worst: PerAxis<f32>,
    lost: bool,
    /// How many values that differ are told, and what is done about them.
    differing: (usize, Write),
    pub(super) flown: Flown,
}

impl Desk {
    pub(super) fn new(
        line: Box<dyn Line>,
        session: Session,
        parameters: Parameters,
        differing: (usize, Write),
    ) -> Self {
        let style = ProgressStyle::with_template("{msg}").expect("the template is well-formed");
        Self {
            line,
            session,
            parameters,
            question: None,
            bar: ProgressBar::new_spinner().with_style(style),
            worst: PerAxis::zero(),
            lost: false,
            differing,
            flown: Flown::default(),
        }
    }

    /// To the end; `told` hears of each step as it happens. Where telling fails, the flight ends.
    pub(super) fn run(&mut self, mut told: impl FnMut(&Step) -> crate::error::Outcome<()>) -> End {
        loop {
            if stop::requested() {
                self.session.stop(Ending::Interrupted);
            }
            if let Some(answer) = self.question.as_ref().and_then(Question::answer) {
                self.question = None;
                self.bar.reset();
                self.session.answer(answer);
            }
            self.turn();
            while let Some(event) = self.session.event() {
                match event {
                    Event::Over(end) => {
                        self.bar.finish_and_clear();
                        return end;
                    }
                    Event::Step(step, what) => {
                        if step == "zeroed" {
                            self.flown.zeroed = self.flown.frames.last().map(|frame| frame.tick);
                        }
                        self.take(step, what, &mut told);
                    }
                    Event::Differs(differences) => {
                        let all = settings(&self.parameters);
                        let (most, writing) = self.differing;
                        for line in differs::lines(&differences, all, most, writing) {
                            self.take("differs", line, &mut told);
                        }
                        self.flown.differences = differences;
                    }
                    Event::Asks(wish) => {
                        // Its line is for the answer.
                        self.bar.finish_and_clear();
                        self.question = Some(Question::put(&wish, &self.parameters));
                    }
                    Event::Frame(frame) => self.note(frame),
                    Event::Health(health) => self.flown.health = Some(health),
                    Event::Begins { tick, .. } => {
                        self.worst = PerAxis::zero();
                        self.line.begins(tick);
                        self.flown.begins.push(tick);
                    }
                }
            }
        }
    }

    /// Tells a step and keeps it.
    fn take(
        &mut self,
        step: &'static str,
        what: String,
        told: &mut impl FnMut(&Step) -> crate::error::Outcome<()>,
    ) {
        let time = (self.line.now().as_secs_f64() * 1e3).round() / 1e3;
        let step = Step { time, step, told: what };
        if let Err(failure) = self.bar.suspend(|| told(&step)) {
            self.session.stop(Ending::Trouble(failure.to_string()));
        }
        self.flown.steps.push(step);
    }

    /// To the line and back.
    fn turn(&mut self) {
        self.session.poll(self.line.now());
        let outgoing = self.session.take_outgoing();
        match self.line.exchange(&outgoing) {
            Ok(bytes) => self.session.push(&bytes, self.line.now()),
            Err(error) => {
                if !self.lost {
                    self.lost = true;
                    self.session.stop(Ending::Trouble(format!("the line to the board failed: {error}")));
                }
                // It may come back until the session has given up.
                std::thread::sleep(Duration::from_millis(5));
            }
        }
    }

    fn note(&mut self, frame: Frame) {
        self.flown.frames.push(frame);
        let error = frame.reference.zip(frame.angle, |reference, angle| (reference - angle).abs());
        self.worst = self.worst.zip(error, f32::max);
        if frame.tick.is_multiple_of(PROGRESS_EVERY) && self.question.is_none() && !self.bar.is_hidden() {
            let degrees = |x: f32| f64::from(x).to_degrees();
            self.bar.set_message(format!(
                "{:9.1} s  {:9}  pitch {:7.2}°  yaw {:7.2}°  worst error {:.2}° {:.2}°",
                f64::from(frame.tick) * SAMPLE_TIME,
                words::state(frame.state),
                degrees(frame.angle.pitch),
                degrees(frame.angle.yaw),
                degrees(self.worst.pitch),
                degrees(self.worst.yaw),
            ));
        }
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        if !self.session.is_over() {
            // The session may be what has failed.
            line::switch_off(&mut *self.line);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Failure;
    use crate::line::Simulated;
    use std::cell::RefCell;
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::rc::Rc;
    use twinrotor::defaults;
    use twinrotor::pipeline::Settings;
    use twinrotor::plant::presets::AERO2;
    use twinrotor::reference::Reference;
    use twinrotor_station::session::{Leg, Motors, Plan};

    /// A board whose line goes through somebody's hands.
    struct Shared {
        board: Rc<RefCell<Simulated>>,
        panics_in_flight: bool,
    }

    impl Line for Shared {
        fn exchange(&mut self, bytes: &[u8]) -> std::io::Result<Vec<u8>> {
            let flies = self.board.borrow().frame().state.motors_may_turn();
            assert!(!(flies && std::mem::take(&mut self.panics_in_flight)), "a mistake of this program");
            self.board.borrow_mut().exchange(bytes)
        }

        fn now(&self) -> Duration {
            self.board.borrow().now()
        }
    }

    fn desk(panics_in_flight: bool) -> (Desk, Rc<RefCell<Simulated>>) {
        let settings = Settings::new(&AERO2, defaults::AERO2, SAMPLE_TIME);
        let parameters = Parameters { checked: true, ..Parameters::new(&AERO2, &settings) };
        let board = Rc::new(RefCell::new(Simulated::new(AERO2.board, &parameters, false).unwrap()));
        let plan = Plan {
            board: AERO2.board,
            parameters,
            write: Write::Never,
            ask: false,
            frame_every: 1,
            injections: Vec::new(),
            legs: vec![Leg::Fly(vec![Reference::default(); 2_000])],
            save: false,
        };
        let line = Box::new(Shared { board: Rc::clone(&board), panics_in_flight });
        (Desk::new(line, Session::new(plan, Duration::ZERO), parameters, (0, Write::Never)), board)
    }

    #[test]
    fn a_panic_in_flight_still_switches_the_motors_off() {
        let (mut desk, board) = desk(true);
        let panicked = catch_unwind(AssertUnwindSafe(move || desk.run(|_| Ok(()))));
        assert!(panicked.is_err() && board.borrow().frame().tick > 1_500);
        assert!(!board.borrow().frame().state.motors_may_turn());
    }

    /// Standard output on a full disk, a closed terminal.
    #[test]
    fn a_step_that_cannot_be_told_ends_the_flight() {
        let (mut desk, board) = desk(false);
        let end = desk.run(|step| match step.step {
            "flying" => Err(Failure::Run("nobody hears it".to_owned())),
            _ => Ok(()),
        });
        assert_eq!(
            end,
            End { ending: Ending::Trouble("nobody hears it".to_owned()), motors: Motors::SeenOff }
        );
        assert!(!board.borrow().frame().state.motors_may_turn());
    }
}
