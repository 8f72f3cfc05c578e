//! The reset and clock control of RM0090 chapter 7, with a crystal that may be missing, be of another
//! frequency, or stop.
//!
//! A crystal that is not there never makes `HSERDY`. One that stops while the clock security is on is
//! noticed as 7.2.7 says; while it is off, what it clocked stands still, and nothing reports it. On the part
//! a PLL without its reference crawls for a while first.

use rigless::device::{Device, DeviceContext, Level, RegisterFile, RequestChange};
use rigless::soc::stm32f427::generated::rcc::{Register, cfgr, cr};
use rigless::soc::stm32f427::peripherals::{iwdg, rcc};
use rigless::time::EventId;

use super::settings::Settings;
use rigless::device::ResetCause;

/// The reset and clock control.
#[derive(Debug)]
pub struct Rcc {
    model: rcc::Rcc,
    crystal_hz: u64,
    lsi_hz: u64,
    watchdog_started: bool,
    /// The core has no clock.
    still: bool,
}

impl Rcc {
    /// Out of reset, with what `settings` says of the oscillators.
    pub fn new(settings: &Settings) -> Self {
        let mut model = rcc::Rcc::new();
        model.attach_crystals(settings.crystal_hz, 0);
        model.calibrate_lsi(settings.lsi_hz);
        let (crystal_hz, lsi_hz) = (settings.crystal_hz, settings.lsi_hz);
        Self { model, crystal_hz, lsi_hz, watchdog_started: false, still: false }
    }

    /// The part restarted for `cause`, with the reset flags `before`: 7.3.21.
    pub fn restarted(&mut self, cause: ResetCause, before: u64, registers: &mut RegisterFile) {
        self.model.restarted(cause, before, registers);
    }

    /// Whether the core stands still for want of a clock.
    pub fn still(&self) -> bool {
        self.still
    }

    /// \[Hz\] The watchdog's clock; zero until it was started.
    pub fn watchdog_hz(&self) -> u64 {
        if self.watchdog_started { self.lsi_hz } else { 0 }
    }

    /// \[Hz\] `HSE_RTC`, the crystal divided by `RTCPRE`, which TIM11 can measure, 7.3.3 and 19.4.11: zero
    /// while there is none.
    pub fn crystal_divided(&self, registers: &RegisterFile) -> u64 {
        let divider = cfgr::RTCPRE.get(registers.get(Register::Cfgr));
        let ready = cr::HSERDY.is_set(registers.get(Register::Cr));
        if ready && divider >= 2 { self.crystal_hz / divider } else { 0 }
    }

    /// The crystal stops, for good. Answers whether the clock security noticed, which then also interrupts
    /// the core by its NMI, 7.2.7: `CSSF`, the internal oscillator instead, and a break at TIM1 and TIM8.
    #[must_use]
    pub fn stop_crystal(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) -> bool {
        let control = registers.get(Register::Cr);
        let noticed = cr::CSSON.is_set(control) && cr::HSERDY.is_set(control);
        self.crystal_hz = 0;
        self.model.attach_crystals(0, 0);
        if noticed {
            self.model.fail_hse(registers, context);
        } else {
            // Any write makes the model drive its clocks anew.
            let same = registers.get(Register::Sscgr);
            Device::write(&mut self.model, Register::Sscgr, same, registers, context);
        }
        self.still = self.model.sysclk(registers) == 0;
        noticed
    }

    /// Lets the model act; one that has no crystal does not hear that it is asked to start it, since the
    /// model would find it ready a moment later.
    fn act(&mut self, registers: &mut RegisterFile, act: impl FnOnce(&mut rcc::Rcc, &mut RegisterFile)) {
        let asked = registers.get(Register::Cr) & cr::HSEON.mask();
        let hidden = self.crystal_hz == 0 && asked != 0 && !cr::HSERDY.is_set(registers.get(Register::Cr));
        if hidden {
            registers.set(Register::Cr, registers.get(Register::Cr) & !asked);
        }
        act(&mut self.model, registers);
        if hidden {
            registers.set(Register::Cr, registers.get(Register::Cr) | asked);
        }
        self.still = self.model.sysclk(registers) == 0;
    }
}

impl Device for Rcc {
    type Register = Register;

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.act(registers, |model, registers| Device::write(model, register, value, registers, context));
    }

    fn on_event(&mut self, event: EventId, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.act(registers, |model, registers| Device::on_event(model, event, registers, context));
    }

    fn on_request(
        &mut self,
        request: RequestChange,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let started = request.instance == "IWDG" && request.request == iwdg::STARTED;
        self.watchdog_started |= started && request.level == Level::High;
        Device::on_request(&mut self.model, request, registers, context);
    }
}
