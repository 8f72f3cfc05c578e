//! The timers TIM1 to TIM14 of RM0090 chapters 17 to 20: one model, of which each kind of timer has a
//! part.
//!
//! | Modelled | Where |
//! |---|---|
//! | Prescaler, up, down and centre-aligned counting, repetition, one pulse, `UDIS`, `URS`, preload of `PSC`, `ARR`, `RCR` and `CCRx` taken at the update event | `counter` |
//! | PWM modes 1 and 2, forced levels, polarity, complementary outputs, `MOE`, `OSSI`, `OSSR`, idle levels, dead time | `outputs` |
//! | Encoder modes, the break input with `BIF`, `MOE` and `AOE`, `LOCK` | `inputs` |
//! | TIM11's capture of the crystal's divided clock | `capture` |
//! | Update and compare flags and interrupts | here |
//!
//! Asked of it but not modelled, which fails a run: any other input capture, the match and toggle output
//! modes, slave modes other than the encoder's, DMA requests, and a register the instance does not have.

mod capture;
mod counter;
mod inputs;
mod outputs;
mod registers;

use rigless::device::{Device, DeviceContext, Level, RegisterFile, RequestChange};
use rigless::soc::stm32f427::peripherals::rcc;
use rigless::time::{EventId, VirtualNanos};

use capture::Capture;
pub use counter::{Control, Counter, Shape, Values};
pub use outputs::{Drive, Side, dead_time_ticks};
pub use registers::{Kind, REGISTERS, Register};

const COMPARE: [Register; 4] = [Register::Ccr1, Register::Ccr2, Register::Ccr3, Register::Ccr4];

/// `SR` and `DIER`.
const UPDATE_FLAG: u64 = 1;
const BREAK_FLAG: u64 = 1 << 7;
/// `BDTR`.
const MOE: u64 = 1 << 15;
const AOE: u64 = 1 << 14;

/// Where an interrupt of the timer goes among the instance's lines: TIM1 and TIM8 have four.
const BREAK_LINE: usize = 0;
const UPDATE_LINE: usize = 1;
const TRIGGER_LINE: usize = 2;
const COMPARE_LINE: usize = 3;

/// One timer.
#[derive(Debug)]
pub struct Timer {
    kind: Kind,
    counter: Counter,
    wake: Option<EventId>,
    lines: [Level; 4],
    /// `CR1.DIR` in encoder mode: the shaft last turned backwards.
    backwards: bool,
    /// `BDTR` as the lock found it.
    locked: Option<u64>,
    /// The level on the break input, once a pin carries one.
    break_input: Option<Level>,
    capture: Capture,
}

impl Timer {
    /// A timer of `kind` out of reset, on a clock of `clock_hz` \[Hz\] until the clock tree says otherwise.
    pub fn new(kind: Kind, clock_hz: u64) -> Self {
        Self {
            kind,
            counter: Counter::new(kind, clock_hz),
            wake: None,
            lines: [Level::Low; 4],
            backwards: false,
            locked: None,
            break_input: None,
            capture: Capture::default(),
        }
    }

    /// Which kind it is.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The time base, as far as the last [`Timer::settle`].
    pub fn counter(&self) -> &Counter {
        &self.counter
    }

    /// What an output of channel `channel` (0 to 3) drives, as far as the last [`Timer::settle`].
    pub fn output(&self, registers: &RegisterFile, channel: usize, side: Side) -> Drive {
        outputs::drive(self.kind, &self.counter, registers, channel, side)
    }

    /// Takes what passed up to now into the flags, and asks to be woken at the next event that
    /// interrupts.
    pub fn settle(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let now = context.now().0;
        let passed = self.counter.advance(now);
        if passed.updates > 0 {
            raise(registers, UPDATE_FLAG);
            if registers.get(Register::Bdtr) & AOE != 0 && !self.break_stands(registers) {
                registers.set(Register::Bdtr, registers.get(Register::Bdtr) | MOE);
            }
        }
        for channel in 0..self.kind.channels() {
            if passed.matched[channel] && outputs::selection(registers, channel) == 0 {
                raise(registers, 2 << channel);
            }
        }
        if passed.stopped {
            registers.set(Register::Cr1, registers.get(Register::Cr1) & !1);
        }
        self.drive_lines(registers, context);
        self.wake_at_next(registers, context);
    }

