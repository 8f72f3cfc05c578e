//! A controller that is tried between two flights.

use super::*;

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
