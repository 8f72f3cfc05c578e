//! What a board flies with: parameter records, and the image of the flash that holds them.

use twinrotor::SAMPLE_TIME;
use twinrotor::defaults;
use twinrotor::gains::PAPER;
use twinrotor::parameters::Parameters;
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{AREA_ADDRESS, MAX_PAYLOAD, SLOT_SIZE, Store};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{self, Rig};

/// Where the parameter sectors begin.
pub const ADDRESS: u64 = AREA_ADDRESS as u64;
/// The preset of the record that the firmware has built in, unless it was built for another.
pub const BUILT_IN: &str = "aero2";

/// The paper's controller with the paper's gains for `rig`, its wiring checked.
pub fn paper_parameters(rig: &Rig) -> Parameters {
    checked(rig, &Settings::paper(rig, PAPER, SAMPLE_TIME))
}

/// A preset's rig, and the controller tuned for it, its wiring checked.
///
/// # Panics
///
/// If there is no such preset.
pub fn tuned(preset: &str) -> (Rig, Parameters) {
    let of = |(name, _): &(&str, _)| *name == preset;
    let (_, rig) = presets::ALL.into_iter().find(of).expect("a preset");
    let controller = defaults::named(preset).expect("every preset has a controller");
    (rig, checked(&rig, &Settings::new(&rig, controller, SAMPLE_TIME)))
}

fn checked(rig: &Rig, settings: &Settings<f64>) -> Parameters {
    Parameters { checked: true, ..Parameters::new(rig, settings) }
}

/// The parameter sectors with these records saved in turn.
///
/// # Panics
///
/// If a record does not fit its place, which none can.
pub fn image(records: &[Parameters]) -> Vec<u8> {
    let mut store = Store::new(RamFlash::default(), 0);
    for record in records {
        let mut buffer = [0; MAX_PAYLOAD];
        let bytes = record.encode(&mut buffer).expect("it has room");
        store.save(bytes, &mut [0; SLOT_SIZE]).expect("a flash that never fails");
    }
    store.into_flash().bytes().to_vec()
}
