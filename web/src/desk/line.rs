//! A board at the other end of a line: who it is, what it flies with, and what to do when it is not heard.

use super::tuning::Tuning;
use super::{Choice, Desk};
use std::time::Duration;
use twinrotor::link::{BAUD, Identity, ToBoard, ticks_per_frame};
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets::AERO2;
use twinrotor::real::Real;
use twinrotor::supervisor::{ArmState, Condition, Request};
use twinrotor_sim::{Error, Outcome};
use twinrotor_station::client::Question;
use twinrotor_station::words;

/// \[ticks\] Of silence that is told.
const QUIET: u64 = 1_000;
/// \[ticks\] Within which a rig that is simulated has been checked, zeroed and armed.
const LONGEST_START: u32 = 200_000;

impl Desk {
    /// With a board that somebody else carries bytes to and from ([`Desk::due`], [`Desk::hear`]). What it
    /// flies with it says itself; until then an Aero 2 stands for it.
    ///
    /// # Panics
    ///
    /// Never: [`super::OWN`] is there.
    #[must_use]
    pub fn at_a_line() -> Self {
        let settings =
            twinrotor::pipeline::Settings::new(&AERO2, twinrotor::defaults::AERO2, twinrotor::SAMPLE_TIME);
        let parameters = Parameters::new(&AERO2, &settings);
        let tuning = Tuning::new("the board's", twinrotor::defaults::AERO2);
        Self::with("the board's".to_owned(), AERO2, None, parameters, tuning)
    }

    /// What is to be said over the line at `now`, by the line's clock.
    pub fn due(&mut self, now: Duration) -> Vec<u8> {
        self.ticks = u64::try_from(now.as_millis()).unwrap_or(u64::MAX);
        self.say()
    }

    /// What came over it.
    pub fn hear(&mut self, bytes: &[u8]) {
        self.listen(bytes, self.now());
    }

    /// What came over the line by `now`, and what is to be said over it then. [`Desk::samples`] has what came
    /// in it.
    pub fn exchange(&mut self, came: &[u8], now: Duration) -> Vec<u8> {
        self.samples.clear();
        self.ticks = u64::try_from(now.as_millis()).unwrap_or(u64::MAX);
        self.hear(came);
        self.say()
    }

    /// The simulated board alone, for an operator elsewhere: what it says to what was said to it, after so
    /// many ticks.
    ///
    /// # Errors
    ///
    /// If the board is at a line itself.
    pub fn serve(&mut self, said: &[u8], ticks: u32) -> Outcome<Vec<u8>> {
        let begun = self.ticks;
        self.ticks += u64::from(ticks);
        let bench = self.bench()?;
        let mut said = said;
        let exchange = |tick| bench.exchange(std::mem::take(&mut said), begun + u64::from(tick));
        Ok((0..ticks).flat_map(exchange).collect())
    }

    /// Rows of samples since the last time they were taken.
    pub fn take_samples(&mut self) -> Vec<f32> {
        std::mem::take(&mut self.samples)
    }

    /// The line is broken: why, and what to do.
    pub fn line_lost(&mut self, why: &str, remedy: &str) {
        let unseen = if self.motors_may_turn() { "; that its motors are off was not seen" } else { "" };
        let told = format!("the line to the board failed: {why}{unseen}; {remedy}");
        if self.trouble.as_ref() != Some(&told) {
            self.journal.trouble(self.ticks, told.clone());
        }
        self.trouble = Some(told);
    }

    /// The line is there again: whoever is at its end is asked who it is.
    pub fn line_found(&mut self) {
        let ticks = self.ticks;
        self.turn_to(Self { ticks, heard: ticks, ..Self::at_a_line() });
        self.client.ask(Question::Identify, self.now());
        self.journal.note(self.ticks, "the line is open again");
    }

