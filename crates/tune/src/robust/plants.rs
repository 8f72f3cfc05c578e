//! The plants that a controller must be robust against: drawn around a preset, each with its own disturbance
//! and encoder phase.

use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::plant::presets::{self, Rig};
use twinrotor::plant::{Effectiveness, PlantParameters};
pub use twinrotor_sim::device::Draw;
use twinrotor_sim::error::{Error, Outcome};

/// Spread of the body's constants and thrust gains: uniform, each on its own, within this part of the
/// preset's.
pub const SPREAD: f64 = 0.3;
/// Spread of each rotor's lag.
pub const LAG_SPREAD: f64 = 0.7;

/// How far constants may lie from the preset's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    /// Part of the body's constants and thrust gains, 0 to .9.
    pub constants: f64,
    /// Part of each rotor's lag, 0 to .95.
    pub lag: f64,
}

impl Default for Scatter {
    fn default() -> Self {
        Self { constants: SPREAD, lag: LAG_SPREAD }
    }
}

impl Scatter {
    /// Could there be plants with it?
    ///
    /// # Errors
    ///
    /// Which is out of range, and what is allowed.
    pub fn validate(&self) -> Outcome<()> {
        for (field, value, most) in [("spread", self.constants, 0.9), ("lag-spread", self.lag, 0.95)] {
            if !(0.0..=most).contains(&value) {
                let allowed = format_args!("0 to {most}, a part of the preset's value");
                return Err(Error::invalid(field, value, allowed));
            }
        }
        Ok(())
    }

    /// In words, where it is not the usual.
    pub fn told(&self) -> Option<String> {
        (*self != Self::default()).then(|| format!("spread {}, lag spread {}", self.constants, self.lag))
    }
}

/// What is added to a seed for plants that no tuning has seen: tuning draws from the seed itself.
pub const UNSEEN: u64 = 1_000_000;
/// \[V\] Largest disturbance of each motor.
pub const DISTURBANCE: f64 = 2.0;

/// `count` plants around `rig`. The same seed gives the same plants, and the first of many are those of few.
///
/// L, both inertias, both dampings, K_sp and the four thrust gains (linear and quadratic part by one factor)
/// are uniform within ±30 %, lags within ±70 %, disturbances within ±2 V. `tilting_inertia` keeps its part of
/// yaw's. Mass, gravity, friction, reaction torque and what tilts of the rotors' are the preset's.
pub fn draw(rig: &Rig, count: usize, seed: u64) -> Vec<Draw> {
    draw_within(rig, count, seed, &Scatter::default())
}

/// As [`draw`], with constants and lags within `scatter` instead of ±30 and ±70 %.
pub fn draw_within(rig: &Rig, count: usize, seed: u64, scatter: &Scatter) -> Vec<Draw> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // Another stream than scenario disturbances and encoder phases of the same seed.
    rng.set_stream(2);
    (0..count).map(|_| one(&rig.plant, scatter, &mut rng)).collect()
}

fn one(nominal: &PlantParameters<f64>, scatter: &Scatter, rng: &mut impl Rng) -> Draw {
    let spread = scatter.constants;
    let mut around = |value: f64, spread: f64| {
        // Without a spread, or with one that is lost beside 1, a number is drawn all the same: what is drawn
        // after it stays.
        let ends = 1.0 - spread..1.0 + spread;
        let none = ends.is_empty();
        let factor = rng.random_range(if none { 0.0..1.0 } else { ends });
        if none { value } else { value * factor }
    };
    let center_of_mass = around(nominal.center_of_mass, spread);
    let inertia = nominal.inertia.map(|x| around(x, spread));
    // A part of yaw's inertia, as on the preset.
    let tilting_inertia = nominal.tilting_inertia * (inertia.yaw / nominal.inertia.yaw);
    let damping = nominal.damping.map(|x| around(x, spread));
    let stiffness = around(nominal.stiffness, spread);
    let factors =
        Effectiveness { main_on_pitch: 1.0, tail_on_pitch: 1.0, main_on_yaw: 1.0, tail_on_yaw: 1.0 }
            .map(|x| around(x, spread));
    let rotor_time_constant = nominal.rotor_time_constant.map(|x| around(x, scatter.lag));
    let plant = PlantParameters {
        center_of_mass,
        inertia,
        damping,
        stiffness,
        effectiveness: nominal.effectiveness.zip(factors, |k, f| k * f),
        quadratic_effectiveness: nominal.quadratic_effectiveness.zip(factors, |k, f| k * f),
        rotor_time_constant,
        tilting_inertia,
        ..*nominal
    };
    let mut volts = || rng.random_range(-DISTURBANCE..DISTURBANCE);
    let disturbance = PerMotor::new(volts(), volts());
    let encoder_phase = PerAxis::new(rng.random(), rng.random());
    Draw { plant, disturbance, encoder_phase }
}

