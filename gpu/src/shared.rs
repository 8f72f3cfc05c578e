//! A multiprocessor's shared memory: where a thread keeps what few ticks look at.
//!
//! A thread has at most 255 registers, and what a flight looks at is more. An assembler that runs out of them
//! chooses for itself what goes to memory; here what is looked at in every fourth tick alone is put there,
//! and none is left for it to choose.

#![allow(unsafe_code, reason = "memory that the language has no name for")]

use crate::BLOCK;
use core::arch::nvptx::_thread_idx_x;
use core::arch::{asm, global_asm};
use core::borrow::{Borrow, BorrowMut};
use twinrotor::monitor::Motion;

/// \[bytes\] From one thread's to the next one's: an odd number of words, so that what the threads of a warp
/// look at at a time, the same word of each, is in different banks.
const STRIDE: u32 = (size_of::<Motion<f32>>() as u32 / 4 | 1) * 4;

// One for each thread of a block. A multiprocessor of the oldest cards has 64 KiB and is to have two blocks.
global_asm!(".shared .align 4 .b8 twinrotor_kept[{bytes}];", bytes = const STRIDE * BLOCK);
const _: () = assert!(2 * STRIDE * BLOCK <= 64 << 10 && align_of::<Motion<f32>>() == 4);

/// This thread's [`Motion`], in shared memory.
#[derive(Debug)]
pub(crate) struct Kept {
    /// \[bytes\] From the beginning of the block's.
    offset: u32,
}

impl Kept {
    /// Puts it there.
    #[inline(always)]
    pub(crate) fn new(motion: Motion<f32>) -> Self {
        // SAFETY: a special register, which can always be read.
        let kept = Self { offset: unsafe { _thread_idx_x() } * STRIDE };
        // SAFETY: this thread's own, of this size and aligned to words.
        unsafe { kept.at().write(motion) };
        kept
    }

    /// Where it is. The compiler does not know that this is the same place every time, and so does not keep
    /// in registers what stands there.
    #[inline(always)]
    fn at(&self) -> *mut Motion<f32> {
        let at: *mut Motion<f32>;
        // SAFETY: reads the address of what is declared above, and writes the registers declared.
        unsafe {
            asm!(
                "{{ .reg .b64 begin;",
                "mov.u64 begin, twinrotor_kept;",
                "cvta.shared.u64 begin, begin;",
                "cvt.u64.u32 {at}, {offset};",
                "add.s64 {at}, {at}, begin; }}",
                offset = in(reg32) self.offset,
                at = out(reg64) at,
                options(nomem, nostack, preserves_flags)
            );
        }
        at
    }
}

impl Borrow<Motion<f32>> for Kept {
    #[inline(always)]
    fn borrow(&self) -> &Motion<f32> {
        // SAFETY: `new` has written it, and only this thread knows of it.
        unsafe { &*self.at() }
    }
}

impl BorrowMut<Motion<f32>> for Kept {
    #[inline(always)]
    fn borrow_mut(&mut self) -> &mut Motion<f32> {
        // SAFETY: as above; borrowed as `self` is.
        unsafe { &mut *self.at() }
    }
}
