//! The PWM of both motors, and the tick: one advanced timer does both.
//!
//! It counts up and down between 0 and [`TOP`] at 168 MHz, 20 kHz PWM. Its repetition counter lets an update
//! event pass every [`HALF_PERIODS`] half periods, exactly 1 ms. That event raises the tick's interrupt and
//! at the same instant takes over the compare values that the tick before has written: what a tick decides
//! acts from the next one on, to the clock cycle.

use crate::board::{AMPLIFIER, DEAD_TIME, PWM};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac::timer::vals::{Bkp, Ccds, Cms, Lock, Ocm, Ossi, Ossr, Urs};
use embassy_stm32::peripherals::TIM1;
use embassy_stm32::timer::complementary_pwm::ComplementaryPwmPin;
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::timer::{Ch1, Ch2, Ch3, Ch4};
use twinrotor::axes::PerMotor;
use twinrotor::drive::FULL_STEPS;

/// \[counts\] Half a PWM period: 168 MHz / 20 kHz / 2.
const TOP: u16 = 4_200;
/// 1 ms: 40 x 4200 / 168 MHz.
const HALF_PERIODS: u16 = 40;
const _: () = assert!(FULL_STEPS == TOP as u32 / 2, "half of the period each is zero volts");

/// \[counts\] Zero volts.
const NO_VOLTS: u16 = match AMPLIFIER {
    Amplifier::LockedAntiphase => TOP / 2,
    Amplifier::SignMagnitude => 0,
};

/// What a duty means to the amplifiers.
#[derive(Clone, Copy)]
pub(crate) enum Amplifier {
    /// Each motor's bridge gets a PWM and its complement; half of the period each is zero volts.
    LockedAntiphase,
    /// Each motor's bridge gets a PWM on one of two inputs, one for each direction.
    SignMagnitude,
}

/// The pins, in their alternate function for good.
#[expect(dead_code, reason = "held so that the pins stay as they are")]
pub(crate) enum Outputs {
    /// Main and its complement, tail and its complement.
    LockedAntiphase(
        PwmPin<'static, TIM1, Ch1>,
        ComplementaryPwmPin<'static, TIM1, Ch1>,
        PwmPin<'static, TIM1, Ch2>,
        ComplementaryPwmPin<'static, TIM1, Ch2>,
    ),
    /// Main forward and reverse, tail forward and reverse.
    SignMagnitude(
        PwmPin<'static, TIM1, Ch1>,
        PwmPin<'static, TIM1, Ch3>,
        PwmPin<'static, TIM1, Ch2>,
        PwmPin<'static, TIM1, Ch4>,
    ),
}

/// Sets the timer up, outputs off and low, break input armed; it does not run yet.
pub(crate) fn configure() {
    PWM.cr1().write(|w| {
        w.set_cms(Cms::CENTER_ALIGNED1);
        w.set_arpe(true);
        w.set_urs(Urs::COUNTER_ONLY);
    });
    // All output idle states stay 0: low when the outputs are off.
    PWM.cr2().write(|w| w.set_ccds(Ccds::ON_COMPARE));
    PWM.psc().write_value(0);
    PWM.arr().write(|w| w.set_arr(TOP));
    PWM.rcr().write(|w| w.set_rep(HALF_PERIODS - 1));
    for channel in 0..4 {
        PWM.ccmr_output(channel / 2).modify(|w| {
            w.set_ocm(channel % 2, Ocm::PWM_MODE1);
            w.set_ocpe(channel % 2, true);
        });
    }
    PWM.ccer().modify(|w| match AMPLIFIER {
        Amplifier::LockedAntiphase => (0..2).for_each(|channel| {
            w.set_cce(channel, true);
            w.set_ccne(channel, true);
        }),
        Amplifier::SignMagnitude => (0..4).for_each(|channel| w.set_cce(channel, true)),
    });
    // The break input switches the outputs off without any program, and they stay off (AOE = 0). Lock level 1
    // keeps these settings until the next reset.
    PWM.bdtr().write(|w| {
        w.set_dtg(DEAD_TIME);
        w.set_ossi(Ossi::IDLE_LEVEL);
        w.set_ossr(Ossr::IDLE_LEVEL);
        w.set_bke(0, true);
        w.set_bkp(0, Bkp::ACTIVE_HIGH);
        w.set_lock(Lock::LEVEL1);
    });
    let set = PWM.bdtr().read();
    assert!(set.dtg() == DEAD_TIME && set.bke(0) && set.bkp(0) == Bkp::ACTIVE_HIGH && !set.moe());
    self::set(PerMotor::both(0));
    PWM.egr().write(|w| w.set_ug(true));
}

/// From here on the tick comes, with the highest priority.
pub(crate) fn run() {
    PWM.sr().write(|w| w.0 = 0);
    PWM.dier().write(|w| w.set_uie(true));
    let tick = interrupt::TIM1_UP_TIM10;
    tick.set_priority(Priority::P0);
    #[expect(unsafe_code, reason = "an interrupt is enabled")]
    // SAFETY: what its handler uses is in place: `tick::start` calls this last.
    unsafe {
        tick.enable();
    }
    PWM.cr1().modify(|w| w.set_cen(true));
}

/// Steps of either sign, to be latched at the next tick.
pub(crate) fn set(steps: PerMotor<i32>) {
    match AMPLIFIER {
        Amplifier::LockedAntiphase => {
            compare(0, steps.main.wrapping_add(FULL_STEPS as i32));
            compare(1, steps.tail.wrapping_add(FULL_STEPS as i32));
        }
        Amplifier::SignMagnitude => {
            compare(0, steps.main.max(0).wrapping_mul(2));
            compare(2, steps.main.min(0).wrapping_mul(-2));
            compare(1, steps.tail.max(0).wrapping_mul(2));
            compare(3, steps.tail.min(0).wrapping_mul(-2));
        }
    }
}

/// The outputs follow the compare values, unless the break input holds them.
pub(crate) fn outputs_on() {
    PWM.bdtr().modify(|w| w.set_moe(true));
}

/// Has the next tick come due?
pub(crate) fn tick_due() -> bool {
    PWM.sr().read().uif()
}

/// This tick is being dealt with.
pub(crate) fn take_tick() {
    PWM.sr().write(|w| {
        w.0 = u32::MAX;
        w.set_uif(false);
    });
}

/// A value that cannot be, which the core never gives, is zero volts.
fn compare(channel: usize, value: i32) {
    let value = u16::try_from(value).ok().filter(|&value| value <= TOP).unwrap_or(NO_VOLTS);
    PWM.ccr(channel).write(|w| w.set_ccr(value));
}