/// \[s\] T_d: how long a rig has for the step, which is when the disturbance comes. Slower machines get more;
/// one of your own gets fifty times its longer rotor lag, rounded up, and at least 4 s.
pub fn allowance(name: &str, rig: &Rig) -> f64 {
    let known = [("paper", 4), ("paper-fixed", 4), ("aero", 5), ("aero-lab", 5), ("aero2", 8), ("heli", 6)];
    debug_assert!(presets::ALL.iter().all(|(preset, _)| known.iter().any(|(k, _)| k == preset)));
    let lag = rig.plant.rotor_time_constant;
    known
        .iter()
        .find(|(preset, _)| *preset == name)
        .map_or((50.0 * lag.main.max(lag.tail)).ceil().max(4.0), |(_, seconds)| f64::from(*seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same draws, drawn closer together: what a rig's owner knows better lies nearer.
    #[test]
    fn a_smaller_spread_is_the_same_draw_closer_to_the_preset() {
        let rig = presets::AERO2;
        let (usual, close) =
            (draw(&rig, 40, 3), draw_within(&rig, 40, 3, &Scatter { constants: 0.03, lag: 0.0 }));
        for (far, near) in usual.iter().zip(&close) {
            let off = |d: &Draw| d.plant.inertia.pitch / rig.plant.inertia.pitch - 1.0;
            assert!((off(near) - 0.1 * off(far)).abs() < 1e-12);
            assert_eq!(near.plant.rotor_time_constant, rig.plant.rotor_time_constant);
            assert_eq!((near.disturbance, near.encoder_phase), (far.disturbance, far.encoder_phase));
        }
        // So small a spread is lost beside 1.
        for tiny in [0.0, 1e-320, 1e-17] {
            let here = draw_within(&rig, 3, 3, &Scatter { constants: tiny, lag: tiny });
            assert!(here.iter().all(|d| d.plant == rig.plant));
            assert_eq!(here[2].disturbance, usual[2].disturbance);
        }
        let told = |constants: f64, lag: f64| Scatter { constants, lag }.validate().unwrap_err().to_string();
        assert_eq!(told(1.0, 0.2), "spread is 1; allowed: 0 to 0.9, a part of the preset's value");
        assert!(told(0.1, f64::NAN).starts_with("lag-spread is NaN"));
    }

    #[test]
    fn draws_are_within_their_spread_and_fill_it() {
        let rig = presets::AERO;
        let plants = draw(&rig, 500, 3);
        assert_eq!(plants[..20], draw(&rig, 20, 3));
        assert_ne!(plants[0], draw(&rig, 1, 4)[0]);
        let ratios = |of: fn(&PlantParameters<f64>) -> f64| {
            let r: Vec<f64> = plants.iter().map(|d| of(&d.plant) / of(&rig.plant)).collect();
            (r.iter().copied().fold(f64::MAX, f64::min), r.iter().copied().fold(f64::MIN, f64::max))
        };
        for of in [
            (|p| p.inertia.pitch) as fn(&PlantParameters<f64>) -> f64,
            |p| p.damping.yaw,
            |p| p.stiffness,
            |p| p.effectiveness.main_on_yaw,
        ] {
            let (low, high) = ratios(of);
            assert!((0.7..0.72).contains(&low) && (1.28..1.3).contains(&high), "{low} {high}");
        }
        let (low, high) = ratios(|p| p.rotor_time_constant.tail);
        assert!((0.3..0.32).contains(&low) && (1.68..1.7).contains(&high));
        assert!(plants.iter().all(|d| d.disturbance.main.abs() < 2.0 && d.plant.mass == rig.plant.mass));
    }
}
