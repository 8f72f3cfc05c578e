//! A board that is simulated with its rig, as fast as it goes or in real time.

use super::Line;
use std::io;
use std::time::{Duration, Instant};
use twinrotor::board::Board;
use twinrotor::parameters::Parameters;
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{SLOT_SIZE, Store};
use twinrotor::parameters::{self, ParameterError};
use twinrotor::plant::presets::Rig;
use twinrotor::rig_port::RigPort;
use twinrotor::telemetry::Frame;
use twinrotor_sim::scenario::{Befallen, Scenario};
use twinrotor_station::SimulatedBoard;

/// A line whose clock is the board's own: a tick is a millisecond.
pub struct Simulated {
    board: SimulatedBoard,
    ticks: u64,
    rig: Rig,
    /// What befalls the rig in each leg, and what is random in it.
    scenario: Option<(Scenario, u64)>,
    /// The same in the leg that is flown, and the board's tick in which that began.
    befallen: Option<(Befallen, u32)>,
    /// When it began, in real time.
    begun: Option<Instant>,
}

impl Simulated {
    /// A board of that kind that was given `parameters` before and computes the rig of which they speak, in
    /// its rest pose. Its wiring has been checked.
    ///
    /// # Errors
    ///
    /// If they have no room in a board's flash.
    pub fn new(board: Board, parameters: &Parameters, real_time: bool) -> Result<Self, ParameterError> {
        let parameters = Parameters { checked: true, port: RigPort::Simulated, ..*parameters };
        let mut store = Store::new(RamFlash::default(), 0);
        parameters::save(&mut store, &parameters, &mut [0; SLOT_SIZE])?;
        let (rig, begun) = (parameters.rig(board), real_time.then(Instant::now));
        let board = SimulatedBoard::alone(board, parameters, store.into_flash());
        Ok(Self { board, ticks: 0, rig, scenario: None, befallen: None, begun })
    }

    /// The same rig with the hardware that `scenario` has, and with all that befalls it in each leg.
    #[must_use]
    pub fn befallen_by(mut self, scenario: &Scenario, seed: u64) -> Self {
        Befallen::wear(scenario, &mut self.board.rig.bench);
        self.scenario = Some((scenario.clone(), seed));
        self
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
        let tick = self.board.frame().tick.wrapping_add(1);
        if let Some((befallen, begun)) = &mut self.befallen {
            befallen.befall(&mut self.board.rig.bench, tick.wrapping_sub(*begun));
        }
        self.board.tick();
        self.ticks += 1;
        if let Some(begun) = self.begun {
            std::thread::sleep(self.now().saturating_sub(begun.elapsed()));
        }
        Ok(self.board.take_outgoing())
    }

    fn begins(&mut self, tick: u32) {
        let Some((scenario, seed)) = &self.scenario else { return };
        let befallen = Befallen::new(scenario, *seed, &self.rig, &self.board.rig.bench);
        self.befallen = Some((befallen, tick));
    }

    fn now(&self) -> Duration {
        Duration::from_millis(self.ticks)
    }
}
