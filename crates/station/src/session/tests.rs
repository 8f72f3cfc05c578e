mod line;
mod trial;

use super::*;
use crate::SimulatedBoard;
use crate::again::again;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::defaults;
use twinrotor::link::{Decoder, MAX_FRAME, encode};
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{SLOT_SIZE, Store};
use twinrotor::parameters::{self, Parameters};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{AERO2, HELI, Rig};
use twinrotor::reference::Reference;
use twinrotor::supervisor::{ArmState, Condition};

fn record(rig: &Rig, checked: bool) -> Parameters {
    let controller = if *rig == HELI { defaults::HELI } else { defaults::AERO2 };
    Parameters { checked, ..Parameters::new(rig, &Settings::new(rig, controller, SAMPLE_TIME)) }
}

/// A board that has been written before.
fn stored(rig: &Rig, checked: bool) -> SimulatedBoard {
    let mut store = Store::new(RamFlash::default(), 0);
    parameters::save(&mut store, &record(rig, checked), &mut [0; SLOT_SIZE]).unwrap();
    SimulatedBoard::new(rig, record(&AERO2, false), store.into_flash())
}

fn plan(rig: &Rig) -> Plan {
    let to = |angle, ticks| vec![Reference::at_rest(angle); ticks];
    let leg = [to(PerAxis::new(0.15, 0.3), 4_000), to(PerAxis::new(0.0, 0.1), 1_500)].concat();
    Plan {
        board: rig.board,
        parameters: record(rig, false),
        write: Write::Never,
        ask: false,
        frame_every: 1,
        injections: Vec::new(),
        legs: vec![Leg::Fly(leg)],
        save: false,
    }
}

/// A session with a board, a millisecond at a time, and a line between them that may do anything.
struct Desk {
    board: SimulatedBoard,
    session: Session,
    ticks: u64,
    events: Vec<Event>,
    /// What becomes of the bytes that the board says.
    line: Box<dyn FnMut(u64, Vec<u8>) -> Vec<u8>>,
}

impl Desk {
    fn new(board: SimulatedBoard, plan: Plan) -> Self {
        let session = Session::new(plan, Duration::ZERO);
        Self { board, session, ticks: 0, events: Vec::new(), line: Box::new(|_, bytes| bytes) }
    }

    fn tick(&mut self) {
        let now = Duration::from_millis(self.ticks);
        self.session.poll(now);
        self.board.push(&self.session.take_outgoing());
        self.board.tick();
        self.ticks += 1;
        let heard = (self.line)(self.ticks, self.board.take_outgoing());
        self.session.push(&heard, now);
        self.events.extend(std::iter::from_fn(|| self.session.event()));
    }

    /// Until it is over, or `done`.
    fn until(&mut self, mut done: impl FnMut(&Self) -> bool) {
        for _ in 0..400_000 {
            if self.session.is_over() || done(self) {
                return;
            }
            self.tick();
        }
        panic!("no end: {:?} {:?}", self.session.phase, self.steps());
    }

    fn end(&mut self) -> End {
        self.until(|_| false);
        self.events.extend(std::iter::from_fn(|| self.session.event()));
        match self.events.last() {
            Some(Event::Over(end)) => end.clone(),
            other => panic!("{other:?}"),
        }
    }

    fn flying(mut self) -> Self {
        self.until(|desk| matches!(desk.session.phase, Phase::Flying { begin: Begin::In(_), .. }));
        assert!(self.board.frame().state.motors_may_turn(), "{:?}", self.events.last());
        self
    }

    fn steps(&self) -> Vec<&str> {
        let step = |event: &Event| if let Event::Step(name, _) = event { Some(*name) } else { None };
        self.events.iter().filter_map(step).collect()
    }

    fn turns(&self) -> bool {
        self.board.frame().state.motors_may_turn()
    }
}

