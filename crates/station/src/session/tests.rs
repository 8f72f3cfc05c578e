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
fn a_silent_port_an_echo_and_noise_are_told_apart() {
    let mut silent = Desk::new(stored(&AERO2, true), plan(&AERO2));
    silent.line = Box::new(|_, _| Vec::new());
    assert!(why(&silent.end()).contains("did not answer within 3 s"));
    let mut noisy = Desk::new(stored(&AERO2, true), plan(&AERO2));
    // 100 bytes a millisecond: a line of a megabaud, full.
    noisy.line = Box::new(|tick, _| (0..100_u64).map(|k| ((tick * 100 + k) * 37 % 251) as u8).collect());
    assert!(why(&noisy.end()).contains("that are no messages"));
    // One that speaks, and does not hear.
    let mut deaf = Desk::new(stored(&AERO2, true), plan(&AERO2));
    deaf.until(|desk| desk.board.frame().tick > 3);
    (0..50).for_each(|_| deaf.board.tick());
    deaf.board.take_outgoing();
    let telemetry: Vec<u8> = (0..20)
        .flat_map(|_| {
            deaf.board.tick();
            deaf.board.take_outgoing()
        })
        .collect();
    let mut desk = Desk::new(deaf.board, plan(&AERO2));
    desk.line = Box::new(move |_, _| telemetry.clone());
    assert!(why(&desk.end()).contains("speaks and does not answer"));
    let mut session = Session::new(plan(&AERO2), Duration::ZERO);
    for ms in 0..5_000 {
        session.poll(Duration::from_millis(ms));
        let said = session.take_outgoing();
        session.push(&said, Duration::from_millis(ms));
    }
    let over = std::iter::from_fn(|| session.event()).last();
    let Some(Event::Over(end)) = over else { panic!("{over:?}") };
    assert!(why(&end).contains("hands back what is sent"), "{end:?}");
}

/// A cable that is pulled in flight, and then a line that drowns in noise.
#[test]
fn a_board_that_falls_silent_is_told_to_stop_and_not_believed_to_have() {
    for noise in [false, true] {
        let mut desk = Desk::new(stored(&AERO2, true), plan(&AERO2)).flying();
        desk.line = Box::new(move |_, _| if noise { vec![0x55; 100] } else { Vec::new() });
        let end = desk.end();
        assert_eq!(end.motors, Motors::NotSeenOff);
        assert_eq!(why(&end), "the board has fallen silent");
        // Only its voice was lost: it has heard.
        assert!(!desk.turns());
    }
}

#[test]
fn a_line_that_loses_a_tenth_of_all_frames_still_flies() {
    let mut desk = Desk::new(stored(&AERO2, true), plan(&AERO2));
    desk.line = Box::new(|tick, mut bytes| {
        if tick.is_multiple_of(10) {
            bytes.truncate(bytes.len() / 2);
        }
        bytes
    });
    assert_eq!(desk.end(), End { ending: Ending::Flown, motors: Motors::SeenOff }, "{:?}", desk.steps());
}

#[test]
fn a_board_that_is_reset_in_flight_ends_it() {
    let mut desk = Desk::new(stored(&AERO2, true), plan(&AERO2)).flying();
    desk.board = desk.board.reset();
    let end = desk.end();
    assert!(why(&end).contains("was reset") && matches!(end.ending, Ending::Stopped(_)), "{end:?}");
    assert!(end.motors == Motors::SeenOff && !desk.turns());
}

/// Word of one `Zero` comes when the next is on its way already.
#[test]
fn what_the_board_says_may_come_late() {
    let mut desk = Desk::new(stored(&AERO2, true), plan(&AERO2));
    let mut late = VecDeque::new();
    desk.line = Box::new(move |_, bytes| {
        late.push_back(bytes);
        if late.len() > 700 { late.pop_front().unwrap_or_default() } else { Vec::new() }
    });
    assert_eq!(desk.end(), End { ending: Ending::Flown, motors: Motors::SeenOff }, "{:?}", desk.steps());
}

/// A verdict is said once: whether it passed is in every frame.
#[test]
fn a_verdict_that_is_lost_is_known_from_the_frames() {
    let mut desk = Desk::new(stored(&AERO2, false), plan(&AERO2));
    let mut decoder = Decoder::new();
    desk.line = Box::new(move |_, bytes| {
        let messages = bytes.into_iter().filter_map(|byte| decoder.push::<ToHost>(byte)?.ok());
        let heard = messages.filter(|message| !matches!(message, ToHost::Verdict(_)));
        heard.flat_map(|message| encode(&message, &mut [0; MAX_FRAME]).unwrap().to_vec()).collect()
    });
    assert_eq!(desk.end(), End { ending: Ending::Flown, motors: Motors::SeenOff }, "{:?}", desk.steps());
    assert!(desk.steps().contains(&"checked"));
}

