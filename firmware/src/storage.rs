//! The parameters on flash.

use crate::family::flash::ParameterFlash;
use crate::port::{PlantPort, Port};
use crate::{flash_cache, watchdog};
use twinrotor::parameters::store::{AREA_OFFSET, SLOT_SIZE, Store};
use twinrotor::parameters::{self, ParameterError, Parameters, Provenance};

/// The record store.
pub(crate) struct Storage {
    store: Store<ParameterFlash>,
    buffer: [u8; SLOT_SIZE],
}

impl Storage {
    /// The store, the parameters in force, and where they come from.
    pub(crate) fn load(flash: ParameterFlash) -> (Self, Parameters, Provenance) {
        let mut storage = Self { store: Store::new(flash, AREA_OFFSET), buffer: [0; SLOT_SIZE] };
        let (parameters, provenance) =
            parameters::load(&mut storage.store, &mut storage.buffer, Port::KIND, defaults);
        (storage, parameters, provenance)
    }

    /// Writes the parameters; the motors are off, and ticks may be missed meanwhile.
    pub(crate) fn save(&mut self, new: &Parameters) -> Result<(), ParameterError> {
        watchdog::lengthened(|| {
            flash_cache::without(|| parameters::save(&mut self.store, new, &mut self.buffer))
        })
    }
}

/// What is compiled in; `build.rs` makes it with the same code.
fn defaults() -> Parameters {
    Parameters::decode(include_bytes!(concat!(env!("OUT_DIR"), "/defaults.bin")))
        .expect("build.rs has checked it")
}
