//! The whole part without a core: for what takes more than one instance.

use rigless::device::ResetCause;
use rigless::emulator::{Error, Memory};
use rigless::mcu::{Mcu, Operate};
use rigless::soc::Width;
use rigless::time::VirtualNanos;
use virtual_board::chip::{SRAM, Settings, Stm32f405};
use virtual_board::serial::Line;

pub(crate) const RCC: u64 = 0x4002_3800;
pub(crate) const RCC_CFGR: u64 = RCC + 0x08;
pub(crate) const US: u64 = 1_000;
pub(crate) const MS: u64 = 1_000_000;

/// USART2.
const PORT: usize = 1;

/// The part's RAM, where the DMA finds it.
struct Ram(Vec<u8>);

impl Ram {
    fn place(address: u64) -> usize {
        usize::try_from(address - SRAM.0).expect("an address of the RAM")
    }
}

impl Memory for Ram {
    fn read(&mut self, address: u64, width: Width) -> Result<u64, Error> {
        let start = Self::place(address);
        let bytes = self.0[start..start + width.bytes() as usize].iter().rev();
        Ok(bytes.fold(0, |value, &byte| value << 8 | u64::from(byte)))
    }

    fn write(&mut self, address: u64, width: Width, value: u64) -> Result<(), Error> {
        let (start, length) = (Self::place(address), width.bytes() as usize);
        self.0[start..start + length].copy_from_slice(&value.to_le_bytes()[..length]);
        Ok(())
    }
}

/// The part, and the time.
pub(crate) struct Whole {
    pub(crate) part: Stm32f405,
    ram: Ram,
    now: u64,
    /// The interrupts that were raised.
    pub(crate) raised: Vec<u16>,
    /// What a model asked to be reset for.
    pub(crate) reset: Option<ResetCause>,
}

impl Whole {
    /// Out of power-on, like `settings`, every clock that the tests need enabled.
    pub(crate) fn new(settings: Settings) -> Self {
        let part = Stm32f405::new(1, settings).expect("the part");
        let ram = Ram(vec![0; usize::try_from(SRAM.1).expect("128 KiB")]);
        let mut whole = Self { part, ram, now: 0, raised: Vec::new(), reset: None };
        whole.part.serial(PORT).attach(Line::default());
        whole.write(RCC + 0x30, 1 << 21); // DMA1
        whole.write(RCC + 0x40, 1 << 17 | 1 << 28); // USART2, PWR
        whole.write(RCC + 0x44, 1 << 0 | 1 << 18); // TIM1, TIM11
        whole
    }

    /// Now.
    pub(crate) fn now(&self) -> VirtualNanos {
        VirtualNanos(self.now)
    }

    /// The serial line.
    pub(crate) fn line(&mut self) -> &mut Line {
        self.part.serial(PORT).line().expect("attached")
    }

    /// A byte of the RAM, counted from its start.
    pub(crate) fn ram(&self, nth: usize) -> u8 {
        self.ram.0[nth]
    }

    fn settle(&mut self) {
        let refused = self.part.settle(&mut self.ram).expect("the memory answers");
        assert!(refused.is_empty(), "the bus refused an access");
        let high = rigless::device::Level::High;
        let raised = self.part.drain_interrupts().into_iter().filter(|change| change.level == high);
        self.raised.extend(raised.map(|change| change.interrupt));
        self.reset = self.reset.or(self.part.take_reset_request());
    }

    /// The firmware writes a register.
    pub(crate) fn write(&mut self, address: u64, value: u64) {
        let at = self.now();
        self.part.write(at, address, Width::W32, value).expect("the bus takes it");
        self.settle();
    }

    /// The firmware reads a register.
    pub(crate) fn read(&mut self, address: u64) -> u64 {
        let at = self.now();
        let value = self.part.read(at, address, Width::W32).expect("the bus answers");
        self.settle();
        value
    }

    /// Time goes on, from event to event.
    pub(crate) fn pass(&mut self, nanoseconds: u64) {
        let end = self.now + nanoseconds;
        let now = self.now();
        self.part.poll(now);
        self.settle();
        while let Some(next) = self.part.next_event().filter(|next| next.0 <= end && self.reset.is_none()) {
            self.now = self.now.max(next.0);
            let now = self.now();
            self.part.advance_to(now);
            self.settle();
        }
        self.now = end;
    }

    /// Time until a model asks for a reset \[ns\], if it does within `limit`.
    pub(crate) fn until_reset(&mut self, limit: u64) -> Option<u64> {
        let (start, step) = (self.now, MS / 10);
        while self.now < start + limit {
            self.pass(step);
            if self.reset.is_some() {
                return Some(self.now - start);
            }
        }
        None
    }

    /// The part restarts.
    pub(crate) fn restart(&mut self, cause: ResetCause) {
        let at = self.now();
        self.part.reset(at, cause);
        self.settle();
    }
}
