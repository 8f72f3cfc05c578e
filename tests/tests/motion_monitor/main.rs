//! The board's motion monitor: disturbances are no faults, and faults are found as soon as ever.
//!
//! `cargo test --release -p tests --test motion_monitor -- --nocapture` prints both tables;
//! `TWINROTOR_FLIGHTS=100` flies a hundred flights of every kind of disturbance instead of three.

mod disturbances;
mod faults;
mod flight;

use twinrotor::SAMPLE_TIME;
use twinrotor::defaults;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{self, Rig};

/// Every rig with what its boards boot with.
fn flown() -> impl Iterator<Item = (&'static str, Rig, Settings<f64>)> {
    presets::ALL.into_iter().map(|(name, rig)| {
        let tuned = defaults::named(name).expect("a controller for every preset");
        (name, rig, Settings::new(&rig, tuned, SAMPLE_TIME))
    })
}
