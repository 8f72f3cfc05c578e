//! The PWM of both motors: the outputs of the timer that is also the clock of the tick.

use crate::boards::{BOARD, PwmTimer};
use crate::clock::{TIMER, TOP};
use crate::{family, pins};
use embassy_stm32::pac::timer::vals::{Bkp, Ccds, Lock, Ocm, Ossi, Ossr};
use embassy_stm32::timer::complementary_pwm::ComplementaryPwmPin;
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::timer::{Ch1, Ch2, Ch3};
use twinrotor::axes::PerMotor;

/// How the amplifiers are driven.
pub(crate) const AMPLIFIER: Amplifier =
    if cfg!(feature = "sign-magnitude") { Amplifier::SignMagnitude } else { Amplifier::LockedAntiphase };
/// Compare steps from zero to the full supply.
pub(crate) const FULL_STEPS: u32 = BOARD.full_steps();
// What the host simulates is what this board does.
const _: () = assert!(FULL_STEPS == BOARD.known.pwm_steps());

/// \[steps\] The most of them. A half bridge with a bootstrap needs 3 % of each period to charge it, 1.5 µs,
/// its output low. In locked antiphase one of a motor's two half bridges is low for half of what the motor's
/// volts leave of a period.
pub(crate) const MOST_STEPS: u32 = match AMPLIFIER {
    _ if !cfg!(feature = "bootstrap") => FULL_STEPS,
    Amplifier::LockedAntiphase => FULL_STEPS * 94 / 100,
    Amplifier::SignMagnitude => FULL_STEPS * 97 / 100,
};

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

/// The main motor's PWM is the complement of channel 3, of which this makes channel 1's opposite: so it comes
/// out as channel 1 would, dead time included.
const MIRRORED: bool = BOARD.wiring.main_is_mirrored();

/// Which pin the main motor's PWM comes out at.
pub(crate) struct Main<const MIRRORED: bool>;

/// The type of a pin.
pub(crate) trait Output {
    /// It.
    type Pin;
}

impl Output for Main<false> {
    type Pin = PwmPin<'static, PwmTimer, Ch1>;
}

impl Output for Main<true> {
    type Pin = ComplementaryPwmPin<'static, PwmTimer, Ch3>;
}

/// The main motor's pin.
pub(crate) type MainPin = <Main<MIRRORED> as Output>::Pin;

/// The pins, in their alternate function for good: main and its complement, tail and its complement.
#[cfg(not(feature = "sign-magnitude"))]
pub(crate) type Outputs = (
    MainPin,
    ComplementaryPwmPin<'static, PwmTimer, Ch1>,
    PwmPin<'static, PwmTimer, Ch2>,
    ComplementaryPwmPin<'static, PwmTimer, Ch2>,
);

/// The pins, in their alternate function for good: main forward and reverse, tail forward and reverse.
#[cfg(feature = "sign-magnitude")]
pub(crate) type Outputs = (
    MainPin,
    PwmPin<'static, PwmTimer, Ch3>,
    PwmPin<'static, PwmTimer, Ch2>,
    PwmPin<'static, PwmTimer, embassy_stm32::timer::Ch4>,
);

/// Sets the outputs up, off and low, break input armed.
pub(crate) fn configure() {
    const DEAD_TIME: u8 = BOARD.dead_time();
    // All output idle states stay 0: low when the outputs are off.
    TIMER.cr2().write(|w| w.set_ccds(Ccds::ON_COMPARE));
    for channel in 0..4 {
        TIMER.ccmr_output(channel / 2).modify(|w| {
            let mode = if MIRRORED && channel == 2 { Ocm::PWM_MODE2 } else { Ocm::PWM_MODE1 };
            w.set_ocm(channel % 2, mode);
            w.set_ocpe(channel % 2, true);
        });
    }
    TIMER.ccer().modify(|w| match AMPLIFIER {
        Amplifier::LockedAntiphase => (0..if MIRRORED { 3 } else { 2 }).for_each(|channel| {
            w.set_cce(channel, true);
            w.set_ccne(channel, true);
        }),
        Amplifier::SignMagnitude => (0..4).for_each(|channel| w.set_cce(channel, true)),
    });
    // The break input switches the outputs off without any program, and they stay off (AOE = 0). Lock level 1
    // keeps these settings until the next reset.
    TIMER.bdtr().write(|w| {
        w.set_dtg(DEAD_TIME);
        w.set_ossi(Ossi::IDLE_LEVEL);
        w.set_ossr(Ossr::IDLE_LEVEL);
        w.set_bke(0, true);
        w.set_bkp(0, Bkp::ACTIVE_HIGH);
        family::filter_break(w);
        w.set_lock(Lock::LEVEL1);
    });
    let set = TIMER.bdtr().read();
    assert!(set.dtg() == DEAD_TIME && set.bke(0) && set.bkp(0) == Bkp::ACTIVE_HIGH && !set.moe());
    self::set(PerMotor::both(0));
}

/// Steps of either sign, to be latched at the next tick.
pub(crate) fn set(steps: PerMotor<i32>) {
    const FULL: i32 = FULL_STEPS.cast_signed();
    match AMPLIFIER {
        Amplifier::LockedAntiphase => {
            compare(0, steps.main.wrapping_add(FULL));
            compare(1, steps.tail.wrapping_add(FULL));
            if MIRRORED {
                compare(2, steps.main.wrapping_add(FULL));
            }
        }
        Amplifier::SignMagnitude => {
            compare(0, steps.main.max(0).wrapping_mul(2));
            compare(2, steps.main.min(0).wrapping_mul(-2));
            compare(1, steps.tail.max(0).wrapping_mul(2));
            compare(3, steps.tail.min(0).wrapping_mul(-2));
        }
    }
}

/// The outputs follow the compare values, unless the break input holds them; the enable pin is on.
pub(crate) fn on() {
    TIMER.bdtr().modify(|w| w.set_moe(true));
    pins::enable_amplifiers(true);
}

/// Off, whatever state the program is in: outputs first, then the enable pin.
pub(crate) fn off() {
    TIMER.bdtr().modify(|w| w.set_moe(false));
    pins::enable_amplifiers(false);
}

/// A value that cannot be, which the core never gives, is zero volts.
fn compare(channel: usize, value: i32) {
    let value = u16::try_from(value).ok().filter(|&value| value <= TOP).unwrap_or(NO_VOLTS);
    TIMER.ccr(channel).write(|w| w.set_ccr(value));
}
