//! The step that controllers of a real Aero flew, (30°, 45°) from rest, on what its logs say it is: the
//! preset `aero-lab`.

use host_sim::files;
use rayon::prelude::*;
use twinrotor::axes::PerAxis;
use twinrotor::plant::presets::{AERO_LAB, Rig};
use twinrotor_identify::constants::{CONSTANTS, from_array, to_array};
use twinrotor_sim::flight::{Fidelity, Flight, Plan, Scalar, fly};
use twinrotor_tune::robust::{LAG_SPREAD, SPREAD, draw};

fn flown(rig: &Rig, scalar: Scalar, seed: u64) -> Flight {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let settings =
        files::gains("--gains", &format!("{folder}/gains/aero-lab.toml")).unwrap().settings(&AERO_LAB);
    let scenario = files::scenario(&format!("{folder}/scenarios/step-30-45.toml")).unwrap();
    let plan = Plan {
        rig,
        truth: rig,
        settings: &settings,
        scenario: &scenario,
        initial: PerAxis::both(0.0),
        fidelity: Fidelity::Rig,
        seed,
    };
    fly(&plan, scalar).unwrap()
}

/// The best controller of the published logs needed 2.8/3.5 s.
#[test]
fn both_axes_settle_sooner_than_the_best_published_controller() {
    for seed in 1..=10 {
        let report = flown(&AERO_LAB, Scalar::F32, seed).report;
        for (axis, seconds, percent) in [(report.pitch, 2.2, 2.0), (report.yaw, 3.0, 2.0)] {
            assert!(axis.settling_time_2.unwrap() < seconds, "seed {seed}: {axis:?}");
            assert!(axis.overshoot_percent.unwrap() < percent, "seed {seed}: {axis:?}");
            // The friction band is ±1.5° and more; what is left is the encoder's count.
            assert!(axis.final_error_deg.abs() < 0.3, "seed {seed}: {axis:?}");
        }
    }
}

/// Constants within ±20 %, lags included; the controller believes the preset.
#[test]
fn no_plant_around_the_preset_fails() {
    const WITHIN: f64 = 0.2;
    let nominal = to_array(&AERO_LAB.plant);
    let failed: Vec<_> = draw(&AERO_LAB, 300, 1)
        .par_iter()
        .enumerate()
        .filter_map(|(k, drawn)| {
            let mut values = to_array(&drawn.plant);
            for ((value, nominal), constant) in values.iter_mut().zip(nominal).zip(CONSTANTS) {
                let lag = constant.name.starts_with("rotor_time_constant");
                *value = nominal + WITHIN / if lag { LAG_SPREAD } else { SPREAD } * (*value - nominal);
            }
            let flight = flown(&Rig { plant: from_array(&values), ..AERO_LAB }, Scalar::F64, 1);
            let inside = flight.rows.iter().all(|r| r.state.angle.pitch.abs() < AERO_LAB.envelope.pitch);
            let settled =
                [flight.report.pitch, flight.report.yaw].iter().all(|a| a.settling_time_5.is_some());
            (!inside || !settled).then_some((k, flight.report))
        })
        .collect();
    assert!(failed.is_empty(), "{} of 300: {:?}", failed.len(), failed[0]);
}
