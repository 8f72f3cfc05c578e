//! The supply goes during a trial, or while what was accepted is being saved.

use twinrotor::link::{Nonce, ToBoard};
use twinrotor::parameters::Provenance;
use twinrotor::supervisor::Request;
use twinrotor::telemetry::{InForce, TrialPhase};
use twinrotor::trial::Attempt;
use virtual_board::chip::flash::Cut;
use virtual_board::record;
use virtual_board::station::Station;

use super::super::flying_with;
use super::super::parameters::read;
use super::{await_phase, scaled, try_out, with};

/// In its shadow, fading in, alone, taken back, accepted: the board boots with what is stored.
#[test]
fn a_power_cut_at_any_moment_of_a_trial_boots_the_stored_record() {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    for (moment, said) in [
        (1, None),
        (150, None),
        (330, None),
        (390, None),
        (450, None),
        (450, Some(ToBoard::Revert)),
        (450, Some(ToBoard::Accept(Nonce::default()))),
    ] {
        let mut station = flying_with(&rig, &parameters);
        try_out(&mut station, Attempt::new(scaled(&parameters, 0.9)));
        station.run(moment);
        if let Some(said) = &said {
            station.send(said);
            station.run(20);
        }
        let boots = station.heard.identities.len();
        station.machine.with(|board| board.cut_power());
        assert!(station.run_until(500, |heard| heard.identities.len() > boots));
        station.run(20);
        assert_eq!(read(&mut station), parameters, "{moment} ms, {said:?}");
        assert_eq!(station.heard.identities[boots].provenance, Provenance::Stored);
        assert_eq!(station.heard.frames.last().expect("frames").controller, InForce::default());
    }
}

/// Accepted in flight, motors off.
fn unsaved() -> Station {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    let mut station = flying_with(&rig, &parameters);
    try_out(&mut station, Attempt { fade_ms: 10, ..Attempt::new(scaled(&parameters, 0.9)) });
    await_phase(&mut station, 600, TrialPhase::Flying);
    station.send(&ToBoard::Accept(Nonce::default()));
    // A `Disarm` forgets what waits.
    station.run(20);
    station.request(Request::Disarm);
    station.run(50);
    station
}

#[test]
fn a_power_cut_in_a_save_leaves_the_stored_record_or_the_accepted_one_whole() {
    let (_, parameters) = record::tuned(record::BUILT_IN);
    let accepted = with(&parameters, scaled(&parameters, 0.9));
    let mut found = Vec::new();
    for (operation, share) in [(1, 0.0), (1, 0.5), (40, 0.5), (80, 1.0)] {
        let mut station = unsaved();
        let boots = station.heard.identities.len();
        let cut = Cut { operation, share };
        station.machine.with(move |board| board.flash().plan(&[cut]));
        station.send(&ToBoard::Save(Nonce::default()));
        assert!(station.run_until(2_000, |heard| heard.identities.len() > boots), "{cut:?} never came");
        station.run(20);
        found.push(read(&mut station) == accepted);
        assert!(found.last() == Some(&true) || read(&mut station) == parameters, "{cut:?}");
    }
    assert_eq!(found[..3], [false; 3], "the record's CRC is its last word");
}
