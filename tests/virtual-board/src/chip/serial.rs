//! A serial port of RM0090 chapter 30 on whose line one chosen word arrives badly.
//!
//! The model draws noise and framing errors by rate; here they come to the word that [`Line::say_flawed`]
//! marked. A word with an error has other data bits than the one that was sent.

use rigless::chip::uart::{Errors, Rate};
use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::RegisterSpec;
use rigless::soc::stm32f427::generated::usart6::{Register, cr3, sr};
use rigless::soc::stm32f427::peripherals::usart;
use rigless::time::{EventId, VirtualNanos};

use crate::serial::{Flaw, Line};

/// A serial port.
#[derive(Debug)]
pub struct Usart {
    model: usart::Usart,
    /// The DMA is kept from a word that arrived, until the next has come.
    unread: bool,
}

impl Usart {
    /// A port of `kind` out of reset, on a clock of `clock_hz` \[Hz\].
    pub fn with_clock(kind: usart::Kind, clock_hz: u64) -> Self {
        Self { model: usart::Usart::with_clock(kind, clock_hz), unread: false }
    }

    /// Hangs `line` on the port.
    pub fn attach(&mut self, line: Line) {
        self.model.attach(line);
    }

    /// Whether a line hangs there.
    pub fn attached(&self) -> bool {
        self.model.attached()
    }

    /// The line.
    pub fn line(&mut self) -> Option<&mut Line> {
        self.model.chip_mut()
    }

    /// Cuts the line, or joins it again.
    pub fn silence(&mut self, silent: bool) {
        let _ = self.model.silence(silent);
    }

    /// How the line garbles what arrives, by rate.
    pub fn errors_mut(&mut self) -> &mut Errors {
        self.model.errors_mut()
    }

    /// Takes the line off `from`, as it is.
    pub fn inherit(&mut self, from: &mut Self) {
        self.model.inherit(&mut from.model);
    }

    /// Lets the model act, its receiver's request to the DMA held down if `held`.
    fn act<T>(
        &mut self,
        held: bool,
        registers: &mut RegisterFile,
        act: impl FnOnce(&mut usart::Usart, &mut RegisterFile) -> T,
    ) -> T {
        let asks = registers.get(Register::Cr3) & if held { cr3::DMAR.mask() } else { 0 };
        registers.set(Register::Cr3, registers.get(Register::Cr3) & !asks);
        let result = act(&mut self.model, registers);
        registers.set(Register::Cr3, registers.get(Register::Cr3) | asks);
        result
    }

    /// The DMA gets its request after all.
    fn release(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.unread = false;
        let same = registers.get(Register::Cr2);
        // Any write makes the model drive its request and interrupt anew.
        Device::write(&mut self.model, Register::Cr2, same, registers, context);
    }
}

impl Device for Usart {
    type Register = Register;

    fn layout(&self) -> &'static [RegisterSpec] {
        Device::layout(&self.model)
    }

    fn on_clock(&mut self, hz: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let held = self.unread;
        self.act(held, registers, |model, registers| Device::on_clock(model, hz, registers, context));
    }

    fn read(
        &mut self,
        register: Register,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        let held = self.unread && register != Register::Cr3;
        self.act(held, registers, |model, registers| Device::read(model, register, registers, context))
    }

    fn peek(&self, register: Register, registers: &RegisterFile, now: VirtualNanos) -> Option<u64> {
        Device::peek(&self.model, register, registers, now)
    }

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let held = self.unread;
        self.act(held, registers, |model, registers| {
            Device::write(model, register, value, registers, context);
        });
    }

    fn on_event(&mut self, event: EventId, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let flaw = self.line().map_or(Flaw::None, |line| line.on_wire());
        let rates = *self.model.errors_mut();
        let every = |name| Rate { name, per_million: Rate::EVERY_WORD };
        match flaw {
            Flaw::Noise => self.model.errors_mut().noise = every("a noisy word"),
            Flaw::Framing => self.model.errors_mut().framing = every("a word without its stop bit"),
            Flaw::Overrun | Flaw::None => {}
        }
        let before = *self.model.errors_mut();
        let held = self.unread || flaw == Flaw::Overrun;
        self.act(held, registers, |model, registers| Device::on_event(model, event, registers, context));
        // The model counts the words that have come whole.
        let came = *self.model.errors_mut() != before;
        let errors = self.model.errors_mut();
        (errors.noise, errors.framing) = (rates.noise, rates.framing);
        let idle = sr::IDLE.is_set(registers.get(Register::Sr));
        if self.unread && (came || idle) {
            self.release(registers, context);
        } else if came && flaw == Flaw::Overrun {
            self.unread = true;
        }
    }

    fn poll(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let held = self.unread;
        self.act(held, registers, |model, registers| Device::poll(model, registers, context));
    }

    fn reset(&mut self) {
        Device::reset(&mut self.model);
        self.unread = false;
    }

    fn reset_line(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        Device::reset_line(&mut self.model, registers, context);
        self.unread = false;
    }
}
