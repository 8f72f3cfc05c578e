//! The emulator's driver: the millisecond stops, the rig, and the count of what a control tick takes.

use std::any::Any;
use std::collections::BTreeSet;
use std::sync::mpsc::{Receiver, SyncSender};

use rigless::emulator::{Driver, Hit, Host, Settled, Stop, Watch};
use rigless::mcu::Operate;
use rigless::session::{Reset, Session};
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use super::{Failure, MILLISECOND, Rig, Setup, gaps};
use crate::board::{Board, Inputs, Outputs};

/// Says at each millisecond's end whether what was waited for has come.
pub(super) type Until = Box<dyn FnMut(&mut Live<'_>) -> bool + Send>;

/// What the thread that tests asks of the thread that emulates.
pub(super) enum Command {
    Run(u64, Option<Until>),
    With(Box<dyn FnOnce(&mut Live<'_>) + Send>),
}

/// One control tick, from the entry of its interrupt to its return.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TickRecord {
    /// When the interrupt was entered.
    pub at: VirtualNanos,
    /// The instructions from the first of the interrupt to its return.
    pub instructions: u64,
}

/// What the driver keeps between stops.
pub(super) struct Lockstep {
    setup: Setup,
    rig: Box<dyn Rig>,
    commands: Receiver<Command>,
    replies: SyncSender<Result<bool, Failure>>,
    /// The end of the run that was asked for, and what may end it before.
    until: VirtualNanos,
    reached: Option<Until>,
    started: bool,
    /// The tick's interrupt: its first instruction, those that leave it, and the tick under way.
    entry: Option<u64>,
    exits: BTreeSet<u64>,
    under_way: Option<(VirtualNanos, u64)>,
    ticks: Vec<TickRecord>,
    /// Watched to follow ticks instruction by instruction, and where they went since.
    followed: BTreeSet<u64>,
    path: Vec<u64>,
    trace: Vec<Outputs>,
    inputs: Option<Inputs>,
    held: bool,
    /// The core stands still until then.
    stalled_until: VirtualNanos,
}

impl Lockstep {
    pub(super) fn new(
        setup: Setup,
        rig: Box<dyn Rig>,
        commands: Receiver<Command>,
        replies: SyncSender<Result<bool, Failure>>,
        first: VirtualNanos,
        session: &mut Session<Board>,
    ) -> Result<Self, Failure> {
        let entry = setup.firmware.address(setup.tick);
        if entry.is_none() {
            let why = format!("the firmware has no function {}", setup.tick);
            return Err(Failure(why));
        }
        let exits: BTreeSet<u64> = setup.firmware.returns(setup.tick).into_iter().collect();
        for &address in entry.iter().chain(&exits) {
            session.watch(Watch::Instruction(address));
        }
        Ok(Self {
            setup,
            rig,
            commands,
            replies,
            until: first,
            reached: None,
            started: false,
            entry,
            exits,
            under_way: None,
            ticks: Vec::new(),
            followed: BTreeSet::new(),
            path: Vec::new(),
            trace: Vec::new(),
            inputs: None,
            held: false,
            stalled_until: VirtualNanos(0),
        })
    }

    fn note(&mut self, hit: Hit) {
        if Some(hit.address) == self.entry {
            self.under_way = Some((hit.at, hit.instruction_count));
        }
        if self.under_way.is_some() && !self.followed.is_empty() {
            self.path.push(hit.address);
        }
        if self.exits.contains(&hit.address)
            && let Some((at, count)) = self.under_way.take()
        {
            self.ticks.push(TickRecord { at, instructions: hit.instruction_count - count + 1 });
        }
    }

    /// The next stop: a millisecond on, or where it comes to lie half-way between two ticks.
    fn next_stop(&self, at: VirtualNanos) -> VirtualNanos {
        let regular = at.0 + MILLISECOND;
        let since = |tick: &TickRecord| at.0 - tick.at.0;
        match self.ticks.last().map(since) {
            Some(since) if since < MILLISECOND && since.abs_diff(MILLISECOND / 2) > 100_000 => {
                VirtualNanos(regular + MILLISECOND / 2 - since)
            }
            _ => VirtualNanos(regular),
        }
    }

    /// Serves commands until one lets the run go on; `false` when there is nobody to run it for.
    fn serve(&mut self, session: &mut Session<Board>, host: &mut dyn Host, stop: &Stop) -> bool {
        loop {
            match self.commands.recv() {
                Ok(Command::Run(milliseconds, reached)) => {
                    // Half a millisecond of grace: the stops may have been shifted.
                    let end = stop.at.0 + milliseconds * MILLISECOND;
                    self.until = VirtualNanos(end.saturating_sub(MILLISECOND / 2));
                    self.reached = reached;
                    if milliseconds == 0 {
                        let _ = self.replies.send(Ok(false));
                        continue;
                    }
                    return true;
                }
                Ok(Command::With(act)) => {
                    act(&mut Live { session, host, stop, lockstep: self });
                    let _ = self.replies.send(Ok(true));
                }
                Err(_) => return false,
            }
        }
    }
}

/// When the run settled.
fn now(settled: &Settled) -> VirtualNanos {
    match settled {
        Settled::Access { access, .. } => access.virtual_time,
        Settled::Stop(stop) => stop.at,
        Settled::Hit(hit) => hit.at,
        _ => VirtualNanos(u64::MAX),
    }
}

impl Driver<Board> for Lockstep {
    fn on_settled(&mut self, session: &mut Session<Board>, host: &mut dyn Host, settled: Settled) {
        if let Settled::Hit(hit) = settled {
            self.note(hit);
        }
        let random = session.board_mut().chip().take_power_on();
        for (address, value) in random.into_iter().flatten() {
            let written = host.write(address, Width::W64, value);
            written.expect("the part's own RAM");
        }
        // The core fetches from the flash, so it stands still while the flash is busy.
        let stalled = session.board_mut().chip().stalled() || now(&settled) < self.stalled_until;
        if session.unpowered() {
            self.held = false;
        } else if stalled != self.held {
            self.held = stalled;
            host.hold(stalled);
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<Board>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        let allowed = self.setup.refusals_allowed;
        if let Some(failure) = gaps::first(session, &self.setup.firmware, allowed) {
            let seconds = stop.at.0 / MILLISECOND;
            // Nobody may be left to hear it.
            let _ = self.replies.send(Err(Failure(format!("after {seconds} ms: {failure}"))));
            return None;
        }
        let outputs = session.board_mut().outputs(stop.at);
        self.trace.push(outputs);
        let inputs = self.rig.step(&outputs);
        session.board_mut().apply(stop.at, inputs);
        self.inputs = Some(inputs);
        let came = self.reached.take().is_some_and(|mut reached| {
            let came = reached(&mut Live { session, host, stop: &stop, lockstep: self });
            self.reached = Some(reached);
            came
        });
        if came || stop.at >= self.until {
            self.reached = None;
            if self.started {
                // Nobody may be left to hear it.
                let _ = self.replies.send(Ok(came));
            }
            self.started = true;
            if !self.serve(session, host, &stop) {
                return None;
            }
        }
        Some(self.next_stop(stop.at))
    }
}

/// The board while it stands.
pub struct Live<'a> {
    session: &'a mut Session<Board>,
    host: &'a mut dyn Host,
    stop: &'a Stop,
    lockstep: &'a mut Lockstep,
}

impl Live<'_> {
    /// Now, and the instructions the core has retired.
    pub fn now(&self) -> (VirtualNanos, u64) {
        (self.stop.at, self.stop.instruction_count)
    }

    /// The board.
    pub fn board(&mut self) -> &mut Board {
        self.session.board_mut()
    }

    /// The outputs now.
    pub fn outputs(&mut self) -> Outputs {
        let at = self.stop.at;
        self.board().outputs(at)
    }

    /// The rig, as the type it was connected as.
    ///
    /// # Panics
    ///
    /// If it is another type.
    pub fn rig<R: Rig>(&mut self) -> &mut R {
        let any: &mut dyn Any = &mut *self.lockstep.rig;
        any.downcast_mut().expect("the rig is of another type")
    }

    /// The outputs at every millisecond since the start.
    pub fn trace(&self) -> &[Outputs] {
        &self.lockstep.trace
    }

    /// Every control tick since the start.
    pub fn ticks(&self) -> &[TickRecord] {
        &self.lockstep.ticks
    }

    /// Follows the ticks from now on, instruction by instruction, through `instructions`; or no more, with
    /// none. It is a hundred times slower.
    pub fn follow(&mut self, instructions: BTreeSet<u64>) {
        for &address in self.lockstep.followed.difference(&instructions) {
            self.session.unwatch(Watch::Instruction(address));
        }
        for &address in instructions.difference(&self.lockstep.followed) {
            self.session.watch(Watch::Instruction(address));
        }
        self.lockstep.followed = instructions;
    }

    /// Where the ticks that were followed went, instruction by instruction, since the last call.
    pub fn take_path(&mut self) -> Vec<u64> {
        std::mem::take(&mut self.lockstep.path)
    }

    /// Every reset since the start.
    pub fn resets(&self) -> &[Reset] {
        self.session.resets()
    }

    /// The word at an address of the RAM or flash.
    ///
    /// # Panics
    ///
    /// If there is none.
    pub fn word(&mut self, address: u64) -> u32 {
        let read = self.host.read(address, Width::W32);
        let word = read.unwrap_or_else(|why| panic!("{why}"));
        u32::try_from(word).expect("32 bits")
    }

    /// Puts a word into the RAM.
    ///
    /// # Panics
    ///
    /// If there is no RAM.
    pub fn set_word(&mut self, address: u64, word: u32) {
        let written = self.host.write(address, Width::W32, u64::from(word));
        written.unwrap_or_else(|why| panic!("{why}"));
    }

    /// Writes a register as a debugger does, or a fault of the part would.
    ///
    /// # Panics
    ///
    /// If there is no such register.
    pub fn poke(&mut self, address: u64, value: u32) {
        let at = self.stop.at;
        let written = self.session.mcu().write(at, address, Width::W32, u64::from(value));
        written.unwrap_or_else(|why| panic!("{why}"));
    }

    /// The core's next access to the instance's registers from `address` on fails with a bus error.
    pub fn fail_next(&mut self, address: u64) {
        self.session.fail_next(address, address + 0x400);
    }

    /// The core stands still for `milliseconds`, while everything around it goes on.
    pub fn stall(&mut self, milliseconds: u64) {
        let until = VirtualNanos(self.stop.at.0 + milliseconds * MILLISECOND);
        self.lockstep.stalled_until = until;
        self.lockstep.held = true;
        self.host.hold(true);
    }

    /// The supply goes, and comes back a moment later.
    pub fn cut_power(&mut self) {
        let at = self.stop.at;
        self.board().chip().drive_flash(at, crate::chip::flash::Flash::cut);
    }

    /// Puts `bytes` into the flash from `address` on, behind the firmware's back.
    pub fn replace_flash(&mut self, address: u64, bytes: &[u8]) {
        let at = self.stop.at;
        self.board().chip().drive_flash(at, |flash, context| flash.replace(address, bytes, context));
    }

    /// The address of one of the firmware's symbols.
    ///
    /// # Panics
    ///
    /// If it has no such symbol.
    pub fn symbol(&self, name: &str) -> u64 {
        let address = self.lockstep.setup.firmware.address(name);
        address.unwrap_or_else(|| panic!("the firmware has no symbol {name}"))
    }

    /// How much of the stack between `low` and `high` was ever used [bytes], told by the words at its
    /// low end that still are all the same, as a firmware paints them.
    pub fn stack_used(&mut self, low: u64, high: u64) -> u64 {
        let paint = self.word(low);
        let untouched = (low..high).step_by(4).take_while(|&address| self.word(address) == paint).count();
        high - low - 4 * untouched as u64
    }
}
