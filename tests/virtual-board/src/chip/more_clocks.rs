//! What the F446's clock control has behind the F405's, RM0390 6.3.27 and 6.3.28: which clocks are gated by
//! themselves, and what feeds peripherals that nothing here uses. Both hold what is written, and do nothing.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::{Access, Layout, Peripheral, ReadAction, RegisterSpec, Width, WriteModify};

/// The name of the instance.
pub const NAME: &str = "RCC_F446";

const fn word(name: &'static str, offset: u32) -> RegisterSpec {
    RegisterSpec {
        name,
        offset,
        width: Width::W32,
        reset: 0,
        access: Access::ReadWrite,
        read: ReadAction::None,
        write: WriteModify::None,
        fields: &[],
    }
}

static REGISTERS: [RegisterSpec; 2] = [word("CKGATENR", 0x0), word("DCKCFGR2", 0x4)];

/// The two registers, for the bus.
pub const PERIPHERAL: Peripheral =
    Peripheral { name: NAME, base: 0x4002_3890, size: 8, interrupts: &[], registers: &REGISTERS };

/// One of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Register {
    Ckgatenr,
    Dckcfgr2,
}

impl Layout for Register {
    const REGISTERS: &'static [RegisterSpec] = &REGISTERS;

    fn from_index(index: usize) -> Option<Self> {
        [Self::Ckgatenr, Self::Dckcfgr2].get(index).copied()
    }

    fn index(self) -> usize {
        self as usize
    }
}

/// Their model.
#[derive(Debug, Default)]
pub struct MoreClocks;

impl Device for MoreClocks {
    type Register = Register;

    fn write(
        &mut self,
        _register: Register,
        _value: u64,
        _registers: &mut RegisterFile,
        _context: &mut DeviceContext<'_>,
    ) {
    }
}
