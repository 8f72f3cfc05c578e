//! A controller to be tried, on its way from the thread to the tick: one place, which the thread writes while
//! it is free, and the tick reads and frees while it is not.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};
use twinrotor::control_loop::OperatorCommand;
use twinrotor::conversation::commands;
use twinrotor::sequence::Numbered;
use twinrotor::trial::Candidate;

struct Slot(UnsafeCell<MaybeUninit<Candidate>>);

#[expect(unsafe_code, reason = "FULL says whose it is")]
// SAFETY: the thread alone uses it while FULL is not set, the tick alone while it is; each hands it over with
// its last access.
unsafe impl Sync for Slot {}

static SLOT: Slot = Slot(UnsafeCell::new(MaybeUninit::uninit()));
static FULL: AtomicBool = AtomicBool::new(false);

/// For the thread: may [`put`] be called?
pub(crate) fn is_free() -> bool {
    !FULL.load(Ordering::Acquire)
}

/// For the thread, while the slot [`is_free`]: there it is for the tick.
pub(crate) fn put(candidate: Candidate) {
    if is_free() {
        #[expect(unsafe_code, reason = "the slot is free")]
        // SAFETY: FULL is not set, and only the thread, here, sets it.
        unsafe {
            (*SLOT.0.get()).write(candidate);
        }
        FULL.store(true, Ordering::Release);
    }
}

/// For the tick: what there is.
#[inline(always)]
pub(crate) fn peek() -> Option<&'static Candidate> {
    #[expect(unsafe_code, reason = "the slot is full")]
    // SAFETY: FULL was set after it was written, and the thread leaves it alone until `settle` frees it,
    // after the tick's last look.
    (!is_free()).then(|| unsafe { (*SLOT.0.get()).assume_init_ref() })
}

/// For the tick, at the end of one with `command` and `disarm`: free again, if what is there was taken or
/// forgotten.
#[cold]
pub(crate) fn settle(command: Option<&Numbered<OperatorCommand>>, disarm: bool) {
    if peek().is_some_and(|candidate| commands::is_done_with(candidate, command, disarm)) {
        FULL.store(false, Ordering::Release);
    }
}
