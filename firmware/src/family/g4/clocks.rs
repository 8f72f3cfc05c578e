//! The clock tree.

use crate::boards::{BOARD, Source};
use crate::critical::BELOW_TICK;
use embassy_stm32::rcc::mux::Adcsel;
use embassy_stm32::rcc::{Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, pac};

/// From the board's own clock, or as fast from the chip's internal oscillator. Above 150 MHz the core's
/// regulator has to be in its boost mode (RM0440, 6.1.5); the buses are as fast as the core.
pub(crate) fn configuration(sound: bool) -> Config {
    const FALLBACK_DIVIDE: u8 = BOARD.clocks.fallback_divide();
    let clocks = &BOARD.clocks;
    const _: () = assert!(BOARD.clocks.apb1_divide == 1 && BOARD.clocks.apb2_divide == 1);
    let (source, divide) =
        if sound { (PllSource::HSE, clocks.divide) } else { (PllSource::HSI, FALLBACK_DIVIDE) };
    let mode = match clocks.source {
        Source::Crystal => HseMode::Oscillator,
        Source::External => HseMode::Bypass,
    };
    let mut config = Config::default();
    config.bdma_interrupt_priority = BELOW_TICK;
    config.rcc.hsi48 = None;
    config.rcc.hse = sound.then_some(Hse { freq: Hertz(clocks.source_hz), mode });
    config.rcc.pll = Some(Pll {
        source,
        prediv: PllPreDiv::from_bits(divide - 1),
        mul: PllMul::from_bits(MULTIPLIER),
        divp: None,
        divq: None,
        divr: Some(PllRDiv::from_bits(clocks.post_divide / 2 - 1)),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.boost = true;
    config.rcc.mux.adc12sel = Adcsel::SYS;
    config
}

/// 8 to 127.
#[expect(clippy::cast_possible_truncation, reason = "asserted")]
const MULTIPLIER: u8 = {
    assert!(BOARD.clocks.multiply >= 8 && BOARD.clocks.multiply <= 127);
    BOARD.clocks.multiply as u8
};

/// Watchdog, tick and stopwatch stop with the core, so that the program can be stepped through.
pub(crate) fn stand_still_at_breakpoints() {
    pac::DBGMCU.apb1lfzr().modify(|w| {
        w.set_iwdg(true);
        w.set_tim5(true);
    });
    pac::DBGMCU.apb2fzr().modify(|w| w.set_tim1(true));
}
