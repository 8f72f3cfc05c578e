//! A fingerprint of a long flight: what shows that a browser computes the bits of a PC and of a board.

use twinrotor::axes::PerMotor;
use twinrotor::defaults;
use twinrotor::plant::presets;
use twinrotor::reference::Reference;
use twinrotor_sim::closed_loop::ClosedLoop;
use twinrotor_sim::error::known_name;
use twinrotor_sim::flight::{Fidelity, Plan, board_loop};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::{Error, Outcome};

/// FNV-1a's offset and prime, 64 bits.
const FNV: (u64, u64) = (0xcbf2_9ce4_8422_2325, 0x0100_0000_01b3);

/// Flies `ticks` of a scenario, over and over, with the board's own loop on a rig of a preset with its own
/// gains, and gives the hash of every bit of angles, rates and volts.
///
/// # Errors
///
/// If there is no preset or scenario of that name.
pub fn fingerprint(preset: &str, scenario: &str, ticks: u32) -> Outcome<u64> {
    let rig = *known_name("preset", preset, &presets::ALL)?;
    let controller = defaults::named(preset)
        .ok_or_else(|| Error::invalid("preset", preset, "one with gains of its own"))?;
    let settings = GainsFile { controller, provenance: None }.settings(&rig);
    let scenario = Scenario::named(scenario)?;
    let plan = Plan {
        rig: &rig,
        truth: &rig,
        settings: &settings,
        scenario: &scenario,
        initial: twinrotor::axes::PerAxis::zero(),
        fidelity: Fidelity::Rig,
        seed: 1,
    };
    let mut closed_loop = board_loop(&plan);
    let references: Vec<Reference<f32>> = scenario.references();
    let disturbances: Vec<PerMotor<f32>> = scenario.disturbances(plan.seed);
    let course = references.iter().zip(&disturbances).cycle();
    let (mut hash, prime) = FNV;
    for (reference, disturbance) in course.take(ticks as usize) {
        let happened = closed_loop.tick(reference, *disturbance);
        let twinrotor::plant::State { angle, rate } = happened.state;
        let volts = happened.applied;
        for number in [angle.pitch, angle.yaw, rate.pitch, rate.yaw, volts.main, volts.tail] {
            for byte in number.to_bits().to_le_bytes() {
                hash = (hash ^ u64::from(byte)).wrapping_mul(prime);
            }
        }
    }
    Ok(hash)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_tick_preset_or_scenario_has_another_fingerprint() {
        let all: std::collections::BTreeSet<u64> = [
            ("aero2", "step", 6_000),
            ("aero2", "step", 6_001),
            ("aero2", "3", 6_000),
            ("heli", "step", 6_000),
        ]
        .map(|(preset, scenario, ticks)| fingerprint(preset, scenario, ticks).unwrap())
        .into();
        assert_eq!(all.len(), 4);
        assert!(fingerprint("aero3", "step", 1).is_err() && fingerprint("aero", "steps", 1).is_err());
    }
}
