//! The debug registers of the core that a firmware meets, DDI 0403E.b C1.6 and C1.8: `DEMCR.TRCENA`, without
//! which the cycle counter stands still, and `DHCSR`, which says whether a debugger is attached. A probe
//! writes both, and clears `TRCENA` when its session ends.
//!
//! Not modelled: what reaches the core's registers through `DCRSR`, vector catch, the debug monitor.

use rigless::cpu::armv7m::{self, Register as DwtRegister};
use rigless::device::{Device, DeviceContext, Level, RegisterFile, RequestChange};
use rigless::soc::{Access, Layout, Peripheral, ReadAction, RegisterSpec, Width, WriteModify};
use rigless::time::VirtualNanos;

/// The name of the instance.
pub const NAME: &str = "DCB";
/// The request that `TRCENA` drives.
const TRACE: usize = 0;
/// `DEMCR.TRCENA`, C1.6.5.
pub const TRCENA: u64 = 1 << 24;
/// `DHCSR.C_DEBUGEN`, C1.6.2.
pub const C_DEBUGEN: u64 = 1;
/// `DHCSR.S_HALT`.
pub const S_HALT: u64 = 1 << 17;

const fn register(name: &'static str, offset: u32, access: Access) -> RegisterSpec {
    RegisterSpec {
        name,
        offset,
        width: Width::W32,
        reset: 0,
        access,
        read: ReadAction::None,
        write: WriteModify::None,
        fields: &[],
    }
}

/// The debug control block's registers.
pub static REGISTERS: [RegisterSpec; 4] = [
    register("DHCSR", 0x0, Access::ReadWrite),
    register("DCRSR", 0x4, Access::WriteOnly),
    register("DCRDR", 0x8, Access::ReadWrite),
    register("DEMCR", 0xC, Access::ReadWrite),
];

/// The debug control block, for the bus.
pub const PERIPHERAL: Peripheral =
    Peripheral { name: NAME, base: 0xE000_EDF0, size: 0x10, interrupts: &[], registers: &REGISTERS };

/// A register of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Register {
    Dhcsr,
    Dcrsr,
    Dcrdr,
    Demcr,
}

impl Layout for Register {
    const REGISTERS: &'static [RegisterSpec] = &REGISTERS;

    fn from_index(index: usize) -> Option<Self> {
        [Self::Dhcsr, Self::Dcrsr, Self::Dcrdr, Self::Demcr].get(index).copied()
    }

    fn index(self) -> usize {
        self as usize
    }
}

/// The debug control block.
#[derive(Debug, Default)]
pub struct Dcb {
    traces: bool,
    /// `DHCSR`, which the core itself can only read.
    state: u64,
}

impl Dcb {
    /// Whether `TRCENA` is set.
    pub fn traces(&self) -> bool {
        self.traces
    }

    /// A debugger is attached, or not, and halts the core, or not.
    pub fn attach(&mut self, attached: bool, halted: bool, registers: &mut RegisterFile) {
        self.state = if attached { C_DEBUGEN } else { 0 } | if halted { S_HALT } else { 0 };
        registers.set(Register::Dhcsr, self.state);
    }
}

impl Device for Dcb {
    type Register = Register;

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        match register {
            Register::Demcr => {
                let traces = value & TRCENA != 0;
                if traces != self.traces {
                    self.traces = traces;
                    context.request(TRACE, Level::from(traces));
                }
            }
            Register::Dhcsr => registers.set(Register::Dhcsr, self.state),
            Register::Dcrsr | Register::Dcrdr => {}
        }
    }
}

/// The cycle counter, which `TRCENA` lets count.
#[derive(Debug)]
pub struct Dwt {
    model: armv7m::Dwt,
    clock_hz: u64,
    traces: bool,
}

impl Dwt {
    /// Out of reset, on a core clock of `clock_hz` \[Hz\], with `TRCENA` off.
    pub fn with_clock(clock_hz: u64) -> Self {
        Self { model: armv7m::Dwt::with_clock(0), clock_hz, traces: false }
    }

    fn follow(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let hz = if self.traces { self.clock_hz } else { 0 };
        Device::on_clock(&mut self.model, hz, registers, context);
    }
}

impl Device for Dwt {
    type Register = DwtRegister;

    fn on_clock(&mut self, hz: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.clock_hz = hz;
        self.follow(registers, context);
    }

    fn on_request(
        &mut self,
        request: RequestChange,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if request.instance == NAME && request.request == TRACE {
            self.traces = request.level == Level::High;
            self.follow(registers, context);
        }
    }

    fn read(
        &mut self,
        register: DwtRegister,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        Device::read(&mut self.model, register, registers, context)
    }

    fn peek(&self, register: DwtRegister, registers: &RegisterFile, now: VirtualNanos) -> Option<u64> {
        Device::peek(&self.model, register, registers, now)
    }

    fn write(
        &mut self,
        register: DwtRegister,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        Device::write(&mut self.model, register, value, registers, context);
    }
}
