//! ADC1, which measures the amplifiers' supply: one conversion a tick.

use embassy_stm32::adc::{Adc, AdcConfig};
use embassy_stm32::pac::adc::vals::SampleTime;
use embassy_stm32::peripherals::ADC1;
use embassy_stm32::{Peri, pac};

const CONVERTER: pac::adc::Adc = pac::ADC1;

/// The converter, which works.
pub(crate) struct Converter {
    _adc: Adc<'static, ADC1>,
}

impl Converter {
    /// Calibrates it, and starts the first conversion of `CHANNEL`. Answers the converter's own supply, as
    /// [`own_supply`].
    pub(crate) fn start<const CHANNEL: u8>(adc: Peri<'static, ADC1>) -> (Self, f32) {
        let adc = Adc::new(adc, AdcConfig::default());
        let own = own_supply(&adc);
        // 92.5 + 12.5 cycles of a quarter of 170 MHz: 2.5 µs, long enough for 9 k ohm and a code in 1,000.
        choose(CHANNEL, SampleTime::CYCLES92_5);
        begin();
        (Self { _adc: adc }, own)
    }

    /// The last conversion's code, and whether it is new; starts the next.
    #[inline(always)]
    pub(crate) fn take(&mut self) -> (u16, bool) {
        let fresh = CONVERTER.isr().read().eoc();
        // This clears the flag.
        let code = CONVERTER.dr().read().rdata();
        begin();
        (code, fresh)
    }
}

fn choose(channel: u8, time: SampleTime) {
    let place = usize::from(channel) % 10;
    if channel < 10 {
        CONVERTER.smpr().modify(|w| w.set_smp(place, time));
    } else {
        CONVERTER.smpr2().modify(|w| w.set_smp(place, time));
    }
    CONVERTER.sqr1().write(|w| w.set_sq(0, channel));
}

#[inline(always)]
fn begin() {
    CONVERTER.cr().modify(|w| w.set_adstart(true));
}

/// \[V / 3.3 V\] The converter's supply, against which it measures, by the chip's internal reference. Not a
/// number where that cannot be, which the core takes for a supply that jumps.
fn own_supply(adc: &Adc<'static, ADC1>) -> f32 {
    const REFERENCE: u8 = 18;
    const SETTLING: u16 = 4;
    const READINGS: u16 = 8;
    /// \[V\] At which the factory has read the reference.
    const READ_AT: f32 = 3.0;
    let _on = adc.enable_vrefint();
    // 640.5 + 12.5 cycles: 15 µs. The reference wants 4, and 12 to start.
    choose(REFERENCE, SampleTime::CYCLES640_5);
    let mut sum = 0;
    for reading in 0..SETTLING + READINGS {
        begin();
        while !CONVERTER.isr().read().eoc() {}
        let code = CONVERTER.dr().read().rdata();
        sum += if reading < SETTLING { 0 } else { code };
    }
    let supply = f32::from(calibrated() * READINGS) / f32::from(sum) * (READ_AT / 3.3);
    // 2.7 to 3.8 V: what the chip runs from, and what that does to the reading.
    if (0.8..1.15).contains(&supply) { supply } else { f32::NAN }
}

/// The code of the internal reference at 3.0 V, from the factory (datasheet DS12288, table 6), if this chip
/// has one there; the typical one otherwise.
fn calibrated() -> u16 {
    const FROM_FACTORY: *const u16 = 0x1FFF_75AA as *const u16;
    /// 1.182 to 1.232 V, and a percent.
    const POSSIBLE: core::ops::Range<u16> = 1597..1699;
    const TYPICAL: u16 = 1654;
    #[expect(unsafe_code, reason = "a constant in the chip's own memory")]
    // SAFETY: aligned, and always readable.
    let code = unsafe { FROM_FACTORY.read_volatile() };
    if POSSIBLE.contains(&code) { code } else { TYPICAL }
}
