//! The power controller of RM0090 chapter 5, with the voltage detector of the STM32F405's datasheet in place
//! of the STM32F427's: eight levels, each with the tolerance that a part may have.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::stm32f427::generated::pwr::{Register, cr, csr};
use rigless::soc::stm32f427::peripherals::pwr;
use rigless::time::EventId;

use super::settings::Tolerance;

/// \[mV\] Lowest, typical and highest threshold of the rising and of the falling rail, by `PLS`: DS8626
/// table 19.
const THRESHOLDS: [[[u32; 3]; 2]; 8] = [
    [[2090, 2140, 2190], [1980, 2040, 2080]],
    [[2230, 2300, 2370], [2130, 2190, 2250]],
    [[2390, 2450, 2510], [2290, 2350, 2390]],
    [[2540, 2600, 2650], [2440, 2510, 2560]],
    [[2700, 2760, 2820], [2590, 2660, 2710]],
    [[2860, 2930, 2990], [2750, 2840, 2920]],
    [[2960, 3030, 3100], [2850, 2930, 2990]],
    [[3070, 3140, 3210], [2950, 3030, 3090]],
];

/// The power controller.
#[derive(Debug)]
pub struct Pwr {
    model: pwr::Pwr,
    tolerance: Tolerance,
    below: bool,
}

impl Pwr {
    /// Out of reset, on a part whose detector lies at `tolerance`.
    pub fn new(tolerance: Tolerance) -> Self {
        Self { model: pwr::Pwr::new(), tolerance, below: false }
    }

    /// The rail is at `millivolts` \[mV\] from now on.
    pub fn set_supply(&mut self, millivolts: u32, registers: &mut RegisterFile) {
        self.model.set_supply(millivolts, registers);
        self.detect(registers);
    }

    /// `PVDO`, 5.5.2: set once the rail is below the falling threshold, cleared once it is above the rising
    /// one, zero while the detector is off.
    fn detect(&mut self, registers: &mut RegisterFile) {
        let control = registers.get(Register::Cr);
        let level = usize::try_from(cr::PLS.get(control)).expect("three bits");
        let edge = THRESHOLDS[level][usize::from(!self.below)];
        let threshold = edge[self.tolerance as usize];
        self.below = cr::PVDE.is_set(control) && self.model.supply() < threshold;
        let status = registers.get(Register::Csr);
        registers.set(Register::Csr, csr::PVDO.set(status, u64::from(self.below)));
    }
}

impl Device for Pwr {
    type Register = Register;

    fn read(
        &mut self,
        register: Register,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        Device::read(&mut self.model, register, registers, context)
    }

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        Device::write(&mut self.model, register, value, registers, context);
        self.detect(registers);
    }

    fn on_event(&mut self, event: EventId, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        Device::on_event(&mut self.model, event, registers, context);
    }

    fn reset(&mut self) {
        Device::reset(&mut self.model);
        self.below = false;
    }

    fn reset_line(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        Device::reset_line(&mut self.model, registers, context);
        self.below = false;
    }
}
