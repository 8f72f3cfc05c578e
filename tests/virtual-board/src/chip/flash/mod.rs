//! The flash interface and array of the STM32F405, RM0090 sections 3.5 to 3.9 and the F405 datasheet's
//! table 40, with a supply that can be cut in the middle of an operation.
//!
//! Modelled: the unlock keys, sector erase and programming with their durations, `PSIZE` and sequence errors,
//! flags and `EOP`/`OPERR` behind their enables, write access to `CR` only while unlocked. The caches are
//! followed as far as their registers go, see `cache`. The core stands still while an operation runs, since
//! it fetches from the array being written: the machine around this model holds it for as long as
//! [`Flash::busy`].
//! Not modelled, and a run that asks for it fails: mass erase, option bytes, write protection.

mod array;
mod cache;

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::Width;
use rigless::soc::stm32f427::generated::flash::{Register, acr, cr, sr};
use rigless::time::{EventId, VirtualNanos};

use array::{Array, PROGRAM_NS};
pub use array::{BASE, Cut, Operation, SIZE, sector};
use cache::Cache;

const CONTROL_AT_RESET: u64 = cr::LOCK.mask();
const KEYS: [u64; 2] = [0x4567_0123, 0xCDEF_89AB];

/// An operation under way.
#[derive(Debug)]
struct Running {
    operation: Operation,
    started: u64,
    duration: u64,
    ends: EventId,
}

/// The flash interface with its array.
#[derive(Debug)]
pub struct Flash {
    array: Array,
    keys_taken: usize,
    locked_out: bool,
    /// `CR` as it stood before the write being served.
    control: u64,
    running: Option<Running>,
    /// Cuts still to come, the next one last, and the event of the one that is due.
    cuts: Vec<Cut>,
    cutting: Option<EventId>,
    /// Every operation started.
    pub log: Vec<(VirtualNanos, Operation)>,
    /// How long the supply stays away after a cut \[ns\], set as it goes.
    pub outage: Option<u64>,
    returning: Option<EventId>,
    /// The instruction and the data cache.
    caches: [Cache; 2],
}

/// How long the supply stays away after a cut \[ns\].
const OUTAGE_NS: u64 = 2_000_000;

impl Flash {
    /// An erased array.
    pub fn new(seed: u64) -> Self {
        Self {
            array: Array::new(seed),
            keys_taken: 0,
            locked_out: false,
            control: CONTROL_AT_RESET,
            running: None,
            cuts: Vec::new(),
            cutting: None,
            log: Vec::new(),
            outage: None,
            returning: None,
            caches: [Cache::default(); 2],
        }
    }

    /// Whether an operation runs, and the core with it stands still.
    pub fn busy(&self) -> bool {
        self.running.is_some()
    }

    /// Whether the instruction and the data cache may give the core a line from before the array changed.
    pub fn serves_stale_lines(&self) -> [bool; 2] {
        self.caches.map(|cache| cache.serves_stale_lines())
    }

    /// The array's bytes from `address` on.
    pub fn bytes(&self, address: u64, length: usize) -> &[u8] {
        self.array.bytes(address, length)
    }

    /// Puts `bytes` at `address` before the part runs, as a programming tool does.
    pub fn place(&mut self, address: u64, bytes: &[u8]) {
        self.array.place(address, bytes);
    }

    /// Puts `bytes` at `address` while the part runs, behind the firmware's back.
    pub fn replace(&mut self, address: u64, bytes: &[u8], context: &mut DeviceContext<'_>) {
        for (word, four) in bytes.chunks_exact(4).enumerate() {
            let at = address + 4 * word as u64;
            if self.bytes(at, 4) != four {
                let value = u64::from(u32::from_le_bytes(four.try_into().expect("four bytes")));
                self.array.put(at, Width::W32, value, context);
            }
        }
    }

    /// Forgets what was done and what was planned.
    pub fn forget(&mut self) {
        self.log.clear();
        self.cuts.clear();
    }

    /// Plans the supply to go in operations still to come. `operation` counts from each cut on.
    pub fn plan(&mut self, cuts: &[Cut]) {
        self.cuts = cuts.iter().rev().copied().collect();
    }

    /// Whether every planned cut happened.
    pub fn all_cut(&self) -> bool {
        self.cuts.is_empty()
    }

    /// The supply goes now, with whatever runs half done.
    pub fn cut(&mut self, context: &mut DeviceContext<'_>) {
        if let Some(running) = self.running.take() {
            let elapsed = context.now().0 - running.started;
            #[expect(clippy::cast_precision_loss, reason = "a share of a second at most")]
            let share = elapsed as f64 / running.duration as f64;
            self.array.leave_half_done(running.operation, share, context);
        }
        self.outage = Some(OUTAGE_NS);
        context.request_power(false);
    }

    /// After the supply went: it comes back by itself after the outage.
    pub fn await_supply(&mut self, context: &mut DeviceContext<'_>) {
        if let Some(outage) = self.outage.take() {
            self.returning = Some(context.schedule(VirtualNanos(context.now().0 + outage)));
        }
    }

