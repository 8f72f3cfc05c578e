//! Shared memory.
#![allow(unsafe_code, reason = "memory that the language has no name for")]

use core::arch::nvptx::_thread_idx_x;
use core::arch::{asm, global_asm};
use core::borrow::{Borrow, BorrowMut};
use core::marker::PhantomData;
use twinrotor::monitor::Motion;

const BLOCK: usize = 128;
const STRIDE: usize = (size_of::<Motion<f32>>() / 4 | 1) * 4;

global_asm!(".shared .align 4 .b8 twinrotor_kept[{}];", const STRIDE * BLOCK);

#[derive(Debug, Clone, Copy)]
pub struct Kept<T> {
    offset: u32,
    of: PhantomData<T>,
}

impl<T> Kept<T> {
    #[inline(always)]
    pub fn new(value: T) -> Self {
        let offset = unsafe { _thread_idx_x() as u32 } * STRIDE as u32;
        let kept = Self { offset, of: PhantomData };
        unsafe { kept.at().write(value) };
        kept
    }

    #[inline(always)]
    fn at(&self) -> *mut T {
        let at: *mut T;
        unsafe {
            asm!(
                "{{ .reg .u32 a; mov.u32 a, twinrotor_kept; add.u32 a, a, {offset}; cvt.u64.u32 {at}, a; cvta.shared.u64 {at}, {at}; }}",
                offset = in(reg32) self.offset,
                at = out(reg64) at,
                options(nomem, nostack, preserves_flags)
            );
        }
        at
    }
}

impl<T> Borrow<T> for Kept<T> {
    #[inline(always)]
    fn borrow(&self) -> &T {
        unsafe { &*self.at() }
    }
}

impl<T> BorrowMut<T> for Kept<T> {
    #[inline(always)]
    fn borrow_mut(&mut self) -> &mut T {
        unsafe { &mut *self.at() }
    }
}
