//! Input capture as far as TIM11 measures the crystal by it: `HSE_RTC` on its channel 1, RM0090 7.2.11,
//! 19.4.11 and 19.3.5. The edges are worked out in closed form, like the counter. Polled only: the flag, the
//! overcapture flag and the captured count; no interrupt.

use rigless::device::{DeviceContext, RegisterFile};

use super::registers::{Kind, Register};
use super::{Timer, raise};

const NANOS: u128 = 1_000_000_000;
/// `SR`.
const CAPTURED: u64 = 1 << 1;
const OVERCAPTURED: u64 = 1 << 9;
/// `OR.TI1_RMP`: `HSE_RTC`.
const FROM_CRYSTAL: u64 = 2;

/// What arrives at the channel.
#[derive(Debug, Default)]
pub(super) struct Capture {
    hz: u64,
    /// The edges up to the last look, by the prescaler they were counted with.
    seen: Option<(u64, u64)>,
    value: u64,
}

impl Timer {
    /// \[Hz\] The frequency of `HSE_RTC` from now on.
    pub fn feed(&mut self, hz: u64) {
        if self.capture.hz != hz {
            self.capture.hz = hz;
            self.capture.seen = None;
        }
    }

    /// Whether channel 1 captures what this model can follow: TIM11, rising edges of `HSE_RTC`.
    pub(super) fn captures(&self, registers: &RegisterFile) -> bool {
        let enabled = registers.get(Register::Ccer) & 0b1011 == 1;
        let selected = registers.get(Register::Ccmr1) & 3 == 1;
        self.kind == Kind::Remapped && enabled && selected && registers.get(Register::Or) & 3 == FROM_CRYSTAL
    }

    /// Takes the edges up to now into the flags and the captured count.
    pub(super) fn capture(&mut self, registers: &mut RegisterFile, context: &DeviceContext<'_>) {
        if !self.captures(registers) || self.capture.hz == 0 {
            self.capture.seen = None;
            return;
        }
        let now = u128::from(context.now().0);
        let every = 1 << ((registers.get(Register::Ccmr1) >> 2) & 3);
        let hz = u128::from(self.capture.hz);
        let edges = now * hz / (u128::from(every) * NANOS);
        let counted = u64::try_from(edges).expect("centuries of edges");
        let seen = self.capture.seen.replace((every, counted));
        let Some((_, before)) = seen.filter(|&(by, _)| by == every) else {
            return;
        };
        if counted == before {
            return;
        }
        let last = u64::try_from((edges * u128::from(every) * NANOS).div_ceil(hz)).expect("up to now");
        self.capture.value = self.counter.count_at(last, context.now().0);
        let over = counted - before > 1 || registers.get(Register::Sr) & CAPTURED != 0;
        raise(registers, CAPTURED | if over { OVERCAPTURED } else { 0 });
    }

    /// A read of `CCR1`: the captured count, whose flag it clears.
    pub(super) fn take_capture(&mut self, registers: &mut RegisterFile, context: &DeviceContext<'_>) -> u64 {
        self.capture(registers, context);
        registers.set(Register::Sr, registers.get(Register::Sr) & !CAPTURED);
        self.capture.value
    }
}
