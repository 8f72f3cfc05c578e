//! A unit's whole state: kept, taken back, as bytes.

use super::{ERROR, Instance, Status, failed, with};
use crate::model::Model;
use std::ffi::{c_char, c_void};
use twinrotor_sim::Error;

/// See FMI 2.0.4, 2.1.8: a copy of the unit as it stands.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(instance: *mut c_void, state: *mut *mut c_void) -> Status {
    let act = |instance: &mut Instance| {
        // SAFETY: a place for a pointer, null or what this function gave before, by the standard's contract.
        unsafe {
            let there = state.read().cast::<Model>();
            match there.as_mut() {
                Some(there) => *there = instance.model.clone(),
                None => state.write(Box::into_raw(Box::new(instance.model.clone())).cast()),
            }
        }
        Ok(())
    };
    // SAFETY: see `with`.
    unsafe { with(instance, act) }
}

/// See FMI 2.0.4, 2.1.8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(instance: *mut c_void, state: *mut c_void) -> Status {
    let act = |instance: &mut Instance| {
        // SAFETY: what `fmi2GetFMUstate` gave, by the standard's contract.
        let state = unsafe { state.cast::<Model>().as_ref() };
        instance.model = state.ok_or((ERROR, "the state is a null pointer".to_owned()))?.clone();
        Ok(())
    };
    // SAFETY: see `with`.
    unsafe { with(instance, act) }
}

/// See FMI 2.0.4, 2.1.8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(instance: *mut c_void, state: *mut *mut c_void) -> Status {
    let act = |_: &mut Instance| {
        // SAFETY: where what `fmi2GetFMUstate` gave stands, by the standard's contract.
        unsafe {
            if let Some(place) = state.as_mut()
                && !place.is_null()
            {
                drop(Box::from_raw(place.cast::<Model>()));
                *place = std::ptr::null_mut();
            }
        }
        Ok(())
    };
    // SAFETY: see `with`.
    unsafe { with(instance, act) }
}

/// A state that `fmi2GetFMUstate` gave, as bytes.
unsafe fn bytes_of(state: *mut c_void) -> Result<Vec<u8>, (Status, String)> {
    // SAFETY: what `fmi2GetFMUstate` gave, by the standard's contract.
    let state = unsafe { state.cast::<Model>().as_ref() };
    Ok(state.ok_or((ERROR, "the state is a null pointer".to_owned()))?.to_bytes())
}

/// See FMI 2.0.4, 2.1.8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    instance: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> Status {
    let act = |_: &mut Instance| {
        // SAFETY: a state, and a place for a number, by the standard's contract.
        unsafe { size.write(bytes_of(state)?.len()) };
        Ok(())
    };
    // SAFETY: see `with`.
    unsafe { with(instance, act) }
}

/// See FMI 2.0.4, 2.1.8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    instance: *mut c_void,
    state: *mut c_void,
    place: *mut c_char,
    size: usize,
) -> Status {
    let act = |_: &mut Instance| {
        // SAFETY: a state, by the standard's contract.
        let bytes = unsafe { bytes_of(state)? };
        if bytes.len() > size {
            return Err(failed(&Error::invalid("size", size, format!("at least {}", bytes.len()))));
        }
        // SAFETY: an array of `size`, by the standard's contract.
        unsafe { place.cast::<u8>().copy_from_nonoverlapping(bytes.as_ptr(), bytes.len()) };
        Ok(())
    };
    // SAFETY: see `with`.
    unsafe { with(instance, act) }
}

/// See FMI 2.0.4, 2.1.8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    instance: *mut c_void,
    place: *const c_char,
    size: usize,
    state: *mut *mut c_void,
) -> Status {
    let act = |instance: &mut Instance| {
        if place.is_null() {
            return Err((ERROR, "the serialized state is a null pointer".to_owned()));
        }
        // SAFETY: an array of `size`, by the standard's contract.
        let bytes = unsafe { std::slice::from_raw_parts(place.cast::<u8>(), size) };
        let model = instance.fresh.from_bytes(bytes).map_err(|error| failed(&error))?;
        // SAFETY: a place for a pointer, by the standard's contract.
        unsafe { state.write(Box::into_raw(Box::new(model)).cast()) };
        Ok(())
    };
    // SAFETY: see `with`.
    unsafe { with(instance, act) }
}
