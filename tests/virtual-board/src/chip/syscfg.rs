//! The system configuration controller of RM0090 chapter 9, as far as choosing which port an external
//! interrupt line listens to. The choice reaches [`super::exti::Exti`] as request lines, four to a
//! line, which together are the port's number.

use rigless::device::{Device, DeviceContext, Level, RegisterFile};
use rigless::soc::stm32f427::generated::syscfg::Register;

/// The system configuration controller.
#[derive(Debug, Default)]
pub struct Syscfg;

impl Device for Syscfg {
    type Register = Register;

    fn write(
        &mut self,
        register: Register,
        value: u64,
        _registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let first = match register {
            Register::Exticr1 => 0,
            Register::Exticr2 => 4,
            Register::Exticr3 => 8,
            Register::Exticr4 => 12,
            Register::Memrm | Register::Pmc | Register::Cmpcr => {
                context.tell("SYSCFG", "only EXTICR1 to EXTICR4 are modelled");
                return;
            }
        };
        for bit in 0..16 {
            let level = Level::from(value & (1 << bit) != 0);
            context.request(4 * first + bit, level);
        }
    }
}
