//! What may befall a part that runs: its crystal stops, a debugger halts it.

use rigless::device::Device;
use rigless::soc::stm32f427::generated::dbg::Register;
use rigless::time::VirtualNanos;

use super::{Settings, Stm32f405, debug, there};

/// Where each timer's freeze bit lies, TIM1 first: in `DBGMCU_APB1_FZ` unless the timer is on APB2, 38.16.4.
const TIMER_FREEZE: [u32; 14] = [0, 0, 1, 2, 3, 4, 5, 1, 16, 17, 18, 6, 7, 8];
const ON_APB2: [usize; 5] = [0, 7, 8, 9, 10];
/// `DBG_IWDG_STOP` in `DBGMCU_APB1_FZ`.
const WATCHDOG_FREEZE: u32 = 12;

/// What a debugger's halt stopped, with the clock that it had \[Hz\].
#[derive(Debug, Default)]
pub(super) struct Frozen {
    timers: Vec<(usize, u64)>,
    watchdog: bool,
}

impl Stm32f405 {
    /// What the part is like from its next reset on.
    pub fn settings(&mut self) -> &mut Settings {
        &mut self.settings
    }

    /// The crystal stops now, for good. Answers whether the clock security noticed and interrupts the core,
    /// which is for the caller to do, who has the core.
    #[must_use]
    pub fn stop_crystal(&mut self, at: VirtualNanos) -> bool {
        self.settings.crystal_hz = 0;
        let (registers, mut context) = self.bus.drive(at, self.slots.rcc);
        self.rcc.stop_crystal(registers, &mut context)
    }

    /// A debugger halts the core: what `DBGMCU` says stands still with it, all else goes on.
    pub fn freeze(&mut self, at: VirtualNanos) {
        let registers = self.bus.slots()[self.slots.dbg].registers();
        let (one, two) = (registers.get(Register::DbgmcuApb1Fz), registers.get(Register::DbgmcuApb2Fz));
        self.frozen.watchdog = one >> WATCHDOG_FREEZE & 1 != 0;
        for (nth, bit) in TIMER_FREEZE.into_iter().enumerate() {
            let bits = if ON_APB2.contains(&nth) { two } else { one };
            if bits >> bit & 1 != 0 {
                let hz = self.timers[nth].counter().clock_hz();
                self.frozen.timers.push((nth, hz));
                self.clock_timer(at, nth, 0);
            }
        }
        if self.frozen.watchdog {
            self.clock_watchdog(at, 0);
        }
        self.dcb.attach(true, true, self.bus.slot_mut(self.slots.dcb).registers_mut());
    }

    /// The debugger lets the core go on, and stays attached.
    pub fn thaw(&mut self, at: VirtualNanos) {
        let Frozen { timers, watchdog } = std::mem::take(&mut self.frozen);
        for (nth, hz) in timers {
            self.clock_timer(at, nth, hz);
        }
        if watchdog {
            let hz = self.rcc.watchdog_hz();
            self.clock_watchdog(at, hz);
        }
        self.dcb.attach(true, false, self.bus.slot_mut(self.slots.dcb).registers_mut());
    }

    fn clock_timer(&mut self, at: VirtualNanos, nth: usize, hz: u64) {
        let (registers, mut context) = self.bus.drive(at, there(self.slots.timers[nth]));
        Device::on_clock(&mut self.timers[nth], hz, registers, &mut context);
    }

    fn clock_watchdog(&mut self, at: VirtualNanos, hz: u64) {
        let (registers, mut context) = self.bus.drive(at, self.slots.iwdg);
        Device::on_clock(&mut self.iwdg, hz, registers, &mut context);
    }

    /// `TRCENA` outlasts every reset but that of the supply, C1.6.5.
    pub(super) fn restore_debug(&mut self, at: VirtualNanos, traced: bool) {
        if traced {
            let (registers, mut context) = self.bus.drive(at, self.slots.dcb);
            registers.set(debug::Register::Demcr, debug::TRCENA);
            Device::write(&mut self.dcb, debug::Register::Demcr, debug::TRCENA, registers, &mut context);
        }
    }
}
