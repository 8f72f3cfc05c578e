use super::*;
use twinrotor::defaults;
use twinrotor::plant::presets::AERO_LAB;
use twinrotor::plant::{RealPlant, State};

/// A simulated run at 1 kHz with its true rates: the tail pulses, then the main.
fn recorded() -> (Log, Vec<PerAxis<f64>>) {
    let mut body = RealPlant::<f64>::new(&AERO_LAB.plant, State::default(), 1e-3);
    let per_count: PerAxis<f64> = AERO_LAB.encoder_counts.map(angle_per_count);
    let mut rates = Vec::new();
    let rows: Vec<_> = (0..8000)
        .map(|k| {
            let volts = match k {
                500..2500 => PerMotor::new(0.0, 14.0),
                3000..6000 => PerMotor::new(12.0, -3.0),
                _ => PerMotor::zero(),
            };
            let state = body.state();
            rates.push(state.rate);
            body.advance(volts, PerMotor::zero());
            (state.angle.zip(per_count, |a, c| (a / c).round() * c), volts)
        })
        .collect();
    (Log::from_rows("simulated", 1e-3, &rows), rates)
}

#[test]
fn the_smoothed_rates_are_the_true_ones() {
    let (log, rates) = recorded();
    let (rows, _) = replay(&log, &AERO_LAB, &defaults::AERO_LAB, None);
    let error =
        |of: fn(PerAxis<f64>) -> f64| rms(rows.iter().zip(&rates).map(|(r, t)| of(r.smoothed.minus(*t))));
    assert!(
        error(|v| v.pitch) < 0.012 && error(|v| v.yaw) < 0.008,
        "{} {}",
        error(|v| v.pitch),
        error(|v| v.yaw)
    );
}

#[test]
fn an_estimator_that_knows_the_rig_is_near_them_and_one_that_does_not_is_not() {
    let (log, _) = recorded();
    let (_, known) = replay(&log, &AERO_LAB, &defaults::AERO_LAB, None);
    let mut other = AERO_LAB;
    other.plant.rotor_reaction = PerMotor::zero();
    other.plant.rotor_time_constant = PerMotor::both(0.05);
    let (_, guessed) = replay(&log, &other, &defaults::AERO_LAB, None);
    assert!(known.rate_error_transient.pitch < 0.02 && known.rate_error_transient.yaw < 0.02, "{known:?}");
    assert!(guessed.rate_error_transient.yaw > 2.0 * known.rate_error_transient.yaw, "{guessed:?} {known:?}");
}

/// Tick for tick: what a flight's own controller sent is what its replay asks for.
#[test]
fn a_flight_of_our_law_replayed_asks_for_its_own_volts() {
    use crate::flight::{Fidelity, Plan, Scalar, fly};
    let controller = defaults::AERO_LAB;
    let settings = Settings::new(&AERO_LAB, controller, SAMPLE_TIME);
    let scenario = Scenario::load("step").unwrap();
    let initial = PerAxis::zero();
    let plan = Plan {
        rig: &AERO_LAB,
        settings: &settings,
        scenario: &scenario,
        initial,
        fidelity: Fidelity::Rig,
        seed: 4,
    };
    let rows = fly(&plan, Scalar::F32).unwrap().rows;
    // True angles become counts again; the flight's encoders stood elsewhere between two counts, so volts agree but for a count.
    let log = Log::from_rows(
        "flight",
        SAMPLE_TIME,
        &rows.iter().map(|r| (r.state.angle, r.volts)).collect::<Vec<_>>(),
    );
    let wanted = references(&log, Some(&scenario)).unwrap();
    let (replayed, report) = replay(&log, &AERO_LAB, &controller, Some(&wanted));
    assert!(report.volts_difference.is_some());
    let late: Vec<f64> = replayed.windows(2).map(|w| w[0].ours.unwrap().tail - w[1].volts.tail).collect();
    assert!(rms(late.iter().copied()) < 1.0, "{}", rms(late.into_iter()));
}
