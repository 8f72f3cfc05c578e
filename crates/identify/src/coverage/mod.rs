//! Do intervals hold what they claim? Rigs drawn around a preset fly, each gives a log, each log is
//! identified, and it is counted how often a constant's interval holds the truth.
//!
//! What is done for one rig is a pure function of the study and the rig's number, so rigs can be computed in
//! any order, on any machine ([`Study::verdicts`], [`Study::encode`], [`Study::decode`]).

mod tally;

pub use tally::{Coverage, Failed, Report};

use super::constants::{CONSTANTS, COUNT, from_array, to_array};
use super::identification::Question;
use super::log::{Columns, Log};
use serde::{Deserialize, Serialize};
use std::ops::{ControlFlow, Range};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor_sim::flight::{Fidelity, LOG_COLUMNS, Plan, Scalar, fly};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::rig;
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::table::Table;
use twinrotor_sim::{Error, Outcome};
use twinrotor_tune::checkpoint::{self, Identity};
use twinrotor_tune::parallel::{self, Stop};
use twinrotor_tune::robust::{Scatter, draw_within};

/// The flight that docs/identify.md records: steps of both axes in turn, of several sizes.
pub const EXCITATION: &str = "\
duration = 30.0
[pitch.steps]
jumps = [[1, 20], [7, -15], [13, 10], [19, 25], [25, 0]]
[yaw.steps]
jumps = [[4, 60], [10, -30], [16, 40], [22, 0]]
";
/// Most rigs of a study.
pub const MOST_RIGS: usize = 100_000;

/// One constant of one rig.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// As the rig had it.
    pub truth: f64,
    /// As it was found.
    pub value: f64,
    /// The interval that is printed, if one is.
    pub ci95: Option<[f64; 2]>,
    /// Is it narrower than the value?
    pub identifiable: bool,
    /// Was it found at the bound that physics sets?
    pub at_bound: bool,
}

/// What became of a rig: its constants in the order of [`Question::free`], or why there are none.
pub type Verdict = Result<Vec<Estimate>, String>;

/// Rigs around a preset, and what is done with each.
#[derive(Debug, Clone)]
pub struct Study {
    question: Question,
    settings: Settings<f64>,
    scenario: Scenario,
    scatter: Scatter,
    truths: Vec<Rig>,
    identity: Identity,
}

impl Study {
    /// `count` rigs within `scatter` of the question's preset, as the robust objective draws them. A constant
    /// that is not fitted is the preset's in truth as well: angles and volts give only ratios to inertias. A
    /// controller of these `gains` that believes the preset flies `scenario` on each.
    ///
    /// # Errors
    ///
    /// Which of them cannot be, and what is allowed.
    pub fn new(
        question: Question,
        gains: &GainsFile,
        scenario: Scenario,
        count: usize,
        scatter: Scatter,
    ) -> Outcome<Self> {
        if !(1..=MOST_RIGS).contains(&count) {
            return Err(Error::invalid("rigs", count, format!("1 to {MOST_RIGS}")));
        }
        scatter.validate()?;
        let nominal = question.preset().rig;
        let seed = question.effort().seed;
        let true_rig = |drawn: [f64; COUNT]| {
            let mut values = to_array(&nominal.plant);
            question.free().iter().for_each(|k| values[*k] = drawn[*k]);
            Rig { plant: from_array(&values), ..nominal }
        };
        let truths: Vec<Rig> = draw_within(&nominal, count, seed, &scatter)
            .into_iter()
            .map(|draw| true_rig(to_array(&draw.plant)))
            .collect();
        let identity = Identity::new()
            .with("version", env!("CARGO_PKG_VERSION"))
            .with("preset", &question.preset().name)
            .with_toml(&rig::to_toml(&nominal));
        let identity = question
            .identify(identity)
            .with("rigs", count)
            .with("spread", scatter.constants)
            .with("lag spread", scatter.lag)
            .with("gains", gains.to_toml())
            .with("scenario", format!("{scenario:?}"));
        let settings = gains.settings(&nominal);
        Ok(Self { question, settings, scenario, scatter, truths, identity })
    }

    /// How many rigs.
    pub fn count(&self) -> usize {
        self.truths.len()
    }

