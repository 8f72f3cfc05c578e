//! The board's serial line over TCP, for one program at a time.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use twinrotor::link::{Decoder, ToHost};
use twinrotor::supervisor::ArmState;
use twinrotor_station::pace::Pace;

use crate::helicopter::Helicopter;
use crate::machine::{Failure, Machine};

/// \[ms\] What is said to a board that has not booted is lost, and an emulator is slowest at first.
const BOOT: u64 = 200;
/// \[ms\] At once, where it goes as fast as it can.
const STRETCH: u64 = 4;
/// \[ms\] That it goes on so when its program has gone in flight, which ends within that.
const LEFT: u64 = 1_000;
/// How long nothing is done where there is nothing to do.
const PAUSE: Duration = Duration::from_micros(200);

/// A board that is served.
pub struct Server {
    listener: TcpListener,
    machine: Machine,
    real: bool,
    program: Option<TcpStream>,
    pace: Pace,
    begun: Instant,
    /// \[ms\] Since its program has gone.
    left: u64,
    table: Table,
}

impl Server {
    /// At `address`, in real time or as fast as it goes.
    ///
    /// # Errors
    ///
    /// If nothing can listen there, or the firmware does not boot.
    pub fn new(address: &str, mut machine: Machine, real: bool) -> Result<Self, Failure> {
        machine.try_run(BOOT)?;
        Self::listening(address, machine, real).map_err(|why| Failure(format!("{address}: {why}")))
    }

    fn listening(address: &str, machine: Machine, real: bool) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            machine,
            real,
            program: None,
            pace: Pace::new(real, Duration::ZERO),
            begun: Instant::now(),
            left: LEFT,
            table: Table::default(),
        })
    }

    /// Where it listens.
    ///
    /// # Errors
    ///
    /// If that is not known.
    pub fn address(&self) -> io::Result<std::net::SocketAddr> {
        self.listener.local_addr()
    }

    /// Serves for as long as the firmware runs and `goes_on` says so.
    ///
    /// # Errors
    ///
    /// If the firmware reached something that is not modelled.
    pub fn serve(&mut self, mut goes_on: impl FnMut() -> bool) -> Result<(), Failure> {
        while goes_on() {
            self.listen();
            self.welcome();
            let now = self.begun.elapsed();
            let due = if self.real {
                self.pace.due(now)
            } else if self.program.is_some() {
                (0..STRETCH).map(|_| self.pace.due(now)).sum()
            } else {
                STRETCH * u64::from(self.is_left())
            };
            if due == 0 {
                std::thread::sleep(PAUSE);
                continue;
            }
            self.left += due;
            self.machine.try_run(due)?;
            let bytes = self.machine.heard();
            self.table.watch(&bytes, &mut self.machine);
            self.tell(&bytes);
        }
        Ok(())
    }

    /// One program at a time: the line of any other is closed at once. Where time waits for programs, the
    /// next one comes when the board has found that the last one has gone.
    fn welcome(&mut self) {
        if self.program.is_none() && !self.real && self.is_left() {
            return;
        }
        while let Ok((stream, _)) = self.listener.accept() {
            if self.program.is_none() && stream.set_nonblocking(true).is_ok() {
                let _ = stream.set_nodelay(true);
                self.program = Some(stream);
                self.pace.meet(self.begun.elapsed());
            }
        }
    }

    /// Its program has gone in flight, and it has not yet had the time to find that.
    fn is_left(&self) -> bool {
        self.left < LEFT && self.table.state.motors_may_turn()
    }

    /// All that has come, and whether the program has gone.
    fn listen(&mut self) {
        let mut bytes = [0; 4096];
        while let Some(program) = &mut self.program {
            self.left = 0;
            match program.read(&mut bytes) {
                Ok(count) if count > 0 => {
                    self.machine.say(&bytes[..count]);
                    self.pace.hear(&bytes[..count], self.begun.elapsed());
                }
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {
                    return;
                }
                _ => self.program = None,
            }
        }
    }

    /// As a serial line does: what nobody takes in time is lost, a piece at a time.
    fn tell(&mut self, bytes: &[u8]) {
        let Some(program) = &mut self.program else { return };
        match program.write(bytes) {
            Err(error) if !matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {
                self.program = None;
            }
            _ => {}
        }
    }
}

/// Somebody who puts a table under the rig for the first-power check and after a flight, and takes it away
/// when the board is armed. Before that somebody holds the rig.
#[derive(Default)]
struct Table {
    decoder: Decoder,
    state: ArmState,
}

impl Table {
    fn watch(&mut self, bytes: &[u8], machine: &mut Machine) {
        for received in bytes.iter().filter_map(|&byte| self.decoder.push::<ToHost>(byte)) {
            let Ok(ToHost::Frame(frame)) = received else { continue };
            let before = std::mem::replace(&mut self.state, frame.state);
            let table = match (before, frame.state) {
                (before, now) if before == now => continue,
                (_, ArmState::Checking) | (ArmState::Armed, _) => true,
                (_, ArmState::Armed) => false,
                _ => continue,
            };
            machine.rig(move |rig: &mut Helicopter| rig.set_table(table));
        }
    }
}
