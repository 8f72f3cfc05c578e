//! The external interrupt controller of RM0090 chapter 12: lines 0 to 15 from the ports' pins, as
//! [`super::syscfg::Syscfg`] chooses the port, and line 16 from the supply's voltage detector.
//! Not modelled, and a run that asks for it fails: events, and the lines of the RTC, USB and Ethernet.

use rigless::device::{Device, DeviceContext, Level, RegisterFile, RequestChange};
use rigless::soc::stm32f427::generated::exti::Register;

/// The ports by the number that `SYSCFG_EXTICRx` gives them.
const PORTS: [&str; 9] = ["GPIOA", "GPIOB", "GPIOC", "GPIOD", "GPIOE", "GPIOF", "GPIOG", "GPIOH", "GPIOI"];
const PINS: usize = 16;
/// The line of the programmable voltage detector.
pub const VOLTAGE_DETECTOR: usize = 16;
const LINES: usize = 17;

/// The part's interrupts that the lines share, table 61, and where each lies in the vector table.
pub const INTERRUPTS: &[u16] = &[1, 6, 7, 8, 9, 10, 23, 40];

/// The place in [`INTERRUPTS`] of a line's interrupt.
fn interrupt_of(line: usize) -> usize {
    match line {
        0..=4 => 1 + line,
        5..=9 => 6,
        10..=15 => 7,
        _ => 0,
    }
}

/// The external interrupt controller.
#[derive(Debug, Default)]
pub struct Exti {
    pins: [[bool; PINS]; PORTS.len()],
    chosen: [usize; PINS],
    levels: [bool; LINES],
    driven: [Level; 8],
    software: u64,
}

impl Exti {
    /// The level of a line that no pin feeds.
    pub fn set_line(
        &mut self,
        line: usize,
        high: bool,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let rose = high && !self.levels[line];
        let fell = !high && self.levels[line];
        self.levels[line] = high;
        let bit = 1 << line;
        let noticed = (rose && registers.get(Register::Rtsr) & bit != 0)
            || (fell && registers.get(Register::Ftsr) & bit != 0);
        if noticed {
            registers.set(Register::Pr, registers.get(Register::Pr) | bit);
            self.drive(registers, context);
        }
    }

    fn follow_pin(&mut self, line: usize, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let high = self.pins.get(self.chosen[line]).is_some_and(|port| port[line]);
        self.set_line(line, high, registers, context);
    }

    fn drive(&mut self, registers: &RegisterFile, context: &mut DeviceContext<'_>) {
        let pending = registers.get(Register::Pr) & registers.get(Register::Imr);
        let mut wanted = [Level::Low; INTERRUPTS.len()];
        for line in (0..LINES).filter(|line| pending & (1 << line) != 0) {
            wanted[interrupt_of(line)] = Level::High;
        }
        for (place, (driven, wanted)) in self.driven.iter_mut().zip(wanted).enumerate() {
            if *driven != wanted {
                *driven = wanted;
                context.interrupt(place, wanted);
            }
        }
    }
}

impl Device for Exti {
    type Register = Register;

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        match register {
            Register::Emr if value != 0 => context.tell("EMR", "events are not modelled"),
            Register::Imr if value >> LINES != 0 => {
                context.tell("IMR", "lines past the voltage detector's are not modelled");
            }
            // 12.3.5: a written one that was zero makes the line pending if it is not masked.
            Register::Swier => {
                let fresh = value & !self.software & registers.get(Register::Imr);
                registers.set(Register::Pr, registers.get(Register::Pr) | fresh);
                self.software = value;
            }
            // 12.3.6: clearing a pending bit clears the software request with it.
            Register::Pr => {
                self.software &= !value;
                registers.set(Register::Swier, self.software);
            }
            _ => {}
        }
        self.drive(registers, context);
    }

    fn on_request(
        &mut self,
        request: RequestChange,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let high = request.level == Level::High;
        if request.instance == "SYSCFG" {
            let (line, bit) = (request.request / 4, request.request % 4);
            let chosen = self.chosen[line] & !(1 << bit);
            self.chosen[line] = chosen | usize::from(high) << bit;
            self.follow_pin(line, registers, context);
        } else if let Some(port) = PORTS.iter().position(|&port| port == request.instance) {
            self.pins[port][request.request] = high;
            if self.chosen[request.request] == port {
                self.follow_pin(request.request, registers, context);
            }
        }
    }

    fn reset(&mut self) {
        *self = Self::default();
    }
}
