//! An operator's place: a simulated board with its rig, the client that speaks to it, and what of its
//! telemetry is drawn. Time is the board's: it passes when the page lets it.

pub mod faults;
pub mod flying;
mod orders;
pub mod samples;
pub mod status;
pub mod tuning;

use faults::{Fault, Present};
use flying::{Flights, Flying, Wish};
use serde::Deserialize;
use status::Journal;
use std::time::Duration;
use tuning::Tuning;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::controller::ControllerSettings;
use twinrotor::defaults;
use twinrotor::first_power::Verdict;
use twinrotor::link::{BAUD, Identity, ToBoard, ToHost, ticks_per_frame};
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{SLOT_SIZE, Store};
use twinrotor::parameters::{self, Parameters};
use twinrotor::plant::presets::{self, Rig};
use twinrotor::supervisor::ArmState;
use twinrotor::telemetry::{Frame, TrialPhase};
use twinrotor_sim::error::known_name;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::{Error, Outcome};
use twinrotor_station::client::{Answer, Client, Event, Question};
use twinrotor_station::{SimulatedBoard, words};
use twinrotor_tune::design::CATALOGUE;

/// \[V\] Most that a disturbance may add to the volts in effect at a rotor.
pub const MOST_DISTURBANCE: f32 = 12.0;
/// \[ticks\] How often a hand stops a rig that swings on the ground: an Aero 2 swings on for two minutes.
const STEADY_EVERY: u64 = 500;
/// The preset's own controller.
pub const OWN: &str = "own";

/// Which rig, and with what it begins.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    preset: String,
    controller: String,
}

impl Default for Choice {
    fn default() -> Self {
        Self { preset: "aero2".to_owned(), controller: OWN.to_owned() }
    }
}

/// An operator with a board.
pub struct Desk {
    preset: String,
    rig: Rig,
    board: SimulatedBoard,
    /// \[V\] Of the amplifiers, as it should be.
    supply: f32,
    client: Client,
    ticks: u64,
    parameters: Parameters,
    identity: Option<Identity>,
    frame: Option<Frame>,
    /// \[ticks\] When the board was heard last.
    heard: u64,
    faults: Present,
    /// \[V\] Of the wind, and of a hand at the rig.
    disturbance: PerMotor<f32>,
    push: PerMotor<f32>,
    gusts: Vec<PerMotor<f32>>,
    /// A hand steadies the rig while its motors get nothing.
    steadied: bool,
    /// Since when a zero is wanted.
    zeroing: Option<u64>,
    flying: Option<Flying>,
    flights: Flights,
    tuning: Tuning,
    journal: Journal,
    samples: Vec<f32>,
}

/// The controller of this name for a rig.
///
/// # Errors
///
/// If there is none.
pub fn controller(preset: &str, rig: &Rig, name: &str) -> Outcome<ControllerSettings<f64>> {
    if name == OWN {
        return defaults::named(preset)
            .ok_or_else(|| Error::invalid("preset", preset, "one with gains of its own"));
    }
    Ok(known_name("controller", name, &CATALOGUE)?(rig))
}

impl Desk {
    /// A rig at rest, and a board that holds its parameters and whose wiring has not been checked.
    ///
    /// # Errors
    ///
    /// If there is no rig or controller of that name, or no board could fly it.
    pub fn new(choice: &Choice) -> Outcome<Self> {
        let rig = *known_name("preset", &choice.preset, &presets::ALL)?;
        let controller = controller(&choice.preset, &rig, &choice.controller)?;
        let settings = GainsFile { controller, provenance: None }.settings(&rig);
        let parameters = Parameters::new(&rig, &settings);
        let unusable = |error: twinrotor::parameters::ParameterError| Error::Unusable(error.to_string());
        parameters.validate().map_err(unusable)?;
        let mut store = Store::new(RamFlash::default(), 0);
        parameters::save(&mut store, &parameters, &mut [0; SLOT_SIZE]).map_err(unusable)?;
        let board = SimulatedBoard::new(&rig, parameters, store.into_flash());
        let mut client = Client::new();
        client.resynchronise();
        client.ask(Question::Identify, Duration::ZERO);
        client.send(&ToBoard::Telemetry { every: ticks_per_frame(BAUD) });
        Ok(Self {
            preset: choice.preset.clone(),
            rig,
            supply: board.rig.bench.supply,
            board,
            client,
            ticks: 0,
            parameters,
            identity: None,
            frame: None,
            heard: 0,
            faults: Present::default(),
            disturbance: PerMotor::zero(),
            push: PerMotor::zero(),
            gusts: Vec::new(),
            steadied: true,
            zeroing: None,
            flying: None,
            flights: Flights::default(),
            tuning: Tuning::new(&choice.controller, controller),
            journal: Journal::default(),
            samples: Vec::new(),
        })
    }

    fn now(&self) -> Duration {
        Duration::from_millis(self.ticks)
    }

