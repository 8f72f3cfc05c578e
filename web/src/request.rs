//! What a page can ask, and how it is answered.

use crate::desk::{Choice, Desk, OWN};
use crate::lessons;
use crate::page::Page;
use crate::recorded;
use crate::same_bits;
use crate::tuner::Tuner;
use serde::Deserialize;
use serde_json::{Value, json};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::law::LawSettings;
use twinrotor::plant::presets;
use twinrotor::supervisor;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::{Error, Outcome};
use twinrotor_tune::design::CATALOGUE;

/// The paper's scenarios by name.
const SCENARIOS: [&str; 5] = ["step", "1", "2", "3", "3-square"];

/// A question or a wish.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[expect(missing_docs, reason = "each is what the desk has under the same name")]
pub enum Request {
    /// What there is to choose from.
    About,
    /// A desk anew.
    Begin(Choice),
    /// Where it stands, with what happened after the entry `since` of the journal.
    Status {
        since: u64,
    },
    Supervisor(Wanted),
    Zero,
    /// \[deg\]
    Aim {
        pitch_deg: f32,
        yaw_deg: f32,
    },
    /// One of the paper's scenarios, or the text of a scenario file.
    Fly {
        scenario: String,
        #[serde(default)]
        toml: Option<String>,
    },
    /// \[V\]
    Disturb {
        main: f32,
        tail: f32,
        gusts: bool,
    },
    /// \[V\]
    Push {
        main: f32,
        tail: f32,
    },
    /// Whether a hand steadies the rig on the ground.
    Steady(bool),
    Fault {
        name: String,
        present: bool,
    },
    /// The settings, as rows.
    Settings,
    Set {
        name: String,
        value: f64,
    },
    Draw {
        controller: String,
    },
    /// 0 is the accepted one.
    Recall {
        number: usize,
    },
    /// A gains file becomes the draft.
    Load {
        gains_toml: String,
    },
    /// The draft as a gains file.
    Export,
    Try,
    Accept,
    Revert,
    Save,
    /// Every tick is recorded from now on, or no more.
    Record(bool),
    /// A part of the record as CSV.
    Recorded {
        from: usize,
    },
    /// The last flights with their curves.
    Flights,
    /// Lessons, with how far their tasks are by what was flown.
    Lessons,
    /// A search begins.
    Tune {
        preset: String,
        seed: u64,
    },
    /// It goes on by one exchange.
    TuneOn,
    /// What became of the page's own line to a board.
    Line(Line),
    /// The hash of a long flight.
    Fingerprint {
        preset: String,
        scenario: String,
        ticks: u32,
    },
}

/// A page's own line.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Line {
    /// A board is at its end.
    Opened,
    /// Broken, and why.
    Lost(String),
    /// The simulated board is there again.
    Closed,
}

/// Of the supervisor.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[expect(missing_docs, reason = "as the core has them")]
pub enum Wanted {
    Check,
    Arm,
    Disarm,
    ClearFault,
}

impl Request {
    /// It changes nothing of what others see.
    #[must_use]
    pub const fn only_looks(&self) -> bool {
        matches!(
            self,
            Self::About
                | Self::Status { .. }
                | Self::Settings
                | Self::Export
                | Self::Flights
                | Self::Recorded { .. }
                | Self::Lessons
                | Self::Tune { .. }
                | Self::TuneOn
                | Self::Fingerprint { .. }
        )
    }

    /// It may turn a motor.
    #[must_use]
    pub const fn turns(&self) -> bool {
        matches!(self, Self::Supervisor(Wanted::Arm | Wanted::Check))
    }

    /// It is to switch the motors off.
    #[must_use]
    pub const fn stops(&self) -> bool {
        matches!(self, Self::Supervisor(Wanted::Disarm))
    }
}

/// Answers a question: `{"ok": ...}` or `{"error": "why"}`.
pub fn answer(page: &mut Page, question: &[u8]) -> Vec<u8> {
    let request = serde_json::from_slice(question).map_err(|error| Error::Unusable(error.to_string()));
    let answer = request.and_then(|request| match request {
        Request::Line(line) => {
            page.at(&line);
            Ok(Value::Null)
        }
        request => beside(&mut page.tuner, &request).unwrap_or_else(|| at_desk(&mut page.desk, request)),
    });
    worded(answer).to_string().into_bytes()
}

/// An answer as a page reads it.
#[must_use]
pub fn worded(answer: Outcome<Value>) -> Value {
    match answer {
        Ok(value) => json!({ "ok": value }),
        Err(error) => json!({ "error": error.to_string() }),
    }
}

