//! What a timer's channels put on their pins, RM0090 sections 17.3.9 to 17.3.13: PWM modes, polarity,
//! main output enable, off-state selection and dead time.

use rigless::device::RegisterFile;

use super::counter::{Counter, Shape};
use super::registers::{Kind, Register};

/// What drives a pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// Nothing: the pin floats, and what it is wired to decides.
    Released,
    /// A steady level.
    Low,
    /// A steady level.
    High,
    /// Pulses, high for `high` of `period` counter ticks.
    Pulses { high: u64, period: u64 },
}

impl Drive {
    fn steady(high: bool) -> Self {
        if high { Self::High } else { Self::Low }
    }

    fn inverted_if(self, inverted: bool) -> Self {
        match self {
            Self::Pulses { high, period } if inverted => Self::Pulses { high: period - high, period },
            Self::Low if inverted => Self::High,
            Self::High if inverted => Self::Low,
            same => same,
        }
    }

    /// The share of the time the pin is high, 0 to 1, or `None` for a pin nothing drives.
    #[expect(clippy::cast_precision_loss, reason = "a 16-bit count")]
    pub fn share_high(self) -> Option<f64> {
        match self {
            Self::Released => None,
            Self::Low => Some(0.0),
            Self::High => Some(1.0),
            Self::Pulses { high, period } => Some(high as f64 / period as f64),
        }
    }
}

/// Which of a channel's two outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// `OCx`.
    Main,
    /// `OCxN`.
    Complement,
}

const MOE: u64 = 1 << 15;
const OSSR: u64 = 1 << 11;
const OSSI: u64 = 1 << 10;

/// The output mode of channel `channel`, `OCxM`, and whether its compare value is preloaded, `OCxPE`.
pub(super) fn compare_mode(registers: &RegisterFile, channel: usize) -> (u64, bool) {
    let half = compare_half(registers, channel);
    ((half >> 4) & 7, half & 8 != 0)
}

/// `CCxS`: zero for an output.
pub(super) fn selection(registers: &RegisterFile, channel: usize) -> u64 {
    compare_half(registers, channel) & 3
}

fn compare_half(registers: &RegisterFile, channel: usize) -> u64 {
    let register = [Register::Ccmr1, Register::Ccmr2][channel / 2];
    (registers.get(register) >> (8 * (channel % 2))) & 0xFF
}

/// `CCxE`, `CCxP`, `CCxNE`, `CCxNP`.
fn enables(registers: &RegisterFile, channel: usize) -> [bool; 4] {
    let bits = registers.get(Register::Ccer) >> (4 * channel);
    [0, 1, 2, 3].map(|bit| bits & (1 << bit) != 0)
}

/// The dead time in timer input clock ticks, `BDTR.DTG` of 17.4.18 in units of tDTS (`CR1.CKD`).
pub fn dead_time_ticks(registers: &RegisterFile) -> u64 {
    let generator = registers.get(Register::Bdtr) & 0xFF;
    let steps = match generator >> 5 {
        0..=3 => generator,
        4 | 5 => (64 + (generator & 0x3F)) * 2,
        6 => (32 + (generator & 0x1F)) * 8,
        _ => (32 + (generator & 0x1F)) * 16,
    };
    steps << ((registers.get(Register::Cr1) >> 8) & 3)
}

/// `OCxREF` as the share of a period it is active: the ticks active and the ticks in all.
fn reference(counter: &Counter, registers: &RegisterFile, channel: usize) -> Drive {
    let (compare, reload) = (counter.active().compare[channel], counter.active().reload);
    let (mode, _) = compare_mode(registers, channel);
    let (active, period) = match counter.control().shape {
        // 17.3.10: upwards OCxREF is high while CNT < CCRx, downwards while CNT <= CCRx.
        Shape::Up => (compare.min(reload + 1), reload + 1),
        Shape::Down => ((compare + 1).min(reload + 1), reload + 1),
        Shape::Centre { .. } => (2 * compare.min(reload), 2 * reload),
    };
    let pulses = if let Some(count) = counter.stands_at() {
        // Between two edges for good: a leg stays as it was.
        Drive::steady(if counter.control().shape == Shape::Down { count <= compare } else { count < compare })
    } else if active == 0 {
        Drive::Low
    } else if active >= period {
        Drive::High
    } else {
        Drive::Pulses { high: active, period }
    };
    match mode {
        4 => Drive::Low,
        5 => Drive::High,
        6 => pulses,
        7 => pulses.inverted_if(true),
        // Frozen, and the match modes that the timer's model refuses when enabled.
        _ => Drive::Low,
    }
}

/// What one output of a channel drives, table 96 of 17.4.9.
pub(super) fn drive(
    kind: Kind,
    counter: &Counter,
    registers: &RegisterFile,
    channel: usize,
    side: Side,
) -> Drive {
    let [main, main_low, complement, complement_low] = enables(registers, channel);
    let (enabled, active_low, other) = match side {
        Side::Main => (main, main_low, complement),
        Side::Complement => (complement, complement_low, main),
    };
    let bdtr = registers.get(Register::Bdtr);
    if kind == Kind::Advanced && bdtr & MOE == 0 {
        // With the main output off a channel idles at OISx or OISxN where OSSI asks for it.
        let shift = 8 + 2 * channel + usize::from(side == Side::Complement);
        let idle = registers.get(Register::Cr2) & (1 << shift) != 0;
        let idles = bdtr & OSSI != 0 && (enabled || other);
        return if idles { Drive::steady(idle) } else { Drive::Released };
    }
    if !enabled {
        let off_state = kind == Kind::Advanced && bdtr & OSSR != 0 && other;
        return if off_state { Drive::steady(active_low) } else { Drive::Released };
    }
    let reference = reference(counter, registers, channel);
    // Alone, OCxN follows OCxREF; beside OCx it is its complement.
    let flipped = side == Side::Complement && other;
    let signal = reference.inverted_if(flipped);
    let dead = if other { dead_time_ticks(registers) } else { 0 };
    shortened(signal, dead / (counter.active().prescaler + 1)).inverted_if(active_low)
}

/// Each rising edge comes later by the dead time; a pulse shorter than that does not come at all.
fn shortened(signal: Drive, dead: u64) -> Drive {
    match signal {
        Drive::Pulses { high, .. } if high <= dead => Drive::Low,
        Drive::Pulses { high, period } => Drive::Pulses { high: high - dead, period },
        steady => steady,
    }
}
