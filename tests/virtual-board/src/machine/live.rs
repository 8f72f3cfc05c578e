//! What a test may look at and do while the board stands between two milliseconds.

use std::any::Any;
use std::collections::BTreeSet;

use rigless::device::Level;
use rigless::emulator::{Host, Stop, Watch};
use rigless::mcu::Operate;
use rigless::session::{Reset, Session};
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use super::lockstep::{Lockstep, TickRecord};
use super::{MILLISECOND, Rig};
use crate::board::{Board, Outputs};
use crate::chip::flash::Flash;
use crate::serial::Line;
use crate::warm_core::NMI;

/// The board while it stands.
pub struct Live<'a> {
    pub(super) session: &'a mut Session<Board>,
    pub(super) host: &'a mut dyn Host,
    pub(super) stop: &'a Stop,
    pub(super) lockstep: &'a mut Lockstep,
}

impl Live<'_> {
    /// Now, and the instructions the core has retired.
    pub fn now(&self) -> (VirtualNanos, u64) {
        (self.stop.at, self.stop.instruction_count)
    }

    /// The board, to do anything with.
    pub fn board(&mut self) -> &mut Board {
        self.lockstep.tampered = true;
        self.session.board_mut()
    }

    /// The flash: what was done to it, and cuts of its supply to come.
    pub fn flash(&mut self) -> &mut Flash {
        self.session.board_mut().chip().flash()
    }

    /// The host's end of the serial line.
    pub fn line(&mut self) -> &mut Line {
        self.session.board_mut().line()
    }

    /// Whether something was done that outlasts a power-on, or may.
    pub(super) fn tampered(&self) -> bool {
        self.lockstep.tampered
    }

    /// The outputs now.
    pub fn outputs(&mut self) -> Outputs {
        let at = self.stop.at;
        self.session.board_mut().outputs(at)
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
        self.lockstep.tampered = true;
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
        &self.session.resets()[self.lockstep.resets_before..]
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
        self.lockstep.tampered = true;
        self.session.fail_next(address, address + 0x400);
    }

    /// The core stands still for `milliseconds`, while everything around it goes on.
    pub fn stall(&mut self, milliseconds: u64) {
        let until = VirtualNanos(self.stop.at.0 + milliseconds * MILLISECOND);
        self.lockstep.stalled_until = until;
        self.lockstep.held = true;
        self.host.hold(true);
    }

    /// A debugger halts the core for `milliseconds`: what the debug registers say stands still with it.
    pub fn halt(&mut self, milliseconds: u64) {
        let at = self.stop.at;
        self.stall(milliseconds);
        self.lockstep.halted = true;
        self.board().chip().freeze(at);
    }

    /// At the `nth` arrival at `address` from now the core waits until the next tick is due: one phase of
    /// thread and tick, chosen.
    pub fn wait_there_for_a_tick(&mut self, address: u64, nth: u32) {
        self.lockstep.tampered = true;
        self.session.watch(Watch::Instruction(address));
        self.lockstep.waiting_place = Some((address, nth));
    }

    /// When it did, each time that it was asked to.
    pub fn waited(&self) -> &[VirtualNanos] {
        &self.lockstep.waited
    }

    /// A register of a peripheral, as the part answers the core.
    ///
    /// # Panics
    ///
    /// If there is no such register.
    pub fn register(&mut self, address: u64) -> u64 {
        let at = self.stop.at;
        let read = self.session.mcu().read(at, address, Width::W32);
        read.unwrap_or_else(|why| panic!("{why}"))
    }

    /// The crystal stops, for good.
    pub fn stop_crystal(&mut self) {
        let at = self.stop.at;
        if self.board().chip().stop_crystal(at) {
            self.host.set_interrupt(NMI, Level::High);
        }
    }

    /// The supply goes, and comes back a moment later.
    pub fn cut_power(&mut self) {
        let at = self.stop.at;
        self.session.board_mut().chip().drive_flash(at, Flash::cut);
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

    /// How much of the stack between `low` and `high` was ever used \[bytes\], told by the words at its
    /// low end that still are all the same, as a firmware paints them.
    pub fn stack_used(&mut self, low: u64, high: u64) -> u64 {
        let paint = self.word(low);
        let untouched = (low..high).step_by(4).take_while(|&address| self.word(address) == paint).count();
        high - low - 4 * untouched as u64
    }
}
