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
    let (knows, guesses) = (known.rate_error_transient, guessed.rate_error_transient);
    assert!(guesses.pitch > 3.0 * knows.pitch && guesses.yaw > 1.5 * knows.yaw, "{guessed:?} {known:?}");
}

/// Tick for tick, to the bit: what a flight's own controller asked for is what its replay asks for.
#[test]
fn a_flight_of_our_law_replayed_asks_for_its_own_volts() {
    use crate::closed_loop::{ClosedLoop, Hardware, RigLoop};
    let controller = defaults::AERO_LAB;
    let settings = Settings::new(&AERO_LAB, controller, SAMPLE_TIME).map(f32::from_f64);
    let scenario = Scenario::load("step").unwrap();
    let plant = RealPlant::<f32>::new(&AERO_LAB.plant, State::default(), SAMPLE_TIME);
    // Counts are rounded from true angles, as replay does it.
    let hardware = Hardware::of(&AERO_LAB, PerAxis::both(0.5));
    let mut flight = RigLoop::<f32>::new(plant, &hardware, &settings);
    let ticks: Vec<_> =
        scenario.references().iter().map(|reference| flight.tick(reference, PerMotor::zero())).collect();
    let rows: Vec<_> =
        ticks.iter().map(|t| (t.state.angle.map(f64::from), t.applied.map(f64::from))).collect();
    let log = Log::from_rows("flight", SAMPLE_TIME, &rows);
    let wanted = references(&log, Some(&scenario)).unwrap();
    let (replayed, report) = replay(&log, &AERO_LAB, &controller, Some(&wanted));
    assert!(report.volts_difference.is_some());
    for (tick, row) in ticks.iter().zip(&replayed) {
        assert_eq!(row.ours, Some(tick.command.allocation.volts.map(f64::from)), "{}", row.time);
    }
}
