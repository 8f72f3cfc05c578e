//! What a trial takes of the tick.

use twinrotor::axes::PerAxis;
use twinrotor::link::{Nonce, ToBoard};
use twinrotor::telemetry::TrialPhase;
use twinrotor::trial::Attempt;
use virtual_board::record;

use super::super::flying_with;
use super::{await_phase, scaled, try_out};

/// \[instructions\] Of the 168,000 there are. The longest tick accepts: it copies a controller and all that
/// it has, matrices included, whether or not there are any.
const LONGEST: u64 = 4_700;

/// Two controllers in every tick, a trial's beginning, its end either way, and a setpoint in each phase.
#[test]
fn the_longest_tick_of_a_trial_is_within_its_bound() {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    let mut station = flying_with(&rig, &parameters);
    let before = station.machine.with(|board| board.ticks().len());
    for turn in 0..20_u8 {
        try_out(&mut station, Attempt { fade_ms: 20, ..Attempt::new(scaled(&parameters, 0.95)) });
        for phase in [TrialPhase::Shadow, TrialPhase::FadingIn, TrialPhase::Flying] {
            await_phase(&mut station, 600, phase);
            station.aim(PerAxis::new(0.01 * f32::from(turn % 7), 0.1));
        }
        // Some work is done every fourth tick, some every fifth.
        station.run(20 + u64::from(turn));
        station.send(&if turn % 2 == 0 { ToBoard::Revert } else { ToBoard::Accept(Nonce::default()) });
        await_phase(&mut station, 100, TrialPhase::None);
    }
    let ticks = station.machine.with(move |board| board.ticks()[before..].to_vec());
    let mut counts: Vec<(u64, usize)> = ticks.iter().map(|tick| tick.instructions).zip(before..).collect();
    counts.sort_unstable();
    let ((median, _), (longest, tick)) = (counts[counts.len() / 2], counts[counts.len() - 1]);
    println!("{median} instructions by the median, {longest} at most, in {} ticks", counts.len());
    let frame = station.heard.frames.iter().find(|frame| frame.tick as usize == tick);
    assert!(longest <= LONGEST, "a tick takes {longest} instructions, allowed are {LONGEST}: {frame:?}");
    assert!(median > 1_500, "two controllers computed: {median}");
}
