//! The emulator's core, kept warm: what it translated of the firmware outlasts a reset.
//!
//! The emulator drops every translation at a reset, and to translate the firmware anew takes longer than to
//! run it from power-on to a save; thousands of power cuts would take an hour. But a core that is given back
//! the state it was built with is a core after a reset, and keeps what it knows of the code, as the emulator
//! does for its own snapshots.

use rigless::device::Level;
use rigless::emulator::{
    BitAlias, CoreBus, DataModel, Error, Exit, HaltReason, HostCall, InterruptLine, Processor, Queued,
};
use rigless::soc::{Endian, Width};
use rigless::time::VirtualNanos;

/// The line that pends the core's NMI, which no line of the interrupt controller reaches: past the last.
pub(crate) const NMI: InterruptLine = InterruptLine::new(1023).expect("below the emulator's limit");
/// `ICSR` and `NMIPENDSET`, DDI 0403E.b B3.2.4.
const ICSR: u64 = 0xE000_ED04;
const NMI_PENDING: u64 = 1 << 31;

/// A core with the state it was built with.
#[derive(Debug)]
pub(crate) struct WarmCore {
    core: Box<dyn Processor>,
    /// The state of a core that has run nothing, without the count of instructions at its end.
    fresh: Vec<u8>,
}

impl WarmCore {
    /// Around a core that has run nothing.
    pub(crate) fn new(core: Box<dyn Processor>) -> Self {
        let mut fresh = core.save();
        let retired = fresh.pop();
        debug_assert_eq!(retired, Some(0), "the state ends with the instructions run, which are none");
        Self { core, fresh }
    }
}

/// A count as the state has it: seven bits a byte, the lowest first, the top bit set in all but the last.
fn counted(mut count: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    loop {
        let seven = count.to_le_bytes()[0] & 0x7F;
        count >>= 7;
        if count == 0 {
            bytes.push(seven);
            return bytes;
        }
        bytes.push(seven | 0x80);
    }
}

impl Processor for WarmCore {
    /// The state of a core that has run nothing, but for the count of instructions, which is the run's.
    fn reset(&mut self) {
        let mut state = self.fresh.clone();
        state.extend(counted(self.core.retired()));
        if self.core.load(&state).is_err() {
            self.core.reset();
        }
    }

    fn run(&mut self, budget: u32, bus: &mut dyn CoreBus) -> (Exit, u64) {
        self.core.run(budget, bus)
    }

    fn retired(&self) -> u64 {
        self.core.retired()
    }

    fn ask(&mut self, queued: Queued) {
        match queued {
            Queued::Line(NMI, level) => {
                if level == Level::High {
                    let now = VirtualNanos(0);
                    let pended = self.core.debugger_access(Some(NMI_PENDING), ICSR, Width::W32, now);
                    debug_assert!(pended.is_some(), "the core answers for its own registers");
                }
            }
            other => self.core.ask(other),
        }
    }

    fn maps(&self, start: u64, length: u64) -> bool {
        self.core.maps(start, length)
    }

    fn page_size(&self) -> u64 {
        self.core.page_size()
    }

    #[expect(unsafe_code, reason = "handed on as it came")]
    unsafe fn map(&mut self, start: u64, length: u64, host: *mut u8, writable: bool) {
        // SAFETY: the caller's promise, to the core that it is meant for, which this owns and drops with
        // itself.
        unsafe { self.core.map(start, length, host, writable) }
    }

    fn boot(&mut self, table: u64, read: &dyn Fn(u64, Width) -> Option<u64>) {
        self.core.boot(table, read);
    }

    fn take_reset_request(&mut self) -> bool {
        self.core.take_reset_request()
    }

    fn next_event(&self) -> Option<VirtualNanos> {
        self.core.next_event()
    }

    fn on_event(&mut self, now: VirtualNanos) {
        self.core.on_event(now);
    }

    fn waiting(&self) -> bool {
        self.core.waiting()
    }

    fn pc(&self) -> u64 {
        self.core.pc()
    }

    fn add_breakpoint(&mut self, address: u64) -> bool {
        self.core.add_breakpoint(address)
    }

    fn remove_breakpoint(&mut self, address: u64) {
        self.core.remove_breakpoint(address);
    }

    fn pass_breakpoint(&mut self, address: u64) {
        self.core.pass_breakpoint(address);
    }

    fn attach_debugger(&mut self, attached: bool) {
        self.core.attach_debugger(attached);
    }

    fn hold_interrupts(&mut self, held: bool) {
        self.core.hold_interrupts(held);
    }

    fn gdb_register(&self, number: usize) -> Option<Vec<u8>> {
        self.core.gdb_register(number)
    }

    fn set_gdb_register(&mut self, number: usize, bytes: &[u8]) -> bool {
        self.core.set_gdb_register(number, bytes)
    }

    fn debugger_access(
        &mut self,
        write: Option<u64>,
        address: u64,
        width: Width,
        now: VirtualNanos,
    ) -> Option<u64> {
        self.core.debugger_access(write, address, width, now)
    }

    fn take_debugger_trace(&mut self) -> Vec<u8> {
        self.core.take_debugger_trace()
    }

    fn target_xml(&self) -> &'static str {
        self.core.target_xml()
    }

    fn data_model(&self) -> DataModel {
        self.core.data_model()
    }

    fn byte_order(&self, address: u64) -> Endian {
        self.core.byte_order(address)
    }

    fn save(&self) -> Vec<u8> {
        self.core.save()
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.core.load(bytes)
    }

    fn monitor_command(&mut self, command: &str) -> Option<String> {
        self.core.monitor_command(command)
    }

    fn debugger_halted(&mut self, why: HaltReason) -> bool {
        self.core.debugger_halted(why)
    }

    fn bit_alias(&self, address: u64, width: Width) -> Option<BitAlias> {
        self.core.bit_alias(address, width)
    }

    fn own_ranges(&self) -> Vec<std::ops::Range<u64>> {
        self.core.own_ranges()
    }

    fn check_reads(&mut self, every: bool) {
        self.core.check_reads(every);
    }

    fn check_words(&mut self, words: &[u64]) {
        self.core.check_words(words);
    }

    fn host_call(&self, read: &mut dyn FnMut(u64, Width) -> Option<u64>) -> Option<HostCall> {
        self.core.host_call(read)
    }

    fn answer_host_call(&mut self, answer: Option<u64>) {
        self.core.answer_host_call(answer);
    }
}
