//! A scenario under way, and what came of those before.

use serde::Serialize;
use std::collections::VecDeque;
use twinrotor::axes::PerAxis;
use twinrotor::controller::ControllerSettings;
use twinrotor::plant::presets::Rig;
use twinrotor::reference::Reference;
use twinrotor::sequence::Sequence;
use twinrotor::telemetry::Frame;
use twinrotor_sim::metrics::Report;
use twinrotor_sim::scenario::Scenario;
use twinrotor_station::flown::flown;
use twinrotor_station::session::Course;

/// \[rad\], \[rad/s\] What counts as level and at rest, as in a session.
const LEVEL: (f32, f32) = (0.02, 0.05);
/// \[ticks\] For how long it must be.
const STEADY: u32 = 1_000;
/// \[ticks\] After which a flight begins although it is not.
const LONGEST_RISE: u32 = 20_000;
/// \[ticks\] From one point of a curve to the next.
const DRAWN_EVERY: usize = 10;
/// How many flights are kept to be compared.
const KEPT: usize = 2;

/// Where a flight stands.
#[derive(Debug, Clone)]
enum Stage {
    /// On the way to level, begun and last not level in these ticks.
    Rising { from: u32, unsteady: u32 },
    /// Its first setpoint is said, and should be taken in this tick.
    Said(Sequence, u32),
    /// It was, in this one.
    Begun(u32),
}

/// A scenario that is being flown.
#[derive(Debug, Clone)]
pub struct Flying {
    scenario: Scenario,
    controller: (String, ControllerSettings<f64>),
    course: Course,
    stage: Stage,
    frames: Vec<Frame>,
}

/// What a flight wants done after a frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Wish {
    /// Nothing.
    Nothing,
    /// This setpoint to be said; the number of the message goes to [`Flying::said`].
    Say(Reference<f32>),
    /// It is over.
    End,
}

/// What a page shows of a flight under way.
#[derive(Debug, Serialize)]
pub struct Progress {
    scenario: String,
    rising: bool,
    /// \[s\]
    time: f64,
    /// \[s\]
    duration: f64,
}

/// A flight that was flown to its end.
#[derive(Debug, Clone, Serialize)]
pub struct Flown {
    /// Counted from 1.
    pub number: usize,
    /// What was flown.
    pub scenario: String,
    /// With what.
    pub controller: String,
    /// The same in full.
    #[serde(skip)]
    pub flew: ControllerSettings<f64>,
    /// On which rig.
    pub preset: String,
    /// In numbers, as `host-sim fly` reports a record.
    pub report: Report,
    /// Its curves: time \[s\], angles and references \[deg\], volts.
    pub curves: Curves,
}

/// Curves to be drawn over each other.
#[derive(Debug, Clone, Default, Serialize)]
#[expect(missing_docs, reason = "the names of what is drawn")]
pub struct Curves {
    pub time: Vec<f64>,
    pub pitch: Vec<f64>,
    pub yaw: Vec<f64>,
    pub pitch_reference: Vec<f64>,
    pub yaw_reference: Vec<f64>,
    pub main_volts: Vec<f64>,
    pub tail_volts: Vec<f64>,
}

impl Flying {
    /// From level, to which the rig goes first; `tick` is the board's.
    #[must_use]
    pub fn new(scenario: Scenario, controller: (String, ControllerSettings<f64>), tick: u32) -> Self {
        let course = Course::new(scenario.references());
        let stage = Stage::Rising { from: tick, unsteady: tick };
        Self { scenario, controller, course, stage, frames: Vec::new() }
    }

    /// The setpoint that was wanted last has this number.
    pub fn said(&mut self, sequence: Sequence, tick: u32) {
        if let Stage::Rising { .. } = self.stage {
            self.stage = Stage::Said(sequence, tick);
        }
    }

