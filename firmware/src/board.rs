//! From a chip that has just been reset to peripherals ready to use, as the [`boards`] file says.

#[cfg(not(feature = "simulated"))]
use crate::boards;
use crate::boards::{BOARD, Parts, Serial, SerialInterrupts, Source};
use crate::clock::Clock;
use crate::critical::BELOW_TICK;
use crate::port::Port;
use crate::receiver::Receiver;
use crate::{flash_cache, led, oscillator};
use embassy_stm32::flash::{Bank1Region1, Blocking, Flash};
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::mode::Async;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::usart::{self, UartTx};
use embassy_stm32::{Config, pac};
use twinrotor::supervisor::{Condition, Conditions};

/// Everything but the tick itself, ready to use: motors off, timers stopped.
pub(crate) struct Board {
    pub(crate) clock: Clock,
    /// What is wrong with the board itself.
    pub(crate) standing: Conditions,
    pub(crate) port: Port,
    pub(crate) serial_in: Receiver,
    pub(crate) serial_out: UartTx<'static, Async>,
    pub(crate) led: Output<'static>,
    pub(crate) flash: Bank1Region1<'static, Blocking>,
}

/// Clocks and peripherals.
pub(crate) fn start() -> Board {
    let sound = oscillator::is_sound();
    let parts = Parts::of(embassy_stm32::init(clocks(sound)));
    if sound {
        // Should it stop, the hardware breaks the PWM and interrupts the core, which ends the program.
        pac::RCC.cr().modify(|w| w.set_csson(true));
    }
    flash_cache::start();
    if cfg!(feature = "debug") {
        stand_still_at_breakpoints();
    }
    let clock = Clock::new(parts.pwm_timer, parts.stopwatch);
    let enable = Output::new(parts.enable, Level::Low, Speed::Low);
    #[cfg(feature = "simulated")]
    let port = {
        crate::pins::hold_button();
        Port::start(enable)
    };
    #[cfg(not(feature = "simulated"))]
    let port = {
        use crate::emergency_stop;
        use crate::port::amplifier::{AMPLIFIER, Amplifier, Outputs};
        use crate::port::senses::Senses;
        use embassy_stm32::adc::Adc;
        use embassy_stm32::gpio::{AfType, Flex, Input, OutputType, Pull};
        use embassy_stm32::pac::timer::vals::FilterValue;
        use embassy_stm32::timer::complementary_pwm::ComplementaryPwmPin;
        use embassy_stm32::timer::qei::{Config as QeiConfig, Qei};
        use embassy_stm32::timer::simple_pwm::PwmPin;

        let encoder = || QeiConfig { ch1_pull: Pull::Up, ch2_pull: Pull::Up, ..QeiConfig::default() };
        let pitch = Qei::new(parts.pitch_timer, parts.pitch_a, parts.pitch_b, encoder());
        let yaw = Qei::new(parts.yaw_timer, parts.yaw_a, parts.yaw_b, encoder());
        // The longest filter, 8 samples at 84 MHz / 32: an edge counts after 3 µs, far from what the PWM
        // induces.
        boards::filter_encoders(FilterValue::FDTS_DIV32_N8);

        let mut stop = Flex::new(parts.emergency_stop);
        stop.set_as_af_unchecked(1, AfType::input(Pull::Up));
        let outputs = match AMPLIFIER {
            Amplifier::LockedAntiphase => Outputs::LockedAntiphase(
                PwmPin::new(parts.main, OutputType::PushPull),
                ComplementaryPwmPin::new(parts.main_complement, OutputType::PushPull),
                PwmPin::new(parts.tail, OutputType::PushPull),
                ComplementaryPwmPin::new(parts.tail_complement, OutputType::PushPull),
            ),
            Amplifier::SignMagnitude => Outputs::SignMagnitude(
                PwmPin::new(parts.main, OutputType::PushPull),
                PwmPin::new(parts.main_reverse, OutputType::PushPull),
                PwmPin::new(parts.tail, OutputType::PushPull),
                PwmPin::new(parts.tail_reverse, OutputType::PushPull),
            ),
        };

        let mut supply = Flex::new(parts.supply);
        supply.set_as_analog();
        // A wire that is cut reads as a fault.
        let current_limit = Input::new(parts.current_limit, Pull::Down);
        let senses = Senses::start(stop, current_limit, supply, Adc::new(parts.adc));
        emergency_stop::listen();
        Port::start(outputs, enable, pitch, yaw, senses)
    };

    let mut config = usart::Config::default();
    config.baudrate = twinrotor::link::BAUD;
    let serial_out =
        UartTx::new(parts.serial, parts.serial_out, parts.serial_out_dma, SerialInterrupts, config);
    Board {
        clock,
        standing: Conditions::NONE
            // A simulated rig does not mind an inexact clock.
            .with(Condition::ClockFallback, !sound && cfg!(not(feature = "simulated")))
            .with(Condition::DebugBuild, cfg!(feature = "debug")),
        port,
        serial_out: serial_out.expect("the baud rate can be had from the clock"),
        serial_in: Receiver::start::<Serial, _, _>(parts.serial_in, &parts.serial_in_dma),
        led: Output::new(parts.led, led::level(false), Speed::Low),
        flash: Flash::new_blocking(parts.flash).into_blocking_regions().bank1_region1,
    }
}

/// Watchdog, tick and stopwatch stop with the core, so that the program can be stepped through.
fn stand_still_at_breakpoints() {
    pac::DBGMCU.apb1fzr().modify(|w| {
        w.set_iwdg(true);
        w.set_tim5(true);
    });
    pac::DBGMCU.apb2fzr().modify(|w| w.set_tim1(true));
}

/// From the board's own clock, or as fast from the chip's internal oscillator.
fn clocks(sound: bool) -> Config {
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
