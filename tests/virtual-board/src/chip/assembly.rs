//! The part put together: which model answers for which instance of the bus.

use rigless::cpu::armv7m;
use rigless::mcu::Operate;
use rigless::soc::Error;
use rigless::soc::stm32f427::peripherals::{self as models, adc, dbg::Dbg, gpio, iwdg::Iwdg, rcc};
use rigless::time::VirtualNanos;

use super::clocks::Rcc;
use super::debug::{self, Dcb, Dwt};
use super::description;
use super::dma::Dma;
use super::exti::Exti;
use super::flash::Flash;
use super::mishaps::Frozen;
use super::more_clocks::{self, MoreClocks};
use super::serial::Usart;
use super::supply::Pwr;
use super::syscfg::Syscfg;
use super::timer::Timer;
use super::{PORTS, Settings, Stm32f405, TIMERS};

/// The serial ports the part has, in the order of [`models::SERIAL_PORTS`].
const SERIAL_PORTS: [usize; 6] = [0, 1, 2, 3, 6, 7];

/// Which model answers for a slot of the bus.
#[derive(Debug, Clone, Copy)]
pub(super) enum Field {
    None,
    Rcc,
    Pwr,
    Port(usize),
    Serial(usize),
    Dma(usize),
    Adc(usize),
    AdcCommon,
    Iwdg,
    Dbg,
    Dcb,
    Dwt,
    Timer(usize),
    Flash,
    Exti,
    Syscfg,
    MoreClocks,
}

/// Where each kind of instance sits on the bus.
#[derive(Debug, Clone)]
pub(super) struct Slots {
    pub(super) rcc: usize,
    pub(super) pwr: usize,
    pub(super) flash: usize,
    pub(super) exti: usize,
    pub(super) ports: [Option<usize>; 9],
    pub(super) serial: [Option<usize>; 6],
    pub(super) iwdg: usize,
    pub(super) dbg: usize,
    pub(super) dcb: usize,
    pub(super) timers: [Option<usize>; 14],
}

impl Stm32f405 {
    /// The part out of a power-on reset, like `settings`, its RAM and all else that chance decides drawn from
    /// `seed`.
    ///
    /// # Errors
    ///
    /// If the description contradicts itself.
    pub fn new(seed: u64, settings: Settings) -> Result<Self, Error> {
        let bus = description::builder(settings.part).build()?;
        let mut wiring = vec![Field::None; bus.slots().len()].into_boxed_slice();
        let mut wire = |name: &'static str, field: Field| -> Result<usize, Error> {
            let slot = bus.slot(name)?;
            wiring[slot] = field;
            Ok(slot)
        };
        let mut slots = Slots {
            rcc: wire("RCC", Field::Rcc)?,
            pwr: wire("PWR", Field::Pwr)?,
            flash: wire("FLASH", Field::Flash)?,
            exti: wire("EXTI", Field::Exti)?,
            iwdg: wire("IWDG", Field::Iwdg)?,
            dbg: wire("DBG", Field::Dbg)?,
            dcb: wire(debug::NAME, Field::Dcb)?,
            ports: [None; 9],
            serial: [None; 6],
            timers: [None; 14],
        };
        wire("SYSCFG", Field::Syscfg)?;
        wire(armv7m::DWT, Field::Dwt)?;
        wire(models::ADC_COMMON, Field::AdcCommon)?;
        // And what not every part has.
        let mut wire = |name, field| settings.part.has(name).then(|| wire(name, field)).transpose();
        wire(more_clocks::NAME, Field::MoreClocks)?;
        for (nth, name) in PORTS.into_iter().enumerate() {
            slots.ports[nth] = wire(name, Field::Port(nth))?;
        }
        for (nth, &port) in SERIAL_PORTS.iter().enumerate() {
            slots.serial[nth] = wire(models::SERIAL_PORTS[port].instance, Field::Serial(nth))?;
        }
        for (nth, timer) in TIMERS.iter().enumerate() {
            slots.timers[nth] = wire(timer.name, Field::Timer(nth))?;
        }
        for (nth, name) in models::CONVERTERS.into_iter().enumerate() {
            wire(name, Field::Adc(nth))?;
        }
        for (nth, controller) in models::CONTROLLERS.iter().enumerate() {
            wire(controller.instance, Field::Dma(nth))?;
        }
        let hz = rcc::HSI_HZ;
        let adc_common = adc::AdcCommon::with_clock(hz);
        let mut part = Self {
            rcc: Rcc::new(&settings),
            pwr: Pwr::new(settings.detector),
            ports: std::array::from_fn(|_| gpio::Gpio::default()),
            serial: std::array::from_fn(|nth| {
                Usart::with_clock(models::SERIAL_PORTS[SERIAL_PORTS[nth]].kind, hz)
            }),
            dma: std::array::from_fn(|nth| Dma::new(&models::CONTROLLERS[nth], settings.stream_stop)),
            adc: std::array::from_fn(|_| adc::Adc::with_clock(hz / 2)),
            adc_common,
            iwdg: Iwdg::new(),
            dbg: Dbg,
            dcb: Dcb::default(),
            dwt: Dwt::with_clock(hz),
            timers: std::array::from_fn(|nth| Timer::new(TIMERS[nth].kind, hz)),
            flash: Flash::new(seed),
            exti: Exti::default(),
            syscfg: Syscfg,
            more_clocks: MoreClocks,
            bus,
            wiring,
            slots,
            powered: true,
            came_up: None,
            seed,
            settings,
            frozen: Frozen::default(),
        };
        part.set_rail(VirtualNanos(0), settings.rail_millivolts);
        part.check()?;
        Ok(part)
    }
}
