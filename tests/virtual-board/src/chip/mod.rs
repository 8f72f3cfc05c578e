//! An STM32F405 on the public traits of `rigless`: the bus of [`description`] and a model for each
//! peripheral that a controller board of this kind has use for. The clock tree, power controller,
//! ports, serial ports, DMA, converters, watchdog and debug component are the crate's own models of the
//! same reference manual; the timers, the flash, the external interrupts and what a supply that goes
//! and comes does to the part are here.

mod description;
pub mod exti;
pub mod flash;
pub mod syscfg;
pub mod timer;

use rigless::cpu::armv7m::{self, Dwt};
use rigless::device::{DeviceContext, ErasedDevice, Level, RegisterFile, ResetCause};
use rigless::mcu::{Mcu, Operate};
use rigless::soc::stm32f427::generated;
use rigless::soc::stm32f427::peripherals::{
    self as models, adc, dbg::Dbg, dma::Dma, gpio, iwdg::Iwdg, pwr::Pwr, rcc, usart,
};
use rigless::soc::{Bus, Error};
use rigless::time::VirtualNanos;

pub use description::{INTERRUPT_LINES, PORTS, SRAM, TIMERS, builder};
use exti::Exti;
use flash::Flash;
use syscfg::Syscfg;
use timer::{Side, Timer};

/// The crystal on the board \[Hz\].
const CRYSTAL_HZ: u64 = 8_000_000;
/// `RCC_CSR` after a power-on: PORRSTF, PINRSTF, BORRSTF, 7.3.21.
const POWER_ON_FLAGS: u64 = 0x0E00_0000;
/// The rail of the part \[mV\].
const RAIL_MILLIVOLTS: u32 = 3300;

/// The serial ports the part has, in the order of [`models::SERIAL_PORTS`].
const SERIAL_PORTS: [usize; 6] = [0, 1, 2, 3, 6, 7];

/// Which model answers for a slot of the bus.
#[derive(Debug, Clone, Copy)]
enum Field {
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
    Dwt,
    Timer(usize),
    Flash,
    Exti,
    Syscfg,
}

/// The microcontroller.
#[derive(Debug)]
pub struct Stm32f405 {
    rcc: rcc::Rcc,
    pwr: Pwr,
    ports: [gpio::Gpio; 9],
    serial: [usart::Usart; 6],
    dma: [Dma; 2],
    adc: [adc::Adc; 3],
    adc_common: adc::AdcCommon,
    iwdg: Iwdg,
    dbg: Dbg,
    dwt: Dwt,
    timers: [Timer; 14],
    flash: Flash,
    exti: Exti,
    syscfg: Syscfg,
    bus: Bus,
    wiring: Box<[Field]>,
    slots: Slots,
    powered: bool,
    came_up: Option<VirtualNanos>,
    seed: u64,
}

/// Where each kind of instance sits on the bus.
#[derive(Debug, Clone)]
struct Slots {
    rcc: usize,
    pwr: usize,
    flash: usize,
    exti: usize,
    ports: [usize; 9],
    serial: [usize; 6],
    timers: [usize; 14],
}

