//! How the tick wakes the thread.
//!
//! The tick may not touch what critical sections protect, so an interrupt of low priority, which the chip has
//! no other use for, carries the word.

use crate::family::interrupts::WORD;
use crate::receiver;
use cortex_m::peripheral::NVIC;
use embassy_stm32::interrupt::InterruptExt;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

static WOKEN: Signal<CriticalSectionRawMutex, ()> = Signal::new();
static BYTES: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// From now on, [`wake`] is heard.
pub(crate) fn listen() {
    #[expect(unsafe_code, reason = "an interrupt is enabled")]
    // SAFETY: its handler sets signals only.
    unsafe {
        WORD.enable();
    }
}

/// A tick has passed: for the tick. There may be something to send, and something may have come.
#[inline(always)]
pub(crate) fn wake() {
    NVIC::pend(WORD);
}

/// There is something to send: for the thread.
pub(crate) fn wake_from_thread() {
    WOKEN.signal(());
}

/// Until there may be something to send.
pub(crate) async fn woken() {
    WOKEN.wait().await;
}

/// Until something has come.
pub(crate) async fn bytes() {
    BYTES.wait().await;
}

/// For the interrupt that carries the word.
#[inline(always)]
pub(crate) fn hand_on() {
    WOKEN.signal(());
    if receiver::waits() {
        BYTES.signal(());
    }
}
