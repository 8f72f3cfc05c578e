//! The controllers there are to choose from and to compare with, each designed for a rig by its own rules.
//! Tuning starts from these.
//!
//! | name | design |
//! |---|---|
//! | `paper` | the paper's law and gains, a filtered derivative of 100 rad/s |
//! | `backstepping` | the same law, to be tuned |
//! | `pid` | a double pole and a slow integral, axes decoupled by K⁻¹ |
//! | `pd` | the manufacturer's: peak time 2.5 s (pitch), 3.5 s (yaw), 5 % overshoot, each motor its own axis |
//! | `lqr` | Q = diag(200, 200, 100, 100), R = I, with feed-forward |
//! | `lqi` | the same with integrals, limited to 20 V: the classic default of these laboratories |
//! | `super-twisting` | second-order sliding mode |
//! | `integral` | integral backstepping, Luenberger observer, command filter, weighted allocation: for an uncertain lag |
//! | `cancelling` | integral backstepping, extended state observer with cancellation and lead, filter, allocation: for a known lag |
//! | `pid-plus`, `lqr-plus`, `lqi-plus` | PID, LQR, LQI with the observer, the filter and the allocation of `integral` |

use super::riccati::lqr;
use crate::robust::STEP_DEG;
use nalgebra::DMatrix;
use twinrotor::allocation::AllocationSettings;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::command_filter::FilterSettings;
use twinrotor::controller::ControllerSettings;
use twinrotor::estimator::EstimatorSettings;
use twinrotor::gains;
use twinrotor::law::{
    ControlLaw, IntegralGains, Law, LawSettings, MotorGains, PidGains, StateFeedbackGains, SuperTwistingGains,
};
use twinrotor::lead::Lead;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{RigidBody, State};

/// Designs a controller for a rig.
pub type Design = fn(&Rig) -> ControllerSettings<f64>;

/// Every controller by name.
pub const CATALOGUE: [(&str, Design); 12] = [
    ("paper", paper),
    ("backstepping", paper),
    ("pid", pid),
    ("pd", pd),
    ("lqr", |rig| lab(state_feedback(rig, false))),
    ("lqi", |rig| lab(state_feedback(rig, true))),
    ("super-twisting", super_twisting),
    ("integral", integral),
    ("cancelling", cancelling),
    ("pid-plus", |rig| assisted(rig, pid(rig).law)),
    ("lqr-plus", |rig| assisted(rig, state_feedback(rig, false))),
    ("lqi-plus", |rig| assisted(rig, state_feedback(rig, true))),
];

/// As laboratories run a law: a filtered derivative, each motor clamped on its own.
fn lab(law: LawSettings<f64>) -> ControllerSettings<f64> {
    ControllerSettings { law, ..paper_settings() }
}

fn paper_settings() -> ControllerSettings<f64> {
    ControllerSettings::paper(gains::PAPER)
}

fn paper(_rig: &Rig) -> ControllerSettings<f64> {
    paper_settings()
}

/// \[rad/s\] What a rig's closed loop can be asked for: a part of its rotors' bandwidth.
fn bandwidth(rig: &Rig) -> f64 {
    let lag = rig.plant.rotor_time_constant;
    0.8 / lag.main.max(lag.tail).max(0.02)
}

fn pid(rig: &Rig) -> ControllerSettings<f64> {
    let w = bandwidth(rig);
    let gains = PidGains { proportional: w * w, integral: 0.2 * w * w * w, derivative: 2.0 * w };
    lab(LawSettings::Pid(PerAxis::both(gains)))
}

fn diagonal(main: f64, tail: f64) -> MotorGains<f64> {
    PerMotor { main: PerAxis::new(main, 0.0), tail: PerAxis::new(0.0, tail) }
}

