//! An operator's place: the client that speaks to a board, and what of its telemetry is drawn. The board is
//! simulated here with its rig, and then time is the board's: it passes when the page lets it. Or it is at
//! the other end of a line, whose bytes and time somebody else carries.

pub mod bench;
pub mod faults;
pub mod flying;
mod line;
mod orders;
pub mod recorder;
pub mod samples;
pub mod status;
pub mod tuning;

use bench::Bench;
use flying::{Flights, Flying, Wish};
use recorder::Recorder;
use serde::Deserialize;
use status::Journal;
use std::time::Duration;
use tuning::Tuning;
use twinrotor::axes::PerAxis;
use twinrotor::controller::ControllerSettings;
use twinrotor::defaults;
use twinrotor::first_power::Verdict;
use twinrotor::link::{Identity, ToBoard, ToHost};
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
use twinrotor_station::words;
use twinrotor_tune::design::CATALOGUE;

/// The preset's own controller.
pub const OWN: &str = "own";

/// Which rig, and with what it begins.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// Of the rig.
    pub preset: String,
    /// `own`, or of the catalogue.
    pub controller: String,
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
    /// The board, if it is simulated here.
    bench: Option<Bench>,
    client: Client,
    /// Milliseconds of the board's time here, of the line's clock there.
    ticks: u64,
    /// Counts the boards that there have been: what was drawn of one is not the next one's.
    pub number: u32,
    parameters: Parameters,
    identity: Option<Identity>,
    frame: Option<Frame>,
    /// \[ticks\] When the board was heard last.
    heard: u64,
    /// What is wrong with the line or the board at its end, and what to do.
    trouble: Option<String>,
    /// Since when a zero is wanted, and when the board is asked for it again.
    zeroing: Option<(u64, u64)>,
    /// Motors off is said until it is seen, next in this tick.
    cutting: Option<u64>,
    flying: Option<Flying>,
    flights: Flights,
    tuning: Tuning,
    journal: Journal,
    samples: Vec<f32>,
    /// A record, if one is wanted.
    pub recorder: Recorder,
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
        let bench = Bench::new(&rig, parameters, store.into_flash());
        let tuning = Tuning::new(&choice.controller, controller);
        Ok(Self::with(choice.preset.clone(), rig, Some(bench), parameters, tuning))
    }

    fn with(preset: String, rig: Rig, bench: Option<Bench>, parameters: Parameters, tuning: Tuning) -> Self {
        let mut client = Client::new();
        client.resynchronise();
        client.ask(Question::Identify, Duration::ZERO);
        Self {
            preset,
            rig,
            bench,
            client,
            ticks: 0,
            number: 0,
            parameters,
            identity: None,
            frame: None,
            heard: 0,
            trouble: None,
            zeroing: None,
            cutting: None,
            flying: None,
            flights: Flights::default(),
            tuning,
            journal: Journal::default(),
            samples: Vec::new(),
            recorder: Recorder::default(),
        }
    }

    fn now(&self) -> Duration {
        Duration::from_millis(self.ticks)
    }

    /// Lets so many ticks of a simulated board pass. Gives how many rows [`Desk::samples`] has for them.
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
        let said = self.say();
        let Some(bench) = &mut self.bench else { return };
        let came = bench.exchange(&said, self.ticks);
        let now = self.now();
        self.ticks += 1;
        self.listen(&came, now);
    }

    /// What is to be said to the board now.
    fn say(&mut self) -> Vec<u8> {
        if let Some(Event::Answered(Err(error))) = self.client.poll(self.now()) {
            self.unanswered(&error);
        }
        self.zero_again();
        self.cut_again();
        self.client.take_outgoing()
    }

    fn listen(&mut self, came: &[u8], now: Duration) {
        for event in self.client.push(came, now) {
            self.take(event);
        }
    }

    fn take(&mut self, event: Event) {
        match event {
            Event::Message(ToHost::Frame(frame)) => self.look(frame),
            Event::Message(ToHost::Verdict(verdict)) => self.checked(&verdict),
            Event::Message(ToHost::Refused(refusal)) => {
                self.journal.trouble(self.ticks, words::refusal(&refusal));
            }
            Event::Message(ToHost::Identity(identity)) => self.meet_again(&identity),
            Event::Message(_) | Event::Damaged => {}
            Event::Answered(Ok(Answer::Identity(identity))) => self.meet(identity),
            Event::Answered(Ok(Answer::Parameters(kept))) => {
                self.adopt(*kept);
                if self.tuning.saved != self.tuning.accepted {
                    self.tuning.saved = self.tuning.accepted;
                    self.journal.note(self.ticks, "saved: the board boots with this controller from now on");
                }
            }
            Event::Answered(Ok(Answer::Replayed(_))) => {}
            Event::Answered(Err(error)) => self.unanswered(&error),
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

    fn look(&mut self, frame: Frame) {
        let before = self.frame.replace(frame);
        self.heard = self.ticks;
        if let Some(ended) = self.recorder.take(&frame) {
            self.journal.trouble(self.ticks, ended);
        }
        let place = |frame: &Frame| frame.tick / samples::EVERY;
        if before.is_none_or(|before| place(&before) != place(&frame)) {
            let rotors = self.bench.as_ref().map(|bench| bench.board.rig.bench.rotor_volts());
            self.samples.extend(samples::row(&frame, rotors));
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
                state => {
                    self.journal.note(self.ticks, words::state(state));
                    if state == ArmState::Armed {
                        self.trouble = None;
                    }
                }
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
            self.end_flight();
            self.journal.trouble(self.ticks, "the flight was broken off: the motors are off");
            return;
        }
        let Some(flying) = &mut self.flying else { return };
        let rising = flying.begun().is_none();
        let wish = flying.hear(frame);
        if let (true, Some(begun), Some(bench)) = (rising, flying.begun(), &mut self.bench) {
            bench.begins(flying.scenario(), begun);
        }
        match wish {
            Wish::Nothing => {}
            Wish::Say(setpoint) => {
                let sequence = self.client.send(&ToBoard::Setpoint(setpoint)).unwrap_or_default();
                flying.said(sequence, frame.tick.wrapping_add(1));
            }
            Wish::End => {
                if let Some(flying) = self.end_flight() {
                    self.flights.note(flying, (&self.preset, &self.rig));
                    self.journal.note(self.ticks, "flown to its end; back to level");
                }
                self.client.aim(PerAxis::zero());
            }
        }
    }
}

#[cfg(test)]
mod tests;
