//! Where a desk stands, for the page: the board's state and what is wrong in words, and for every button why
//! it cannot be pressed now.

use super::faults::Listed;
use super::flying::Progress;
use super::recorder::Recorded;
use super::{Desk, samples};
use serde::Serialize;
use std::collections::VecDeque;
use twinrotor::axes::PerMotor;
use twinrotor::supervisor::{ArmState, Condition, Conditions};
use twinrotor::telemetry::{Frame, Kept, TrialPhase};
use twinrotor_station::words;

/// \[ticks\] Of silence after which the page says so.
const SILENT: u64 = 200;

/// How much of what happened is kept.
const KEPT: usize = 200;

/// Something that happened.
#[derive(Debug, Clone, Serialize)]
pub struct Entry {
    /// Counted from 1.
    number: u64,
    /// \[s\] When.
    time: f64,
    words: String,
    trouble: bool,
}

/// What happened.
#[derive(Debug, Default)]
pub struct Journal {
    entries: VecDeque<Entry>,
    count: u64,
}

impl Journal {
    /// Something that is well.
    pub fn note(&mut self, ticks: u64, words: impl Into<String>) {
        self.enter(ticks, words.into(), false);
    }

    /// Something that is not.
    pub fn trouble(&mut self, ticks: u64, words: impl Into<String>) {
        self.enter(ticks, words.into(), true);
    }

    fn enter(&mut self, ticks: u64, words: String, trouble: bool) {
        #[expect(clippy::cast_precision_loss, reason = "exact for thousands of years of milliseconds")]
        let time = ticks as f64 * 1e-3;
        self.count += 1;
        self.entries.push_back(Entry { number: self.count, time, words, trouble });
        if self.entries.len() > KEPT {
            self.entries.pop_front();
        }
    }

    /// After the entry of that number.
    fn since(&self, number: u64) -> Vec<Entry> {
        self.entries.iter().filter(|entry| entry.number > number).cloned().collect()
    }
}

/// A thing that is wrong.
#[derive(Debug, Serialize)]
pub struct Wrong {
    name: String,
    words: &'static str,
    hazard: bool,
}

/// Why each step cannot be done now; nothing where it can.
#[derive(Debug, Serialize)]
#[expect(missing_docs, reason = "the names of the buttons")]
pub struct Steps {
    pub check: Option<String>,
    pub zero: Option<String>,
    pub arm: Option<String>,
    pub clear: Option<String>,
    pub fly: Option<String>,
    #[serde(rename = "try")]
    pub attempt: Option<String>,
    pub accept: Option<String>,
    pub revert: Option<String>,
    pub save: Option<String>,
}

/// All of it.
#[derive(Debug, Serialize)]
pub struct Status {
    /// \[s\] Of simulated time, or of the line's clock.
    time: f64,
    /// Which board it is: another one is drawn anew.
    board: u32,
    /// The rig is simulated here.
    simulated: bool,
    preset: String,
    /// \[V\]
    volts_limit: PerMotor<f64>,
    firmware: Option<String>,
    silent: bool,
    /// What is wrong with the line or the board at its end, and what to do.
    trouble: Option<String>,
    state: &'static str,
    cause: Option<&'static str>,
    wrong: Vec<Wrong>,
    /// The step that an operator does next on the ground.
    next: Option<&'static str>,
    steps: Steps,
    trial: &'static str,
    trial_share: u8,
    unsaved: bool,
    flying: Option<Progress>,
    flights: usize,
    faults: Vec<Listed>,
    record: Recorded,
    journal: Vec<Entry>,
}

impl Desk {
    /// Where it stands, with what happened after the entry of the journal of the number `since`.
    #[must_use]
    pub fn status(&self, since: u64) -> Status {
        let frame = self.frame.unwrap_or_default();
        let known = self.frame.is_some();
        #[expect(clippy::cast_precision_loss, reason = "exact for thousands of years of milliseconds")]
        let time = self.ticks as f64 * 1e-3;
        let hazards = Conditions::HAZARDS;
        let wrong = frame.conditions.iter().map(|condition| Wrong {
            name: format!("{condition:?}"),
            words: words::condition(condition),
            hazard: hazards.contains(condition),
        });
        Status {
            time,
            board: self.number,
            simulated: self.bench.is_some(),
            preset: self.preset.clone(),
            volts_limit: self.rig.volts_limit,
            firmware: self.identity.as_ref().map(|identity| identity.firmware.to_string()),
            silent: self.ticks > self.heard + SILENT,
            trouble: self.trouble.clone().or_else(|| self.quiet()),
            state: if known { words::state(frame.state) } else { "connecting" },
            cause: match frame.state {
                ArmState::Fault(cause) => Some(words::condition(cause)),
                _ => None,
            },
            wrong: wrong.collect(),
            next: next(&frame).filter(|_| known),
            steps: self.steps(&frame),
            trial: phase(frame.controller.trial),
            trial_share: frame.controller.blend,
            unsaved: frame.controller.accepted == Kept::Unsaved,
            flying: self.flying.as_ref().map(|flying| flying.progress(frame.tick)),
            flights: self.flights.count(),
            faults: self.bench.as_ref().map_or_else(Vec::new, |bench| bench.faults.list()),
            record: self.recorder.status(),
            journal: self.journal.since(since),
        }
    }

