//! A board that computes the rig of its own record, flown by a session and computed once more.

use super::*;
use crate::again::again;
use crate::session::{End, Ending, Event as Told, Leg, Motors, Plan, Session, Write};
use crate::words;
use twinrotor::axes::PerMotor;
use twinrotor::bench::{Faults, Injection};
use twinrotor::board::F405;
use twinrotor::plant::presets;
use twinrotor::reference::Reference;

fn record_of(name: &str, checked: bool) -> Parameters {
    let (_, rig) = presets::ALL.into_iter().find(|(known, _)| *known == name).unwrap();
    let settings = Settings::new(&rig, defaults::named(name).unwrap(), SAMPLE_TIME);
    Parameters { checked, port: RigPort::Simulated, ..Parameters::new(&rig, &settings) }
}

fn stored(record: &Parameters) -> SimulatedBoard {
    let mut store = Store::new(RamFlash::default(), 0);
    twinrotor::parameters::save(&mut store, record, &mut [0; SLOT_SIZE]).unwrap();
    SimulatedBoard::alone(F405, *record, store.into_flash())
}

fn plan(parameters: Parameters, injections: Vec<(u32, Injection)>) -> Plan {
    let there = vec![Reference::at_rest(PerAxis::new(0.15, 0.4)); 700];
    let back = vec![Reference::at_rest(PerAxis::new(-0.1, -0.4)); 2_500];
    let legs = vec![Leg::Fly([there, back].concat())];
    let board = F405;
    Plan {
        board,
        parameters,
        write: Write::Always,
        ask: false,
        frame_every: 1,
        injections,
        legs,
        save: false,
    }
}

/// To the end; how it ended, how many ticks were the same computed once more, and the steps.
fn fly(board: &mut SimulatedBoard, plan: Plan) -> (End, usize, Vec<&'static str>) {
    let parameters = plan.parameters;
    let (mut session, mut frames, mut steps) = (Session::new(plan, Duration::ZERO), Vec::new(), Vec::new());
    for tick in 0..400_000 {
        let now = Duration::from_millis(tick);
        session.poll(now);
        board.push(&session.take_outgoing());
        board.tick();
        session.push(&board.take_outgoing(), now);
        while let Some(event) = session.event() {
            match event {
                Told::Frame(frame) => frames.push(frame),
                Told::Step(step, _) => steps.push(step),
                Told::Over(end) => {
                    let rig = parameters.rig(F405);
                    let same = again(&rig, &parameters, &frames, session.said(), None);
                    return (end, same.unwrap_or_else(|why| panic!("{why}")), steps);
                }
                _ => {}
            }
        }
    }
    panic!("no end: {steps:?}");
}

#[test]
fn every_presets_rig_flies_from_its_record_and_the_same_once_more() {
    for (name, _) in presets::ALL {
        let record = record_of(name, true);
        let (end, same, steps) = fly(&mut stored(&record), plan(record, Vec::new()));
        assert_eq!(end, End { ending: Ending::Flown, motors: Motors::SeenOff }, "{name}: {steps:?}");
        assert!(same > 3_200, "{name}: {same}");
    }
}

/// From nothing stored: written, checked on the simulated rig, kept, flown.
#[test]
fn a_new_board_is_written_checked_and_flown_with_another_rig_than_the_built_in_one() {
    let mut board = SimulatedBoard::alone(F405, record_of("aero2", false), RamFlash::default());
    let (end, same, steps) = fly(&mut board, plan(record_of("heli", false), Vec::new()));
    assert_eq!(end.ending, Ending::Flown, "{steps:?}");
    assert!(same > 3_200 && steps.contains(&"checked"), "{steps:?}");
    // The board has kept that it was checked, on a simulated rig.
    let kept = board.reset().conversation;
    assert_eq!((kept.parameters().checked, kept.parameters().port), (true, RigPort::Simulated));
}

/// The supervisor's answer to each, and that the next session finds everything sound.
#[test]
fn whatever_befalls_the_rig_the_supervisor_answers_and_it_is_computed_once_more() {
    let stuck = Faults { encoder_stuck: PerAxis::new(true, false), ..Faults::default() };
    let reversed = Faults { encoder_reversed: PerAxis::new(false, true), ..Faults::default() };
    let slip = Faults { slip: PerAxis::new(0, 1_000), ..Faults::default() };
    let cases = [
        (Injection::Wiring(stuck), Some(Condition::PitchMotion)),
        (Injection::Wiring(reversed), Some(Condition::YawMotion)),
        (Injection::Wiring(slip), Some(Condition::YawJump)),
        (Injection::Supply(9.0), Some(Condition::SupplyJump)),
        (Injection::CurrentLimit(true), Some(Condition::CurrentLimit)),
        (Injection::EmergencyStop(true), Some(Condition::EmergencyStop)),
        (Injection::Stall { ticks: 3 }, Some(Condition::TickOverrun)),
        (Injection::Disturbance(PerMotor::new(2.0, -2.0)), None),
        (Injection::Weight { mass: 0.004, arm: 0.1 }, None),
    ];
    let record = record_of("aero2", true);
    let mut board = stored(&record);
    for (injection, answer) in cases {
        let (end, same, _) = fly(&mut board, plan(record, vec![(600, injection)]));
        let expected = answer.map_or(Ending::Flown, |cause| {
            Ending::Stopped(format!("a fault stopped the flight: {}", words::condition(cause)))
        });
        assert_eq!(end, End { ending: expected, motors: Motors::SeenOff }, "{injection:?}");
        assert!(same > 600, "{injection:?}: {same}");
    }
}

/// A board with a real rig at its port is not even armed for it.
#[test]
fn a_session_with_a_real_rig_refuses_that_anything_is_to_befall_it() {
    let record = Parameters { port: RigPort::Pwm, ..record_of("aero2", true) };
    let mut board = SimulatedBoard::new(&AERO2, record, RamFlash::default());
    let mut session = Session::new(plan(record, vec![(600, Injection::Supply(9.0))]), Duration::ZERO);
    for tick in 0..2_000 {
        session.poll(Duration::from_millis(tick));
        board.push(&session.take_outgoing());
        board.tick();
        session.push(&board.take_outgoing(), Duration::from_millis(tick));
        assert!(!board.frame().state.motors_may_turn());
    }
    let over = std::iter::from_fn(|| session.event())
        .find_map(|e| if let Told::Over(end) = e { Some(end) } else { None });
    let why = words::refusal(&Refusal::NotSimulated);
    assert_eq!(over, Some(End { ending: Ending::Trouble(why), motors: Motors::NeverTurned }));
}
