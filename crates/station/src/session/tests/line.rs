//! What may go wrong on the line between a session and its board.

use super::*;

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
