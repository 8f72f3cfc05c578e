//! What the standard wants of every unit and this one has none of.

use super::{DISCARD, ERROR, Status, with};
use std::ffi::{c_char, c_int, c_void};

/// Functions that a unit must have and that this one has nothing to say in: no numbers but real ones, no
/// derivatives, no steps that are pending.
macro_rules! none_of {
    ($($name:ident($($argument:ident: $type:ty),*) -> $status:expr;)+) => {$(
        #[doc = "See FMI 2.0.4: a unit has none of it."]
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: *mut c_void, $($argument: $type),*) -> Status {
            $(let _ = $argument;)*
            let told = || concat!(stringify!($name), ": this unit has none of it").to_owned();
            // SAFETY: see `with`.
            unsafe { with(instance, |_| Err(($status, told()))) }
        }
    )+};
}

/// The same of arrays, which may be empty.
macro_rules! empty {
    ($($name:ident($($argument:ident: $type:ty),*);)+) => {$(
        #[doc = "See FMI 2.0.4, 2.1.7: a unit has no such variables."]
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            instance: *mut c_void,
            _references: *const u32,
            count: usize,
            $($argument: $type),*
        ) -> Status {
            $(let _ = $argument;)*
            let told = || concat!(stringify!($name), ": all variables of this unit are real").to_owned();
            // SAFETY: see `with`.
            unsafe { with(instance, |_| if count == 0 { Ok(()) } else { Err((ERROR, told())) }) }
        }
    )+};
}

empty! {
    fmi2GetInteger(values: *mut c_int);
    fmi2SetInteger(values: *const c_int);
    fmi2GetBoolean(values: *mut c_int);
    fmi2SetBoolean(values: *const c_int);
    fmi2GetString(values: *mut *const c_char);
    fmi2SetString(values: *const *const c_char);
    fmi2SetRealInputDerivatives(orders: *const c_int, values: *const f64);
    fmi2GetRealOutputDerivatives(orders: *const c_int, values: *mut f64);
}

none_of! {
    fmi2GetDirectionalDerivative(
        unknown: *const u32, unknowns: usize, known: *const u32, knowns: usize, seed: *const f64,
        values: *mut f64
    ) -> ERROR;
    fmi2CancelStep() -> ERROR;
    fmi2GetStatus(kind: c_int, value: *mut Status) -> DISCARD;
    fmi2GetRealStatus(kind: c_int, value: *mut f64) -> DISCARD;
    fmi2GetIntegerStatus(kind: c_int, value: *mut c_int) -> DISCARD;
    fmi2GetBooleanStatus(kind: c_int, value: *mut c_int) -> DISCARD;
    fmi2GetStringStatus(kind: c_int, value: *mut *const c_char) -> DISCARD;
}
