use super::*;
use crate::closed_loop::{ClosedLoop, Hardware, RigLoop};
use crate::gains_file::GainsFile;
use twinrotor::defaults;
use twinrotor::plant::presets;

/// \[deg\] Largest error about the level pose in the last 10 s of a minute in the rig's world, counts, PWM
/// steps, gravity and all, after a push: the standard of whether it holds.
fn swing(rig: &Rig, settings: &Settings<f64>, change: Change) -> f64 {
    let mut plant = rig.plant;
    plant.effectiveness = plant.effectiveness.map(|k| change.thrust * k);
    plant.quadratic_effectiveness = plant.quadratic_effectiveness.map(|k| change.thrust * k);
    plant.rotor_time_constant = plant.rotor_time_constant.map(|tau| change.lag * tau);
    plant.inertia = plant.inertia.map(|inertia| change.inertia * inertia);
    let plant = RealPlant::<f64>::new(&plant, State::at_rest(PerAxis::new(0.0, 0.0)), SAMPLE_TIME);
    let mut rig_loop = RigLoop::new(plant, &Hardware::of(rig, PerAxis::new(0.3, 0.8)), settings);
    let mut worst = 0.0_f64;
    for tick in 0..60_000 {
        let push = if tick < 5_000 { PerMotor::both(2.0) } else { PerMotor::zero() };
        let state = rig_loop.tick(&Reference::default(), push).state;
        if tick >= 50_000 {
            worst = worst.max(state.angle.pitch.abs()).max(state.angle.yaw.abs());
        }
    }
    worst.to_degrees()
}

/// Inside the edge the rig holds its pose; outside it swings, in the world of counts and limits as well.
#[test]
fn a_simulation_holds_inside_the_edge_and_swings_outside() {
    for (name, rig, tuned) in [
        ("paper-fixed", presets::PAPER_FIXED, defaults::PAPER_FIXED),
        ("aero2", presets::AERO2, defaults::AERO2),
    ] {
        let settings = Settings::new(&rig, tuned, SAMPLE_TIME);
        let margins = Margins::of(&rig, &settings);
        for (what, edge, change) in [
            ("thrust", margins.thrust[1], (|thrust| Change { thrust, ..NONE }) as fn(f64) -> Change),
            ("lag", margins.lag[1], |lag| Change { lag, ..NONE }),
            ("inertia", margins.inertia[1], |inertia| Change { inertia, ..NONE }),
        ] {
            let edge = edge.unwrap_or_else(|| panic!("{name} {what}: no edge"));
            let (inside, outside) =
                (swing(&rig, &settings, change(0.85 * edge)), swing(&rig, &settings, change(1.25 * edge)));
            assert!(inside < 0.3, "{name} {what} {edge}: {inside} deg inside");
            assert!(outside > 2.0 * inside && outside > 0.4, "{name} {what} {edge}: {outside} deg outside");
        }
    }
}

/// A loop whose poles are known: the paper's law on its own world but for a tick of delay, fed by a fast
/// observer, has its slowest pole at -2.40 /s, the lesser root of s² + 13.08 s + 25.624 (yaw).
#[test]
fn the_slowest_pole_is_that_of_the_characteristic_equation() {
    let mut rig = presets::PAPER;
    rig.plant.rotor_time_constant = PerMotor::zero();
    let mut settings = Settings::paper(&rig, twinrotor::gains::PAPER, SAMPLE_TIME);
    settings.controller.estimator =
        twinrotor::estimator::EstimatorSettings::FilteredDerivative { bandwidth: PerAxis::both(1900.0) };
    let found = Margins::of(&rig, &settings).slowest_pole;
    let exact = 0.5 * (13.08 - f64::sqrt(13.08 * 13.08 - 4.0 * 25.624));
    assert!((found / exact - 1.0).abs() < 0.02, "{found} {exact}");
}

/// \[x, x, x, ms\] Upper thrust, lag and inertia margin and delay margin, from the eigenvalues of an
/// independent f64 model of the sampled loop; `paper` and `paper-fixed` with the gains in `eigenvalues/`.
const EIGENVALUES: [(&str, [f64; 4]); 5] = [
    ("paper", [2.5, 3.2, 6.7, 9.0]),
    ("paper-fixed", [2.8, 3.7, 6.0, 45.0]),
    ("aero", [2.3, 3.3, 7.9, 60.0]),
    ("aero2", [2.3, 2.7, 4.4, 85.0]),
    ("aero-lab", [5.6, 3.6, 4.4, 60.0]),
];

#[test]
fn the_edges_are_those_of_the_eigenvalues() {
    for ((name, expected), (_, rig)) in EIGENVALUES.into_iter().zip(presets::ALL) {
        let file =
            |text: &str| GainsFile::load("eigenvalues.toml", &|_| Ok(text.to_owned())).unwrap().controller;
        let tuned = match name {
            "paper" => file(include_str!("eigenvalues/paper.toml")),
            "paper-fixed" => file(include_str!("eigenvalues/paper-fixed.toml")),
            _ => defaults::named(name).unwrap(),
        };
        let found = Margins::of(&rig, &Settings::new(&rig, tuned, SAMPLE_TIME));
        let delay = found.delay_ms.map(f64::from);
        for (found, expected) in
            [found.thrust[1], found.lag[1], found.inertia[1], delay].into_iter().zip(expected)
        {
            let found = found.unwrap();
            assert!((found / expected - 1.0).abs() < 0.07, "{name}: {found} for {expected}");
        }
    }
}

/// Beside a loop that is unstable as it is there are no edges to tell.
#[test]
fn an_unstable_loop_is_said_to_be_and_has_no_margins() {
    let most = twinrotor::gains::Gains::from_paper_order([25.0; 4]);
    let found = Margins::of(&presets::PAPER, &Settings::paper(&presets::PAPER, most, SAMPLE_TIME));
    assert!(!found.stable && found.slowest_pole < 0.0, "{found:?}");
    assert_eq!((found.thrust, found.lag, found.inertia), ([None; 2], [None; 2], [None; 2]));
    assert_eq!(found.delay_ms, None);
    let own = Settings::new(&presets::AERO2, defaults::AERO2, SAMPLE_TIME);
    assert!(Margins::of(&presets::AERO2, &own).stable);
}
