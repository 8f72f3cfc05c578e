use super::*;
use twinrotor::controller::ControllerSettings;
use twinrotor::defaults;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::AERO_LAB;
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;

/// A log through `controller` on `rig`, which was asked for nothing.
fn replayed(log: &Log, rig: &Rig, controller: &ControllerSettings<f64>) -> (Vec<Row>, Report) {
    let parameters = Parameters::new(rig, &Settings::new(rig, *controller, SAMPLE_TIME));
    let samples = samples(log, rig, None);
    compare(log, &samples, &replay(&parameters, &samples))
}

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
    let (rows, _) = replayed(&log, &AERO_LAB, &defaults::AERO_LAB);
    let error =
        |of: fn(PerAxis<f64>) -> f64| rms(rows.iter().zip(&rates).map(|(r, t)| of(r.smoothed.minus(*t))));
    assert!(
        error(|v| v.pitch) < 0.012 && error(|v| v.yaw) < 0.008,
        "{} {}",
        error(|v| v.pitch),
        error(|v| v.yaw)
    );
}

/// A twentieth less squared error than with half the reach or with twice, on steps that a board's controller
/// flies: where the true rates are known, and as a log would have them.
#[test]
fn no_other_reach_comes_nearer_to_rates_that_are_known() {
    use twinrotor_sim::flight::{Fidelity, Plan, Scalar, fly};
    const EVERY: usize = 2;
    let lab = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/step-30-45.toml");
    let settings = Settings::new(&AERO_LAB, defaults::AERO_LAB, SAMPLE_TIME);
    let mut squares = [PerAxis::<f64>::zero(); 3];
    for scenario in ["step", lab] {
        let scenario = Scenario::load(scenario, &|path| Ok(std::fs::read_to_string(path).unwrap())).unwrap();
        let plan = Plan {
            rig: &AERO_LAB,
            truth: &AERO_LAB,
            settings: &settings,
            scenario: &scenario,
            initial: PerAxis::both(0.0),
            fidelity: Fidelity::Rig,
            seed: 1,
        };
        let rows = fly(&plan, Scalar::F64).unwrap().rows;
        // What follows the step holds still, where any smoother is right.
        let rows: Vec<_> = rows.iter().take(3_000).step_by(EVERY).map(|row| row.state).collect();
        let step = EVERY as f64 * SAMPLE_TIME;
        let axis = |of: fn(PerAxis<f64>) -> f64, reach: f64| {
            let count = of(AERO_LAB.encoder_counts.map(angle_per_count));
            let counted: Vec<f64> = rows.iter().map(|s| (of(s.angle) / count).round() * count).collect();
            let smoothed = smooth(&counted, step, reach);
            rows.iter().zip(&smoothed).map(|(s, found)| (found.rate - of(s.rate)).powi(2)).sum::<f64>()
        };
        for (sum, factor) in squares.iter_mut().zip([0.5, 1.0, 2.0]) {
            sum.pitch += axis(|v| v.pitch, factor * SMOOTHER_REACH.pitch);
            sum.yaw += axis(|v| v.yaw, factor * SMOOTHER_REACH.yaw);
        }
    }
    let [half, whole, twice] = squares;
    for other in [half, twice] {
        assert!(whole.pitch < 0.95 * other.pitch && whole.yaw < 0.95 * other.yaw, "{squares:?}");
    }
}

#[test]
fn an_estimator_that_knows_the_rig_is_near_them_and_one_that_does_not_is_not() {
    let (log, _) = recorded();
    let (_, known) = replayed(&log, &AERO_LAB, &defaults::AERO_LAB);
    let mut other = AERO_LAB;
    other.plant.rotor_reaction = PerMotor::zero();
    other.plant.rotor_time_constant = PerMotor::both(0.05);
    let (_, guessed) = replayed(&log, &other, &defaults::AERO_LAB);
    assert!(known.rate_error_transient.pitch < 0.02 && known.rate_error_transient.yaw < 0.02, "{known:?}");
    let (knows, guesses) = (known.rate_error_transient, guessed.rate_error_transient);
    assert!(guesses.pitch > 3.0 * knows.pitch && guesses.yaw > 1.5 * knows.yaw, "{guessed:?} {known:?}");
}

/// Tick for tick, to the bit: what a flight's own controller asked for is what its replay asks for.
#[test]
fn a_flight_of_our_law_replayed_asks_for_its_own_volts() {
    use twinrotor_sim::closed_loop::{ClosedLoop, Hardware, RigLoop};
    let controller = defaults::AERO_LAB;
    let settings = Settings::new(&AERO_LAB, controller, SAMPLE_TIME).map(f32::from_f64);
    let scenario = Scenario::named("step").unwrap();
    let plant = RealPlant::<f32>::new(&AERO_LAB.plant, State::default(), SAMPLE_TIME);
    // Counts are rounded from true angles, as replay does it.
    let hardware = Hardware::of(&AERO_LAB, PerAxis::both(0.5));
    let mut flight = RigLoop::<f32>::new(plant, &hardware, &settings);
    let ticks: Vec<_> =
        scenario.references().iter().map(|reference| flight.tick(reference, PerMotor::zero())).collect();
    let rows: Vec<_> =
        ticks.iter().map(|t| (t.state.angle.map(f64::from), t.applied.map(f64::from))).collect();
    let log = Log::from_rows("flight", SAMPLE_TIME, &rows);
    let samples = samples(&log, &AERO_LAB, Some(&scenario));
    let parameters = Parameters::new(&AERO_LAB, &Settings::new(&AERO_LAB, controller, SAMPLE_TIME));
    let (replayed, report) = compare(&log, &samples, &replay(&parameters, &samples));
    assert!(report.volts_difference.is_some());
    for (tick, row) in ticks.iter().zip(&replayed) {
        assert_eq!(row.ours, Some(tick.decision.allocation.volts.map(f64::from)), "{}", row.time);
    }
}

/// Whatever the log's rate, the ticks are a board's: one every millisecond from its first row to its last,
/// volts held, angles between those of the rows beside.
#[test]
fn a_log_of_any_rate_becomes_a_tick_every_millisecond() {
    for (step, rows, ticks) in
        [(1e-3, 101, 101), (2e-3, 51, 101), (1.5e-3, 41, 61), (5e-4, 201, 101), (0.02, 6, 101)]
    {
        let angle = |k: usize| PerAxis::new(step * k as f64, -2.0 * step * k as f64);
        let rows: Vec<_> = (0..rows).map(|k| (angle(k), PerMotor::new((k + 1) as f64 * 0.01, 0.0))).collect();
        let samples = samples(&Log::from_rows("ramp", step, &rows), &AERO_LAB, None);
        assert_eq!(samples.len(), ticks, "{step}");
        let per_count: PerAxis<f64> = AERO_LAB.encoder_counts.map(angle_per_count);
        for (k, sample) in samples.iter().enumerate() {
            let time = SAMPLE_TIME * k as f64;
            assert_eq!(sample.number as usize, k);
            assert!(
                (f64::from(sample.counts.pitch) * per_count.pitch - time).abs() <= 0.51 * per_count.pitch
            );
            assert!(
                (f64::from(sample.counts.yaw) * per_count.yaw + 2.0 * time).abs() <= 0.51 * per_count.yaw
            );
            let row = ((time / step + 1e-6).floor() as usize).min(rows.len() - 1);
            assert_eq!(sample.volts.main, rows[row].1.main as f32, "{step} {k}");
        }
    }
}
