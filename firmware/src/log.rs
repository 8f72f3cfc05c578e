//! What the board says to a debug probe, by defmt: every change of state and of what is wrong, every verdict,
//! refusal, message that was none, save, slow tick and reset, with the time of the tick. From the thread
//! only: the tick hands its changes over in a queue. The words stay in the ELF.

use crate::shared::{Change, TICKS};
use core::sync::atomic::Ordering;
use twinrotor::first_power::Verdict;
use twinrotor::link::{LinkError, Refusal, ResetReport};
use twinrotor::parameters::Provenance;

defmt::timestamp!("{=u32:ms}", TICKS.load(Ordering::Relaxed));

/// \[cycles\] Ticks that take this long are worth a line: a tenth of the time there is.
const SLOW_CYCLES: u32 = crate::clock::COUNTS * crate::clock::CYCLES / 10;

pub(crate) fn boot(board: &str, reset: Option<ResetReport>, provenance: Provenance) {
    defmt::info!("{=str}: parameters {}", board, provenance);
    if let Some(report) = reset {
        defmt::warn!("the last boot ended by {}", report);
    }
}

pub(crate) fn change(change: &Change) {
    defmt::info!("tick {=u32}: {}, {}", change.tick, change.state, change.conditions);
}

pub(crate) fn verdict(verdict: Verdict) {
    defmt::info!("first-power check: {}", verdict);
}

pub(crate) fn refusal(refusal: &Refusal) {
    defmt::warn!("refused: {}", refusal);
}

pub(crate) fn rejected(error: LinkError) {
    defmt::warn!("no message: {}", error);
}

pub(crate) fn stale(messages: u32) {
    defmt::warn!("an old message, number {=u32} since boot", messages);
}

pub(crate) fn saved() {
    defmt::info!("parameters saved");
}

/// The longest tick since boot has taken longer than before.
pub(crate) fn longest_tick(cycles: u32) {
    if cycles > SLOW_CYCLES {
        defmt::warn!("a tick took {=u32} cycles", cycles);
    } else {
        defmt::debug!("longest tick: {=u32} cycles", cycles);
    }
}
