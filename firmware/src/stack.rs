//! The stack's end: a guard below it, and how close it came.

use crate::shared::Flag;
use cortex_m::peripheral::MPU;

/// What the start-up code paints the stack with.
const PAINT: u32 = 0xCCCC_CCCC;
/// \[byte\] No access here: a region of the MPU, so that an overflow faults before anything else happens.
const GUARD: u32 = 256;

#[expect(unsafe_code, reason = "symbols of the linker's")]
unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// \[byte address\] The stack grows down from the first to the second.
pub(crate) fn bounds() -> (u32, u32) {
    (&raw const _stack_start as u32, &raw const _stack_end as u32 + GUARD)
}

/// Puts the guard up. All else keeps its default access.
pub(crate) fn guard() {
    const NO_EXECUTE: u32 = 1 << 28;
    const REGION_ENABLE: u32 = 1;
    const KEEP_DEFAULT_MAP: u32 = 1 << 2;
    const ENABLE: u32 = 1;
    let size = (GUARD.trailing_zeros() - 1) << 1;
    #[expect(unsafe_code, reason = "registers of the core")]
    // SAFETY: runs once, before anything else does; the guard lies in memory that nothing uses.
    unsafe {
        let mpu = &*MPU::PTR;
        mpu.rnr.write(0);
        mpu.rbar.write(bounds().1 - GUARD);
        mpu.rasr.write(NO_EXECUTE | size | REGION_ENABLE);
        mpu.ctrl.write(KEEP_DEFAULT_MAP | ENABLE);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// \[byte\] The most that was ever in use, and all there is. Past three quarters, the tick learns of it.
pub(crate) fn high_water() -> (u32, u32) {
    let (start, end) = bounds();
    let mut low = end;
    #[expect(unsafe_code, reason = "reads the stack as words")]
    // SAFETY: between its bounds, aligned, and only read.
    while low < start && unsafe { (low as *const u32).read_volatile() } == PAINT {
        low += 4;
    }
    let (used, size) = (start - low, start - end);
    if used > size / 4 * 3 {
        Flag::StackLow.raise();
    }
    (used, size)
}