fn why(end: &End) -> &str {
    match &end.ending {
        Ending::Trouble(why) | Ending::Stopped(why) => why,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_checked_board_flies_its_plan_and_comes_down() {
    for rig in [AERO2, HELI] {
        let mut desk = Desk::new(stored(&rig, true), plan(&rig));
        let end = desk.end();
        assert_eq!(end, End { ending: Ending::Flown, motors: Motors::SeenOff }, "{:?}", desk.steps());
        let steps =
            ["found", "compared", "resting", "zeroed", "arming", "armed", "flying", "landing", "down"];
        assert_eq!(desk.steps(), steps);
        assert!(!desk.turns());
        // It followed: at the end of the first setpoint it was there.
        let begin = desk.events.iter().find_map(|event| match event {
            Event::Begins { leg: 0, tick } => Some(*tick),
            _ => None,
        });
        let at = |tick| move |event: &&Event| matches!(event, Event::Frame(frame) if frame.tick == tick);
        let Some(Event::Frame(there)) = desk.events.iter().find(at(begin.unwrap() + 3_990)) else { panic!() };
        assert!((there.angle.pitch - 0.15).abs() < 0.03 && (there.angle.yaw - 0.3).abs() < 0.03, "{there:?}");
    }
}

/// The host's own loop and bench, through exactly the ticks that the frames name.
#[test]
fn a_flight_computed_once_more_is_the_same_bit_for_bit_and_another_is_not() {
    for rig in [AERO2, HELI] {
        let mut desk = Desk::new(stored(&rig, true), plan(&rig));
        assert_eq!(desk.end().ending, Ending::Flown);
        let frame = |event: &Event| if let Event::Frame(frame) = event { Some(*frame) } else { None };
        let mut frames: Vec<Frame> = desk.events.iter().filter_map(frame).collect();
        let same = again(&rig, &record(&rig, true), &frames, desk.session.said(), None).unwrap();
        assert!(same > 6_000, "{same}");
        let middle = frames.iter().position(|frame| frame.state == ArmState::Armed).unwrap() + 3_000;
        frames[middle].rate.yaw = f32::from_bits(frames[middle].rate.yaw.to_bits() ^ 1);
        let told =
            again(&rig, &record(&rig, true), &frames, desk.session.said(), None).unwrap_err().to_string();
        assert!(told.starts_with("3000 ticks after arming"), "{told}");
    }
}

#[test]
fn a_board_from_the_bag_is_written_checked_and_flown_and_knows_it_after() {
    let board = SimulatedBoard::new(&AERO2, record(&AERO2, false), RamFlash::default());
    let mut desk = Desk::new(board, Plan { write: Write::Always, ..plan(&AERO2) });
    let end = desk.end();
    assert_eq!(end.ending, Ending::Flown, "{:?}", desk.steps());
    let steps = desk.steps();
    assert_eq!(steps[..6], ["found", "flash", "written", "checking", "checked", "written"]);
    // The next time there is nothing to do before zeroing.
    let mut again = Desk::new(desk.board.reset(), plan(&AERO2));
    assert_eq!(again.end().ending, Ending::Flown);
    assert_eq!(again.steps()[..3], ["found", "compared", "resting"]);
}

#[test]
fn what_differs_is_told_by_name_and_written_only_if_that_is_wanted() {
    let mut other = plan(&AERO2);
    other.parameters.limits.approach_rate = 0.25;
    let mut desk = Desk::new(stored(&AERO2, true), other.clone());
    let end = desk.end();
    assert!(why(&end).contains("does not have the parameters") && end.motors == Motors::NeverTurned);
    let told = desk.events.iter().find_map(|event| match event {
        Event::Differs(different) => Some(different.clone()),
        _ => None,
    });
    let told: Vec<String> = told.unwrap().iter().map(ToString::to_string).collect();
    assert_eq!(told, ["limits.approach_rate: 0.25 here, 0.5 on the board"]);
    let mut desk = Desk::new(desk.board, Plan { write: Write::Always, ..other });
    assert_eq!(desk.end().ending, Ending::Flown);
    // That its wiring had been checked is not forgotten.
    assert!(!desk.steps().contains(&"checking"));
}

#[test]
fn each_wish_waits_for_its_answer_and_a_no_turns_nothing() {
    let asking = Plan { ask: true, write: Write::Ask, ..plan(&AERO2) };
    let board = || SimulatedBoard::new(&AERO2, record(&AERO2, false), RamFlash::default());
    let wishes = [Wish::Write, Wish::Check, Wish::Rest, Wish::Arm];
    for (refused, wish) in wishes.iter().enumerate() {
        let mut desk = Desk::new(board(), asking.clone());
        for (k, expected) in wishes[..=refused].iter().enumerate() {
            desk.until(|desk| matches!(desk.session.phase, Phase::Asking(_)));
            // A person takes a while.
            (0..3_000).for_each(|_| desk.tick());
            assert!(!desk.turns() && desk.events.contains(&Event::Asks(expected.clone())), "{expected:?}");
            desk.session.answer(k < refused);
        }
        let end = desk.end();
        assert!(why(&end).contains("not agreed to"), "{wish:?}");
        assert!(!desk.turns() && end.motors != Motors::NotSeenOff);
    }
}

#[test]
fn an_interrupted_flight_ends_with_the_motors_seen_off_at_once() {
    let mut desk = Desk::new(stored(&AERO2, true), plan(&AERO2)).flying();
    let before = desk.ticks;
    desk.session.stop(Ending::Interrupted);
    desk.session.stop(Ending::Flown);
    assert_eq!(desk.end(), End { ending: Ending::Interrupted, motors: Motors::SeenOff });
    assert!(!desk.turns() && desk.ticks - before < 10, "{} ms", desk.ticks - before);
    // Before anything turned there is nothing to be switched off.
    let mut early = Desk::new(stored(&AERO2, true), plan(&AERO2));
    early.until(|desk| desk.steps().contains(&"compared"));
    early.session.stop(Ending::Interrupted);
    assert_eq!(early.end().motors, Motors::NeverTurned);
}

#[test]
fn a_fault_in_flight_is_told_in_words_and_cleared_the_next_time() {
    let mut desk = Desk::new(stored(&AERO2, true), plan(&AERO2)).flying();
    desk.board.rig.bench.supply = 2.0;
    let end = desk.end();
    assert!(why(&end).starts_with("a fault stopped the flight: the "), "{end:?}");
    assert!(matches!(end.ending, Ending::Stopped(_)) && end.motors == Motors::SeenOff && !desk.turns());
    // A supply that is out of range is told after ten ticks.
    (0..20).for_each(|_| desk.board.tick());
    let mut again = Desk::new(desk.board, plan(&AERO2));
    let end = again.end();
    assert!(why(&end).contains("cannot be cleared while the amplifiers' supply"), "{end:?}");
    again.board.rig.bench.supply = 24.0;
    let mut again = Desk::new(again.board, plan(&AERO2));
    assert_eq!(again.end().ending, Ending::Flown, "{:?}", again.steps());
    assert_eq!(again.steps()[..3], ["found", "fault", "cleared"]);
}

#[test]
fn an_emergency_stop_that_is_pressed_keeps_it_on_the_ground() {
    let mut board = stored(&AERO2, true);
    board.senses = twinrotor::supervisor::Conditions::of(&[Condition::EmergencyStop]);
    let end = Desk::new(board, plan(&AERO2)).end();
    assert!(why(&end).contains("the emergency stop is pressed"), "{end:?}");
    assert_eq!(end.motors, Motors::NeverTurned);
}

#[test]
fn wrong_wiring_is_found_before_the_flight() {
    let mut board = stored(&AERO2, false);
    board.rig.bench.faults.motors_swapped = true;
    let mut desk = Desk::new(board, plan(&AERO2));
    let end = desk.end();
    assert!(why(&end).contains("the motors are swapped"), "{end:?}");
    assert!(end.motors == Motors::SeenOff && !desk.turns() && !desk.steps().contains(&"arming"));
}

/// A gust ends it: the board's fault is told, whatever its number.
#[test]
fn a_rig_that_leaves_its_envelope_ends_the_flight() {
    let mut desk = Desk::new(stored(&AERO2, true), plan(&AERO2)).flying();
    desk.board.rig.bench.disturbance = PerMotor::new(200.0, -200.0);
    let end = desk.end();
    assert!(matches!(end.ending, Ending::Stopped(_)) && end.motors == Motors::SeenOff, "{end:?}");
    assert!(matches!(desk.board.frame().state, ArmState::Fault(_)));
}
