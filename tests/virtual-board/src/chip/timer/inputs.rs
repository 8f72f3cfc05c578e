//! A timer's inputs: the encoder on channels 1 and 2, 18.3.12, and the break input, 17.3.12.

use rigless::device::{DeviceContext, Level, RegisterFile};

use super::registers::{Kind, Register};
use super::{BREAK_FLAG, MOE, Timer, UPDATE_FLAG, outputs, raise};

/// `BDTR`.
const BREAK_HIGH: u64 = 1 << 13;
const BREAK_ENABLE: u64 = 1 << 12;
const LOCK: u64 = 3 << 8;
/// What `LOCK` at level 1 and up freezes in `BDTR`, 17.4.18: DTG, BKE, BKP, AOE; level 2 OSSR, OSSI too.
const FROZEN: [u64; 4] = [0, 0x70FF, 0x7CFF, 0x7CFF];

impl Timer {
    /// Whether the counter follows an encoder on channels 1 and 2, 18.3.12.
    pub fn follows_encoder(registers: &RegisterFile) -> bool {
        matches!(registers.get(Register::Smcr) & 7, 1..=3)
            && registers.get(Register::Cr1) & 1 != 0
            && (0..2).all(|channel| outputs::selection(registers, channel) == 1)
    }

    /// Turns the encoder's shaft by `edges` edges of its two channels, four to a line, the positive
    /// direction being the one in which channel 1 leads.
    pub fn turn(&mut self, edges: i64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if edges == 0 || !Self::follows_encoder(registers) {
            return;
        }
        // Modes 1 and 2 count the edges of one channel only; CCxP inverts a channel and so the sense.
        let both = registers.get(Register::Smcr) & 7 == 3;
        let polarity = registers.get(Register::Ccer);
        let reversed = (polarity >> 1 ^ polarity >> 5) & 1 != 0;
        let counts = if both { edges } else { edges / 2 } * if reversed { -1 } else { 1 };
        let modulus = i64::try_from(self.counter.active().reload + 1).expect("33 bits");
        let count = i64::try_from(registers.get(Register::Cnt)).expect("32 bits") + counts;
        let wrapped = count.rem_euclid(modulus);
        registers.set(Register::Cnt, u64::try_from(wrapped).expect("not negative"));
        self.backwards = counts < 0;
        if wrapped != count && !self.counter.control().updates_disabled {
            raise(registers, UPDATE_FLAG);
        }
        self.drive_lines(registers, context);
    }

    /// The level on the break input, `None` where no pin is in that function. 17.3.12.
    pub fn set_break_input(
        &mut self,
        level: Option<Level>,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if self.break_input != level {
            self.settle(registers, context);
            self.break_input = level;
            self.obey_break(registers, context);
        }
    }

    pub(super) fn break_stands(&self, registers: &RegisterFile) -> bool {
        let bdtr = registers.get(Register::Bdtr);
        let active = Level::from(bdtr & BREAK_HIGH != 0);
        bdtr & BREAK_ENABLE != 0 && self.break_input.is_some_and(|level| level == active)
    }

    fn obey_break(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.kind == Kind::Advanced && self.break_stands(registers) {
            registers.set(Register::Bdtr, registers.get(Register::Bdtr) & !MOE);
            raise(registers, BREAK_FLAG);
        }
        self.drive_lines(registers, context);
    }

    pub(super) fn write_break(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if let Some(locked) = self.locked {
            let level = usize::try_from((locked & LOCK) >> 8).expect("two bits");
            registers.restore(Register::Bdtr, FROZEN[level] | LOCK, locked);
        } else if registers.get(Register::Bdtr) & LOCK != 0 {
            self.locked = Some(registers.get(Register::Bdtr));
        }
        self.obey_break(registers, context);
    }

    /// The clock security system's failure breaks as the pin does, whatever its level.
    pub(super) fn break_on_clock_failure(
        &mut self,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if registers.get(Register::Bdtr) & BREAK_ENABLE != 0 {
            registers.set(Register::Bdtr, registers.get(Register::Bdtr) & !MOE);
            raise(registers, BREAK_FLAG);
        }
        self.drive_lines(registers, context);
    }
}
