//! What there is to see beside the encoders: supply voltage, emergency stop, the amplifiers' current limit.

use crate::board::{self, EMERGENCY_STOP, SUPPLY};
use crate::shared::{STOP_EDGE, take};
use core::sync::atomic::Ordering;
use embassy_stm32::adc::Adc;
use embassy_stm32::gpio::{Flex, Input};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac::adc::vals::SampleTime;
use embassy_stm32::peripherals::ADC1;
use embassy_stm32::{interrupt, pac};

/// One tick's view.
#[derive(Clone, Copy)]
pub(crate) struct Sensed {
    /// \[V\] Supply of the amplifiers, converted since the last tick.
    pub(crate) supply: f32,
    /// That conversion is done, and both encoders' timers count.
    pub(crate) fresh: bool,
    /// Pressed, or its cable broken, now or at any time since the last tick.
    pub(crate) emergency_stop: bool,
    /// The amplifiers limit the current or are at fault.
    pub(crate) current_limit: bool,
}

/// The inputs.
pub(crate) struct Senses {
    _emergency_stop: Flex<'static>,
    _current_limit: Input<'static>,
    _supply: Flex<'static>,
    _adc: Adc<'static, ADC1>,
}

impl Senses {
    /// Starts the first conversion and listens to the emergency stop's edge.
    pub(crate) fn start(
        emergency_stop: Flex<'static>,
        current_limit: Input<'static>,
        supply: Flex<'static>,
        adc: Adc<'static, ADC1>,
    ) -> Self {
        let (regs, channel, _) = SUPPLY;
        // 84 + 12 cycles of 21 MHz: 4.6 µs, long enough for 9 k ohm.
        regs.smpr1().modify(|w| w.set_smp(usize::from(channel) - 10, SampleTime::CYCLES84));
        regs.sqr3().modify(|w| w.set_sq(0, channel));
        regs.cr2().modify(|w| w.set_swstart(true));
        listen_to_emergency_stop();
        Self { _emergency_stop: emergency_stop, _current_limit: current_limit, _supply: supply, _adc: adc }
    }

    /// What the last conversion gave; starts the next.
    pub(crate) fn read(&mut self) -> Sensed {
        let (regs, _, full_scale) = SUPPLY;
        let fresh = regs.sr().read().eoc() && board::encoders_count();
        let code = regs.dr().read().data();
        regs.cr2().modify(|w| w.set_swstart(true));
        Sensed {
            supply: f32::from(code) * (full_scale / 4095.0),
            fresh,
            emergency_stop: board::emergency_stop() | take(&STOP_EDGE),
            current_limit: board::current_limit(),
        }
    }
}

/// A rising edge switches off at once; the timer's break input has cut the PWM by then.
fn listen_to_emergency_stop() {
    let (_, port, pin) = EMERGENCY_STOP;
    let line = usize::from(pin);
    pac::SYSCFG.exticr(line / 4).modify(|w| w.set_exti(line % 4, port));
    pac::EXTI.rtsr(0).modify(|w| w.set_line(line, true));
    pac::EXTI.imr(0).modify(|w| w.set_line(line, true));
    let edge = interrupt::EXTI15_10;
    edge.set_priority(Priority::P0);
    #[expect(unsafe_code, reason = "an interrupt is enabled")]
    // SAFETY: its handler uses registers and an atomic only.
    unsafe {
        edge.enable();
    }
}

#[interrupt]
fn EXTI15_10() {
    board::amplifiers_off();
    STOP_EDGE.store(true, Ordering::Relaxed);
    pac::EXTI.pr(0).write(|w| w.set_line(usize::from(EMERGENCY_STOP.2), true));
}
