//! The clock of the tick: the update event of the timer that makes the PWM.
//!
//! TIM1, or TIM8 where the board leads that one out, counts up and down between 0 and [`TOP`], [`PWM_HZ`]
//! times a second. Its repetition counter lets an update event pass every [`HALF_PERIODS`] half periods,
//! exactly 1 ms. That event raises the tick's interrupt and at the same instant takes over the compare values
//! that the tick before has written: what a tick decides acts from the next one on, to the clock cycle.
//!
//! A second timer, TIM5, only counts, from boot on: the stopwatch by which a tick that was left out, or took
//! too long, is found. The core's own cycle counter would do, but a debug probe that detaches stops it.

use crate::boards::{self, BOARD, PwmTimer};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac::timer::vals::{Cms, Urs};
use embassy_stm32::peripherals::TIM5;
use embassy_stm32::timer::low_level::Timer;
use embassy_stm32::{Peri, pac};
use twinrotor::drive::PWM_HZ;

/// The timer, whose outputs are the amplifiers'.
pub(crate) const TIMER: pac::timer::TimAdv = boards::PWM_TIMER;
/// The stopwatch: 32 bits.
const STOPWATCH: pac::timer::TimGp32 = pac::TIM5;
/// \[counts\] Half a PWM period.
pub(crate) const TOP: u16 = BOARD.pwm_top();
/// \[Hz\] Of the tick.
const TICK_HZ: u32 = 1_000;
/// Of the PWM, in a tick.
#[expect(clippy::cast_possible_truncation, reason = "40")]
const HALF_PERIODS: u16 = (2 * PWM_HZ / TICK_HZ) as u16;
/// \[counts\] Of the stopwatch, in a tick.
pub(crate) const COUNTS: u32 = BOARD.clocks.slow_timer_hz() / TICK_HZ;
/// \[cycles\] Of the core, in a count of the stopwatch.
pub(crate) const CYCLES: u32 = BOARD.clocks.core_hz() / BOARD.clocks.slow_timer_hz();

/// The timer set up, for good.
#[derive(Clone, Copy)]
pub(crate) struct Clock(());

impl Clock {
    /// Sets the timer's period; it does not run yet, the stopwatch does.
    pub(crate) fn new(timer: Peri<'static, PwmTimer>, stopwatch: Peri<'static, TIM5>) -> Self {
        // Dropping them would switch the timers off.
        core::mem::forget((Timer::new(timer), Timer::new(stopwatch)));
        STOPWATCH.psc().write_value(0);
        STOPWATCH.cr1().modify(|w| w.set_cen(true));
        TIMER.cr1().write(|w| {
            w.set_cms(Cms::CENTER_ALIGNED1);
            w.set_arpe(true);
            w.set_urs(Urs::COUNTER_ONLY);
        });
        TIMER.psc().write_value(0);
        TIMER.arr().write(|w| w.set_arr(TOP));
        TIMER.rcr().write(|w| w.set_rep(HALF_PERIODS - 1));
        Self(())
    }

    /// Takes over what was set up, the compare values included; from here on the tick comes, with the highest
    /// priority.
    pub(crate) fn run(self) {
        TIMER.egr().write(|w| w.set_ug(true));
        TIMER.sr().write(|w| w.0 = 0);
        TIMER.dier().write(|w| w.set_uie(true));
        let tick = boards::TICK;
        tick.set_priority(Priority::P0);
        #[expect(unsafe_code, reason = "an interrupt is enabled")]
        // SAFETY: what its handler uses is in place: `tick::start` calls this last.
        unsafe {
            tick.enable();
        }
        TIMER.cr1().modify(|w| w.set_cen(true));
    }

    /// \[counts\] What the stopwatch shows; it wraps at 2^32.
    #[inline(always)]
    pub(crate) fn now(self) -> u32 {
        STOPWATCH.cnt().read()
    }

    /// This tick is being dealt with.
    #[inline(always)]
    pub(crate) fn take_tick(self) {
        TIMER.sr().write(|w| {
            w.0 = u32::MAX;
            w.set_uif(false);
        });
    }

    /// Has the next tick come due?
    #[inline(always)]
    pub(crate) fn tick_due(self) -> bool {
        TIMER.sr().read().uif()
    }
}

/// Does nothing for so many ticks.
#[cfg(feature = "simulated")]
pub(crate) fn idle(ticks: u32) {
    let begin = STOPWATCH.cnt().read();
    while STOPWATCH.cnt().read().wrapping_sub(begin) < ticks.wrapping_mul(COUNTS) {}
}
