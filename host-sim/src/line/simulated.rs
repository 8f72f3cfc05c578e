//! A board that is simulated with its rig, as fast as it goes or in real time.

use super::Line;
use std::io;
use std::time::{Duration, Instant};
use twinrotor::parameters::Parameters;
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{SLOT_SIZE, Store};
use twinrotor::parameters::{self, ParameterError};
use twinrotor::rig_port::RigPort;
use twinrotor::telemetry::Frame;
use twinrotor_station::SimulatedBoard;

/// A line whose clock is the board's own: a tick is a millisecond.
pub struct Simulated {
    board: SimulatedBoard,
    ticks: u64,
    /// When it began, in real time.
    begun: Option<Instant>,
}

impl Simulated {
    /// A board that was given `parameters` before and computes the rig of which they speak, in its rest pose.
    /// Its wiring has been checked.
    ///
    /// # Errors
    ///
    /// If they have no room in a board's flash.
    pub fn new(parameters: &Parameters, real_time: bool) -> Result<Self, ParameterError> {
        let parameters = Parameters { checked: true, port: RigPort::Simulated, ..*parameters };
        let mut store = Store::new(RamFlash::default(), 0);
        parameters::save(&mut store, &parameters, &mut [0; SLOT_SIZE])?;
        let board = SimulatedBoard::alone(parameters, store.into_flash());
        Ok(Self { board, ticks: 0, begun: real_time.then(Instant::now) })
    }

    /// The board's last tick.
    #[must_use]
    pub fn frame(&self) -> Frame {
        self.board.frame()
    }
}

impl Line for Simulated {
    fn exchange(&mut self, bytes: &[u8]) -> io::Result<Vec<u8>> {
        self.board.push(bytes);
        self.board.tick();
        self.ticks += 1;
        if let Some(begun) = self.begun {
            std::thread::sleep(self.now().saturating_sub(begun.elapsed()));
        }
        Ok(self.board.take_outgoing())
    }

    fn now(&self) -> Duration {
        Duration::from_millis(self.ticks)
    }
}
