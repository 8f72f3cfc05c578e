//! The clock tree.

use crate::boards::{BOARD, Source};
use crate::critical::BELOW_TICK;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, pac};

/// From the board's own clock, or as fast from the chip's internal oscillator.
pub(crate) fn configuration(sound: bool) -> Config {
    const FALLBACK_DIVIDE: u8 = BOARD.clocks.fallback_divide();
    let clocks = &BOARD.clocks;
    let (source, divide) =
        if sound { (PllSource::HSE, clocks.divide) } else { (PllSource::HSI, FALLBACK_DIVIDE) };
    let mode = match clocks.source {
        Source::Crystal => HseMode::Oscillator,
        Source::External => HseMode::Bypass,
    };
    let mut config = Config::default();
    config.dma_interrupt_priority = BELOW_TICK;
    config.rcc.hse = sound.then_some(Hse { freq: Hertz(clocks.source_hz), mode });
    config.rcc.pll_src = source;
    config.rcc.pll = Some(Pll {
        prediv: PllPreDiv::from_bits(divide),
        mul: PllMul::from_bits(clocks.multiply),
        divp: Some(PllPDiv::from_bits(clocks.post_divide / 2 - 1)),
        divq: None,
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = bus_divider(clocks.apb1_divide);
    config.rcc.apb2_pre = bus_divider(clocks.apb2_divide);
    config
}

/// A power of two.
const fn bus_divider(by: u8) -> APBPrescaler {
    match by {
        1 => APBPrescaler::DIV1,
        2 => APBPrescaler::DIV2,
        4 => APBPrescaler::DIV4,
        8 => APBPrescaler::DIV8,
        _ => APBPrescaler::DIV16,
    }
}

/// Watchdog, tick and stopwatch stop with the core, so that the program can be stepped through.
pub(crate) fn stand_still_at_breakpoints() {
    pac::DBGMCU.apb1fzr().modify(|w| {
        w.set_iwdg(true);
        w.set_tim5(true);
    });
    pac::DBGMCU.apb2fzr().modify(|w| match BOARD.wiring.pwm_timer.as_bytes() {
        b"TIM1" => w.set_tim1(true),
        _ => w.set_tim8(true),
    });
}
