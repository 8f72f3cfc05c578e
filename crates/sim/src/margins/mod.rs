//! How far a rig may be from what its controller believes before the loop is unstable.
//!
//! The sampled loop is linearised about the level pose: thrust by its slope at the nominal volts, no
//! Coulomb friction, no constant weight, no counts, no PWM steps, and nothing at its limit; rotor lag,
//! reaction torque, stiffness and one tick of delay as they are. A small offset from the pose then dies or
//! grows as the slowest pole says. The loop is stepped until it shows which, so any law, observer and
//! surroundings will do.

use crate::scenario::SAMPLE_TIME;
use serde::Serialize;
use std::collections::VecDeque;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::law::{Law, LawSettings};
use twinrotor::pipeline::{Pipeline, Settings};
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{Effectiveness, RealPlant, State};
use twinrotor::reference::Reference;

/// \[-\] Factors beyond which no edge is looked for.
pub const FARTHEST: [f64; 2] = [0.01, 20.0];
/// \[ms\] The longest delay that is tried.
pub const LONGEST_DELAY: u32 = 500;
/// \[-\] From one factor that is tried to the next, before the edge between two is narrowed down.
const STRIDE: f64 = 1.25;
/// Halvings of what is between the last stable and the first unstable factor: to within 1 %.
const HALVINGS: u32 = 5;
/// \[V\] Which nothing is limited by: at its limits an unstable loop swings on without growing.
const UNLIMITED: f64 = 1e9;
/// \[rad\] Where the loop starts.
const OFFSET: f64 = 1e-4;
/// \[s\] A stretch over which the largest error is taken: longer than half a period of what swings slowest.
const STRETCH: f64 = 3.0;
/// \[1/s\] At which what is inside a law may seem to grow and yet stand still.
const STANDING: f64 = 1e-6;
/// How many of them are flown.
const STRETCHES: usize = 8;

/// The margins of one controller on one rig. An edge is none where the loop is stable as far as is looked:
/// [`FARTHEST`], [`LONGEST_DELAY`]; all are, and there is no delay, where it is not stable at all.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Margins {
    /// Does a small error die where the rig is what it is believed to be? If not, there are no margins.
    pub stable: bool,
    /// \[-\] Thrust of both motors, for what is believed: least and most.
    pub thrust: [Option<f64>; 2],
    /// \[-\] Rotor lag of both motors.
    pub lag: [Option<f64>; 2],
    /// \[-\] Inertia about both axes.
    pub inertia: [Option<f64>; 2],
    /// \[ms\] Delay beyond the one tick that there is.
    pub delay_ms: Option<u32>,
    /// \[1/s\] At which the slowest part of a small error dies where the rig is what it is believed to be.
    /// Negative: it grows.
    pub slowest_pole: f64,
}

/// How a rig differs from what is believed of it.
#[derive(Debug, Clone, Copy)]
struct Change {
    thrust: f64,
    lag: f64,
    inertia: f64,
    /// \[ticks\]
    delay: u32,
}

const NONE: Change = Change { thrust: 1.0, lag: 1.0, inertia: 1.0, delay: 0 };

impl Margins {
    /// Of the controller of `settings` on `rig`.
    pub fn of(rig: &Rig, settings: &Settings<f64>) -> Self {
        let (rig, settings) = linear(rig, settings);
        let dies = |change: Change| rate(&rig, &settings, change) > 0.0;
        let edges = |change: fn(f64) -> Change| {
            FARTHEST.map(|farthest| edge(farthest, |factor| dies(change(factor))))
        };
        let delay = |delay| Change { delay, ..NONE };
        let slowest_pole = rate(&rig, &settings, NONE);
        if slowest_pole.is_nan() || slowest_pole <= 0.0 {
            let none = [None; 2];
            let (thrust, lag, inertia) = (none, none, none);
            return Self { stable: false, thrust, lag, inertia, delay_ms: None, slowest_pole };
        }
        Self {
            stable: true,
            thrust: edges(|thrust| Change { thrust, ..NONE }),
            lag: edges(|lag| Change { lag, ..NONE }),
            inertia: edges(|inertia| Change { inertia, ..NONE }),
            delay_ms: longest(|ticks| dies(delay(ticks))),
            slowest_pole,
        }
    }
}

/// \[1/s\] [`Margins::slowest_pole`] alone.
pub fn slowest_pole(rig: &Rig, settings: &Settings<f64>) -> f64 {
    let (rig, settings) = linear(rig, settings);
    rate(&rig, &settings, NONE)
}

