//! Does the board's own crystal swing at the frequency that its file says? Asked before the program runs from
//! it: without this, a missing crystal is a silent hang, and another one makes all times wrong.
//!
//! TIM16 counts the internal oscillator over periods of the clock in question, a 32nd of it (reference manual
//! RM0440, 30.6.19).

use crate::boards::{BOARD, INTERNAL_HZ, Source};
use embassy_stm32::pac;
use embassy_stm32::pac::timer::vals::CcmrInputCcs;

/// \[ms\] A crystal takes a few to start.
const PATIENCE: u16 = 100;
/// Periods of the clock in a capture: every eighth of the divided one.
const EVERY: u32 = 32 * 8;
/// Captures from the first to the last.
const CAPTURES: u32 = 32;
/// \[counts\] From the first to the last, of a clock that is as it should be.
const EXPECTED: u32 = CAPTURES * EVERY * (INTERNAL_HZ / 1_000) / (BOARD.clocks.source_hz / 1_000);
/// The internal oscillator's own tolerance over temperature, and some.
const TOLERANCE: u32 = EXPECTED / 10;
const _: () = assert!(EXPECTED + TOLERANCE < 1 << 16, "the counter's width");

const TIMER: pac::timer::Tim1chCmp = pac::TIM16;

/// Starts it and measures it. The core runs from the internal oscillator, all dividers at one.
pub(crate) fn is_sound() -> bool {
    pac::RCC.apb2enr().modify(|w| w.set_tim16en(true));
    pac::RCC.cr().modify(|w| w.set_hsebyp(BOARD.clocks.source == Source::External));
    pac::RCC.cr().modify(|w| w.set_hseon(true));
    let sound = starts() && period().is_some_and(|counts| counts.abs_diff(EXPECTED) <= TOLERANCE);
    pac::RCC.apb2rstr().modify(|w| w.set_tim16rst(true));
    pac::RCC.apb2rstr().modify(|w| w.set_tim16rst(false));
    pac::RCC.apb2enr().modify(|w| w.set_tim16en(false));
    sound
}

#[expect(clippy::cast_possible_truncation, reason = "15,999")]
fn starts() -> bool {
    TIMER.psc().write_value((INTERNAL_HZ / 1_000 - 1) as u16);
    TIMER.egr().write(|w| w.set_ug(true));
    TIMER.cr1().modify(|w| w.set_cen(true));
    while !pac::RCC.cr().read().hserdy() {
        if TIMER.cnt().read().cnt() >= PATIENCE {
            return false;
        }
    }
    true
}

/// \[counts\] Of the internal oscillator from the first to the last capture, if they all come.
fn period() -> Option<u32> {
    /// TI1SEL: HSE / 32.
    const DIVIDED: u8 = 3;
    TIMER.cr1().modify(|w| w.set_cen(false));
    TIMER.psc().write_value(0);
    TIMER.egr().write(|w| w.set_ug(true));
    TIMER.tisel().modify(|w| w.set_tisel(0, DIVIDED));
    TIMER.ccmr_input(0).modify(|w| {
        w.set_ccs(0, CcmrInputCcs::TI4);
        w.set_icpsc(0, 3);
    });
    TIMER.ccer().modify(|w| w.set_cce(0, true));
    TIMER.cr1().modify(|w| w.set_cen(true));
    let first = capture()?;
    let mut last = first;
    for _ in 0..CAPTURES {
        last = capture()?;
    }
    Some(u32::from(last.wrapping_sub(first)))
}

fn capture() -> Option<u16> {
    const TRIES: u32 = 10_000;
    (0..TRIES).find(|_| TIMER.sr().read().ccif(0)).map(|_| TIMER.ccr(0).read().ccr())
}
