//! A scenario flown on the board by an operator's hand, and what the board's telemetry said of it.

use twinrotor::axes::PerAxis;
use twinrotor::first_power::REST_TICKS;
use twinrotor::link::ToBoard;
use twinrotor::plant::presets::Rig;
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::supervisor::{ArmState, Condition, Request};
use twinrotor::telemetry::Frame;
use twinrotor_sim::flight::Flight;
use twinrotor_sim::scenario::{Now, Scenario};
use twinrotor_station::flown::flown;

use crate::helicopter::Helicopter;
use crate::machine::Failure;
use crate::station::Station;

/// \[ms\] From one setpoint of a scenario that moves to the next.
const SETPOINT_EVERY: usize = 10;
/// \[ms\] How often the board's state is looked at in flight.
const LOOK_EVERY: u64 = 100;
/// \[ms\] Until telemetry comes at the rate that was asked for: one frame at the rate before.
const TO_FULL_RATE: u64 = 20;
/// \[ms\] Longest that anything on the ground may take; the first-power check is the longest.
const PATIENCE: u64 = 400_000;
/// \[ms\] To rise from where the rig rests and to hold still before the scenario begins.
const RISE: u64 = 8_000;

/// From switched on to hovering level: zeroes, checks the wiring if that has not been done, arms, waits.
/// `told` hears of every change of state.
///
/// # Errors
///
/// If the board does not come so far, with what it says instead.
pub fn take_off(station: &mut Station, told: &mut impl FnMut(&Frame)) -> Result<(), Failure> {
    wait(station, u64::from(REST_TICKS) + 100, told)?;
    if station.heard.conditions().contains(&Condition::NotChecked) {
        station.machine.rig(|rig: &mut Helicopter| rig.set_table(true));
        station.request(Request::Check);
        reach(station, ArmState::Checking, told)?;
        station.run_until(PATIENCE, |heard| !heard.verdicts.is_empty());
    }
    // Refused for as long as the rig still swings.
    for _ in 0..PATIENCE / 500 {
        station.send(&ToBoard::Zero);
        wait(station, 500, told)?;
        if !station.heard.conditions().contains(&Condition::NotZeroed) {
            break;
        }
    }
    reach(station, ArmState::Ready, told)?;
    station.aim(PerAxis::both(0.0));
    station.machine.rig(|rig: &mut Helicopter| rig.set_table(false));
    station.request(Request::Arm);
    reach(station, ArmState::Armed, told)?;
    wait(station, RISE, told)
}

fn reach(station: &mut Station, state: ArmState, told: &mut impl FnMut(&Frame)) -> Result<(), Failure> {
    for _ in 0..1_000 {
        wait(station, 2, told)?;
        if station.heard.state() == Some(state) {
            return Ok(());
        }
    }
    Err(Failure(format!("the board does not become {state:?}; it is {}", station.heard.summary())))
}

/// Lets the board run, and tells of every change.
fn wait(station: &mut Station, milliseconds: u64, told: &mut impl FnMut(&Frame)) -> Result<(), Failure> {
    let known = station.heard.frames.len().saturating_sub(1);
    station.try_run(milliseconds)?;
    let frames = &station.heard.frames[known..];
    let changes = frames.windows(2).filter(|pair| pair[0].state != pair[1].state);
    changes.for_each(|pair| told(&pair[1]));
    Ok(())
}

/// Flies a scenario on a board that hovers level. Its telemetry becomes the flight: what the board believed,
/// not what the simulated rig knew. What befalls the rig does so every `SETPOINT_EVERY` ms.
///
/// # Errors
///
/// If the board leaves the air.
pub fn fly(
    station: &mut Station,
    rig: &Rig,
    scenario: &Scenario,
    seed: u64,
    told: &mut impl FnMut(&Frame),
) -> Result<Flight, Failure> {
    let references = scenario.references::<f32>();
    let befalls: Vec<Now> = scenario.befalls(seed).take(references.len()).collect();
    // Of the flight every tick is wanted; what came before may have taken minutes.
    station.send(&ToBoard::Telemetry { every: 1 });
    wait(station, TO_FULL_RATE, told)?;
    let first = station.heard.frames.len();
    let mut befallen = Now::nothing();
    let mut sent = Reference::at_rest(PerAxis::both(0.0));
    let mut left = 0;
    for (references, befalls) in references.chunks(SETPOINT_EVERY).zip(befalls.chunks(SETPOINT_EVERY)) {
        let (reference, now) = (references[0], &befalls[0]);
        let change = befalls.iter().rev().find_map(|now| now.change.clone());
        let befalls_more = change.is_some() || !now.is_as(&befallen);
        // Nothing is looked at or touched more often than it must be: that stops the emulator.
        if reference != sent || befalls_more || left >= LOOK_EVERY {
            stay(station, std::mem::take(&mut left), told)?;
        }
        if reference != sent {
            station.send(&ToBoard::Setpoint(reference));
            sent = reference;
        }
        if befalls_more {
            befallen = now.clone();
            let now = now.clone();
            let plant = change.map(|change| change.of(&rig.plant).map(f32::from_f64));
            station.machine.rig(move |helicopter: &mut Helicopter| helicopter.befall(&now, plant.as_ref()));
        }
        left += references.len() as u64;
    }
    stay(station, left, told)?;
    let frames = &station.heard.frames[first..];
    // The first setpoint takes a moment over the link.
    let level = PerAxis::both(0.0);
    let begin = frames.iter().find(|frame| frame.reference != level).or(frames.first());
    Ok(flown(frames, begin.map_or(0, |frame| frame.tick), rig, scenario))
}

/// Flies on; the board must still be armed then.
fn stay(station: &mut Station, milliseconds: u64, told: &mut impl FnMut(&Frame)) -> Result<(), Failure> {
    wait(station, milliseconds, told)?;
    if station.heard.state() == Some(ArmState::Armed) {
        return Ok(());
    }
    Err(Failure(format!("the board left the air: {}", station.heard.summary())))
}