/// The rig as the linearised loop has it, and a controller that believes so and is limited by nothing.
fn linear(rig: &Rig, settings: &Settings<f64>) -> (Rig, Settings<f64>) {
    let mut plant = rig.plant;
    let square = plant.mass * plant.center_of_mass * plant.center_of_mass;
    plant.inertia = plant.inertia.map(|inertia| inertia + square);
    plant.center_of_mass = 0.0;
    plant.effectiveness = rig.plant.effectiveness_at(rig.nominal_volts);
    plant.quadratic_effectiveness = Effectiveness::zero();
    plant.coulomb_friction = PerAxis::zero();
    let volts_limit = PerMotor::both(UNLIMITED);
    let mut settings = Settings { model: plant, current_limit: None, volts_limit, ..*settings };
    if let LawSettings::StateSpace(gains) = &mut settings.controller.law {
        gains.saturation = volts_limit;
    }
    (Rig { plant, ..*rig }, settings)
}

/// \[1/s\] At which a small error dies in the last stretches; negative where it grows.
fn rate(rig: &Rig, settings: &Settings<f64>, change: Change) -> f64 {
    let mut plant = rig.plant;
    plant.effectiveness = plant.effectiveness.map(|k| change.thrust * k);
    plant.rotor_time_constant = plant.rotor_time_constant.map(|tau| change.lag * tau);
    plant.inertia = plant.inertia.map(|inertia| change.inertia * inertia);
    let start = PerAxis::new(OFFSET, -OFFSET);
    let mut plant = RealPlant::<f64>::new(&plant, State::at_rest(start), SAMPLE_TIME);
    let mut pipeline = Pipeline::new(settings, start);
    let mut under_way: VecDeque<PerMotor<f64>> = (0..change.delay).map(|_| PerMotor::zero()).collect();
    let mut volts = PerMotor::zero();
    let (mut peaks, mut inside) = ([0.0_f64; STRETCHES], [0.0_f64; STRETCHES]);
    let ticks = twinrotor::trajectory::ticks(STRETCH, SAMPLE_TIME);
    for (peak, inside) in peaks.iter_mut().zip(&mut inside) {
        for _ in 0..ticks {
            let angle = plant.state().angle;
            let decision = pipeline.tick(angle, volts, &Reference::default());
            under_way.push_back(volts);
            let late = under_way.pop_front().unwrap_or(volts);
            plant.advance(late, PerMotor::zero());
            volts = decision.allocation.volts;
            *peak = peak.max(angle.pitch.abs()).max(angle.yaw.abs());
            if let Law::StateSpace(law) = pipeline.law() {
                *inside = law.state().iter().fold(*inside, |most, x| most.max(x.abs()));
            }
        }
        // It has shown what it does: far gone, or as near to rest as rounding allows.
        if peak.is_nan() || *peak >= 1e3 * OFFSET {
            return -(*peak / OFFSET).ln() / STRETCH;
        }
    }
    let dying = |[.., before, last]: [f64; STRETCHES]| {
        (before.max(f64::MIN_POSITIVE) / last.max(f64::MIN_POSITIVE)).ln() / STRETCH
    };
    // A law's state may grow where no angle shows it, until it is no number.
    let hidden = dying(inside);
    if hidden < -STANDING { hidden } else { dying(peaks) }
}

/// Where between 1 and `farthest` the loop stops being stable; none if it does not.
fn edge(farthest: f64, dies: impl Fn(f64) -> bool) -> Option<f64> {
    let up = farthest > 1.0;
    let beyond = |factor: f64| if up { factor > farthest } else { factor < farthest };
    let mut good = 1.0;
    let mut bad = loop {
        let next = if up { good * STRIDE } else { good / STRIDE };
        if beyond(next) {
            return None;
        }
        if !dies(next) {
            break next;
        }
        good = next;
    };
    for _ in 0..HALVINGS {
        let middle = (good * bad).sqrt();
        if dies(middle) { good = middle } else { bad = middle }
    }
    Some(good)
}

/// \[ticks\] The longest delay with which it is stable; none if that is the longest that is tried.
fn longest(dies: impl Fn(u32) -> bool) -> Option<u32> {
    if !dies(0) {
        return Some(0);
    }
    let (mut good, mut bad) = (0, 1);
    while dies(bad) {
        if bad >= LONGEST_DELAY {
            return None;
        }
        (good, bad) = (bad, (2 * bad).min(LONGEST_DELAY));
    }
    while bad - good > 1 {
        let middle = good.midpoint(bad);
        if dies(middle) { good = middle } else { bad = middle }
    }
    Some(good)
}

#[cfg(test)]
mod tests;