    /// Lets so many ticks pass. Gives how many rows [`Desk::samples`] has for them.
    pub fn advance(&mut self, ticks: u32) -> usize {
        self.samples.clear();
        for _ in 0..ticks {
            self.tick();
        }
        self.samples.len() / samples::COLUMNS
    }

    /// The rows of the last [`Desk::advance`].
    #[must_use]
    pub fn samples(&self) -> &[f32] {
        &self.samples
    }

    fn tick(&mut self) {
        let now = self.now();
        if let Some(Event::Answered(Err(error))) = self.client.poll(now) {
            self.journal.trouble(self.ticks, error.to_string());
        }
        self.zero_again();
        let said = self.client.take_outgoing();
        let connected = !self.faults.has(Fault::LinkLost);
        if connected {
            self.board.push(&said);
        }
        let gust = usize::try_from(self.ticks).unwrap_or(0).checked_rem(self.gusts.len());
        let gust = gust.map_or(PerMotor::zero(), |now| self.gusts[now]);
        let all = self.disturbance.plus(gust).plus(self.push);
        self.board.rig.bench.disturbance = all.map(|volts| volts.clamp(-MOST_DISTURBANCE, MOST_DISTURBANCE));
        let idle = |frame: Frame| frame.state != ArmState::Armed && frame.volts == PerMotor::zero();
        if self.steadied && self.ticks.is_multiple_of(STEADY_EVERY) && idle(self.board.frame()) {
            self.board.rig.bench.steady();
        }
        self.board.tick();
        self.ticks += 1;
        let came = self.board.take_outgoing();
        if connected {
            for event in self.client.push(&came, now) {
                self.take(event);
            }
        }
    }

    fn take(&mut self, event: Event) {
        match event {
            Event::Message(ToHost::Frame(frame)) => self.hear(frame),
            Event::Message(ToHost::Verdict(verdict)) => self.checked(&verdict),
            Event::Message(ToHost::Refused(refusal)) => {
                self.journal.trouble(self.ticks, words::refusal(&refusal));
            }
            Event::Message(_) | Event::Damaged => {}
            Event::Answered(Ok(Answer::Identity(identity))) => {
                self.journal.note(self.ticks, format!("connected: firmware {}", identity.firmware));
                self.identity = Some(identity);
            }
            Event::Answered(Ok(Answer::Parameters(kept))) => {
                self.parameters = *kept;
                if self.tuning.saved != self.tuning.accepted {
                    self.tuning.saved = self.tuning.accepted;
                    self.journal.note(self.ticks, "saved: the board boots with this controller from now on");
                }
            }
            Event::Answered(Ok(Answer::Replayed(_))) => {}
            Event::Answered(Err(error)) => self.journal.trouble(self.ticks, error.to_string()),
        }
    }

    fn checked(&mut self, verdict: &Verdict) {
        let told = format!("first-power check: {}", words::verdict(verdict));
        if *verdict == Verdict::Passed {
            self.journal.note(self.ticks, told);
        } else {
            self.journal.trouble(self.ticks, told);
        }
    }

    fn hear(&mut self, frame: Frame) {
        let before = self.frame.replace(frame);
        self.heard = self.ticks;
        if frame.tick.is_multiple_of(samples::EVERY) {
            self.samples.extend(samples::row(&frame, self.board.rig.bench.rotor_volts()));
        }
        if let Some(before) = before {
            self.compare(&before, &frame);
        }
        self.fly_on(&frame);
    }

    /// What has changed since the frame before, in words.
    fn compare(&mut self, before: &Frame, now: &Frame) {
        if before.state != now.state {
            match now.state {
                ArmState::Fault(cause) => {
                    self.journal.trouble(self.ticks, format!("motors off: {}", words::condition(cause)));
                }
                state => self.journal.note(self.ticks, words::state(state)),
            }
        }
        let (was, is) = (before.controller.trial, now.controller.trial);
        if was != is && now.state == ArmState::Armed {
            if (was, is) == (TrialPhase::Flying, TrialPhase::None) {
                self.tuning.accept();
            }
            self.journal.note(self.ticks, status::trial(was, is));
        }
    }

    /// The scenario under way, by a frame.
    fn fly_on(&mut self, frame: &Frame) {
        if self.flying.is_none() {
            return;
        }
        if frame.state != ArmState::Armed {
            self.flying = None;
            self.journal.trouble(self.ticks, "the flight was broken off: the motors are off");
            return;
        }
        let Some(flying) = &mut self.flying else { return };
        match flying.hear(frame) {
            Wish::Nothing => {}
            Wish::Say(setpoint) => {
                let sequence = self.client.send(&ToBoard::Setpoint(setpoint)).unwrap_or_default();
                flying.said(sequence, frame.tick.wrapping_add(1));
            }
            Wish::End => {
                if let Some(flying) = self.flying.take() {
                    self.flights.note(flying, &self.rig);
                    self.journal.note(self.ticks, "flown to its end; back to level");
                }
                self.client.aim(PerAxis::zero());
            }
        }
    }
}

#[cfg(test)]
mod tests;