    fn steps(&self, frame: &Frame) -> Steps {
        let armed = frame.state == ArmState::Armed;
        let only_armed = |otherwise: Option<&str>| {
            if armed { otherwise.map(str::to_owned) } else { Some("the board is not armed".to_owned()) }
        };
        let on_ground = |forbidding: Conditions| match frame.state {
            ArmState::Fault(_) => Some("clear the fault first".to_owned()),
            state if state.motors_may_turn() => Some("the motors may turn: stop first".to_owned()),
            _ if !frame.conditions.intersection(forbidding).is_empty() => {
                Some(words::conditions(frame.conditions.intersection(forbidding)))
            }
            _ => None,
        };
        let trial = frame.controller.trial;
        let arm = match frame.state {
            ArmState::Ready => None,
            ArmState::Disarmed => Some(words::conditions(frame.conditions)),
            _ => on_ground(Conditions::NONE),
        };
        let clear = match frame.state {
            ArmState::Fault(_) if frame.conditions.intersection(Conditions::HAZARDS).is_empty() => None,
            ArmState::Fault(_) => Some(words::conditions(frame.conditions.intersection(Conditions::HAZARDS))),
            _ => Some("there is no fault".to_owned()),
        };
        let in_trial = |otherwise| only_armed((trial == TrialPhase::None).then_some(otherwise));
        Steps {
            check: on_ground(Conditions::HAZARDS.union(Conditions::NO_CHECK)),
            zero: on_ground(Conditions::NONE),
            arm,
            clear,
            fly: only_armed(self.flying.as_ref().map(|_| "a scenario is being flown")),
            attempt: only_armed(
                (trial != TrialPhase::None).then_some("a trial is under way: accept it or take it back"),
            ),
            accept: only_armed((trial != TrialPhase::Flying).then_some("no trial flies alone now")),
            revert: in_trial("there is no trial to take back"),
            save: if frame.state.motors_may_turn() {
                Some("the board saves with the motors off: stop first".to_owned())
            } else {
                (frame.controller.accepted != Kept::Unsaved).then(|| "nothing is unsaved".to_owned())
            },
        }
    }

    /// The columns of the samples, and how often they come.
    #[must_use]
    pub const fn columns() -> (&'static [samples::Column], u32) {
        (&samples::TABLE, samples::EVERY)
    }
}

/// What an operator does next on the ground.
fn next(frame: &Frame) -> Option<&'static str> {
    let has = |condition| frame.conditions.contains(condition);
    match frame.state {
        ArmState::Fault(_) => Some("clear"),
        ArmState::Ready => Some("arm"),
        ArmState::Disarmed if has(Condition::NotChecked) => Some("check"),
        ArmState::Disarmed if has(Condition::NotZeroed) => Some("zero"),
        _ => None,
    }
}

const fn phase(phase: TrialPhase) -> &'static str {
    match phase {
        TrialPhase::None => "none",
        TrialPhase::Shadow => "shadow",
        TrialPhase::FadingIn => "fading in",
        TrialPhase::Flying => "flying",
        TrialPhase::FadingOut => "fading out",
    }
}

/// What became of a trial.
pub(super) const fn trial(was: TrialPhase, is: TrialPhase) -> &'static str {
    match (was, is) {
        (_, TrialPhase::Shadow) => "trial: it computes beside the accepted controller",
        (_, TrialPhase::FadingIn) => "trial: its volts fade in",
        (_, TrialPhase::Flying) => "trial: it flies alone",
        (_, TrialPhase::FadingOut) => "trial: the accepted controller takes over again",
        (TrialPhase::Flying, TrialPhase::None) => "accepted: in force until the power goes",
        (_, TrialPhase::None) => "taken back: the accepted controller flies",
    }
}
