//! ADC1, which measures the amplifiers' supply: one conversion a tick.

use embassy_stm32::adc::Adc;
use embassy_stm32::pac::adc::vals::SampleTime;
use embassy_stm32::peripherals::ADC1;
use embassy_stm32::{Peri, pac};

const CONVERTER: pac::adc::Adc = pac::ADC1;

/// The converter, which works.
pub(crate) struct Converter {
    _adc: Adc<'static, ADC1>,
}

impl Converter {
    /// Starts the first conversion of `CHANNEL`. Answers the converter's own supply, as [`own_supply`].
    pub(crate) fn start<const CHANNEL: u8>(adc: Peri<'static, ADC1>) -> (Self, f32) {
        let adc = Adc::new(adc);
        let own = own_supply(&adc);
        // 84 + 12 cycles of a quarter of the APB2's clock, at most 25 MHz: 3.8 µs, long enough for 9 k ohm.
        let place = usize::from(CHANNEL) % 10;
        if CHANNEL < 10 {
            CONVERTER.smpr2().modify(|w| w.set_smp(place, SampleTime::CYCLES84));
        } else {
            CONVERTER.smpr1().modify(|w| w.set_smp(place, SampleTime::CYCLES84));
        }
        CONVERTER.sqr3().modify(|w| w.set_sq(0, CHANNEL));
        CONVERTER.cr2().modify(|w| w.set_swstart(true));
        (Self { _adc: adc }, own)
    }

    /// The last conversion's code, and whether it is new; starts the next.
    #[inline(always)]
    pub(crate) fn take(&mut self) -> (u16, bool) {
        let fresh = CONVERTER.sr().read().eoc();
        let code = CONVERTER.dr().read().data();
        CONVERTER.cr2().modify(|w| w.set_swstart(true));
        (code, fresh)
    }
}

/// \[V / 3.3 V\] The converter's supply, against which it measures, by the chip's internal reference: boards
/// of 3.0 V are ordinary. Not a number where that cannot be, which the core takes for a supply that jumps.
fn own_supply(adc: &Adc<'static, ADC1>) -> f32 {
    const REFERENCE: u8 = 17;
    const SETTLING: u16 = 4;
    const READINGS: u16 = 16;
    let _on = adc.enable_vrefint();
    // 480 + 12 cycles: 23 µs. The reference wants 10, and as long to start.
    CONVERTER.smpr1().modify(|w| w.set_smp(usize::from(REFERENCE) - 10, SampleTime::CYCLES480));
    CONVERTER.sqr3().modify(|w| w.set_sq(0, REFERENCE));
    let mut sum = 0;
    for reading in 0..SETTLING + READINGS {
        CONVERTER.cr2().modify(|w| w.set_swstart(true));
        while !CONVERTER.sr().read().eoc() {}
        let code = CONVERTER.dr().read().data();
        sum += if reading < SETTLING { 0 } else { code };
    }
    let supply = f32::from(calibrated() * READINGS) / f32::from(sum);
    // 2.7 to 3.8 V: what the chip runs from, and what that does to the reading.
    if (0.8..1.15).contains(&supply) { supply } else { f32::NAN }
}

/// The code of the internal reference at 3.3 V, from the factory (datasheet DS8626, table 72), if this chip
/// has one there; the typical one otherwise.
fn calibrated() -> u16 {
    const FROM_FACTORY: *const u16 = 0x1FFF_7A2A as *const u16;
    /// 1.18 to 1.24 V, and a percent.
    const POSSIBLE: core::ops::Range<u16> = 1450..1554;
    const TYPICAL: u16 = 1501;
    #[expect(unsafe_code, reason = "a constant in the chip's own memory")]
    // SAFETY: aligned, and always readable.
    let code = unsafe { FROM_FACTORY.read_volatile() };
    if POSSIBLE.contains(&code) { code } else { TYPICAL }
}
