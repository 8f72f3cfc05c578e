//! From a chip that has just been reset to peripherals ready to use, as the [`boards`] file says.

#[cfg(not(feature = "simulated"))]
use crate::boards::{self, PwmTimer};
use crate::boards::{Parts, Serial, SerialInterrupts};
use crate::clock::Clock;
use crate::family::flash::ParameterFlash;
use crate::port::Port;
use crate::receiver::Receiver;
use crate::{family, flash_cache, led};
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::mode::Async;
use embassy_stm32::pac;
use embassy_stm32::usart::{self, UartTx};
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
    pub(crate) flash: ParameterFlash,
}

/// Clocks and peripherals.
pub(crate) fn start() -> Board {
    let sound = family::oscillator::is_sound();
    let parts = Parts::of(embassy_stm32::init(family::configuration(sound)));
    if sound {
        // Should it stop, the hardware breaks the PWM and interrupts the core, which ends the program.
        pac::RCC.cr().modify(|w| w.set_csson(true));
    }
    flash_cache::start();
    if cfg!(feature = "debug") {
        family::stand_still_at_breakpoints();
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
        use crate::port::amplifier::MainPin;
        use crate::port::senses::Senses;
        use embassy_stm32::gpio::{AfType, Flex, Input, OutputType, Pull};
        use embassy_stm32::pac::timer::vals::FilterValue;
        #[cfg(not(feature = "sign-magnitude"))]
        use embassy_stm32::timer::complementary_pwm::ComplementaryPwmPin;
        use embassy_stm32::timer::qei::{Config as QeiConfig, Qei};
        use embassy_stm32::timer::simple_pwm::PwmPin;
        use embassy_stm32::timer::{BkIn1, BreakInputPin};

        let encoder = || QeiConfig { ch1_pull: Pull::Up, ch2_pull: Pull::Up, ..QeiConfig::default() };
        let pitch = Qei::new(parts.pitch_timer, parts.pitch_a, parts.pitch_b, encoder());
        let yaw = Qei::new(parts.yaw_timer, parts.yaw_a, parts.yaw_b, encoder());
        // The longest filter, 8 samples at a 32nd of the timer's clock: at 84 MHz an edge counts after 3 µs,
        // far from what the PWM induces.
        boards::filter_encoders(FilterValue::FDTS_DIV32_N8);

        let break_function = BreakInputPin::<PwmTimer, BkIn1>::af_num(&*parts.emergency_stop);
        let mut stop = Flex::new(parts.emergency_stop);
        stop.set_as_af_unchecked(break_function, AfType::input(Pull::Up));
        #[cfg(not(feature = "sign-magnitude"))]
        let outputs = (
            MainPin::new(parts.main, OutputType::PushPull),
            ComplementaryPwmPin::new(parts.main_complement, OutputType::PushPull),
            PwmPin::new(parts.tail, OutputType::PushPull),
            ComplementaryPwmPin::new(parts.tail_complement, OutputType::PushPull),
        );
        #[cfg(feature = "sign-magnitude")]
        let outputs = (
            MainPin::new(parts.main, OutputType::PushPull),
            PwmPin::new(parts.main_reverse, OutputType::PushPull),
            PwmPin::new(parts.tail, OutputType::PushPull),
            PwmPin::new(parts.tail_reverse, OutputType::PushPull),
        );

        let mut supply = Flex::new(parts.supply);
        supply.set_as_analog();
        // A wire that is cut reads as a fault.
        let current_limit = Input::new(parts.current_limit, Pull::Down);
        let senses = Senses::start(stop, current_limit, supply, parts.adc);
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
        flash: family::flash::parameters(parts.flash),
    }
}
