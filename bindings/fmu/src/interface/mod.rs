//! The C functions of FMI 2.0.4 for co-simulation (`fmi2FunctionTypes.h`): pointers in, statuses out. Nothing
//! is decided here: every function finds its unit and asks [`Model`]. No panic crosses the border.

#![allow(unsafe_code, reason = "the standard is an interface of C")]
#![allow(non_snake_case, reason = "the standard's names")]
#![allow(clippy::missing_safety_doc, reason = "what C must keep to is the standard's text")]

mod absent;
mod state;

pub use absent::*;
pub use state::*;

use crate::design::Design;
use crate::model::Model;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use twinrotor_sim::{Error, Outcome};

type Status = c_int;
const OK: Status = 0;
const DISCARD: Status = 2;
const ERROR: Status = 3;
const FATAL: Status = 4;

type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`.
#[repr(C)]
pub struct Callbacks {
    logger: Option<Logger>,
    allocate: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    free: Option<unsafe extern "C" fn(*mut c_void)>,
    finished: Option<unsafe extern "C" fn(*mut c_void, Status)>,
    environment: *mut c_void,
}

/// A unit that somebody holds.
struct Instance {
    model: Model,
    /// As it was made: for a reset.
    fresh: Model,
    name: CString,
    logger: Option<Logger>,
    environment: *mut c_void,
}

fn log(logger: Option<Logger>, environment: *mut c_void, name: &CStr, status: Status, text: &str) {
    let Some(logger) = logger else { return };
    // A text is one argument of C's printf: what it holds must not be read as a format.
    let text = CString::new(text.replace('\0', " ").replace('%', "%%")).unwrap_or_default();
    // SAFETY: the environment's own function, called as the standard says.
    unsafe { logger(environment, name.as_ptr(), status, c"error".as_ptr(), text.as_ptr()) }
}

/// Does something with an instance; what goes wrong is logged.
unsafe fn with(
    instance: *mut c_void,
    act: impl FnOnce(&mut Instance) -> Result<(), (Status, String)>,
) -> Status {
    // SAFETY: what `fmi2Instantiate` gave, by the standard's contract not freed yet.
    let Some(instance) = (unsafe { instance.cast::<Instance>().as_mut() }) else { return ERROR };
    match catch_unwind(AssertUnwindSafe(|| act(instance))) {
        Ok(Ok(())) => OK,
        Ok(Err((status, text))) => {
            log(instance.logger, instance.environment, &instance.name, status, &text);
            status
        }
        Err(_) => {
            let text = "a fault of this unit's own; please report it";
            log(instance.logger, instance.environment, &instance.name, FATAL, text);
            FATAL
        }
    }
}

fn failed(error: &Error) -> (Status, String) {
    (ERROR, error.to_string())
}

/// The folder that a URI of `file:` names.
fn folder(location: &str) -> Outcome<PathBuf> {
    let path = location.strip_prefix("file://").or_else(|| location.strip_prefix("file:"));
    let path =
        path.ok_or_else(|| Error::invalid("fmuResourceLocation", location, "a URI that begins with file:"))?;
    let path = path.strip_prefix("localhost").unwrap_or(path);
    // A drive's letter has no stroke before it.
    let path = if path.as_bytes().get(2) == Some(&b':') { path.trim_start_matches('/') } else { path };
    let mut bytes = Vec::new();
    let mut rest = path.bytes();
    while let Some(byte) = rest.next() {
        let code = [rest.clone().next(), rest.clone().nth(1)]
            .map(|digit| digit.and_then(|d| char::from(d).to_digit(16)));
        match (byte, code) {
            (b'%', [Some(high), Some(low)]) => {
                bytes.push(u8::try_from(16 * high + low).unwrap_or(b'%'));
                rest.nth(1);
            }
            _ => bytes.push(byte),
        }
    }
    Ok(PathBuf::from(String::from_utf8_lossy(&bytes).into_owned()))
}

fn load(location: &str, guid: &str) -> Outcome<Model> {
    let folder = folder(location)?;
    let design = Design::from_resources(|name| {
        let path = folder.join(name);
        std::fs::read_to_string(&path)
            .map_err(|error| Error::invalid(path.display(), error, "a file that can be read"))
    })?;
    if guid != design.guid() {
        return Err(Error::invalid("guid", guid, format!("{}, this unit's", design.guid())));
    }
    Model::new(design)
}

/// A C string, or nothing of a null pointer.
unsafe fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: a string of C, by the standard's contract.
    unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned()
}

/// See FMI 2.0.4, 2.1.4.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// See FMI 2.0.4, 2.1.4.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// See FMI 2.0.4, 2.1.5: what can be logged, errors alone, is logged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    instance: *mut c_void,
    _on: c_int,
    _count: usize,
    _categories: *const *const c_char,
) -> Status {
    // SAFETY: see `with`.
    unsafe { with(instance, |_| Ok(())) }
}

/// See FMI 2.0.4, 2.1.5; null where it cannot be, with a reason in the log.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: c_int,
    guid: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _visible: c_int,
    _logging: c_int,
) -> *mut c_void {
    // SAFETY: strings and callbacks of the environment, by the standard's contract.
    let (name, guid, resources, callbacks) =
        unsafe { (text(name), text(guid), text(resources), callbacks.as_ref()) };
    let (logger, environment) = callbacks.map_or((None, std::ptr::null_mut()), |c| (c.logger, c.environment));
    let name = CString::new(name).unwrap_or_default();
    let made = catch_unwind(|| match kind {
        1 => load(&resources, &guid),
        _ => Err(Error::invalid("fmuType", kind, "1: co-simulation")),
    });
    let told = match made {
        Ok(Ok(model)) => {
            let fresh = model.clone();
            return Box::into_raw(Box::new(Instance { model, fresh, name, logger, environment })).cast();
        }
        Ok(Err(error)) => error.to_string(),
        Err(_) => "a fault of this unit's own; please report it".to_owned(),
    };
    log(logger, environment, &name, ERROR, &told);
    std::ptr::null_mut()
}

/// See FMI 2.0.4, 2.1.5.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: what `fmi2Instantiate` gave, and it is given back once.
        drop(unsafe { Box::from_raw(instance.cast::<Instance>()) });
    }
}

/// See FMI 2.0.4, 2.1.6: time begins at 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    instance: *mut c_void,
    _has_tolerance: c_int,
    _tolerance: f64,
    start: f64,
    _has_stop: c_int,
    _stop: f64,
) -> Status {
    let act = |_: &mut Instance| {
        if start == 0.0 { Ok(()) } else { Err(failed(&Error::invalid("startTime", start, "0"))) }
    };
    // SAFETY: see `with`.
    unsafe { with(instance, act) }
}

/// See FMI 2.0.4, 2.1.6.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(instance: *mut c_void) -> Status {
    // SAFETY: see `with`.
    unsafe { with(instance, |_| Ok(())) }
}

/// See FMI 2.0.4, 2.1.6.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(instance: *mut c_void) -> Status {
    let act = |instance: &mut Instance| {
        instance.model.begin();
        Ok(())
    };
    // SAFETY: see `with`.
    unsafe { with(instance, act) }
}

/// See FMI 2.0.4, 2.1.6.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(instance: *mut c_void) -> Status {
    // SAFETY: see `with`.
    unsafe { with(instance, |_| Ok(())) }
}

/// See FMI 2.0.4, 2.1.6.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(instance: *mut c_void) -> Status {
    let act = |instance: &mut Instance| {
        instance.model = instance.fresh.clone();
        Ok(())
    };
    // SAFETY: see `with`.
    unsafe { with(instance, act) }
}

/// See FMI 2.0.4, 2.1.7.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
) -> Status {
    let act = |instance: &mut Instance| {
        for k in 0..count {
            // SAFETY: arrays of `count`, by the standard's contract.
            let reference = unsafe { references.add(k).read() };
            let value = instance.model.get(reference).map_err(|error| failed(&error))?;
            // SAFETY: as above.
            unsafe { values.add(k).write(value) };
        }
        Ok(())
    };
    // SAFETY: see `with`.
    unsafe { with(instance, act) }
}

/// See FMI 2.0.4, 2.1.7.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
) -> Status {
    let act = |instance: &mut Instance| {
        for k in 0..count {
            // SAFETY: arrays of `count`, by the standard's contract.
            let (reference, value) = unsafe { (references.add(k).read(), values.add(k).read()) };
            instance.model.set(reference, value).map_err(|error| failed(&error))?;
        }
        Ok(())
    };
    // SAFETY: see `with`.
    unsafe { with(instance, act) }
}

/// See FMI 2.0.4, 4.2.2: a multiple of a tick, from where the unit stands.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(instance: *mut c_void, from: f64, size: f64, _no_set: c_int) -> Status {
    // SAFETY: see `with`.
    unsafe { with(instance, |instance| instance.model.step(from, size).map_err(|error| failed(&error))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_resources_uri_is_a_folder() {
        let cases = [
            ("file:///tmp/a%20b/resources", "/tmp/a b/resources"),
            ("file:/tmp/resources", "/tmp/resources"),
            ("file://localhost/tmp/100%", "/tmp/100%"),
            ("file:///C:/heli/resources", "C:/heli/resources"),
        ];
        for (uri, path) in cases {
            assert_eq!(folder(uri).unwrap(), PathBuf::from(path), "{uri}");
        }
        assert!(folder("http://x/resources").unwrap_err().to_string().contains("begins with file:"));
    }
}
