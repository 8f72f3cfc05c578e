//! What there is to see beside the encoders: supply voltage, emergency stop, the amplifiers' current limit.

use super::Sensed;
use crate::boards::{self, BOARD};
use crate::pins;
use crate::shared::{STOP_EDGE, take};
use embassy_stm32::adc::Adc;
use embassy_stm32::gpio::{Flex, Input};
use embassy_stm32::pac;
use embassy_stm32::pac::adc::vals::SampleTime;
use embassy_stm32::peripherals::ADC1;

/// The converter of the amplifiers' supply.
const CONVERTER: pac::adc::Adc = pac::ADC1;

/// The inputs.
pub(crate) struct Senses {
    _emergency_stop: Flex<'static>,
    _current_limit: Input<'static>,
    _supply: Flex<'static>,
    _adc: Adc<'static, ADC1>,
}

impl Senses {
    /// Starts the first conversion.
    pub(crate) fn start(
        emergency_stop: Flex<'static>,
        current_limit: Input<'static>,
        supply: Flex<'static>,
        adc: Adc<'static, ADC1>,
    ) -> Self {
        const CHANNEL: u8 = BOARD.supply_channel;
        // 84 + 12 cycles of a quarter of the APB2's clock, at most 21 MHz: 4.6 µs, long enough for 9 k ohm.
        CONVERTER.smpr1().modify(|w| w.set_smp(usize::from(CHANNEL) - 10, SampleTime::CYCLES84));
        CONVERTER.sqr3().modify(|w| w.set_sq(0, CHANNEL));
        CONVERTER.cr2().modify(|w| w.set_swstart(true));
        Self { _emergency_stop: emergency_stop, _current_limit: current_limit, _supply: supply, _adc: adc }
    }

    /// What the last conversion gave; starts the next.
    pub(crate) fn read(&mut self) -> Sensed {
        let fresh = CONVERTER.sr().read().eoc() && boards::encoders_count();
        let code = CONVERTER.dr().read().data();
        CONVERTER.cr2().modify(|w| w.set_swstart(true));
        Sensed {
            supply: f32::from(code) * (BOARD.supply_full_scale / 4095.0),
            fresh,
            emergency_stop: pins::emergency_stop() | take(&STOP_EDGE),
            current_limit: pins::current_limit(),
        }
    }
}
