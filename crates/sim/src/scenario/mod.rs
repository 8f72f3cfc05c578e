//! What is to be flown: references, for how long, what befalls the rig meanwhile, and how it begins.

mod befalls;
mod conditions;
mod course;
mod events;
mod inject;
mod ranges;

pub use befalls::{Befallen, Befalls, Change, Lowered, Now};
pub use conditions::{Hardware, Start};
pub use events::{Events, Push, Sag, Sine, Thrust, Weight};
pub use inject::Inject;

use crate::error::{Error, Outcome, at_least, known_name};
use crate::metrics::Step;
use crate::{Read, is_text, toml};
use course::Course;
use serde::Deserialize;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::trajectory::{Profile, Trajectory, ticks};

pub use twinrotor::SAMPLE_TIME;

/// Longest flight \[s\]: a day would fill the memory with rows.
const LONGEST: f64 = 3_600.0;

/// What a scenario's references are.
#[derive(Debug, Clone, PartialEq)]
enum Source {
    Step,
    Sine,
    SquareYaw,
    SquarePitch,
    File(PerAxis<Course>),
}

/// Something to fly.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Its name, or the path of its file.
    pub name: String,
    source: Source,
    /// \[s\] How long.
    pub duration: f64,
    /// What is added to the volts in effect, at random.
    pub disturbance: Option<Disturbance>,
    /// What befalls the rig at chosen times.
    pub events: Events,
    /// How it begins.
    pub start: Start,
    /// How good the rig's hardware is.
    pub hardware: Hardware,
    /// What befalls a rig that a board simulates: none but such a board can fly it.
    pub inject: Vec<Inject>,
}

/// Random volts added to what acts on each motor: uniform within ±volts, a new value every `hold`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// \[V\] Amplitude, at least 0.
    pub volts: f64,
    /// \[s\] How long a value holds, above 0.
    pub hold: f64,
    /// \[s\] From when to when; before and after there is none.
    pub window: [f64; 2],
}

/// The disturbance of scenario 3, eqs (38)-(39): for 20 s. The paper gives neither amplitude nor hold time.
const SCENARIO_3: Disturbance = Disturbance { volts: 2.0, hold: 0.1, window: [0.0, 20.0] };

impl Scenario {
    /// One of the paper's by name, or from the text of that name (anything that ends in `.toml`), for whoever
    /// cannot have anything injected.
    ///
    /// # Errors
    ///
    /// If there is none, or the text is not one of a scenario that can be flown, or it injects something.
    pub fn load(name: &str, read: Read<'_>) -> Outcome<Self> {
        let scenario = Self::load_to_inject(name, read)?;
        if !scenario.inject.is_empty() {
            let why = "inject befalls a rig that a board simulates, and no board flies here";
            return Err(Error::Unusable(why.to_owned()).within(name));
        }
        Ok(scenario)
    }

    /// The same for a board that simulates its rig, which may have something injected.
    ///
    /// # Errors
    ///
    /// If there is none, or the text is not one of a scenario that can be flown.
    pub fn load_to_inject(name: &str, read: Read<'_>) -> Outcome<Self> {
        if is_text(name) {
            return Self::parse(name, &read(name)?);
        }
        Self::named(name)
    }

    /// One of the paper's: `step`, `1`, `2`, `3`, `3-square`.
    ///
    /// # Errors
    ///
    /// If there is none of that name.
    pub fn named(name: &str) -> Outcome<Self> {
        let of = |source, duration, disturbance| (source, duration, disturbance);
        let known = [
            ("step", of(Source::Step, 5.0, None)),
            ("1", of(Source::Sine, 40.0, None)),
            ("2", of(Source::SquareYaw, 40.0, None)),
            ("3", of(Source::Sine, 40.0, Some(SCENARIO_3))),
            ("3-square", of(Source::SquarePitch, 40.0, Some(SCENARIO_3))),
        ];
        let (source, duration, disturbance) = known_name("scenario", name, &known)?.clone();
        Ok(Self {
            name: name.to_owned(),
            source,
            duration,
            disturbance,
            events: Events::default(),
            start: Start::default(),
            hardware: Hardware::default(),
            inject: Vec::new(),
        })
    }

    /// From the text of a scenario file, called `path` in what is said of it.
    ///
    /// # Errors
    ///
    /// If it is not one of a scenario that can be flown.
    pub fn parse(path: &str, text: &str) -> Outcome<Self> {
        let file: File = toml::parse(path, text)?;
        let in_file = |e: Error| e.within(path);
        file.pitch.validate("pitch").map_err(in_file)?;
        file.yaw.validate("yaw").map_err(in_file)?;
        let scenario = Self {
            name: path.to_owned(),
            source: Source::File(PerAxis::new(file.pitch, file.yaw)),
            duration: file.duration,
            disturbance: file.disturbance,
            events: file.events,
            start: file.start,
            hardware: file.hardware,
            inject: file.inject,
        };
        scenario.validate().map_err(in_file)?;
        Ok(scenario)
    }

