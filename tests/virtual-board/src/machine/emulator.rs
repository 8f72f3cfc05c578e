//! The thread that emulates a board.

use std::fmt;
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use rigless::emulator::{self, Start};
use rigless::image::Image;
use rigless::session::Session;
use rigless::time::VirtualNanos;

use super::lockstep::{Command, Lockstep};
use super::{Failure, MILLISECOND, Rig, Setup};
use crate::board::Board;
use crate::chip::flash;

/// A board that is emulated, until this is dropped.
#[derive(Debug)]
pub(super) struct Emulator {
    commands: Option<SyncSender<Command>>,
    replies: Receiver<Result<bool, Failure>>,
    thread: Option<JoinHandle<()>>,
}

impl Emulator {
    pub(super) fn start(setup: Setup, rig: Box<dyn Rig>) -> Self {
        let (commands, taken) = sync_channel(0);
        let (reply, replies) = sync_channel(1);
        let thread = std::thread::spawn(move || {
            if let Err(failure) = emulate(setup, rig, taken, reply.clone()) {
                // Nobody may be left to hear it.
                let _ = reply.send(Err(failure));
            }
        });
        Self { commands: Some(commands), replies, thread: Some(thread) }
    }

    pub(super) fn command(&mut self, command: Command) -> Result<bool, Failure> {
        let sent = self.commands.as_ref().is_some_and(|to| to.send(command).is_ok());
        match self.replies.recv() {
            Ok(reply) => reply,
            Err(_) if sent => Err(Failure("the emulator's thread died".into())),
            Err(_) => Err(Failure("the run had already ended".into())),
        }
    }

    /// Switches the board off and on, with `rig` connected and `sectors` for its parameters. As with a board
    /// that is new, what becomes of it is told at the next command.
    pub(super) fn again(&mut self, sectors: Vec<u8>, rig: Box<dyn Rig>) {
        let commands = self.commands.as_ref().expect("there until it is dropped");
        // A thread that died is told at the next command, too.
        let _ = commands.send(Command::Again(sectors, rig));
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.commands = None;
        if let Some(thread) = self.thread.take() {
            // It failed where a test already heard of it, or panicked where nobody can be told.
            let _ = thread.join();
        }
    }
}

fn emulate(
    setup: Setup,
    rig: Box<dyn Rig>,
    commands: Receiver<Command>,
    replies: SyncSender<Result<bool, Failure>>,
) -> Result<(), Failure> {
    let fail = |why: &dyn fmt::Display| Failure(why.to_string());
    let mut board = Board::new(setup.seed, setup.settings, setup.amplifiers, setup.protects_memory)
        .map_err(|why| fail(&why))?;
    let mut images = vec![setup.firmware.image().clone()];
    for (address, bytes) in &setup.images {
        let name = format!("image at {address:#x}");
        let image = Image::new(Path::new(&name), bytes.clone(), Some(*address));
        images.push(image.map_err(|why| fail(&why))?);
    }
    for (address, bytes) in images.iter().flat_map(Image::segments) {
        let end = flash::BASE + flash::SIZE as u64;
        if (flash::BASE..end).contains(&address) {
            board.chip().flash().place(address, bytes);
        }
    }
    board.chip().start_unpowered();
    let first = VirtualNanos(MILLISECOND);
    let mut session = Session::new(Box::new(board), 0, first).map_err(|why| fail(&why))?;
    let lockstep = Lockstep::new(setup, rig, commands, replies, first, &mut session)?;
    emulator::run(session, &Start::new(&images), lockstep).map_err(|why| fail(&why))?;
    Ok(())
}
