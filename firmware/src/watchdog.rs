//! The independent watchdog: it resets the chip, and so switches the amplifiers off, when good ticks fail to
//! come.
//!
//! It runs from the chip's own LSI oscillator, nominally 32 kHz but anything from 17 to 47 kHz, and cannot be
//! stopped. 10 ms nominal are 6.8 to 18.8 ms: at most 20 ms from a stall to the reset, at least six ticks of
//! patience.

use embassy_stm32::pac::IWDG;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};

/// The period, as prescaler and reload value: (reload + 1) x prescaler / 32 kHz.
struct Period(Pr, u16);

/// 10 ms nominal.
const NORMAL: Period = Period(Pr::DIVIDE_BY4, 79);
/// 4 s nominal, 2.7 s at least: a 16 KiB sector takes up to .5 s to erase.
const LONG: Period = Period(Pr::DIVIDE_BY64, 1999);

/// Starts it; there is no way back. What comes before the first tick has the longer period.
pub(crate) fn start() {
    IWDG.kr().write(|w| w.set_key(Key::START));
    set(&LONG);
}

/// From now on ticks must come.
pub(crate) fn guard_ticks() {
    set(&NORMAL);
}

/// Only a tick that met its deadline with fresh sensors may do this.
pub(crate) fn feed() {
    IWDG.kr().write(|w| w.set_key(Key::RESET));
}

/// Runs `work`, which may stall the core for up to 2.7 s.
pub(crate) fn lengthened<T>(work: impl FnOnce() -> T) -> T {
    set(&LONG);
    let done = work();
    set(&NORMAL);
    done
}

/// A tick that feeds between the first of these writes and the last would lock the two registers again, and
/// the last would be lost: so nothing comes between, not even a tick, and what came of it is looked at.
#[inline(never)]
fn set(period: &Period) {
    while !holds(period) {
        cortex_m::interrupt::free(|_| {
            IWDG.kr().write(|w| w.set_key(Key::ENABLE));
            IWDG.pr().write(|w| w.set_pr(period.0));
            IWDG.rlr().write(|w| w.set_rl(period.1));
        });
    }
    feed();
}

/// Is `period` in force? Waits for what was written before, which takes up to five LSI cycles to arrive;
/// until then the registers read as before, and a write is lost.
fn holds(period: &Period) -> bool {
    while IWDG.sr().read().0 != 0 {}
    IWDG.pr().read().pr() == period.0 && IWDG.rlr().read().rl() == period.1
}