    fn wake_at_next(&mut self, registers: &RegisterFile, context: &mut DeviceContext<'_>) {
        let enables = registers.get(Register::Dier);
        let channels = [0, 1, 2, 3].map(|channel| enables & (2 << channel) != 0);
        let next = self.counter.next_event(enables & UPDATE_FLAG != 0, channels);
        self.wake = next.map(|at| context.schedule(VirtualNanos(at)));
    }

    /// The interrupt lines, 17.4.5: four on TIM1 and TIM8, one on the others.
    fn drive_lines(&mut self, registers: &RegisterFile, context: &mut DeviceContext<'_>) {
        let pending = registers.get(Register::Sr) & registers.get(Register::Dier);
        let mut wanted = [Level::Low; 4];
        if self.kind == Kind::Advanced {
            wanted[BREAK_LINE] = Level::from(pending & BREAK_FLAG != 0);
            wanted[UPDATE_LINE] = Level::from(pending & UPDATE_FLAG != 0);
            wanted[TRIGGER_LINE] = Level::from(pending & 0x60 != 0);
            wanted[COMPARE_LINE] = Level::from(pending & 0x1E != 0);
        } else {
            wanted[0] = Level::from(pending & 0x5F != 0);
        }
        for (line, (held, wanted)) in self.lines.iter_mut().zip(wanted).enumerate() {
            if *held != wanted {
                *held = wanted;
                context.interrupt(line, wanted);
            }
        }
    }

    fn configure(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let cr1 = registers.get(Register::Cr1);
        let slave = registers.get(Register::Smcr) & 7;
        if slave > 3 {
            context.tell("SMCR", "a slave mode other than the encoder's is not modelled");
        }
        let encoder = matches!(slave, 1..=3);
        let was_following = self.counter.control().enabled;
        let shape = match (cr1 >> 5) & 3 {
            0 if cr1 & 0x10 != 0 && !encoder => Shape::Down,
            0 => Shape::Up,
            mode => Shape::Centre { flag_up: mode != 1, flag_down: mode != 2 },
        };
        let mut compare_preloaded = [false; 4];
        for (channel, preloaded) in compare_preloaded.iter_mut().enumerate() {
            *preloaded = outputs::compare_mode(registers, channel).1;
        }
        let control = Control {
            enabled: cr1 & 1 != 0 && !encoder,
            updates_disabled: cr1 & 2 != 0,
            one_pulse: cr1 & 8 != 0,
            reload_preloaded: cr1 & 0x80 != 0,
            compare_preloaded,
            shape,
        };
        if control == *self.counter.control() {
            return;
        }
        let now = context.now().0;
        self.counter.set_control(now, control);
        if was_following && !control.enabled {
            let count = self.counter.count(now);
            registers.set(Register::Cnt, count);
        }
    }

    /// What a write asks for that no code here follows.
    fn check_channels(&self, registers: &RegisterFile, context: &mut DeviceContext<'_>) {
        let enabled = registers.get(Register::Ccer);
        let interrupting = registers.get(Register::Dier);
        for channel in 0..self.kind.channels() {
            let drives = enabled >> (4 * channel) & 5 != 0;
            let output = outputs::selection(registers, channel) == 0;
            let (mode, _) = outputs::compare_mode(registers, channel);
            if drives && output && matches!(mode, 1..=3) {
                context.tell("CCMR", "the match and toggle output modes are not modelled");
            }
            if interrupting & (2 << channel) != 0 && !output {
                context.tell("CCMR", "input capture is not modelled");
            }
        }
    }