/// Answers what needs no desk: what there is, the search. Nothing, if it is a desk's to answer.
pub fn beside(tuner: &mut Option<Tuner>, request: &Request) -> Option<Outcome<Value>> {
    Some(match request {
        Request::About => Ok(about()),
        Request::Tune { preset, seed } => Tuner::new(preset, *seed).map(|begun| {
            *tuner = Some(begun);
            Value::Null
        }),
        Request::TuneOn => match tuner {
            Some(tuner) => told(&tuner.go_on()),
            None => Err(Error::Unusable("no search has begun".to_owned())),
        },
        Request::Fingerprint { preset, scenario, ticks } => {
            same_bits::fingerprint(preset, scenario, *ticks).map(|hash| json!(format!("{hash:016x}")))
        }
        _ => return None,
    })
}

/// Answers what a desk is asked.
///
/// # Errors
///
/// What is wrong with it, in words.
pub fn at_desk(desk: &mut Desk, request: Request) -> Outcome<Value> {
    match request {
        Request::About
        | Request::Tune { .. }
        | Request::TuneOn
        | Request::Line(_)
        | Request::Fingerprint { .. } => {
            return Err(Error::Unusable("this is not asked of a desk".to_owned()));
        }
        Request::Begin(choice) => desk.begin(&choice)?,
        Request::Status { since } => return told(&desk.status(since)),
        Request::Supervisor(wanted) => desk.request(match wanted {
            Wanted::Check => supervisor::Request::Check,
            Wanted::Arm => supervisor::Request::Arm,
            Wanted::Disarm => supervisor::Request::Disarm,
            Wanted::ClearFault => supervisor::Request::ClearFault,
        }),
        Request::Zero => desk.zero(),
        Request::Aim { pitch_deg, yaw_deg } => {
            desk.aim(PerAxis::new(pitch_deg, yaw_deg).map(f32::to_radians));
        }
        Request::Fly { scenario, toml: None } => desk.fly(Scenario::named(&scenario)?)?,
        Request::Fly { scenario, toml: Some(text) } => desk.fly(Scenario::parse(&scenario, &text)?)?,
        Request::Disturb { main, tail, gusts } => desk.disturb(PerMotor::new(main, tail), gusts)?,
        Request::Push { main, tail } => desk.bench()?.push = PerMotor::new(main, tail),
        Request::Steady(steadied) => desk.bench()?.steadied = steadied,
        Request::Fault { name, present } => desk.fault(&name, present)?,
        Request::Settings => return told(&desk.tuning().document()),
        Request::Set { name, value } => desk.tuning().set(&name, value)?,
        Request::Draw { controller } => desk.draw(&controller)?,
        Request::Recall { number } => desk.tuning().recall(number)?,
        Request::Load { gains_toml } => {
            let file = GainsFile::parse("gains", &gains_toml)?;
            if let LawSettings::StateSpace(_) = file.controller.law {
                let why =
                    "a law of matrices has no settings to move here: fly it by host-sim fly --gains FILE";
                return Err(Error::Unusable(why.to_owned()));
            }
            desk.tuning().draw("a gains file", file.controller);
        }
        Request::Export => return told(&desk.tuning().to_toml()),
        Request::Try => desk.try_draft(),
        Request::Accept => desk.judge(true),
        Request::Revert => desk.judge(false),
        Request::Save => desk.save(),
        Request::Record(on) => desk.recorder.wish(on)?,
        Request::Recorded { from } => return told(&desk.recorder.part(from)),
        Request::Flights => return told(desk.flights().kept()),
        Request::Lessons => return told(&lessons::lessons(desk.flights())),
    }
    Ok(Value::Null)
}

fn told(what: &impl serde::Serialize) -> Outcome<Value> {
    serde_json::to_value(what).map_err(|error| Error::Failed(error.to_string()))
}

fn about() -> Value {
    let controllers: Vec<&str> =
        std::iter::once(OWN).chain(CATALOGUE.iter().map(|(name, _)| *name)).collect();
    let (columns, every) = Desk::columns();
    json!({
        "record_bytes": recorded::MOST_BYTES,
        "baud": twinrotor::link::BAUD,
        "version": env!("CARGO_PKG_VERSION"),
        "presets": presets::ALL.map(|(name, _)| name),
        "controllers": controllers,
        "scenarios": SCENARIOS,
        "columns": columns,
        "ticks_per_row": every,
        "gains": twinrotor::gains::NAMES,
        "bounds": twinrotor::gains::PAPER_BOUNDS,
    })
}
