//! Parameters as an image of a board's flash sectors.

use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{AREA_ADDRESS, MAX_PAYLOAD, SLOT_SIZE, Store};
use twinrotor::parameters::{ParameterError, Parameters};
use twinrotor_sim::{Error, Outcome};

/// What says which parameter cannot be used.
pub fn unusable(error: ParameterError) -> Error {
    match error {
        ParameterError::Range { .. } => Error::Unusable(error.to_string()),
        other => Error::Failed(other.to_string()),
    }
}

/// The exact bytes of the three sectors: the record as the board's own code writes it to erased flash, read
/// back to check.
///
/// # Errors
///
/// If a board could not fly with them, or the image does not hold them.
pub fn image(parameters: &Parameters) -> Outcome<Vec<u8>> {
    parameters.validate().map_err(unusable)?;
    let mut payload = [0; MAX_PAYLOAD];
    let payload = parameters.encode(&mut payload).map_err(unusable)?;
    let mut store = Store::new(RamFlash::default(), 0);
    let mut buffer = [0; SLOT_SIZE];
    let failed = |error| Error::Failed(format!("the image does not hold the record: {error:?}"));
    store.save(payload, &mut buffer).map_err(failed)?;
    let read = store.load(&mut buffer).map_err(failed)?.map(Parameters::decode);
    if read != Some(Ok(*parameters)) {
        return Err(Error::Failed("the image does not read back as what was written".to_owned()));
    }
    Ok(store.into_flash().bytes().to_vec())
}

/// An image as Intel HEX at [`AREA_ADDRESS`].
///
/// # Panics
///
/// Never: 32 bytes are no more than a record holds.
pub fn intel_hex(image: &[u8]) -> String {
    use ihex::Record;
    let upper = |address: u32| Record::ExtendedLinearAddress((address >> 16) as u16);
    let mut records = vec![upper(AREA_ADDRESS)];
    for (address, bytes) in (AREA_ADDRESS..).step_by(32).zip(image.chunks(32)) {
        if address & 0xFFFF == 0 {
            records.push(upper(address));
        }
        records.push(Record::Data { offset: (address & 0xFFFF) as u16, value: bytes.to_vec() });
    }
    records.push(Record::EndOfFile);
    ihex::create_object_file_representation(&records).expect("32 bytes are no more than a record holds")
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::SAMPLE_TIME;
    use twinrotor::gains;
    use twinrotor::pipeline::Settings;
    use twinrotor::plant::presets;

    fn parameters() -> Parameters {
        Parameters::new(&presets::AERO, &Settings::paper(&presets::AERO, gains::PAPER, SAMPLE_TIME))
    }

    #[test]
    fn an_image_is_the_whole_area_and_holds_the_record_once() {
        let image = image(&parameters()).unwrap();
        assert_eq!(image.len(), 3 * 16 * 1024);
        let used = image.iter().rposition(|&byte| byte != 0xFF).unwrap();
        assert!(used < SLOT_SIZE, "one record at the beginning, {used} bytes");
    }

    #[test]
    fn what_cannot_fly_makes_no_image() {
        let mut bad = parameters();
        bad.limits.approach_rate = f32::NAN;
        let error = image(&bad).unwrap_err();
        assert!(error.to_string().contains("limits.approach_rate"), "{error}");
        assert!(error.is_input());
    }

    #[test]
    fn intel_hex_holds_the_image_at_its_address() {
        let image = image(&parameters()).unwrap();
        let (mut memory, mut base) = (vec![0; image.len()], 0);
        for record in ihex::Reader::new(&intel_hex(&image)) {
            match record.unwrap() {
                ihex::Record::ExtendedLinearAddress(upper) => base = u32::from(upper) << 16,
                ihex::Record::Data { offset, value } => {
                    let at = (base + u32::from(offset) - AREA_ADDRESS) as usize;
                    memory[at..at + value.len()].copy_from_slice(&value);
                }
                _ => {}
            }
        }
        assert_eq!(memory, image);
    }
}
