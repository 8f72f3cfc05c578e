//! The registers of the timers TIM1 to TIM14, RM0090 sections 17.4, 18.4, 19.4, 19.5 and 20.4. All
//! fourteen share one layout, of which each kind carries a part.

use rigless::soc::{Access, Layout, ReadAction, RegisterSpec, Width, WriteModify};

const fn register(name: &'static str, offset: u32) -> RegisterSpec {
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

/// Every register, a row for each variant of [`Register`].
pub static REGISTERS: [RegisterSpec; 21] = [
    register("CR1", 0x00),
    register("CR2", 0x04),
    register("SMCR", 0x08),
    register("DIER", 0x0C),
    // Every flag is rc_w0: a written zero clears it, a written one leaves it.
    RegisterSpec { write: WriteModify::ZeroToClear, ..register("SR", 0x10) },
    register("EGR", 0x14),
    register("CCMR1", 0x18),
    register("CCMR2", 0x1C),
    register("CCER", 0x20),
    register("CNT", 0x24),
    register("PSC", 0x28),
    RegisterSpec { reset: 0xFFFF, ..register("ARR", 0x2C) },
    register("RCR", 0x30),
    register("CCR1", 0x34),
    register("CCR2", 0x38),
    register("CCR3", 0x3C),
    register("CCR4", 0x40),
    register("BDTR", 0x44),
    register("DCR", 0x48),
    register("DMAR", 0x4C),
    register("OR", 0x50),
];

/// A register of a timer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Register {
    Cr1,
    Cr2,
    Smcr,
    Dier,
    Sr,
    Egr,
    Ccmr1,
    Ccmr2,
    Ccer,
    Cnt,
    Psc,
    Arr,
    Rcr,
    Ccr1,
    Ccr2,
    Ccr3,
    Ccr4,
    Bdtr,
    Dcr,
    Dmar,
    Or,
}

impl Register {
    const ALL: [Self; 21] = [
        Self::Cr1,
        Self::Cr2,
        Self::Smcr,
        Self::Dier,
        Self::Sr,
        Self::Egr,
        Self::Ccmr1,
        Self::Ccmr2,
        Self::Ccer,
        Self::Cnt,
        Self::Psc,
        Self::Arr,
        Self::Rcr,
        Self::Ccr1,
        Self::Ccr2,
        Self::Ccr3,
        Self::Ccr4,
        Self::Bdtr,
        Self::Dcr,
        Self::Dmar,
        Self::Or,
    ];

    /// The register as the manual names it.
    pub fn name(self) -> &'static str {
        REGISTERS[self as usize].name
    }
}

impl Layout for Register {
    const REGISTERS: &'static [RegisterSpec] = &REGISTERS;

    fn from_index(index: usize) -> Option<Self> {
        Self::ALL.get(index).copied()
    }

    fn index(self) -> usize {
        self as usize
    }
}

/// What sort of timer an instance is, RM0090 chapters 17 to 20.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// TIM1 and TIM8: four channels, complementary outputs, dead time, break, repetition.
    Advanced,
    /// TIM2 and TIM5: four channels, a 32-bit counter.
    Wide,
    /// TIM3 and TIM4: four channels, a 16-bit counter.
    General,
    /// TIM9 and TIM12.
    TwoChannels,
    /// TIM10, TIM13 and TIM14.
    OneChannel,
    /// TIM11: one channel, whose input can be the crystal's divided clock.
    Remapped,
    /// TIM6 and TIM7: no channel.
    Basic,
}

impl Kind {
    /// The widest value the counter holds.
    pub const fn top(self) -> u64 {
        match self {
            Self::Wide => 0xFFFF_FFFF,
            _ => 0xFFFF,
        }
    }

    /// How many channels it has.
    pub const fn channels(self) -> usize {
        match self {
            Self::Advanced | Self::Wide | Self::General => 4,
            Self::TwoChannels => 2,
            Self::OneChannel | Self::Remapped => 1,
            Self::Basic => 0,
        }
    }

    /// Whether the manual gives this kind of timer that register.
    pub fn has(self, register: Register) -> bool {
        use Register as R;
        match register {
            R::Cr1 | R::Dier | R::Sr | R::Egr | R::Cnt | R::Psc | R::Arr => true,
            R::Cr2 => !matches!(self, Self::TwoChannels | Self::OneChannel | Self::Remapped),
            R::Smcr => self.channels() >= 2,
            R::Ccmr1 | R::Ccer | R::Ccr1 => self.channels() >= 1,
            R::Ccr2 => self.channels() >= 2,
            R::Ccmr2 | R::Ccr3 | R::Ccr4 | R::Dcr | R::Dmar => self.channels() >= 4,
            R::Rcr | R::Bdtr => self == Self::Advanced,
            R::Or => matches!(self, Self::Wide | Self::Remapped),
        }
    }
}