    /// Another board; what happened with those before is still told, and what was recorded of them kept.
    pub fn turn_to(&mut self, other: Self) {
        let (journal, recorder) = (std::mem::take(&mut self.journal), std::mem::take(&mut self.recorder));
        *self = Self { number: self.number + 1, journal, recorder, ..other };
    }

    /// A simulated desk anew; the next board that is seen.
    ///
    /// # Errors
    ///
    /// If the board is at a line, or there is no such rig or controller.
    pub fn begin(&mut self, choice: &Choice) -> Outcome<()> {
        if self.bench.is_none() {
            return Err(Error::Unusable(
                "the rig is what the board's record says; host-sim flash --port writes another".to_owned(),
            ));
        }
        self.turn_to(Self::new(choice)?);
        Ok(())
    }

    /// A simulated rig checked, zeroed, armed and on its way up, faster than time.
    pub fn take_off(&mut self) {
        self.advance(500);
        let mut asked = false;
        for _ in 0..LONGEST_START / 100 {
            let Some(frame) = self.frame else { return };
            let wants = |condition| frame.conditions.contains(condition);
            match frame.state {
                ArmState::Armed | ArmState::Fault(_) => break,
                ArmState::Checking => {}
                ArmState::Ready if !asked => {
                    asked = true;
                    self.request(Request::Arm);
                }
                ArmState::Ready => {}
                ArmState::Disarmed if wants(Condition::NotChecked) => self.request(Request::Check),
                ArmState::Disarmed if self.zeroing.is_none() => self.zero(),
                ArmState::Disarmed => {}
            }
            self.advance(100);
        }
        self.advance(1);
    }

    /// The board has said who it is.
    pub(super) fn meet(&mut self, identity: Identity) {
        self.journal.note(self.ticks, format!("connected: firmware {}", identity.firmware));
        self.trouble = None;
        self.identity = Some(identity);
        self.client.send(&ToBoard::Telemetry { every: ticks_per_frame(BAUD) });
        if self.bench.is_none() {
            self.client.ask(Question::Read, self.now());
        }
    }

    /// The same board says who it is, or one that has begun anew since.
    pub(super) fn meet_again(&mut self, identity: &Identity) {
        let Some(known) = self.identity.as_ref().filter(|known| known.nonce != identity.nonce) else {
            return;
        };
        let of = known.firmware.clone();
        let cause = identity.reset.as_ref().map_or_else(|| "it does not say why".to_owned(), words::reset);
        let told = format!("the board was reset: {cause}; look at the rig, then zero and arm again");
        self.journal.trouble(self.ticks, told.clone());
        (self.flying, self.zeroing) = (None, None);
        self.number += 1;
        self.meet(Identity { firmware: of, ..identity.clone() });
        self.trouble = Some(told);
    }

    /// What the board flies with.
    pub(super) fn adopt(&mut self, kept: Parameters) {
        if self.bench.is_none() && kept != self.parameters {
            let accepted = self.tuning.accepted.map(f32::from_f64);
            if accepted != kept.settings.controller {
                self.tuning = Tuning::new("the board's", kept.settings.controller.map(f64::from));
                self.number += 1;
            }
            self.rig = kept.rig(self.rig.board);
        }
        self.parameters = kept;
    }

    /// Nobody answered, or in words that are not ours.
    pub(super) fn unanswered(&mut self, error: &Error) {
        let told = error.to_string();
        if self.trouble.as_ref() != Some(&told) {
            self.journal.trouble(self.ticks, told.clone());
        }
        if self.identity.is_none() {
            self.trouble = Some(told);
            self.client.ask(Question::Identify, self.now());
        }
    }

    /// What to do about a board that was heard, and is not any more.
    pub(super) fn quiet(&self) -> Option<String> {
        let heard = self.frame.is_some() && self.ticks > self.heard + QUIET;
        let told = "the board has fallen silent, and switches its motors off by itself; look at its supply \
                    and its cable";
        (heard && self.bench.is_none()).then(|| told.to_owned())
    }
}