impl Stm32f405 {
    /// The part out of a power-on reset, its RAM and all else that chance decides drawn from `seed`.
    ///
    /// # Errors
    ///
    /// If the description contradicts itself.
    pub fn new(seed: u64) -> Result<Self, Error> {
        let bus = description::builder().build()?;
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
            ports: [0; 9],
            serial: [0; 6],
            timers: [0; 14],
        };
        wire("SYSCFG", Field::Syscfg)?;
        wire("IWDG", Field::Iwdg)?;
        wire("DBG", Field::Dbg)?;
        wire(armv7m::DWT, Field::Dwt)?;
        wire(models::ADC_COMMON, Field::AdcCommon)?;
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
            rcc: rcc::Rcc::new(),
            pwr: Pwr::new(),
            ports: std::array::from_fn(|_| gpio::Gpio::default()),
            serial: std::array::from_fn(|nth| {
                usart::Usart::with_clock(models::SERIAL_PORTS[SERIAL_PORTS[nth]].kind, hz)
            }),
            dma: std::array::from_fn(|nth| {
                let wired = &models::CONTROLLERS[nth];
                Dma::new(wired.wiring, wired.last_data, wired.reaches_memory)
            }),
            adc: std::array::from_fn(|_| adc::Adc::with_clock(hz / 2)),
            adc_common,
            iwdg: Iwdg::new(),
            dbg: Dbg,
            dwt: Dwt::with_clock(hz),
            timers: std::array::from_fn(|nth| Timer::new(TIMERS[nth].kind, hz)),
            flash: Flash::new(seed),
            exti: Exti::default(),
            syscfg: Syscfg,
            bus,
            wiring,
            slots,
            powered: true,
            came_up: None,
            seed,
        };
        part.rcc.attach_crystals(CRYSTAL_HZ, 0);
        part.set_rail(VirtualNanos(0), RAIL_MILLIVOLTS);
        part.check()?;
        Ok(part)
    }

    /// The flash, to place an image in before the part runs and to look at after.
    pub fn flash(&mut self) -> &mut Flash {
        &mut self.flash
    }

    /// Drives the flash from outside at `at`.
    pub fn drive_flash(&mut self, at: VirtualNanos, act: impl FnOnce(&mut Flash, &mut DeviceContext<'_>)) {
        let (_, mut context) = self.bus.drive(at, self.slots.flash);
        act(&mut self.flash, &mut context);
    }

    /// The part as it is before its supply comes on for the first time, a moment after the run begins.
    pub fn start_unpowered(&mut self) {
        self.powered = false;
        self.flash.outage = Some(1000);
        self.drive_flash(VirtualNanos(0), |flash, context| {
            context.request_power(false);
            flash.await_supply(context);
        });
    }

    /// Whether the core stands still for the flash.
    pub fn stalled(&self) -> bool {
        self.powered && self.flash.busy()
    }

    /// The part's own rail \[mV\], which its voltage detector watches.
    pub fn set_rail(&mut self, at: VirtualNanos, millivolts: u32) {
        let registers = self.bus.slot_mut(self.slots.pwr).registers_mut();
        self.pwr.set_supply(millivolts, registers);
        self.watch_rail(at);
    }

    /// Takes the voltage detector's output to its external interrupt line, 12.2.5.
    pub fn watch_rail(&mut self, at: VirtualNanos) {
        let status = self.bus.slots()[self.slots.pwr].registers().get(generated::pwr::Register::Csr);
        let low = generated::pwr::csr::PVDO.is_set(status);
        let (registers, mut context) = self.bus.drive(at, self.slots.exti);
        self.exti.set_line(exti::VOLTAGE_DETECTOR, low, registers, &mut context);
    }

    /// What the outside puts on pin `pin` of port `port` (A is 0).
    pub fn drive_pin(&mut self, at: VirtualNanos, port: usize, pin: u8, level: Option<Level>) {
        let (registers, mut context) = self.bus.drive(at, self.slots.ports[port]);
        self.ports[port].drive(pin_of(pin), level, registers, &mut context);
    }

    /// The level on a pin, or `None` where neither the part nor the outside drives it.
    pub fn pin_level(&self, port: usize, pin: u8) -> Level {
        self.ports[port].level(pin_of(pin), self.port_registers(port))
    }

    /// Whether a pin is an output of the port itself.
    pub fn pin_is_output(&self, port: usize, pin: u8) -> bool {
        let modes = self.port_registers(port).get(generated::gpioa::Register::Moder);
        modes >> (2 * u32::from(pin)) & 3 == 1
    }

    /// The alternate function a pin is in, if it is in one.
    pub fn pin_function(&self, port: usize, pin: u8) -> Option<u8> {
        gpio::Gpio::function(pin_of(pin), self.port_registers(port))
    }

    fn port_registers(&self, port: usize) -> &RegisterFile {
        self.bus.slots()[self.slots.ports[port]].registers()
    }

    /// The voltage on input `channel` of converter `converter` (ADC1 is 0) \[mV\].
    pub fn set_analog(&mut self, converter: usize, channel: u8, millivolts: u32) {
        let channel = adc::Channel::new(channel).expect("one of sixteen inputs");
        self.adc[converter].set_input(channel, millivolts);
    }

    /// Serial port `nth` of USART1, USART2, USART3, USART6, UART4, UART5.
    pub fn serial(&mut self, nth: usize) -> &mut usart::Usart {
        &mut self.serial[nth]
    }

    /// Drives timer `nth` (TIM1 is 0) from outside at `at`, its registers beside it, settled.
    pub fn timer<T>(
        &mut self,
        at: VirtualNanos,
        nth: usize,
        act: impl FnOnce(&mut Timer, &mut RegisterFile, &mut DeviceContext<'_>) -> T,
    ) -> T {
        let (registers, mut context) = self.bus.drive(at, self.slots.timers[nth]);
        let timer = &mut self.timers[nth];
        timer.settle(registers, &mut context);
        act(timer, registers, &mut context)
    }

    /// What an output of a timer drives at `at`, if its pin were in the right function.
    pub fn timer_output(&mut self, at: VirtualNanos, nth: usize, channel: usize, side: Side) -> timer::Drive {
        self.timer(at, nth, |timer, registers, _| timer.output(registers, channel, side))
    }

    /// Whether the supply came on since the last call, so that nothing is left of what RAM held: what
    /// each word of it comes up as is for the caller to write, who has the memory.
    pub fn take_power_on(&mut self) -> Option<impl Iterator<Item = (u64, u64)> + use<>> {
        let at = self.came_up.take()?;
        let mut random = self.seed ^ at.0.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let words =
            [SRAM, description::CCM].into_iter().flat_map(|(base, size)| (base..base + size).step_by(8));
        Some(words.map(move |address| {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            (address, random)
        }))
    }
}

fn pin_of(pin: u8) -> gpio::Pin {
    gpio::Pin::new(pin).expect("one of sixteen pins")
}

impl Mcu for Stm32f405 {
    fn bus(&self) -> &Bus {
        &self.bus
    }

    fn bus_mut(&mut self) -> &mut Bus {
        &mut self.bus
    }

    /// A reset: a fresh part, with the reset flags, the flash and what hangs on its pins kept. With the
    /// supply coming back, nothing else is; with the supply gone, its return is what is waited for.
    fn reset(&mut self, at: VirtualNanos, cause: ResetCause) {
        let mut fresh = Self::new(self.seed).expect("a part that assembled once assembles again");
        let rcc = self.slots.rcc;
        if cause != ResetCause::PowerOn {
            let flags = self.bus.slots()[rcc].registers().get(generated::rcc::Register::Csr);
            let registers = fresh.bus.slot_mut(rcc).registers_mut();
            fresh.rcc.restarted(cause, flags, registers);
        }
        for (new, old) in fresh.serial.iter_mut().zip(&mut self.serial) {
            new.inherit(old);
        }
        for (new, old) in fresh.adc.iter_mut().zip(&self.adc) {
            new.inherit(old);
        }
        std::mem::swap(&mut fresh.flash, &mut self.flash);
        fresh.flash.restart();
        fresh.bus.keep_added(&self.bus).expect("the same part");
        *self = fresh;
        if cause == ResetCause::PowerOn {
            let registers = self.bus.slot_mut(rcc).registers_mut();
            debug_assert_eq!(
                registers.get(generated::rcc::Register::Csr),
                POWER_ON_FLAGS,
                "the register resets to the flags of a power-on"
            );
            self.powered = self.flash.outage.is_none();
            if self.powered {
                self.came_up = Some(at);
            } else {
                self.drive_flash(at, Flash::await_supply);
            }
        }
    }

    fn poll(&mut self, now: VirtualNanos) {
        for (port, &slot) in self.serial.iter_mut().zip(&self.slots.serial) {
            if port.attached() {
                let (registers, mut context) = self.bus.drive(now, slot);
                rigless::device::Device::poll(port, registers, &mut context);
            }
        }
    }

    fn split(&mut self, slot: usize) -> (&mut Bus, Option<&mut dyn ErasedDevice>) {
        let field = self.wiring.get(slot).copied().unwrap_or(Field::None);
        let model: Option<&mut dyn ErasedDevice> = match field {
            Field::None => None,
            Field::Rcc => Some(&mut self.rcc),
            Field::Pwr => Some(&mut self.pwr),
            Field::Port(nth) => Some(&mut self.ports[nth]),
            Field::Serial(nth) => Some(&mut self.serial[nth]),
            Field::Dma(nth) => Some(&mut self.dma[nth]),
            Field::Adc(nth) => Some(&mut self.adc[nth]),
            Field::AdcCommon => Some(&mut self.adc_common),
            Field::Iwdg => Some(&mut self.iwdg),
            Field::Dbg => Some(&mut self.dbg),
            Field::Dwt => Some(&mut self.dwt),
            Field::Timer(nth) => Some(&mut self.timers[nth]),
            Field::Flash => Some(&mut self.flash),
            Field::Exti => Some(&mut self.exti),
            Field::Syscfg => Some(&mut self.syscfg),
        };
        (&mut self.bus, model)
    }
}