#[test]
fn two_programs_on_one_board() {
    // The second finds the board in the air, and leaves it alone.
    let desk = Desk::new(stored(&AERO2, true), plan(&AERO2)).flying();
    let mut second = Desk::new(desk.board, plan(&AERO2));
    let end = second.end();
    assert!(why(&end).contains("another program") && end.motors == Motors::NeverTurned, "{end:?}");
    // One that disarms it ends the first one's flight.
    let mut desk = Desk::new(stored(&AERO2, true), plan(&AERO2)).flying();
    let mut other = Client::new();
    other.request(Request::Disarm);
    desk.board.push(&other.take_outgoing());
    let end = desk.end();
    assert!(why(&end).contains("somebody else") && end.motors == Motors::SeenOff && !desk.turns());
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

/// The same law with gains that differ by `factor`.
fn attempt(factor: f32) -> Box<Attempt> {
    let own = record(&AERO2, true).settings.controller;
    let controller = twinrotor::controller::ControllerSettings { law: own.law.map(|g| factor * g), ..own };
    Box::new(Attempt { revert_ms: 60_000, ..Attempt::new(controller) })
}

/// Flown, tried, flown again, then kept or taken back.
fn trying(factor: f32, last: Leg) -> Plan {
    let plan = plan(&AERO2);
    let fly = plan.legs[0].clone();
    Plan { legs: vec![fly.clone(), Leg::Try(attempt(factor)), fly, last], ..plan }
}

#[test]
fn a_controller_is_tried_between_two_flights_accepted_saved_and_the_same_here() {
    let mut desk = Desk::new(stored(&AERO2, true), Plan { save: true, ..trying(0.9, Leg::Accept) });
    let end = desk.end();
    assert_eq!(end, End { ending: Ending::Flown, motors: Motors::SeenOff }, "{:?}", desk.steps());
    let steps = ["flying", "trying", "tried", "flying", "accepted", "landing", "down", "saved"];
    assert_eq!(desk.steps()[6..], steps);
    let begins = desk.events.iter().filter(|event| matches!(event, Event::Begins { .. })).count();
    assert_eq!(begins, 2);
    let frame = |event: &Event| if let Event::Frame(frame) = event { Some(*frame) } else { None };
    let frames: Vec<Frame> = desk.events.iter().filter_map(frame).collect();
    let tried = desk.session.tried().copied();
    let same = again(&AERO2, &record(&AERO2, true), &frames, desk.session.said(), tried.as_ref()).unwrap();
    assert!(same > 14_000, "{same}");
    // It boots with it.
    let mut wanted = plan(&AERO2);
    wanted.parameters.settings.controller = tried.unwrap().1.controller;
    let mut again = Desk::new(desk.board.reset(), wanted);
    assert_eq!(again.end().ending, Ending::Flown);
    assert_eq!(again.steps()[1], "compared");
}

#[test]
fn a_controller_that_is_not_kept_flies_no_more() {
    let mut desk = Desk::new(stored(&AERO2, true), Plan { save: true, ..trying(0.9, Leg::Revert) });
    assert_eq!(desk.end().ending, Ending::Flown);
    assert_eq!(desk.steps()[6..], ["flying", "trying", "tried", "flying", "reverted", "landing", "down"]);
    let mut again = Desk::new(desk.board, plan(&AERO2));
    assert_eq!(again.end().ending, Ending::Flown);
    assert_eq!(again.steps()[1], "compared");
}

/// Errors beyond twice those of the first flight end the trial: the rig comes down with the accepted
/// controller, and it is told.
#[test]
fn a_controller_that_the_board_takes_back_is_not_accepted() {
    let small = Leg::Fly(vec![Reference::at_rest(PerAxis::new(0.01, 0.01)); 2_000]);
    let mut trying = trying(0.9, Leg::Accept);
    trying.legs[0] = small;
    let mut desk = Desk::new(stored(&AERO2, true), trying);
    let end = desk.end();
    assert!(why(&end).contains("has taken the trial back"), "{end:?} {:?}", desk.steps());
    assert!(end.motors == Motors::SeenOff && !desk.turns());
    assert_eq!(desk.steps()[6..], ["flying", "trying", "tried", "flying", "taken back", "landing", "down"]);
}
