//! How the thread gets the tick out of its way: to write the flash, which stalls the core, and to change
//! parameters.

use core::sync::atomic::{AtomicU8, Ordering};
use embassy_time::Timer;
use twinrotor::supervisor::ArmState;

const NOBODY: u8 = 0;
const ASKED: u8 = 1;
const GRANTED: u8 = 2;
const REFUSED: u8 = 3;

static REQUEST: AtomicU8 = AtomicU8::new(NOBODY);

/// The tick stands aside for as long as this exists: it keeps the motors off, does nothing else, and may be
/// missed. There is one at a time, since one task asks.
pub(crate) struct TickAside(());

impl TickAside {
    /// Asks the tick; `None` while the motors may turn, or a fault is to be cleared first.
    pub(crate) async fn ask() -> Option<Self> {
        REQUEST.store(ASKED, Ordering::Release);
        loop {
            Timer::after_micros(500).await;
            match REQUEST.load(Ordering::Acquire) {
                GRANTED => return Some(Self(())),
                REFUSED => {
                    REQUEST.store(NOBODY, Ordering::Release);
                    return None;
                }
                _ => {}
            }
        }
    }
}

impl Drop for TickAside {
    fn drop(&mut self) {
        REQUEST.store(NOBODY, Ordering::Release);
    }
}

/// For the tick: is it to stand aside? `state` is looked at once, when the question is new.
#[inline(always)]
pub(crate) fn stands(state: impl FnOnce() -> ArmState) -> bool {
    match REQUEST.load(Ordering::Acquire) {
        NOBODY | REFUSED => false,
        GRANTED => true,
        _ => {
            let may = state().lets_flash_be_written();
            REQUEST.store(if may { GRANTED } else { REFUSED }, Ordering::Release);
            may
        }
    }
}
