//! Parameters as an image of a board's flash sectors.

use crate::error::{Failure, Outcome};
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{MAX_PAYLOAD, SLOT_SIZE, Store};
use twinrotor::parameters::{ParameterError, Parameters};

/// Where sectors 1 to 3, which hold the parameters, begin in the board's address space.
pub const IMAGE_ADDRESS: u32 = 0x0800_4000;
/// What says which parameter cannot be used.
pub fn unusable(error: ParameterError) -> Failure {
    match error {
        ParameterError::Range { field, allowed } => {
            Failure::Input(format!("{field} cannot be used on a board; allowed: {allowed}"))
        }
        other => Failure::Run(format!("the parameter record cannot be made: {other:?}")),
    }
}

/// The exact bytes of the three sectors: the record as the board's own code writes it to erased flash, read
/// back to check.
pub fn image(parameters: &Parameters) -> Outcome<Vec<u8>> {
    parameters.validate().map_err(unusable)?;
    let mut payload = [0; MAX_PAYLOAD];
    let payload = parameters.encode(&mut payload).map_err(unusable)?;
    let mut store = Store::new(RamFlash::default(), 0);
    let mut buffer = [0; SLOT_SIZE];
    let failed = |error| Failure::Run(format!("the image does not hold the record: {error:?}"));
    store.save(payload, &mut buffer).map_err(failed)?;
    let read = store.load(&mut buffer).map_err(failed)?.map(Parameters::decode);
    if read != Some(Ok(*parameters)) {
        return Err(Failure::Run("the image does not read back as what was written".to_owned()));
    }
    Ok(store.into_flash().bytes().to_vec())
}

/// An image as Intel HEX at [`IMAGE_ADDRESS`].
pub fn intel_hex(image: &[u8]) -> String {
    use ihex::Record;
    let upper = |address: u32| Record::ExtendedLinearAddress((address >> 16) as u16);
    let mut records = vec![upper(IMAGE_ADDRESS)];
    for (address, bytes) in (IMAGE_ADDRESS..).step_by(32).zip(image.chunks(32)) {
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
        assert_eq!(error.exit_status(), 2);
    }

    #[test]
    fn intel_hex_holds_the_image_at_its_address() {
        let image = image(&parameters()).unwrap();
        let (mut memory, mut base) = (vec![0; image.len()], 0);
        for record in ihex::Reader::new(&intel_hex(&image)) {
            match record.unwrap() {
                ihex::Record::ExtendedLinearAddress(upper) => base = u32::from(upper) << 16,
                ihex::Record::Data { offset, value } => {
                    let at = (base + u32::from(offset) - IMAGE_ADDRESS) as usize;
                    memory[at..at + value.len()].copy_from_slice(&value);
                }
                _ => {}
            }
        }
        assert_eq!(memory, image);
    }
}
