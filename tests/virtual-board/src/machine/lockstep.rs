//! The emulator's driver: the millisecond stops, the rig, and the count of what a control tick takes.

use std::collections::BTreeSet;
use std::sync::mpsc::{Receiver, SyncSender};

use rigless::emulator::{Driver, Hit, Host, Settled, Stop, Watch};
use rigless::session::Session;
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use super::live::Live;
use super::{Failure, MILLISECOND, Rig, Setup, gaps};
use crate::board::{Board, Inputs, Outputs};
use crate::record::ADDRESS;
use crate::serial::Line;

/// Says at each millisecond's end whether what was waited for has come.
pub(super) type Until = Box<dyn FnMut(&mut Live<'_>) -> bool + Send>;

/// What the thread that tests asks of the thread that emulates.
pub(super) enum Command {
    Run(u64, Option<Until>),
    With(Box<dyn FnOnce(&mut Live<'_>) + Send>),
    /// The board is switched off and on, with this in its parameter sectors and another rig.
    Again(Vec<u8>, Box<dyn Rig>),
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
    pub(super) setup: Setup,
    pub(super) rig: Box<dyn Rig>,
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
    pub(super) ticks: Vec<TickRecord>,
    /// Watched to follow ticks instruction by instruction, and where they went since.
    pub(super) followed: BTreeSet<u64>,
    pub(super) path: Vec<u64>,
    pub(super) trace: Vec<Outputs>,
    inputs: Option<Inputs>,
    pub(super) held: bool,
    /// The core stands still until then.
    pub(super) stalled_until: VirtualNanos,
    /// A debugger halts the core until then.
    pub(super) halted: bool,
    /// The nth arrival at this instruction waits there until the next tick is due.
    pub(super) waiting_place: Option<(u64, u32)>,
    pub(super) waited: Vec<VirtualNanos>,
    /// Resets before this run of the board.
    pub(super) resets_before: usize,
    /// Something was done to the board that outlasts a power-on.
    pub(super) tampered: bool,
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
            halted: false,
            waiting_place: None,
            waited: Vec::new(),
            resets_before: 0,
            tampered: false,
        })
    }

    /// The board is switched off, and comes on as it did at first.
    fn begin_again(&mut self, session: &mut Session<Board>, stop: &Stop, sectors: &[u8], rig: Box<dyn Rig>) {
        let board = session.board_mut();
        board.apply(stop.at, Inputs::default());
        *board.line() = Line::default();
        board.chip().switch_off_and_on(stop.at, ADDRESS, sectors);
        self.rig = rig;
        // To come back is a reset, too, of which this run knows nothing.
        self.resets_before = session.resets().len() + 1;
        self.until = VirtualNanos(stop.at.0 + MILLISECOND);
        self.started = false;
        self.under_way = None;
        self.stalled_until = VirtualNanos(0);
        self.ticks.clear();
        self.path.clear();
        self.trace.clear();
        self.waited.clear();
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

    /// The core waits at the place that was asked for, until the next tick is due.
    fn wait_for_a_tick(&mut self, session: &mut Session<Board>, hit: Hit) {
        let Some((address, nth)) = self.waiting_place.filter(|&(address, _)| address == hit.address) else {
            return;
        };
        self.waiting_place = (nth > 1).then_some((address, nth.saturating_sub(1)));
        if nth == 1 {
            let last = self.ticks.last().map_or(0, |tick| tick.at.0);
            let due = VirtualNanos(last + ((hit.at.0 - last) / MILLISECOND + 1) * MILLISECOND);
            self.stalled_until = due;
            self.waited.push(hit.at);
            session.pause_at(Some(due));
        }
    }

    /// The next stop: a millisecond on, or where it comes to lie half-way between two ticks.
    fn next_stop(&self, at: VirtualNanos) -> VirtualNanos {
        let regular = at.0 + MILLISECOND;
        let since = |tick: &TickRecord| at.0 - tick.at.0;
        match self.ticks.last().map(since) {
            // A tick that is under way is not among them yet: then the last one was a little over 1 ms ago.
            Some(since)
                if since < 2 * MILLISECOND && (since % MILLISECOND).abs_diff(MILLISECOND / 2) > 100_000 =>
            {
                VirtualNanos(regular + MILLISECOND / 2 - since % MILLISECOND)
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
                Ok(Command::Again(sectors, rig)) => {
                    self.begin_again(session, stop, &sectors, rig);
                    return true;
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
            self.wait_for_a_tick(session, hit);
        }
        let random = session.board_mut().chip().take_power_on();
        for (address, value) in random.into_iter().flatten() {
            let written = host.write(address, Width::W64, value);
            written.expect("the part's own RAM");
        }
        // The core fetches from the flash, so it stands still while the flash is busy.
        let stalled = session.board_mut().chip().stalled() || now(&settled) < self.stalled_until;
        if self.halted && !stalled {
            self.halted = false;
            session.board_mut().chip().thaw(now(&settled));
        }
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
