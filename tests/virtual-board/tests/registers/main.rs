//! The models of the part's peripherals, each alone on the bus or with the rest of the part, against what
//! RM0090 says of its registers.

mod cache;
mod debug;
mod exti;
mod flash;
mod oscillator;
mod serial;
mod stream_stop;
mod supply;
mod timer;
mod timer_outputs;
mod watchdog;
mod whole;

use rigless::device::{Device, DeviceContext, Level, RegisterFile};
use rigless::mcu::{Mcu, Operate, Single};
use rigless::soc::{Layout, Width};
use rigless::time::VirtualNanos;
use virtual_board::chip::{Part, builder};

/// A model on a bus of its own, and the time.
pub struct Alone<D: Device + 'static> {
    single: Single<D>,
    instance: &'static str,
    now: u64,
    told: Vec<&'static str>,
    raised: Vec<(u16, bool)>,
}

impl<D: Device + 'static> Alone<D> {
    /// `model` on `instance` of the part.
    pub fn new(instance: &'static str, model: D) -> Self {
        let single = Single::new(builder(Part::F405), instance, model).expect("the part has it");
        Self { single, instance, now: 0, told: Vec::new(), raised: Vec::new() }
    }

    fn address(&self, register: D::Register) -> u64 {
        let instance = self.single.bus().peripheral(self.instance);
        instance.expect("checked when made").base + u64::from(register.spec().offset)
    }

    fn take(&mut self) {
        self.told.extend(self.single.drain_told().iter().map(|told| told.reason));
        for change in self.single.drain_interrupts() {
            self.raised.push((change.interrupt, change.level == Level::High));
        }
    }

    /// The firmware writes a register.
    pub fn write(&mut self, register: D::Register, value: u64) {
        let (at, address) = (VirtualNanos(self.now), self.address(register));
        self.single.write(at, address, Width::W32, value).expect("the bus takes it");
        self.take();
    }

    /// The firmware reads a register.
    pub fn read(&mut self, register: D::Register) -> u64 {
        let (at, address) = (VirtualNanos(self.now), self.address(register));
        let value = self.single.read(at, address, Width::W32).expect("the bus answers");
        self.take();
        value
    }

    /// The firmware stores a value into memory the model programs.
    pub fn store(&mut self, address: u64, width: Width, value: u64) {
        self.drive(|model, registers, context| {
            assert!(Device::write_region(model, address, width, value, registers, context));
        });
    }

    /// Drives an input that is not on the bus.
    pub fn drive<T>(
        &mut self,
        act: impl FnOnce(&mut D, &mut RegisterFile, &mut DeviceContext<'_>) -> T,
    ) -> T {
        let result = self.single.drive(VirtualNanos(self.now), act);
        self.take();
        result
    }

    /// Time goes on, through every event on the way.
    pub fn pass(&mut self, nanoseconds: u64) {
        self.now += nanoseconds;
        self.single.advance_to(VirtualNanos(self.now));
        self.take();
    }

    /// The model.
    pub fn model(&mut self) -> &mut D {
        &mut self.single.model
    }

    /// What the model holds in its registers, with no access made.
    pub fn held(&mut self, register: D::Register) -> u64 {
        self.single.pair().1.get(register)
    }

    /// What the model said it does not model.
    pub fn told(&self) -> &[&'static str] {
        &self.told
    }

    /// The interrupt lines the model moved since the last call, and whether up.
    pub fn raised(&mut self) -> Vec<(u16, bool)> {
        std::mem::take(&mut self.raised)
    }
}
