//! Controllers that are tried in flight, on the released firmware.

mod agreement;
mod ends;
mod power;
mod time;
mod twin;

use twinrotor::controller::ControllerSettings;
use twinrotor::link::{Nonce, ToBoard};
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets::Rig;
use twinrotor::telemetry::TrialPhase;
use twinrotor::trial::Attempt;
use virtual_board::record;
use virtual_board::station::Station;

use super::flying_with;

/// \[ms\] The longest trial that a board flies.
const MOST_REVERT_MS: u32 = 600_000;

/// The controller of `parameters` with its law's gains times `factor`.
fn scaled(parameters: &Parameters, factor: f32) -> ControllerSettings<f32> {
    let own = parameters.settings.controller;
    ControllerSettings { law: own.law.map(|gain| factor * gain), ..own }
}

fn with(parameters: &Parameters, controller: ControllerSettings<f32>) -> Parameters {
    let mut other = *parameters;
    other.settings.controller = controller;
    other
}

fn try_out(station: &mut Station, attempt: Attempt) {
    station.send(&ToBoard::Trial(Nonce::default(), attempt));
}

fn phase(station: &Station) -> TrialPhase {
    station.heard.frames.last().expect("frames").controller.trial
}

#[track_caller]
fn await_phase(station: &mut Station, milliseconds: u64, phase: TrialPhase) {
    let came = station.run_until(milliseconds, |heard| {
        heard.frames.last().is_some_and(|frame| frame.controller.trial == phase)
    });
    assert!(came, "not {phase:?}: {:?} {}", station.heard.frames.last(), station.heard.summary());
}

/// A flight in which another controller than the built-in one flies alone, and is not accepted for as long as
/// a board lets it.
#[track_caller]
pub(super) fn trying() -> Station {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    trying_with(&rig, &parameters)
}

/// The same of `parameters` at `rig`.
#[track_caller]
pub(super) fn trying_with(rig: &Rig, parameters: &Parameters) -> Station {
    let mut station = flying_with(rig, parameters);
    begin_trial(&mut station, parameters);
    await_phase(&mut station, 1_000, TrialPhase::Flying);
    station
}

/// Has another controller tried, until it flies in the shadow of that of `parameters`.
#[track_caller]
pub(super) fn begin_trial(station: &mut Station, parameters: &Parameters) {
    let attempt = Attempt { revert_ms: MOST_REVERT_MS, ..Attempt::new(scaled(parameters, 0.95)) };
    try_out(station, attempt);
    await_phase(station, 50, TrialPhase::Shadow);
}