    fn generate(&mut self, asked: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if asked & 1 != 0 {
            self.counter.restart(context.now().0);
            registers.set(Register::Cnt, self.counter.count(context.now().0));
            let quiet = registers.get(Register::Cr1) & 0b110 != 0; // URS or UDIS
            if !quiet {
                raise(registers, UPDATE_FLAG);
            }
        }
        raise(registers, asked & 0x5E);
        if asked & BREAK_FLAG != 0 {
            registers.set(Register::Bdtr, registers.get(Register::Bdtr) & !MOE);
            raise(registers, BREAK_FLAG);
        }
        registers.set(Register::Egr, 0);
    }
}

fn raise(registers: &mut RegisterFile, flags: u64) {
    registers.set(Register::Sr, registers.get(Register::Sr) | flags);
}

impl Device for Timer {
    type Register = Register;

    fn read(
        &mut self,
        register: Register,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        if !self.kind.has(register) {
            context.tell(register.name(), "this timer has no such register");
        }
        if let Some(channel) = COMPARE.iter().position(|&each| each == register)
            && outputs::selection(registers, channel) != 0
        {
            if channel == 0 && self.captures(registers) {
                return Some(self.take_capture(registers, context));
            }
            context.tell(register.name(), "input capture is not modelled");
        }
        match register {
            Register::Sr => {
                self.settle(registers, context);
                self.capture(registers, context);
                None
            }
            Register::Cnt if self.counter.control().enabled => {
                self.settle(registers, context);
                Some(self.counter.count(context.now().0))
            }
            Register::Cr1 => {
                self.settle(registers, context);
                let encoder = matches!(registers.get(Register::Smcr) & 7, 1..=3);
                let down = if encoder { self.backwards } else { self.counter.counts_down(context.now().0) };
                let value = registers.get(Register::Cr1) & !0x10;
                Some(value | if down { 0x10 } else { 0 })
            }
            _ => None,
        }
    }

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if !self.kind.has(register) {
            context.tell(register.name(), "this timer has no such register");
        }
        let now = context.now().0;
        // What passed before this write happened under the values before it: the counter still has them.
        self.settle(registers, context);
        match register {
            Register::Sr => registers.set(Register::Sr, registers.get(Register::Sr) & value),
            Register::Egr => self.generate(value, registers, context),
            Register::Psc => self.counter.write_prescaler(value),
            Register::Rcr => self.counter.write_repetition(value),
            Register::Arr => {
                if !self.counter.write_reload(now, value) {
                    context.tell("ARR", "a reload value moved under the count is not modelled");
                }
            }
            Register::Cnt => {
                if self.counter.control().enabled && !self.counter.set_count(now, value) {
                    context.tell("CNT", "a count past the reload value is not modelled");
                } else {
                    let _ = self.counter.set_count(now, value);
                }
            }
            Register::Bdtr => self.write_break(registers, context),
            Register::Dier if value & 0x7F00 != 0 => {
                context.tell("DIER", "the timers' DMA requests are not modelled");
            }
            Register::Dcr | Register::Dmar => {
                context.tell(register.name(), "the timers' DMA burst is not modelled");
            }
            _ => {
                if let Some(channel) = COMPARE.iter().position(|&each| each == register) {
                    self.counter.write_compare(channel, value);
                }
            }
        }
        if matches!(
            register,
            Register::Cr1
                | Register::Smcr
                | Register::Dier
                | Register::Ccmr1
                | Register::Ccmr2
                | Register::Ccer
        ) {
            self.configure(registers, context);
            self.check_channels(registers, context);
        }
        self.settle(registers, context);
    }

    fn on_event(&mut self, event: EventId, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.wake == Some(event) {
            self.settle(registers, context);
        }
    }

    fn on_clock(&mut self, hz: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.settle(registers, context);
        self.counter.set_clock(context.now().0, hz);
        self.settle(registers, context);
    }

    /// 17.3.12: the clock security system's failure breaks as the pin does, whatever its level.
    fn on_request(
        &mut self,
        request: RequestChange,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let failed = request.level == Level::High
            && request.request == rcc::CLOCK_FAILURE
            && request.instance == "RCC";
        if failed {
            self.settle(registers, context);
            self.break_on_clock_failure(registers, context);
        }
    }

    fn reset(&mut self) {
        let clock_hz = self.counter.clock_hz();
        *self = Self::new(self.kind, clock_hz);
    }
}