/// Second-order response of each axis to its own motor, with the manufacturer's specification.
fn pd(rig: &Rig) -> ControllerSettings<f64> {
    let k = rig.plant.effectiveness_at(rig.nominal_volts);
    let body = RigidBody::new(&rig.plant).at(&State::default());
    let overshoot = 0.05_f64.ln();
    let damping_ratio = -overshoot / overshoot.hypot(core::f64::consts::PI);
    let gains = |peak: f64, inertia: f64, damping: f64, stiffness: f64, k: f64| {
        let w = core::f64::consts::PI / (peak * (1.0 - damping_ratio * damping_ratio).sqrt());
        // A rig with more damping than the design asks for gets no negative rate gain.
        [(w * w * inertia - stiffness) / k, ((2.0 * damping_ratio * w * inertia - damping) / k).max(0.01)]
    };
    let p = &rig.plant;
    let [main, main_rate] = gains(2.5, body.inertia.pitch, p.damping.pitch, p.stiffness, k.main_on_pitch);
    let [tail, tail_rate] = gains(3.5, body.inertia.yaw, p.damping.yaw, 0.0, k.tail_on_yaw);
    lab(LawSettings::StateFeedback(StateFeedbackGains {
        angle: diagonal(main, tail),
        rate: diagonal(main_rate, tail_rate),
        integral: diagonal(0.0, 0.0),
        integral_limit: 0.0,
        feed_forward: false,
    }))
}

/// LQR, with integrals of both angle errors if asked for, linearised at the horizontal.
fn state_feedback(rig: &Rig, integral: bool) -> LawSettings<f64> {
    let p = &rig.plant;
    let inertia = RigidBody::new(p).at(&State::default()).inertia;
    let k = p.effectiveness_at(rig.nominal_volts);
    let n = if integral { 6 } else { 4 };
    let mut a = DMatrix::zeros(n, n);
    a[(0, 2)] = 1.0;
    a[(1, 3)] = 1.0;
    a[(2, 0)] = -p.stiffness / inertia.pitch;
    a[(2, 2)] = -p.damping.pitch / inertia.pitch;
    a[(3, 3)] = -p.damping.yaw / inertia.yaw;
    let mut b = DMatrix::zeros(n, 2);
    b[(2, 0)] = k.main_on_pitch / inertia.pitch;
    b[(2, 1)] = k.tail_on_pitch / inertia.pitch;
    b[(3, 0)] = k.main_on_yaw / inertia.yaw;
    b[(3, 1)] = k.tail_on_yaw / inertia.yaw;
    let mut weights = vec![200.0, 200.0, 100.0, 100.0];
    if integral {
        a[(4, 0)] = 1.0;
        a[(5, 1)] = 1.0;
        weights.extend([50.0, 50.0]);
    }
    let q = DMatrix::from_diagonal(&weights.into());
    let gain = lqr(&a, &b, &q, &DMatrix::identity(2, 2)).expect("a rig with thrust on both axes");
    let columns = |first: usize| PerMotor {
        main: PerAxis::new(gain[(0, first)], gain[(0, first + 1)]),
        tail: PerAxis::new(gain[(1, first)], gain[(1, first + 1)]),
    };
    LawSettings::StateFeedback(StateFeedbackGains {
        angle: columns(0),
        rate: columns(2),
        integral: if integral { columns(4) } else { diagonal(0.0, 0.0) },
        integral_limit: if integral { 20.0 } else { 0.0 },
        feed_forward: true,
    })
}

fn super_twisting(rig: &Rig) -> ControllerSettings<f64> {
    let w = bandwidth(rig);
    lab(LawSettings::SuperTwisting(PerAxis::both(SuperTwistingGains {
        surface: 0.7 * w,
        proportional: w,
        integral: 0.5 * w * w,
        width: 0.5,
    })))
}

fn integral_law(w: f64) -> LawSettings<f64> {
    let gains = IntegralGains { position: 0.7 * w, rate: 1.5 * w, weight: 1.0, integral: 0.2 * w * w };
    LawSettings::IntegralBackstepping(PerAxis::both(gains))
}

