//! A board that is simulated with its rig, as fast as it goes or in real time.

use super::Line;
use std::io;
use std::time::{Duration, Instant};
use twinrotor::parameters::Parameters;
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{SLOT_SIZE, Store};
use twinrotor::parameters::{self, ParameterError};
use twinrotor::plant::presets::Rig;
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
    /// `rig` in its rest pose, and a board that was given `parameters` before.
    ///
    /// # Errors
    ///
    /// If they have no room in a board's flash.
    pub fn new(rig: &Rig, parameters: &Parameters, real_time: bool) -> Result<Self, ParameterError> {
        let mut store = Store::new(RamFlash::default(), 0);
        parameters::save(&mut store, parameters, &mut [0; SLOT_SIZE])?;
        let board = SimulatedBoard::new(rig, *parameters, store.into_flash());
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
