//! How the tick wakes the thread.
//!
//! The tick may not touch what critical sections protect, so an interrupt of low priority, which the chip has
//! no other use for, carries the word.

use cortex_m::peripheral::NVIC;
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::InterruptExt;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

static WOKEN: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// From now on, [`wake`] is heard.
pub(crate) fn listen() {
    #[expect(unsafe_code, reason = "an interrupt is enabled")]
    // SAFETY: its handler sets a signal only.
    unsafe {
        embassy_stm32::interrupt::SDIO.enable();
    }
}

/// There is something to send: for the tick.
pub(crate) fn wake() {
    NVIC::pend(embassy_stm32::interrupt::SDIO);
}

/// The same, for the thread.
pub(crate) fn wake_from_thread() {
    WOKEN.signal(());
}

/// Until somebody has called.
pub(crate) async fn woken() {
    WOKEN.wait().await;
}

#[interrupt]
fn SDIO() {
    WOKEN.signal(());
}