    /// Takes a frame of an armed board.
    pub fn hear(&mut self, frame: &Frame) -> Wish {
        let tick = frame.tick;
        match &mut self.stage {
            Stage::Rising { from, unsteady } => {
                let within = |x: PerAxis<f32>, most: f32| x.pitch.abs() < most && x.yaw.abs() < most;
                if !(within(frame.angle, LEVEL.0) && within(frame.rate, LEVEL.1)) {
                    *unsteady = tick;
                }
                let level = tick.wrapping_sub(*unsteady) >= STEADY;
                if level || tick.wrapping_sub(*from) >= LONGEST_RISE {
                    return self.course.due(0).map_or(Wish::End, Wish::Say);
                }
                return Wish::Nothing;
            }
            Stage::Said(sequence, _) => {
                if !sequence.is_newer_than(frame.taken.sequence) && frame.taken.ago < u8::MAX {
                    self.stage = Stage::Begun(tick.wrapping_sub(frame.taken.ago.into()));
                }
            }
            Stage::Begun(_) => {}
        }
        self.frames.push(*frame);
        let (Stage::Said(_, from) | Stage::Begun(from) | Stage::Rising { from, .. }) = self.stage;
        if matches!(self.stage, Stage::Begun(_)) && tick.wrapping_sub(from) >= self.course.ticks() {
            return Wish::End;
        }
        // What is said now is taken in the next tick at the earliest.
        self.course.due(tick.wrapping_add(1).wrapping_sub(from)).map_or(Wish::Nothing, Wish::Say)
    }

    /// What is flown.
    #[must_use]
    pub const fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The board's tick in which it began, once it has.
    #[must_use]
    pub const fn begun(&self) -> Option<u32> {
        match self.stage {
            Stage::Begun(from) => Some(from),
            Stage::Rising { .. } | Stage::Said(..) => None,
        }
    }

    /// How far it is at the board's `tick`.
    #[must_use]
    pub fn progress(&self, tick: u32) -> Progress {
        let begun = self.begun().map(|from| tick.wrapping_sub(from));
        Progress {
            scenario: self.scenario.name.clone(),
            rising: begun.is_none(),
            time: begun.map_or(0.0, |ticks| f64::from(ticks) * twinrotor::SAMPLE_TIME),
            duration: self.scenario.duration,
        }
    }

    /// What it came to.
    fn flown(self, number: usize, (preset, rig): (&str, &Rig)) -> Option<Flown> {
        let Self { scenario, controller, stage: Stage::Begun(from), frames, .. } = self else { return None };
        let flight = flown(&frames, from, rig, &scenario);
        let mut curves = Curves::default();
        for row in flight.rows.iter().step_by(DRAWN_EVERY) {
            curves.time.push(row.time);
            curves.pitch.push(row.state.angle.pitch.to_degrees());
            curves.yaw.push(row.state.angle.yaw.to_degrees());
            curves.pitch_reference.push(row.reference.pitch.to_degrees());
            curves.yaw_reference.push(row.reference.yaw.to_degrees());
            curves.main_volts.push(row.volts.main);
            curves.tail_volts.push(row.volts.tail);
        }
        let (controller, flew) = controller;
        let (preset, report) = (preset.to_owned(), flight.report);
        Some(Flown { number, scenario: scenario.name, controller, flew, preset, report, curves })
    }
}

/// The last flights, the latest last.
#[derive(Debug, Default)]
pub struct Flights {
    kept: VecDeque<Flown>,
    count: usize,
}

impl Flights {
    /// How many there have been.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Those that are kept.
    #[must_use]
    pub const fn kept(&self) -> &VecDeque<Flown> {
        &self.kept
    }

    /// Keeps one that is over.
    pub fn note(&mut self, flying: Flying, rig: (&str, &Rig)) {
        let Some(flown) = flying.flown(self.count + 1, rig) else { return };
        self.count += 1;
        self.kept.push_back(flown);
        if self.kept.len() > KEPT {
            self.kept.pop_front();
        }
    }
}
