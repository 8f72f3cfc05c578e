//! An STM32F405, or an F411 or F446 by what they lack of it (`parts`), on the public traits of `rigless`: the
//! bus of `description` and a model for each peripheral that a controller board of this kind has use for. The
//! clock tree, power controller, ports, serial ports, DMA, converters, watchdog and debug component are the
//! crate's own models of the same reference manual, some of them wrapped to do what they leave out; the
//! timers, the flash, the external interrupts and what a supply that goes and comes does to the part are
//! here. What differs from part to part, and what may befall one, is in [`Settings`] and in `mishaps`.

mod assembly;
pub mod clocks;
pub mod debug;
mod description;
pub mod dma;
pub mod exti;
pub mod flash;
mod mishaps;
pub mod more_clocks;
mod part;
mod parts;
pub mod serial;
mod settings;
pub mod supply;
pub mod syscfg;
pub mod timer;

use rigless::device::{DeviceContext, Level, RegisterFile};
use rigless::soc::Bus;
use rigless::soc::stm32f427::generated;
use rigless::soc::stm32f427::peripherals::{adc, dbg::Dbg, gpio, iwdg::Iwdg};
use rigless::time::VirtualNanos;

use assembly::{Field, Slots};
use clocks::Rcc;
use debug::{Dcb, Dwt};

pub use description::{INTERRUPT_LINES, PORTS, SRAM, TIMERS, builder};
use dma::Dma;
use exti::Exti;
use flash::Flash;
use mishaps::Frozen;
use more_clocks::MoreClocks;
pub use parts::Part;
use serial::Usart;
pub use settings::{Settings, StreamStop, Tolerance};
use supply::Pwr;
use syscfg::Syscfg;
use timer::{Side, Timer};

/// How long a supply that comes on for the first time takes \[ns\].
const FIRST_OUTAGE_NS: u64 = 1_000;

/// The microcontroller.
#[derive(Debug)]
pub struct Stm32f405 {
    rcc: Rcc,
    pwr: Pwr,
    ports: [gpio::Gpio; 9],
    serial: [Usart; 6],
    dma: [Dma; 2],
    adc: [adc::Adc; 3],
    adc_common: adc::AdcCommon,
    iwdg: Iwdg,
    dbg: Dbg,
    dcb: Dcb,
    dwt: Dwt,
    timers: [Timer; 14],
    flash: Flash,
    exti: Exti,
    syscfg: Syscfg,
    more_clocks: MoreClocks,
    bus: Bus,
    wiring: Box<[Field]>,
    slots: Slots,
    powered: bool,
    came_up: Option<VirtualNanos>,
    seed: u64,
    settings: Settings,
    frozen: Frozen,
}

impl Stm32f405 {
    /// The flash, to place an image in before the part runs and to look at after.
    pub fn flash(&mut self) -> &mut Flash {
        &mut self.flash
    }

    /// Which part it is.
    pub fn part(&self) -> Part {
        self.settings.part
    }

    /// Drives the flash from outside at `at`.
    pub fn drive_flash(&mut self, at: VirtualNanos, act: impl FnOnce(&mut Flash, &mut DeviceContext<'_>)) {
        let (_, mut context) = self.bus.drive(at, self.slots.flash);
        act(&mut self.flash, &mut context);
    }

    /// The part as it is before its supply comes on for the first time, a moment after the run begins.
    pub fn start_unpowered(&mut self) {
        self.powered = false;
        self.flash.outage = Some(FIRST_OUTAGE_NS);
        self.drive_flash(VirtualNanos(0), |flash, context| {
            context.request_power(false);
            flash.await_supply(context);
        });
    }

    /// The supply goes, and comes on as at first, with `bytes` in the flash from `address` on.
    pub fn switch_off_and_on(&mut self, at: VirtualNanos, address: u64, bytes: &[u8]) {
        self.drive_flash(at, |flash, context| {
            flash.cut(context);
            flash.replace(address, bytes, context);
            flash.forget();
            flash.outage = Some(FIRST_OUTAGE_NS);
        });
    }

    /// Whether the core stands still, for the flash or for want of a clock.
    pub fn stalled(&self) -> bool {
        self.powered && (self.flash.busy() || self.rcc.still())
    }

    /// The part's own rail \[mV\], which its voltage detector watches and its converters measure against,
    /// from now on.
    pub fn set_rail(&mut self, at: VirtualNanos, millivolts: u32) {
        self.settings.rail_millivolts = millivolts;
        self.adc.iter_mut().for_each(|converter| converter.set_reference(millivolts));
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
        let (registers, mut context) = self.bus.drive(at, there(self.slots.ports[port]));
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
        self.bus.slots()[there(self.slots.ports[port])].registers()
    }

    /// The voltage on input `channel` of converter `converter` (ADC1 is 0) \[mV\].
    pub fn set_analog(&mut self, converter: usize, channel: u8, millivolts: u32) {
        let channel = adc::Channel::new(channel).expect("one of sixteen inputs");
        self.adc[converter].set_input(channel, millivolts);
    }

    /// Serial port `nth` of USART1, USART2, USART3, USART6, UART4, UART5.
    pub fn serial(&mut self, nth: usize) -> &mut Usart {
        &mut self.serial[nth]
    }

    /// Drives timer `nth` (TIM1 is 0) from outside at `at`, its registers beside it, settled.
    pub fn timer<T>(
        &mut self,
        at: VirtualNanos,
        nth: usize,
        act: impl FnOnce(&mut Timer, &mut RegisterFile, &mut DeviceContext<'_>) -> T,
    ) -> T {
        let (registers, mut context) = self.bus.drive(at, there(self.slots.timers[nth]));
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
        let coupled = self.part().is_large().then_some(description::CCM);
        let rams = std::iter::once(SRAM).chain(coupled);
        let words = rams.flat_map(|(base, size)| (base..base + size).step_by(8));
        Some(words.map(move |address| {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            (address, random)
        }))
    }
}

/// The slot of an instance that is only asked for on a part that has it.
fn there(slot: Option<usize>) -> usize {
    slot.expect("the part has it")
}

fn pin_of(pin: u8) -> gpio::Pin {
    gpio::Pin::new(pin).expect("one of sixteen pins")
}
