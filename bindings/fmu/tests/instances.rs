//! A thousand instances that come, fly, are made bytes and go, or as many as `TWINROTOR_INSTANCES` says: run
//! by itself as a test, and by `scripts/fmu.sh` under valgrind, which finds whatever is not given back.

#![allow(unsafe_code, reason = "the standard is an interface of C")]

use std::ffi::{CString, c_char, c_void};
use std::fs;
use std::ptr::{null, null_mut};
use twinrotor_fmu::interface::{
    fmi2DeSerializeFMUstate, fmi2DoStep, fmi2EnterInitializationMode, fmi2ExitInitializationMode,
    fmi2FreeFMUstate, fmi2FreeInstance, fmi2GetFMUstate, fmi2GetReal, fmi2Instantiate, fmi2SerializeFMUstate,
    fmi2SerializedFMUstateSize, fmi2SetFMUstate, fmi2SetReal,
};
use twinrotor_fmu::{Design, What};

/// Flies a little, there and back by bytes, and answers where the pitch is.
fn flight(guid: &CString, resources: &CString) -> f64 {
    let mut angle = 0.0;
    // SAFETY: as FMI 2.0.4 has it: strings of C, places for what is answered, everything given back once.
    unsafe {
        let unit = fmi2Instantiate(c"unit".as_ptr(), 1, guid.as_ptr(), resources.as_ptr(), null(), 0, 0);
        assert!(!unit.is_null());
        let all_well = [
            fmi2EnterInitializationMode(unit),
            fmi2ExitInitializationMode(unit),
            fmi2SetReal(unit, [0].as_ptr(), 1, [0.1].as_ptr()),
            fmi2DoStep(unit, 0.0, 0.01, 1),
        ];
        assert_eq!(all_well, [0; 4]);
        let mut state: *mut c_void = null_mut();
        assert_eq!(fmi2GetFMUstate(unit, &raw mut state), 0);
        let mut size = 0;
        assert_eq!(fmi2SerializedFMUstateSize(unit, state, &raw mut size), 0);
        let mut bytes: Vec<c_char> = vec![0; size];
        assert_ne!(fmi2SerializeFMUstate(unit, state, bytes.as_mut_ptr(), size - 1), 0, "it does not fit");
        assert_eq!(fmi2SerializeFMUstate(unit, state, bytes.as_mut_ptr(), size), 0);
        assert_eq!(fmi2FreeFMUstate(unit, &raw mut state), 0);
        assert_ne!(fmi2DeSerializeFMUstate(unit, bytes.as_ptr(), size - 1, &raw mut state), 0);
        assert_eq!(fmi2DeSerializeFMUstate(unit, bytes.as_ptr(), size, &raw mut state), 0);
        assert_eq!(fmi2DoStep(unit, 0.01, 0.01, 1), 0);
        assert_eq!(fmi2SetFMUstate(unit, state), 0);
        assert_eq!(fmi2DoStep(unit, 0.01, 0.01, 1), 0, "it stands where it stood");
        assert_eq!(fmi2GetReal(unit, [4].as_ptr(), 1, &raw mut angle), 0);
        assert_eq!(fmi2FreeFMUstate(unit, &raw mut state), 0);
        fmi2FreeInstance(unit);
    }
    angle
}

#[test]
fn a_thousand_instances_come_and_go() {
    let design =
        Design::load(What::Loop, "aero2", None, &|path| panic!("{path} is no file of this test")).unwrap();
    let folder = std::env::temp_dir().join(format!("twinrotor-fmu-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    for (name, text) in design.resources() {
        fs::write(folder.join(name), text).unwrap();
    }
    let guid = CString::new(design.guid()).unwrap();
    let resources = CString::new(format!("file://{}", folder.display())).unwrap();
    let first = flight(&guid, &resources);
    assert!(first.is_finite());
    let count = std::env::var("TWINROTOR_INSTANCES").map_or(1_000, |count| count.parse().unwrap());
    for _ in 1..count {
        assert_eq!(flight(&guid, &resources).to_bits(), first.to_bits());
    }
    fs::remove_dir_all(folder).unwrap();
}
