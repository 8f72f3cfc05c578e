//! The entry points that a GPU's driver finds by name, as `ptx-kernel` functions over raw memory.

#![allow(unsafe_code, reason = "raw memory and special registers are what a kernel is called with")]

use crate::integral::{self, INTEGRATED};
use crate::robust::{FLOWN, Given, TRACE, flight, to_words, trace, usual};
use crate::shared::Kept;
use crate::told::COMMON;
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x, trap};
use core::slice;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: ends the launch with an error that the host sees.
    unsafe { trap() }
}

/// The number of this thread.
fn number() -> u32 {
    // SAFETY: special registers, which can always be read.
    unsafe { _block_idx_x() * _block_dim_x() + _thread_idx_x() }
}

/// What all flights have in common: not where it stands, but it itself. What a launch is called with is at
/// hand for every instruction and needs no register.
#[repr(C)]
struct Common {
    words: [u32; COMMON],
}

/// Thread k flies flight k of `flights`; what comes of it goes to the k-th piece of `out`.
macro_rules! kernels {
    ($($name:ident: $words:expr, $fly:expr;)+) => {$(
        /// # Safety
        /// Each pointer is of so many readable words as the number after it says, `out` of so many writable
        /// ones for each flight as come of it.
        #[unsafe(no_mangle)]
        unsafe extern "ptx-kernel" fn $name(
            common: Common,
            settings: *const u32,
            settings_words: u32,
            each: u32,
            plants: *const u32,
            plants_words: u32,
            count: u32,
            course: *const u32,
            course_words: u32,
            out: *mut u32,
            flights: u32,
        ) {
            let k = number();
            if k >= flights {
                return;
            }
            // SAFETY: as the caller promises.
            let given = unsafe {
                Given {
                    common: &common.words,
                    settings: slice::from_raw_parts(settings, settings_words as usize),
                    each,
                    plants: slice::from_raw_parts(plants, plants_words as usize),
                    count,
                    course: slice::from_raw_parts(course, course_words as usize),
                }
            };
            let fly: fn(&Given<'_>, u32) -> Option<[u32; $words]> = $fly;
            let Some(words) = fly(&given, k) else {
                // SAFETY: ends the launch with an error that the host sees.
                unsafe { trap() }
            };
            for (w, word) in words.into_iter().enumerate() {
                // SAFETY: w is below the number of words and k below `flights`.
                unsafe { out.add(k as usize * $words + w).write(word) };
            }
        }
    )+};
}

kernels! {
    robust_any: FLOWN, |given, k| flight(given, k, Some, Kept::new).as_ref().map(to_words);
    robust_usual: FLOWN, |given, k| flight(given, k, usual, Kept::new).as_ref().map(to_words);
    robust_trace: TRACE, trace;
    integral_ideal: INTEGRATED, integral::ideal;
    integral_rig: INTEGRATED, integral::rig;
}
