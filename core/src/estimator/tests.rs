use super::*;
use crate::axes::PerMotor;
use crate::encoder::angle_per_count;
use crate::plant::presets::Rig;
use crate::plant::{PlantParameters, RealPlant, State, presets};
use crate::rotor_model::RotorModel;

const T: f64 = 1e-3;

/// Flies the Aero open loop for 3 s with encoders and `disturbance` \[V\] on the main motor, and gives the
/// estimate, the truth and the mean square error of the rates over the last two seconds.
fn flown(settings: &EstimatorSettings<f64>, disturbance: f64) -> (Estimate<f64>, State<f64>, f64) {
    flown_on(&presets::AERO, &presets::AERO, settings, disturbance)
}

/// The same on `rig`, which the estimator takes for `believed`.
fn flown_on(
    rig: &Rig,
    believed: &Rig,
    settings: &EstimatorSettings<f64>,
    disturbance: f64,
) -> (Estimate<f64>, State<f64>, f64) {
    let model = RigidBody::new(&believed.plant);
    let mut rotors = RotorModel::new(&believed.plant, T);
    let mut plant = RealPlant::<f64>::new(&rig.plant, State::default(), T);
    let mut estimator = Estimator::new(settings, believed.plant.coulomb_friction, PerAxis::zero(), T);
    let count = rig.encoder_counts.map(angle_per_count::<f64>);
    let mut estimate = Estimate::default();
    let (mut truth, mut sum) = (State::default(), 0.0);
    for k in 0..3000 {
        truth = plant.state();
        let measured = truth.angle.zip(count, |q, c| (q / c).round() * c);
        let t = T * f64::from(k);
        let volts = PerMotor::new(5.0 * (3.0 * t).sin(), 4.0 * (2.0 * t).cos());
        let torque = rotors.advance(volts);
        estimate = estimator.update(measured, &model, torque).estimate;
        let error = estimate.state.rate.minus(truth.rate);
        if k >= 1000 {
            sum += (error.pitch * error.pitch + error.yaw * error.yaw) / 2000.0;
        }
        plant.advance(volts, PerMotor::new(disturbance, 0.0));
    }
    (estimate, truth, sum.sqrt())
}

const fn both(bandwidth: f64) -> PerAxis<f64> {
    PerAxis::both(bandwidth)
}

#[test]
fn observers_with_a_true_model_beat_the_filtered_derivative() {
    let (_, _, derivative) = flown(&EstimatorSettings::laboratory(100.0), 0.0);
    let (_, _, luenberger) = flown(&EstimatorSettings::Luenberger { bandwidth: both(40.0) }, 0.0);
    let (_, _, extended) = flown(&EstimatorSettings::ExtendedState { bandwidth: both(20.0) }, 0.0);
    assert!(luenberger < 0.2 * derivative, "{luenberger} {derivative}");
    assert!(extended < 0.2 * derivative, "{extended} {derivative}");
}

/// Friction that is left out biases the rate by 2 F/(I ω), against the motion; believed in, less than half of
/// the error is left.
#[test]
fn an_observer_that_believes_in_friction_is_not_biased_by_it() {
    let frictionless = PlantParameters { coulomb_friction: PerAxis::zero(), ..presets::AERO_LAB.plant };
    let frictionless = Rig { plant: frictionless, ..presets::AERO_LAB };
    let settings = EstimatorSettings::Luenberger { bandwidth: both(20.0) };
    let (_, _, biased) = flown_on(&presets::AERO_LAB, &frictionless, &settings, 0.0);
    let (_, _, unbiased) = flown_on(&presets::AERO_LAB, &presets::AERO_LAB, &settings, 0.0);
    let plant = presets::AERO_LAB.plant;
    let bias = 2.0 * plant.coulomb_friction.yaw / (plant.inertia.yaw * 20.0);
    assert!(biased > 0.5 * bias, "{biased} {bias}");
    assert!(unbiased < 0.5 * biased, "{unbiased} {biased}");
}

#[test]
fn the_extended_state_observer_finds_the_disturbance_and_the_luenberger_observer_none() {
    let rig = presets::AERO.plant;
    let volts = 2.0;
    let exact = rig.effectiveness.main_on_yaw * volts / rig.inertia.yaw;
    let (estimate, truth, _) = flown(&EstimatorSettings::ExtendedState { bandwidth: both(20.0) }, volts);
    assert!((estimate.disturbance.yaw / exact - 1.0).abs() < 0.1);
    assert!((estimate.state.rate.yaw - truth.rate.yaw).abs() < 0.01);

    let (estimate, _, _) = flown(&EstimatorSettings::Luenberger { bandwidth: both(40.0) }, volts);
    assert_eq!(estimate.disturbance, PerAxis::zero());
}

/// The error of the undriven observer dies with both (all three) poles at b: after n ticks no more than n² bⁿ
/// is left.
#[test]
fn observer_errors_die_at_the_bandwidth() {
    let w = 50.0;
    for gains in [luenberger(w, T), extended_state(w, T)] {
        let mut observer = Observer::new(PerAxis::both(gains), PerAxis::zero(), PerAxis::zero(), T);
        let measured = PerAxis::both(1.0);
        let mut error = f64::MAX;
        for _ in 0..400 {
            let estimate = observer.correct(measured);
            error = (estimate.state.angle.yaw - 1.0).abs();
            observer.predict(&estimate, PerAxis::zero());
        }
        let x = w * T * 400.0;
        assert!(error < x * x * (-x).exp() && error > 1e-3 * (-x).exp(), "{error:e}");
    }
}

#[test]
fn a_bad_bandwidth_is_named() {
    let settings = EstimatorSettings::ExtendedState { bandwidth: PerAxis::new(20.0_f32, -1.0) };
    assert_eq!(settings.validate().unwrap_err().field, "estimator.bandwidth.yaw");
}