    /// A system reset: the array and the plan stay, the interface does not. An operation under way is
    /// lost half done.
    pub fn restart(&mut self) {
        self.keys_taken = 0;
        self.locked_out = false;
        self.control = CONTROL_AT_RESET;
        self.running = None;
        self.cutting = None;
        self.caches = [Cache::default(); 2];
    }

    fn start(
        &mut self,
        operation: Operation,
        duration: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let started = context.now().0;
        self.caches.iter_mut().for_each(Cache::array_changes);
        self.log.push((context.now(), operation));
        registers.set(Register::Sr, registers.get(Register::Sr) | sr::BSY.mask());
        if let Some(cut) = self.cuts.last_mut() {
            cut.operation -= 1;
            if cut.operation == 0 {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    clippy::cast_precision_loss,
                    reason = "a share of a second at most"
                )]
                let after = (duration as f64 * cut.share) as u64;
                self.cutting = Some(context.schedule(VirtualNanos(started + after)));
            }
        }
        let ends = context.schedule(VirtualNanos(started + duration));
        self.running = Some(Running { operation, started, duration, ends });
    }

    fn error(registers: &mut RegisterFile, flag: u64) {
        let operr = registers.get(Register::Cr) & cr::ERRIE.mask() != 0;
        let meta = if operr { sr::OPERR.mask() } else { 0 };
        registers.set(Register::Sr, registers.get(Register::Sr) | flag | meta);
    }

    fn take_key(&mut self, value: u64, registers: &mut RegisterFile) {
        if self.locked_out || value != KEYS[self.keys_taken] {
            // 3.6.1: a wrong sequence locks CR until the next reset.
            self.locked_out = true;
            return;
        }
        self.keys_taken += 1;
        if self.keys_taken == KEYS.len() {
            self.keys_taken = 0;
            self.control = cr::LOCK.set(self.control, 0);
            registers.set(Register::Cr, self.control);
        }
    }

    fn write_control(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let written = registers.get(Register::Cr);
        if cr::LOCK.is_set(self.control) {
            registers.set(Register::Cr, self.control);
            return;
        }
        if written & (cr::MER.mask() | cr::MER1.mask()) != 0 {
            context.tell("CR", "mass erase is not modelled");
        }
        self.control = cr::STRT.set(written, 0);
        registers.set(Register::Cr, self.control);
        if !cr::STRT.is_set(written) || self.busy() || !cr::SER.is_set(written) {
            return;
        }
        let Some((address, size)) = sector(cr::SNB.get(written)) else {
            Self::error(registers, sr::WRPERR.mask());
            return;
        };
        let duration = array::erase_ns(size, cr::PSIZE.get(written));
        self.start(Operation::Erase { address, size }, duration, registers, context);
    }
}

impl Device for Flash {
    type Register = Register;

    fn read(
        &mut self,
        register: Register,
        registers: &mut RegisterFile,
        _context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        // ICRST is write only.
        (register == Register::Acr).then(|| acr::ICRST.set(registers.get(register), 0))
    }

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        match register {
            Register::Keyr => self.take_key(value, registers),
            Register::Cr => self.write_control(registers, context),
            Register::Acr => {
                self.caches[0].write(acr::ICEN.is_set(value), acr::ICRST.is_set(value));
                self.caches[1].write(acr::DCEN.is_set(value), acr::DCRST.is_set(value));
            }
            Register::Sr => {}
            Register::Optkeyr | Register::Optcr | Register::Optcr1 => {
                context.tell("OPTCR", "option bytes are not modelled");
            }
        }
    }

    fn write_region(
        &mut self,
        address: u64,
        width: Width,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> bool {
        let control = registers.get(Register::Cr);
        if !cr::PG.is_set(control) || cr::LOCK.is_set(control) || self.busy() {
            Self::error(registers, sr::PGSERR.mask());
        } else if u64::from(width.bytes()) != 1 << cr::PSIZE.get(control) {
            Self::error(registers, sr::PGPERR.mask());
        } else {
            let operation = Operation::Program { address, width, value };
            self.start(operation, PROGRAM_NS, registers, context);
        }
        true
    }

    fn on_event(&mut self, event: EventId, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.returning == Some(event) {
            self.returning = None;
            context.request_power(true);
            return;
        }
        let cut = self.cutting == Some(event);
        let Some(running) = self.running.take_if(|running| cut || running.ends == event) else {
            return;
        };
        if cut {
            self.cutting = None;
            let share = self.cuts.pop().expect("the cut that is due").share;
            self.array.leave_half_done(running.operation, share, context);
            self.outage = Some(OUTAGE_NS);
            context.request_power(false);
            return;
        }
        self.array.finish(running.operation, context);
        let status = sr::BSY.set(registers.get(Register::Sr), 0);
        let eop = cr::EOPIE.is_set(registers.get(Register::Cr));
        registers.set(Register::Sr, status | if eop { sr::EOP.mask() } else { 0 });
    }
}
