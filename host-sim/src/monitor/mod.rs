//! The page, served, with a board behind it: `host-sim monitor`. The page is the one that `host-sim page`
//! writes; what it asks its own module there it asks here over a socket, of the same code, and the board is
//! at a line or simulated here.

mod door;
mod http;
mod record;
mod room;
mod visitor;

pub use door::{Door, Knock};

use crate::error::{Failure, Outcome};
use crate::line::Line;
use crate::page::served;
use room::{Room, Way};
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;
use twinrotor::telemetry::Frame;
use twinrotor_station::pace::Pace;
use twinrotor_web::desk::recorder::Recorder;
use twinrotor_web::desk::{Choice, Desk};

/// Most visitors at a time, files included.
const MOST: usize = 64;

/// Where the board is.
pub enum Board {
    /// Simulated here, of this rig and with this controller; on its way up.
    Simulated(Choice),
    /// At a line of this name.
    Line(String, Box<dyn Line>),
}

/// How it has ended.
pub struct Ended {
    /// Whether the motors were seen to be off, or nothing if none could have turned.
    pub seen: Option<bool>,
    /// What was recorded.
    pub frames: Vec<Frame>,
}

/// A place that is ready to be visited.
pub struct Monitor {
    listener: TcpListener,
    door: Door,
    room: Room,
}

impl Monitor {
    /// Listens at an address; port 0 is any free one. Of every tick so many are recorded at most, if any.
    ///
    /// # Errors
    ///
    /// If it cannot, or the board's choice is none.
    pub fn new(at: SocketAddr, board: Board, record: Option<usize>) -> Outcome<Self> {
        let failed = |error: std::io::Error| Failure::Run(format!("--listen {at}: {error}"));
        let listener = TcpListener::bind(at).map_err(failed)?;
        let door = Door::new(listener.local_addr().map_err(failed)?)
            .map_err(|error| Failure::Run(format!("no random numbers for a token: {error}")))?;
        let recorder = record.map(Recorder::of_program).unwrap_or_default();
        let (mut desk, way) = match board {
            Board::Simulated(choice) => {
                let mut desk = Desk::new(&choice).map_err(Failure::of_flag)?;
                desk.take_off();
                (desk, Way::Here(Box::new(Pace::new(true, Duration::ZERO))))
            }
            Board::Line(name, line) => (Desk::at_a_line(), Way::There(name, Some(line))),
        };
        desk.recorder = recorder;
        Ok(Self { listener, door, room: Room::new(desk, way) })
    }

    /// Where the page is.
    #[must_use]
    pub fn url(&self) -> String {
        self.door.url()
    }

    /// Until a signal asks to stop; then the motors are switched off.
    ///
    /// # Errors
    ///
    /// If no thread can be made.
    pub fn run(self) -> Outcome<Ended> {
        let Self { listener, door, mut room } = self;
        let (to_room, asks) = channel();
        std::thread::Builder::new()
            .name("door".to_owned())
            .spawn(move || let_in(&listener, &Arc::new(door), &to_room))
            .map_err(|error| Failure::Run(format!("no thread for visitors: {error}")))?;
        room.run(&asks);
        let seen = room.close();
        // What the pages are told last has to reach them.
        std::thread::sleep(Duration::from_millis(30));
        Ok(Ended { seen, frames: room.recorded() })
    }
}

/// Each visitor on a thread of its own.
fn let_in(listener: &TcpListener, door: &Arc<Door>, room: &Sender<room::Ask>) {
    let files = Arc::new(served::files());
    let there = Arc::new(AtomicUsize::new(0));
    for (id, stream) in (0..).zip(listener.incoming()) {
        let Ok(stream) = stream else {
            std::thread::sleep(Duration::from_millis(50));
            continue;
        };
        if there.load(Ordering::SeqCst) >= MOST {
            continue;
        }
        there.fetch_add(1, Ordering::SeqCst);
        let (door, files, room, inside) =
            (Arc::clone(door), Arc::clone(&files), room.clone(), Arc::clone(&there));
        let visit = move || {
            let _ = visitor::receive(stream, &door, &files, &room, id);
            inside.fetch_sub(1, Ordering::SeqCst);
        };
        if std::thread::Builder::new().name("visitor".to_owned()).spawn(visit).is_err() {
            there.fetch_sub(1, Ordering::SeqCst);
        }
    }
}