    /// Is all of it usable, but for the references?
    ///
    /// # Errors
    ///
    /// If not: which number, and what is allowed.
    pub fn validate(&self) -> Outcome<()> {
        at_least("duration", self.duration, 0.0, true)?;
        if self.duration > LONGEST {
            return Err(Error::invalid("duration", self.duration, format_args!("at most {LONGEST} s")));
        }
        if self.duration < SAMPLE_TIME {
            let allowed = format_args!("at least one tick of {SAMPLE_TIME} s");
            return Err(Error::invalid("duration", self.duration, allowed));
        }
        self.events.validate()?;
        self.start.validate()?;
        self.hardware.validate()?;
        if let Some(late) = self.inject.iter().find(|inject| inject.seconds >= self.duration) {
            let allowed = format_args!("before the scenario's end at {} s", self.duration);
            return Err(Error::invalid("inject", late.seconds, allowed));
        }
        let Some(d) = self.disturbance else { return Ok(()) };
        at_least("disturbance", d.volts, 0.0, false)?;
        at_least("hold", d.hold, 0.0, true)?;
        at_least("window's start", d.window[0], 0.0, false)?;
        at_least("window's end", d.window[1], d.window[0], false)?;
        Ok(())
    }

    /// Does nothing befall the rig, and is its hardware sound?
    pub fn is_undisturbed(&self) -> bool {
        self.disturbance.is_none() && self.events == Events::default() && self.hardware == Hardware::default()
    }

    /// The same references, and nothing that befalls the rig.
    #[must_use]
    pub fn undisturbed(self) -> Self {
        Self {
            disturbance: None,
            events: Events::default(),
            hardware: Hardware::default(),
            start: Start::default(),
            ..self
        }
    }

    /// What of it the paper's world does not have: its hardware is ideal, and it has no supply.
    pub fn of_the_rigs_world(&self) -> Option<&'static str> {
        if self.hardware != Hardware::default() {
            return Some("hardware");
        }
        if !self.events.supply.is_empty() {
            return Some("events.supply");
        }
        if self.start.rotors() != PerMotor::zero() {
            return Some("start.rotor_volts");
        }
        self.start.hot.then_some("start.hot")
    }

    /// The last tick; the flight has one more.
    pub fn last_tick(&self) -> u32 {
        ticks(self.duration, SAMPLE_TIME)
    }

    /// The references in the arithmetic `R`.
    pub fn trajectory<R: Real<Scalar = R>>(&self) -> Trajectory<R> {
        match &self.source {
            Source::Step => Trajectory::paper_step(),
            Source::Sine => Trajectory::paper_sine(SAMPLE_TIME),
            Source::SquareYaw => Trajectory::paper_square_yaw(SAMPLE_TIME),
            Source::SquarePitch => Trajectory::paper_square_pitch(SAMPLE_TIME),
            Source::File(paths) => PerAxis { pitch: paths.pitch.profile(), yaw: paths.yaw.profile() },
        }
    }

    /// The reference of every tick.
    pub fn references<R: Real<Scalar = R>>(&self) -> Vec<Reference<R>> {
        let trajectory = self.trajectory::<R>();
        (0..=self.last_tick()).map(|tick| trajectory.at(tick)).collect()
    }

    /// What is added to the volts in effect in every tick \[V\].
    pub fn disturbances<R: Real<Scalar = R>>(&self, seed: u64) -> Vec<PerMotor<R>> {
        self.befalls(seed).take(self.last_tick() as usize + 1).map(|now| now.volts.cast()).collect()
    }

    /// The last step of each axis' reference, for a start at `initial` \[rad\].
    pub fn steps(&self, initial: PerAxis<f64>) -> PerAxis<Option<Step>> {
        let last = self.last_tick();
        let trajectory = self.trajectory::<f64>();
        let of = |profile: &Profile<f64>, initial: f64| {
            let Profile::Steps { .. } = profile else { return None };
            let angle = |tick: u32| profile.at(tick)[0];
            let change = |tick: u32| if tick == 0 { initial } else { angle(tick - 1) };
            (0..last)
                .rev()
                .map(|tick| Step { tick, from: change(tick), to: angle(tick) })
                .find(|step| (step.from - step.to).abs() > 0.0)
        };
        PerAxis { pitch: of(&trajectory.pitch, initial.pitch), yaw: of(&trajectory.yaw, initial.yaw) }
    }
}

/// A scenario file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    duration: f64,
    pitch: Course,
    yaw: Course,
    disturbance: Option<Disturbance>,
    #[serde(default)]
    events: Events,
    #[serde(default)]
    start: Start,
    #[serde(default)]
    hardware: Hardware,
    #[serde(default)]
    inject: Vec<Inject>,
}

#[cfg(test)]
mod tests;
