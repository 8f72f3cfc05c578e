//! The part as the emulator sees it: its bus, its models, and what a reset leaves.

use rigless::device::{ErasedDevice, ResetCause};
use rigless::mcu::Mcu;
use rigless::soc::Bus;
use rigless::soc::stm32f427::generated;
use rigless::time::VirtualNanos;

use super::Stm32f405;
use super::assembly::Field;
use super::flash::Flash;

/// `RCC_CSR` after a power-on: PORRSTF, PINRSTF, BORRSTF, 7.3.21.
const POWER_ON_FLAGS: u64 = 0x0E00_0000;
/// TIM11, whose channel 1 can be the crystal's divided clock.
const MEASURES_CRYSTAL: usize = 10;

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
        let mut fresh =
            Self::new(self.seed, self.settings).expect("a part that assembled once assembles again");
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
        let traced = cause != ResetCause::PowerOn && self.dcb.traces();
        *self = fresh;
        self.restore_debug(at, traced);
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
        for (port, slot) in self.serial.iter_mut().zip(self.slots.serial) {
            if let Some(slot) = slot.filter(|_| port.attached()) {
                let (registers, mut context) = self.bus.drive(now, slot);
                rigless::device::Device::poll(port, registers, &mut context);
            }
        }
    }

    fn split(&mut self, slot: usize) -> (&mut Bus, Option<&mut dyn ErasedDevice>) {
        let field = self.wiring.get(slot).copied().unwrap_or(Field::None);
        if let Field::Timer(MEASURES_CRYSTAL) = field {
            let clocks = self.bus.slots()[self.slots.rcc].registers();
            self.timers[MEASURES_CRYSTAL].feed(self.rcc.crystal_divided(clocks));
        }
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
            Field::Dcb => Some(&mut self.dcb),
            Field::Dwt => Some(&mut self.dwt),
            Field::Timer(nth) => Some(&mut self.timers[nth]),
            Field::Flash => Some(&mut self.flash),
            Field::Exti => Some(&mut self.exti),
            Field::Syscfg => Some(&mut self.syscfg),
            Field::MoreClocks => Some(&mut self.more_clocks),
        };
        (&mut self.bus, model)
    }
}
