//! What there is to see beside the encoders: supply voltage, emergency stop, the amplifiers' current limit.

use super::Sensed;
use crate::boards::{self, BOARD};
use crate::family::converter::Converter;
use crate::pins;
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Flex, Input};
use embassy_stm32::peripherals::ADC1;

/// The inputs.
pub(crate) struct Senses {
    _emergency_stop: Flex<'static>,
    _current_limit: Input<'static>,
    _supply: Flex<'static>,
    converter: Converter,
    /// \[V\] Of the amplifiers' supply, for a code of the converter.
    volts_per_code: f32,
}

impl Senses {
    /// Measures the converter's own supply, and starts the first conversion.
    pub(crate) fn start(
        emergency_stop: Flex<'static>,
        current_limit: Input<'static>,
        supply: Flex<'static>,
        adc: Peri<'static, ADC1>,
    ) -> Self {
        let (converter, own_supply) = Converter::start::<{ BOARD.supply_channel }>(adc);
        let volts_per_code = BOARD.supply_full_scale / 4095.0 * own_supply;
        Self {
            _emergency_stop: emergency_stop,
            _current_limit: current_limit,
            _supply: supply,
            converter,
            volts_per_code,
        }
    }

    /// What the last conversion gave; starts the next.
    pub(crate) fn read(&mut self) -> Sensed {
        let (code, fresh) = self.converter.take();
        Sensed {
            supply: f32::from(code) * self.volts_per_code,
            fresh: fresh && boards::encoders_count(),
            emergency_stop: pins::emergency_stop(),
            current_limit: pins::current_limit(),
        }
    }
}
