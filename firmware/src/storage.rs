//! The parameters on flash.

use crate::watchdog;
use embassy_stm32::flash::{Bank1Region1, Blocking};
use twinrotor::parameters::store::{AREA_OFFSET, MAX_PAYLOAD, SLOT_SIZE, Store};
use twinrotor::parameters::{ParameterError, Parameters, Provenance};

/// The record store of sectors 1 to 3.
pub(crate) struct Storage {
    store: Store<Bank1Region1<'static, Blocking>>,
    buffer: [u8; SLOT_SIZE],
}

impl Storage {
    /// The store, the parameters in force, and where they come from.
    pub(crate) fn load(flash: Bank1Region1<'static, Blocking>) -> (Self, Parameters, Provenance) {
        let mut storage = Self { store: Store::new(flash, AREA_OFFSET), buffer: [0; SLOT_SIZE] };
        let stored = storage.store.load(&mut storage.buffer);
        let (parameters, provenance) = match stored.map(|bytes| bytes.map(Parameters::decode)) {
            Ok(Some(Ok(parameters))) => (parameters, Provenance::Stored),
            Ok(None) => (defaults(), Provenance::Missing),
            Ok(Some(Err(error))) => (defaults(), Provenance::without(error)),
            Err(_) => (defaults(), Provenance::Damaged),
        };
        (storage, parameters, provenance)
    }

    /// Writes the parameters; the motors are off, and ticks may be missed meanwhile.
    pub(crate) fn save(&mut self, parameters: &Parameters) -> Result<(), ParameterError> {
        let mut payload = [0; MAX_PAYLOAD];
        let payload = parameters.encode(&mut payload)?;
        watchdog::lengthened(|| self.store.save(payload, &mut self.buffer))
            .map_err(|_| ParameterError::Damaged)
    }
}

/// What is compiled in; `build.rs` makes it with the same code.
fn defaults() -> Parameters {
    Parameters::decode(include_bytes!(concat!(env!("OUT_DIR"), "/defaults.bin")))
        .expect("build.rs has checked it")
}
