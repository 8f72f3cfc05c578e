//! Flights for the report, and what is read off them.

use crate::error::Outcome;
use crate::files;
use twinrotor::axes::PerAxis;
use twinrotor::plant::presets::Rig;
use twinrotor_sim::flight::{self, Fidelity, Flight, Plan, Row, Scalar};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::metrics::Settling;
use twinrotor_sim::scenario::{SAMPLE_TIME, Scenario};

/// A scenario of the paper's by name, flown from rest in the paper's world.
pub(super) fn fly(rig: &Rig, gains: &GainsFile, scenario: &str, seed: u64) -> Outcome<Flight> {
    fly_in(rig, rig, gains, &files::scenario(scenario)?, Fidelity::Ideal, seed)
}

/// A controller made for `believed`, on `rig`.
pub(super) fn fly_in(
    rig: &Rig,
    believed: &Rig,
    gains: &GainsFile,
    scenario: &Scenario,
    fidelity: Fidelity,
    seed: u64,
) -> Outcome<Flight> {
    let settings = gains.settings(believed);
    let plan =
        Plan { rig, truth: rig, settings: &settings, scenario, initial: PerAxis::both(0.0), fidelity, seed };
    Ok(flight::fly(&plan, Scalar::F32)?)
}

/// Reference minus angle \[rad\].
pub(super) fn errors(row: &Row) -> PerAxis<f64> {
    row.reference.minus(row.state.angle)
}

/// \[s\] When an axis' error came within `band` \[deg\] for good; infinity if it did not.
pub(super) fn within_deg(flight: &Flight, band: f64, of: fn(PerAxis<f64>) -> f64) -> f64 {
    let mut settling = Settling::new(band.to_radians());
    let mut last = 0;
    for (tick, row) in (0_u32..).zip(&flight.rows) {
        settling.add(f64::from(tick), of(errors(row)).abs());
        last = tick;
    }
    settling.time(0, last).map_or(f64::INFINITY, |ticks| ticks * SAMPLE_TIME)
}

/// \[deg\] Root mean square of an axis' error from `from` to `to` \[s\].
pub(super) fn rms_deg(flight: &Flight, [from, to]: [f64; 2], of: fn(PerAxis<f64>) -> f64) -> f64 {
    let within: Vec<f64> =
        flight.rows.iter().filter(|r| (from..to).contains(&r.time)).map(|r| of(errors(r)).powi(2)).collect();
    (within.iter().sum::<f64>() / within.len() as f64).sqrt().to_degrees()
}

/// \[deg\] Largest error of an axis from `from` to `to` \[s\].
pub(super) fn peak_deg(flight: &Flight, [from, to]: [f64; 2], of: fn(PerAxis<f64>) -> f64) -> f64 {
    let within = flight.rows.iter().filter(|r| (from..to).contains(&r.time));
    within.map(|r| of(errors(r)).abs()).fold(0.0, f64::max).to_degrees()
}

/// \[V² s\] ∫ of both motors' squared volts: what the electricity costs.
pub(super) fn effort(flight: &Flight) -> f64 {
    let squares = flight.rows.iter().map(|r| r.volts.main.powi(2) + r.volts.tail.powi(2));
    squares.sum::<f64>() * SAMPLE_TIME
}

pub(super) fn pitch(v: PerAxis<f64>) -> f64 {
    v.pitch
}

pub(super) fn yaw(v: PerAxis<f64>) -> f64 {
    v.yaw
}
