//! Which pin and which timer does what: the one file to change for another board. `docs/wiring.md` is its
//! picture.

use crate::critical::BELOW_TICK;
use crate::port::amplifier::{Amplifier, Outputs};
use crate::port::{EncoderPwmPort, senses};
use embassy_stm32::adc::Adc;
use embassy_stm32::flash::{Bank1Region1, Blocking, Flash};
use embassy_stm32::gpio::{AfType, Flex, Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::mode::Async;
use embassy_stm32::pac::gpio::vals::Idr;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::complementary_pwm::ComplementaryPwmPin;
use embassy_stm32::timer::low_level::Timer;
use embassy_stm32::timer::qei::{Config as QeiConfig, Qei};
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::usart::{self, Uart};
use embassy_stm32::{Config, bind_interrupts, dma, pac, peripherals};

/// How the amplifiers are driven.
pub(crate) const AMPLIFIER: Amplifier =
    if cfg!(feature = "sign-magnitude") { Amplifier::SignMagnitude } else { Amplifier::LockedAntiphase };
/// The PWM's timer, whose update event is the tick.
pub(crate) const PWM: pac::timer::TimAdv = pac::TIM1;
/// \[counts\] Dead time between the two outputs of a half bridge, of 1/168 MHz: .5 µs.
pub(crate) const DEAD_TIME: u8 = 84;
/// The converter of the amplifiers' supply, its channel, and the volts of its full scale: 3.3 V behind 100 k
/// and 10 k ohm.
pub(crate) const SUPPLY: (pac::adc::Adc, u8, f32) = (pac::ADC1, 10, 3.3 * 11.0);
/// The emergency stop's port, as SYSCFG numbers them from A = 0, and pin.
pub(crate) const EMERGENCY_STOP: (pac::gpio::Gpio, u8, u8) = (pac::GPIOB, 1, 12);
/// The amplifiers' fault or current limit: low.
const CURRENT_LIMIT: (pac::gpio::Gpio, usize) = (pac::GPIOC, 3);
/// The amplifiers' enable pin: high is on.
const ENABLE: (pac::gpio::Gpio, usize) = (pac::GPIOC, 8);

/// What the crystal is; the ST-LINK of a Nucleo board feeds its 8 MHz in from outside.
#[cfg(not(feature = "stm32f446re"))]
const CRYSTAL: HseMode = HseMode::Oscillator;
#[cfg(feature = "stm32f446re")]
const CRYSTAL: HseMode = HseMode::Bypass;

/// The chip, as features choose it.
pub(crate) const CHIP: &str = if cfg!(feature = "stm32f446re") {
    "stm32f446re"
} else if cfg!(feature = "stm32f407vg") {
    "stm32f407vg"
} else {
    "stm32f405rg"
};

/// Switches the amplifiers off, whatever state the program is in: outputs first, then the enable pin.
pub(crate) fn amplifiers_off() {
    PWM.bdtr().modify(|w| w.set_moe(false));
    enable_pin(false);
}

/// The amplifiers' enable pin.
pub(crate) fn enable_pin(on: bool) {
    let (port, pin) = ENABLE;
    port.bsrr().write(|w| if on { w.set_bs(pin, true) } else { w.set_br(pin, true) });
}

/// Is the emergency stop pressed, or its cable broken?
pub(crate) fn emergency_stop() -> bool {
    let (port, _, pin) = EMERGENCY_STOP;
    port.idr().read().idr(usize::from(pin)) == Idr::HIGH
}

/// Do the amplifiers limit the current, or are they at fault?
pub(crate) fn current_limit() -> bool {
    let (port, pin) = CURRENT_LIMIT;
    port.idr().read().idr(pin) == Idr::LOW
}

/// Does each encoder's timer count?
pub(crate) fn encoders_count() -> bool {
    pac::TIM2.cr1().read().cen() && pac::TIM3.cr1().read().cen()
}

bind_interrupts!(struct Interrupts {
    USART2 => usart::InterruptHandler<peripherals::USART2>;
    DMA1_STREAM5 => dma::InterruptHandler<peripherals::DMA1_CH5>;
    DMA1_STREAM6 => dma::InterruptHandler<peripherals::DMA1_CH6>;
});

/// Everything but the tick itself, ready to use: motors off, timers stopped.
pub(crate) struct Board {
    pub(crate) port: EncoderPwmPort,
    pub(crate) serial: Uart<'static, Async>,
    pub(crate) led: Output<'static>,
    pub(crate) flash: Bank1Region1<'static, Blocking>,
}

/// Clocks and peripherals.
pub(crate) fn start() -> Board {
    let p = embassy_stm32::init(clocks());
    let enable = Output::new(p.PC8, Level::Low, Speed::Low);

    let pitch = Qei::new(p.TIM2, p.PA0, p.PA1, encoder());
    let yaw = Qei::new(p.TIM3, p.PC6, p.PC7, encoder());
    // The longest filter, 8 samples at 84 MHz / 32: an edge counts after 3 µs, far from what the PWM induces.
    pac::TIM2.ccmr_input(0).modify(|w| (0..2).for_each(|channel| w.set_icf(channel, FILTER)));
    pac::TIM3.ccmr_input(0).modify(|w| (0..2).for_each(|channel| w.set_icf(channel, FILTER)));

    let mut stop = Flex::new(p.PB12);
    stop.set_as_af_unchecked(1, AfType::input(Pull::Up));
    let outputs = match AMPLIFIER {
        Amplifier::LockedAntiphase => Outputs::LockedAntiphase(
            PwmPin::new(p.PA8, OutputType::PushPull),
            ComplementaryPwmPin::new(p.PB13, OutputType::PushPull),
            PwmPin::new(p.PA9, OutputType::PushPull),
            ComplementaryPwmPin::new(p.PB14, OutputType::PushPull),
        ),
        Amplifier::SignMagnitude => Outputs::SignMagnitude(
            PwmPin::new(p.PA8, OutputType::PushPull),
            PwmPin::new(p.PA10, OutputType::PushPull),
            PwmPin::new(p.PA9, OutputType::PushPull),
            PwmPin::new(p.PA11, OutputType::PushPull),
        ),
    };

    let mut supply = Flex::new(p.PC0);
    supply.set_as_analog();
    let adc = Adc::new(p.ADC1);
    let current_limit = Input::new(p.PC3, Pull::Up);
    let senses = senses::Senses::start(stop, current_limit, supply, adc);
    let port = EncoderPwmPort::start(Timer::new(p.TIM1), outputs, enable, pitch, yaw, senses);

    let mut config = usart::Config::default();
    // 42 MHz / 42, so without error.
    config.baudrate = twinrotor::link::BAUD;
    let serial = Uart::new(p.USART2, p.PA3, p.PA2, p.DMA1_CH6, p.DMA1_CH5, Interrupts, config);
    Board {
        port,
        serial: serial.expect("the baud rate can be had from the clock"),
        led: Output::new(p.PA5, Level::Low, Speed::Low),
        flash: Flash::new_blocking(p.FLASH).into_blocking_regions().bank1_region1,
    }
}

const FILTER: pac::timer::vals::FilterValue = pac::timer::vals::FilterValue::FDTS_DIV32_N8;

fn encoder() -> QeiConfig {
    QeiConfig { ch1_pull: Pull::Up, ch2_pull: Pull::Up, ..QeiConfig::default() }
}

/// 8 MHz crystal, 168 MHz core, 42 and 84 MHz buses, 84 and 168 MHz timers: the same on all three chips.
fn clocks() -> Config {
    let mut config = Config::default();
    config.dma_interrupt_priority = BELOW_TICK;
    config.rcc.hse = Some(Hse { freq: Hertz(8_000_000), mode: CRYSTAL });
    config.rcc.pll_src = PllSource::HSE;
    config.rcc.pll = Some(Pll {
        prediv: PllPreDiv::DIV4,
        mul: PllMul::MUL168,
        divp: Some(PllPDiv::DIV2),
        divq: None,
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV4;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    config
}
