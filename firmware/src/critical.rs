//! Critical sections that leave the tick alone.
//!
//! Masking by BASEPRI instead of PRIMASK lets interrupts of priority 0 pass: the tick, the emergency stop and
//! the brown-out detector. In return these three may touch nothing that a critical section protects; what
//! they share with the rest is lock-free ([`crate::shared`]).

use cortex_m::register::{basepri, basepri_max};
use embassy_stm32::interrupt::Priority;

/// Of everything that may wait: all but the three.
pub(crate) const BELOW_TICK: Priority = Priority::P8;

/// Masks priorities from 1 on; of the priority byte, the chip has the upper four bits.
const MASK_FROM_1: u8 = 0x10;

struct BelowTick;
critical_section::set_impl!(BelowTick);

#[expect(unsafe_code, reason = "the crate's interface")]
// SAFETY: everything that uses critical sections runs in the thread or in interrupts of priority 1 and below,
// which BASEPRI masks from acquire to release; nesting restores what was found.
unsafe impl critical_section::Impl for BelowTick {
    unsafe fn acquire() -> critical_section::RawRestoreState {
        let before = basepri::read();
        basepri_max::write(MASK_FROM_1);
        before
    }

    unsafe fn release(before: critical_section::RawRestoreState) {
        // SAFETY: `before` is what `acquire` found.
        unsafe { basepri::write(before) }
    }
}

/// Gives every interrupt a priority that critical sections mask; those few that must not wait are raised
/// later.
pub(crate) fn lower_all_interrupts() {
    const NVIC_IPR: *mut u8 = 0xE000_E400 as *mut u8;
    const INTERRUPTS: usize = 102;
    for number in 0..INTERRUPTS {
        #[expect(unsafe_code, reason = "one byte a line; nothing is enabled yet")]
        // SAFETY: NVIC_IPR has a byte for each of the G474's 102 interrupts; spare ones ignore writes.
        unsafe {
            NVIC_IPR.add(number).write_volatile(BELOW_TICK as u8);
        }
    }
}
