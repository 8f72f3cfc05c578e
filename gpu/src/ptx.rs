//! The entry points that a GPU's driver finds by name, as `ptx-kernel` functions over raw memory.

#![allow(unsafe_code, reason = "raw memory and special registers are what a kernel is called with")]

use crate::robust::{self, FLOWN, Given};
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

/// Thread k flies flight k of `flights`; word w of its sums comes to `out` at w x `flights` + k.
macro_rules! robust {
    ($($name:ident: $narrow:expr;)+) => {$(
        /// # Safety
        /// Each pointer is of so many readable words as the number after it says, `out` of so many words for
        /// each flight as a [`FLOWN`] has.
        #[unsafe(no_mangle)]
        unsafe extern "ptx-kernel" fn $name(
            common: *const u32,
            common_words: u32,
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
                    common: slice::from_raw_parts(common, common_words as usize),
                    settings: slice::from_raw_parts(settings, settings_words as usize),
                    each,
                    plants: slice::from_raw_parts(plants, plants_words as usize),
                    count,
                    course: slice::from_raw_parts(course, course_words as usize),
                }
            };
            let Some(flown) = robust::flight(&given, k, $narrow) else {
                // SAFETY: ends the launch with an error that the host sees.
                unsafe { trap() }
            };
            let words: [u32; FLOWN] = robust::to_words(&flown);
            for (w, word) in words.into_iter().enumerate() {
                // SAFETY: w is below FLOWN and k below `flights`.
                unsafe { out.add(w * flights as usize + k as usize).write(word) };
            }
        }
    )+};
}

robust! {
    robust_any: Some;
    robust_usual: robust::usual;
}
