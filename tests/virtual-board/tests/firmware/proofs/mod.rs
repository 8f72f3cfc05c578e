//! What a review of the firmware found, each turned into what must hold: old commands, a watchdog that stays
//! long, a supply that sinks, a crystal that fails, wires that are cut.

mod boot;
mod checking;
mod debugger;
mod line;
mod noise;
mod operator;
mod watchdog;
mod wires;

use twinrotor::parameters::Parameters;
use twinrotor::plant::presets::Rig;
use twinrotor::supervisor::ArmState;
use virtual_board::board::Outputs;
use virtual_board::record;
use virtual_board::serial::Flaw;
use virtual_board::station::Station;

/// What the firmware has built in, at its rig.
fn built_in() -> (Rig, Parameters) {
    record::tuned(record::BUILT_IN)
}

/// Every way in which a word can come badly.
const FLAWS: [Flaw; 3] = [Flaw::Framing, Flaw::Noise, Flaw::Overrun];

/// The board's states from the `from`th frame on, each once while it lasts.
fn states(station: &Station, from: usize) -> Vec<ArmState> {
    let mut found: Vec<ArmState> = station.heard.frames[from..].iter().map(|frame| frame.state).collect();
    found.dedup();
    found
}

/// The outputs of each millisecond from the `from`th on.
fn trace(station: &mut Station, from: usize) -> Vec<Outputs> {
    station.machine.with(move |board| board.trace()[from..].to_vec())
}

/// Milliseconds so far.
fn traced(station: &mut Station) -> usize {
    station.machine.with(|board| board.trace().len())
}

/// \[ms\] From the `from`th millisecond on, until the motors were last seen with volts.
fn driven(station: &mut Station, from: usize) -> usize {
    trace(station, from).iter().rposition(Outputs::live).map_or(0, |last| last + 1)
}