/// For rotors that a lead makes `quicker` by that factor.
fn filter(rig: &Rig, quicker: f64) -> FilterSettings<f64> {
    let lag = rig.plant.rotor_time_constant;
    FilterSettings {
        bandwidth: PerAxis::both(0.7 * bandwidth(rig)),
        damping: Some(PerAxis::both(0.8)),
        advance: Some(PerAxis::new(lag.main, lag.tail).scaled(1.0 / quicker)),
        // What it is tuned on is the most that it is asked for.
        reach: Some(STEP_DEG.map(f64::to_radians)),
    }
}

/// A law with the observer, the filter and the allocation of ours.
fn assisted(rig: &Rig, law: LawSettings<f64>) -> ControllerSettings<f64> {
    let w = bandwidth(rig);
    ControllerSettings {
        law,
        estimator: EstimatorSettings::Luenberger { bandwidth: PerAxis::both(8.0 * w) },
        filter: Some(filter(rig, 1.0)),
        allocation: AllocationSettings::Weighted { pitch_weight: 1.5 },
        lead: None,
        cancellation: None,
    }
}

fn integral(rig: &Rig) -> ControllerSettings<f64> {
    assisted(rig, integral_law(bandwidth(rig)))
}

fn cancelling(rig: &Rig) -> ControllerSettings<f64> {
    let w = bandwidth(rig);
    let lead = Lead { factor: 1.2 };
    ControllerSettings {
        estimator: EstimatorSettings::ExtendedState { bandwidth: PerAxis::both(3.0 * w) },
        filter: Some(filter(rig, lead.factor)),
        lead: Some(lead),
        cancellation: Some(PerAxis::both(0.5)),
        ..integral(rig)
    }
}

/// What a controller has beyond its law, in words.
pub fn uses(controller: &ControllerSettings<f64>) -> Vec<String> {
    let ControllerSettings { law, estimator, filter, allocation, lead, cancellation } = controller;
    let integrates = Law::integrates(law);
    let matrices = match law {
        LawSettings::StateSpace(gains) => Some(gains.states),
        _ => None,
    };
    let mut list = vec![match estimator {
        EstimatorSettings::FilteredDerivative { .. } => "filtered derivative",
        EstimatorSettings::Luenberger { .. } => "Luenberger observer",
        EstimatorSettings::ExtendedState { .. } => "extended state observer",
        EstimatorSettings::Observer { .. } => "observer",
    }];
    list.extend(integrates.then_some("integral, conditional"));
    list.extend(filter.map(|_| "command filter"));
    list.extend(match allocation {
        AllocationSettings::Clamp => None,
        AllocationSettings::Scale => Some("direction-preserving allocation"),
        AllocationSettings::Weighted { .. } => Some("weighted allocation"),
    });
    list.extend(lead.map(|_| "lead"));
    list.extend(cancellation.map(|_| "disturbance cancellation"));
    let matrices = matrices.map(|states| format!("matrices of {states} states"));
    matrices.into_iter().chain(list.into_iter().map(str::to_owned)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::plant::presets;

    #[test]
    fn every_design_is_usable_on_every_rig() {
        for (rig_name, rig) in presets::ALL {
            for (name, design) in CATALOGUE {
                let controller = design(&rig);
                assert_eq!(controller.validate(), Ok(()), "{name} on {rig_name}");
            }
        }
    }

    /// The gains that the manufacturer's course material gives for the Aero 2: 116.2/99.7 and 35.9/38.0.
    #[test]
    fn the_pd_is_the_manufacturers() {
        let LawSettings::StateFeedback(g) = pd(&presets::AERO2).law else { panic!("a PD") };
        assert!((g.angle.main.pitch - 116.2).abs() < 1.5, "{}", g.angle.main.pitch);
        assert!((g.rate.main.pitch - 99.7).abs() < 1.5, "{}", g.rate.main.pitch);
        assert!((g.angle.tail.yaw - 35.9).abs() < 0.5 && (g.rate.tail.yaw - 38.0).abs() < 0.5);
    }
}