    /// What became of these rigs, in their order, however many threads there are; none if `stop` ends it.
    /// `seen` is called after each.
    pub fn verdicts(
        &self,
        rigs: Range<usize>,
        stop: Stop<'_>,
        seen: &(dyn Fn() + Sync),
    ) -> Option<Vec<Verdict>> {
        let rigs: Vec<usize> = rigs.collect();
        parallel::try_map(&rigs, |number| {
            let verdict = self.verdict(*number, stop)?;
            seen();
            Some(verdict)
        })
    }

    /// What became of one; none if `stop` ends it.
    fn verdict(&self, number: usize, stop: Stop<'_>) -> Option<Verdict> {
        let truth = &self.truths[number];
        let evidence = self.log(number).and_then(|log| {
            let question = self.question.clone().with_seed(self.seed_of(number));
            question.put_to(vec![log], Vec::new())
        });
        let evidence = match evidence {
            Ok(evidence) => evidence,
            Err(why) => return Some(Err(why.to_string())),
        };
        let go_on =
            |_: &_, _: &str, _| if stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let answer = match evidence.solve(stop, go_on) {
            Ok(ControlFlow::Continue(answer)) => answer,
            Ok(ControlFlow::Break(())) => return None,
            Err(why) => return Some(Err(why.to_string())),
        };
        let truth = to_array(&truth.plant);
        let estimate = |(k, found): (&usize, &super::Parameter)| Estimate {
            truth: truth[*k],
            value: found.value,
            ci95: found.ci95,
            identifiable: found.identifiable,
            at_bound: found.at_bound,
        };
        Some(Ok(evidence.free().iter().zip(&answer.parameters).map(estimate).collect()))
    }

    /// What a logger on that rig would have written, read as `identify` reads it.
    fn log(&self, number: usize) -> Outcome<Log> {
        let rig = &self.question.preset().rig;
        let plan = Plan {
            rig,
            truth: &self.truths[number],
            settings: &self.settings,
            scenario: &self.scenario,
            initial: self.scenario.start.angle(),
            fidelity: Fidelity::Rig,
            seed: self.seed_of(number),
        };
        let flight = fly(&plan, Scalar::F32)?;
        if let Some(moment) = flight.left_envelope {
            return Err(Error::Failed(format!("left the envelope at {} s", moment.time)));
        }
        if let Some(board) = flight.board.filter(|board| board.state != "armed") {
            let why = board.condition.map_or_else(String::new, |condition| format!(": {condition:?}"));
            return Err(Error::Failed(format!("ended in {}{why}", board.state)));
        }
        let text = Table::of_flight(&flight.rows, &LOG_COLUMNS).to_csv();
        Log::read("log", text.as_bytes(), &Columns::parse("")?, rig)
    }

    /// Of a rig's encoder phase and of its search.
    fn seed_of(&self, number: usize) -> u64 {
        self.question.effort().seed.wrapping_add(number as u64)
    }

    /// Verdicts from rig `first` on, for [`Study::decode`].
    pub fn encode(&self, first: usize, verdicts: &[Verdict]) -> Vec<u8> {
        checkpoint::encode(&self.identity, &(first, verdicts))
    }

    /// What [`Study::encode`] wrote of this study: the first rig's number, and the verdicts.
    ///
    /// # Errors
    ///
    /// If the bytes are damaged, of another version or of another study.
    pub fn decode(&self, bytes: &[u8]) -> Outcome<(usize, Vec<Verdict>)> {
        let (first, verdicts): (usize, Vec<Verdict>) = checkpoint::decode(bytes, &self.identity)?;
        let constants = self.question.free().len();
        let sound = first.checked_add(verdicts.len()).is_some_and(|end| end <= self.count())
            && verdicts.iter().flatten().all(|estimates| estimates.len() == constants);
        if sound { Ok((first, verdicts)) } else { Err(checkpoint::damaged()) }
    }

    /// What is said of the study, from the verdicts on all of its rigs.
    pub fn report(&self, verdicts: &[Verdict]) -> Report {
        let constants: Vec<_> = self.question.free().iter().map(|k| &CONSTANTS[*k]).collect();
        Report {
            preset: self.question.preset().name.clone(),
            scenario: self.scenario.name.clone(),
            seed: self.question.effort().seed,
            rigs: verdicts.len(),
            spread: self.scatter.constants,
            lag_spread: self.scatter.lag,
            failures: tally::failures(verdicts),
            constants: tally::constants(&constants, verdicts),
        }
    }
}

#[cfg(test)]
mod tests;
