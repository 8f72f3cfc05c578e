//! Boards that a run is done with, for the next one.

use std::sync::{Mutex, PoisonError, mpsc};

use twinrotor::parameters::ram_flash::AREA_SIZE;

use super::emulator::Emulator;
use super::lockstep::Command;
use super::{SERIAL_ADDRESS, Setup};
use crate::record::ADDRESS;

static IDLE: Mutex<Vec<(Setup, Emulator)>> = Mutex::new(Vec::new());

/// What the parameter sectors hold at power-on, if `setup` puts nothing anywhere else.
pub(super) fn parameter_sectors(setup: &Setup) -> Option<Vec<u8>> {
    let mut sectors = vec![0xFF; AREA_SIZE];
    for (address, bytes) in setup.images.iter().filter(|(address, _)| *address != SERIAL_ADDRESS) {
        let from = usize::try_from(address.checked_sub(ADDRESS)?).ok()?;
        sectors.get_mut(from..from + bytes.len())?.copy_from_slice(bytes);
    }
    Some(sectors)
}

/// Whether boards of both differ in their parameter sectors at most.
fn alike(one: &Setup, other: &Setup) -> bool {
    let rest = |setup: &Setup| {
        let Setup { amplifiers, tick, settings, seed, refusals_allowed, protects_memory, .. } = *setup;
        (amplifiers, tick, settings, seed, refusals_allowed, protects_memory)
    };
    rest(one) == rest(other) && one.firmware.is(&other.firmware)
}

/// One for a board of `setup`.
pub(super) fn take(setup: &Setup) -> Option<Emulator> {
    let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
    let found = idle.iter().position(|(known, _)| alike(known, setup))?;
    Some(idle.swap_remove(found).1)
}

/// Keeps it, unless a test failed with it or it was tampered with in a way that a power-on does not undo.
pub(super) fn give_back(setup: Setup, mut emulator: Emulator) {
    let (answer, answered) = mpsc::channel();
    let ask = Command::With(Box::new(move |live| {
        // The one that asked waits for it.
        let _ = answer.send(live.tampered());
    }));
    if !std::thread::panicking() && emulator.command(ask).is_ok() && answered.recv() == Ok(false) {
        IDLE.lock().unwrap_or_else(PoisonError::into_inner).push((setup, emulator));
    }
}
