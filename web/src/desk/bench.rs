//! A simulated rig with its board at an operator's place, and what a hand, the wind and the fault buttons do
//! to it.

use super::faults::{Fault, Present};
use twinrotor::axes::PerMotor;
use twinrotor::bench::Injection;
use twinrotor::parameters::Parameters;
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::plant::presets::Rig;
use twinrotor::real::Real;
use twinrotor::supervisor::ArmState;
use twinrotor::telemetry::Frame;
use twinrotor_sim::Outcome;
use twinrotor_sim::scenario::{Befallen, Scenario};
use twinrotor_station::SimulatedBoard;

/// \[V\] Most that a disturbance may add to the volts in effect at a rotor.
pub const MOST_DISTURBANCE: f32 = 12.0;
/// \[ticks\] How often a hand stops a rig that swings on the ground: an Aero 2 swings on for two minutes.
const STEADY_EVERY: u64 = 500;

/// A board with a rig, and the hand that is at it.
pub struct Bench {
    /// The board.
    pub board: SimulatedBoard,
    rig: Rig,
    /// \[V\] Of the amplifiers, as it should be.
    supply: f32,
    /// What has gone wrong.
    pub faults: Present,
    /// \[V\] Of the wind.
    pub wind: PerMotor<f32>,
    /// \[V\] Of a hand at the rig.
    pub push: PerMotor<f32>,
    /// \[V\] Tick by tick, over and over.
    pub gusts: Vec<PerMotor<f32>>,
    /// A hand steadies the rig while its motors get nothing.
    pub steadied: bool,
    flight: Option<Befalling>,
}

/// A scenario that befalls the rig.
struct Befalling {
    befallen: Befallen,
    /// What is injected, and in which tick of the flight, the last first.
    injections: Vec<(u32, Injection)>,
    /// The board's tick.
    begun: u32,
    /// \[V\] What it adds to the volts in effect.
    volts: PerMotor<f32>,
}

impl Befalling {
    /// What comes with the board's next tick.
    fn befall(&mut self, board: &mut SimulatedBoard) {
        let tick = board.frame().tick.wrapping_add(1).wrapping_sub(self.begun);
        // Wind and hand are not its own: it finds what it has left.
        board.rig.bench.disturbance = self.volts;
        while let Some((_, injection)) = self.injections.pop_if(|(due, _)| *due <= tick) {
            board.rig.inject(&injection);
        }
        self.befallen.befall(&mut board.rig.bench, tick);
        self.volts = board.rig.bench.disturbance;
    }
}

impl Bench {
    /// `rig` at rest, and a board that has just booted with what is in `flash`.
    #[must_use]
    pub fn new(rig: &Rig, built_in: Parameters, flash: RamFlash) -> Self {
        let board = SimulatedBoard::new(rig, built_in, flash);
        Self {
            rig: *rig,
            supply: board.rig.bench.supply,
            board,
            faults: Present::default(),
            wind: PerMotor::zero(),
            push: PerMotor::zero(),
            gusts: Vec::new(),
            steadied: true,
            flight: None,
        }
    }

    /// A tick passes: what the operator has said to the board, and what the board says.
    pub fn exchange(&mut self, said: &[u8], tick: u64) -> Vec<u8> {
        let connected = !self.faults.has(Fault::LinkLost);
        if connected {
            self.board.push(said);
        }
        let gust = usize::try_from(tick).unwrap_or(0).checked_rem(self.gusts.len());
        let gust = gust.map_or(PerMotor::zero(), |now| self.gusts[now]);
        let befallen = self.flight.as_mut().map_or(PerMotor::zero(), |flight| {
            flight.befall(&mut self.board);
            flight.volts
        });
        let all = befallen.plus(self.wind).plus(gust).plus(self.push);
        self.board.rig.bench.disturbance = all.map(|volts| volts.clamp(-MOST_DISTURBANCE, MOST_DISTURBANCE));
        let idle = |frame: Frame| frame.state != ArmState::Armed && frame.volts == PerMotor::zero();
        if self.steadied && tick.is_multiple_of(STEADY_EVERY) && idle(self.board.frame()) {
            self.board.rig.bench.steady();
        }
        self.board.tick();
        let came = self.board.take_outgoing();
        if connected { came } else { Vec::new() }
    }

    /// The rig's hardware becomes that of a scenario which is to be flown.
    pub fn wear(&mut self, scenario: &Scenario) {
        self.calm();
        Befallen::wear(scenario, &mut self.board.rig.bench);
    }

    /// The scenario has begun in this tick of the board.
    pub fn begins(&mut self, scenario: &Scenario, begun: u32) {
        let mut injections: Vec<_> =
            scenario.inject.iter().map(|inject| (inject.tick(), inject.injection)).collect();
        injections.sort_by_key(|(due, _)| std::cmp::Reverse(*due));
        let befallen = Befallen::new(scenario, 1, &self.rig, &self.board.rig.bench);
        self.flight = Some(Befalling { befallen, injections, begun, volts: PerMotor::zero() });
    }

    /// It is over, and all that befell the rig with it.
    pub fn calm(&mut self) {
        if let Some(mut flight) = self.flight.take() {
            flight.befallen.befall(&mut self.board.rig.bench, u32::MAX);
            for injection in [Injection::CurrentLimit(false), Injection::EmergencyStop(false)] {
                self.board.rig.inject(&injection);
            }
            self.board.rig.bench.become_plant(&self.rig.plant.map(f32::from_f64));
            self.faults.apply(&mut self.board, &self.rig, self.supply);
        }
    }

    /// A fault comes or goes; what it is, in words.
    ///
    /// # Errors
    ///
    /// If there is none of that name.
    pub fn fault(&mut self, name: &str, present: bool) -> Outcome<&'static str> {
        let words = self.faults.set(name, present)?;
        self.faults.apply(&mut self.board, &self.rig, self.supply);
        Ok(words)
    }
}
