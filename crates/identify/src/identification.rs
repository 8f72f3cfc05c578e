//! From logs to a rig, in the order in which it is done: what was asked, what the logs are worth, the search,
//! and what it found. The command line, the Python package and the study of [`super::coverage`] all go this
//! way.

use super::constants::{CONSTANTS, chosen};
use super::doubts::doubts;
use super::fit::Fit;
use super::interval::Precision;
use super::log::Log;
use super::problem::{Guess, Problem};
use super::search::{Effort, Search};
use super::windows::{Run, Window};
use super::{
    Parameter, THRESHOLD, distinct, fits, hold_measured_lags, identified, offset_of, parameters, tachometer,
    training_windows,
};
use serde::Serialize;
use std::ops::ControlFlow;
use twinrotor::plant::presets::Rig;
use twinrotor_sim::error::at_least;
use twinrotor_sim::rig::{self, NamedRig};
use twinrotor_sim::{Error, Outcome};
use twinrotor_tune::checkpoint::Identity;
use twinrotor_tune::parallel::Stop;

/// What is asked of logs.
#[derive(Debug, Clone)]
pub struct Question {
    /// What is known of the rig before.
    preset: NamedRig,
    /// Which constants are fitted.
    free: Vec<usize>,
    /// Those that were freed by name.
    freed: Vec<String>,
    /// \[s\] How long the windows are.
    window: f64,
    /// How much is searched.
    effort: Effort,
}

impl Question {
    /// The usual constants of `preset`, those of `freed`, and not those of `fixed`, by windows of `window`
    /// \[s\].
    ///
    /// # Errors
    ///
    /// Which of them cannot be, and what is allowed.
    pub fn new(
        preset: NamedRig,
        freed: &[String],
        fixed: &[String],
        window: f64,
        effort: Effort,
    ) -> Outcome<Self> {
        let whole = |field: &str, value: usize, least: usize, most: usize| {
            let allowed = format!("{least} to {most}");
            let wrong = Error::invalid(field, value, allowed);
            if (least..=most).contains(&value) { Ok(()) } else { Err(wrong) }
        };
        whole("population", effort.population, 2, 10_000)?;
        whole("iterations", effort.iterations, 0, 100_000)?;
        let window = at_least("window", window, 0.2, false)?;
        Ok(Self { preset, free: chosen(freed, fixed)?, freed: freed.to_vec(), window, effort })
    }

    /// What is known of the rig before.
    pub fn preset(&self) -> &NamedRig {
        &self.preset
    }

    /// Which constants are fitted, by their place in [`CONSTANTS`].
    pub fn free(&self) -> &[usize] {
        &self.free
    }

    /// How much is searched.
    pub fn effort(&self) -> Effort {
        self.effort
    }

    /// The same with everything random from `seed`.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.effort.seed = seed;
        self
    }

    /// What a run is, with all that is asked.
    pub(super) fn identify(&self, identity: Identity) -> Identity {
        let free: Vec<&str> = self.free.iter().map(|k| CONSTANTS[*k].name).collect();
        identity
            .with("free constants", free.join(","))
            .with("window", self.window)
            .with("population", self.effort.population)
            .with("iterations", self.effort.iterations)
            .with("seed", self.effort.seed)
    }

    /// The logs that decide it, and others that are only compared.
    ///
    /// # Errors
    ///
    /// If nothing can be learnt from them.
    pub fn put_to(mut self, logs: Vec<Log>, others: Vec<Log>) -> Outcome<Evidence> {
        if logs.is_empty() {
            return Err(Error::invalid("logs", "empty", "at least one log"));
        }
        let mut notes: Vec<String> = logs
            .iter()
            .chain(&others)
            .flat_map(|log| log.notes.iter().map(|note| format!("{}: {note}", log.name)))
            .collect();
        let others: Vec<Run> = others.into_iter().map(Run::new).collect();
        let (runs, repeated) = distinct(logs.into_iter().map(Run::new).collect(), &others);
        notes.extend(repeated);
        tachometer::check(&runs)?;
        let plant = &mut self.preset.rig.plant;
        notes.extend(doubts(&runs, plant));
        let measured = hold_measured_lags(&runs, plant, &mut self.free, &self.freed);
        notes.extend(
            measured.iter().map(|p| format!("{} is taken from the tachometers (free it to fit it)", p.name)),
        );
        let windows = training_windows(&runs, self.window)?;
        Ok(Evidence { question: self, runs, others, windows, measured, notes })
    }
}

/// Logs that were looked at, ready to be fitted.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// With the lags that tachometers show held.
    question: Question,
    /// What is fitted to.
    pub runs: Vec<Run>,
    /// What is only compared.
    others: Vec<Run>,
    windows: Vec<Window>,
    /// Read from tachometers.
    measured: Vec<Parameter>,
    /// What was mended, what is held and what is doubtful.
    pub notes: Vec<String>,
}

impl Evidence {
    /// Which constants are fitted, by their place in [`CONSTANTS`].
    pub fn free(&self) -> &[usize] {
        &self.question.free
    }

    /// Into how many windows the logs are cut.
    pub fn windows(&self) -> usize {
        self.windows.len()
    }

    /// The least squares.
    pub fn problem(&self) -> Problem<'_> {
        let Question { preset, free, .. } = &self.question;
        Problem::new(&self.runs, self.windows.clone(), &preset.rig.plant, free, THRESHOLD)
    }

    /// The search of `problem`, which has not begun. It knows its checkpoints by all that decides what comes
    /// out; how `columns` of the logs were named is told with it.
    pub fn search(&self, problem: &Problem<'_>, columns: &str) -> Search {
        let Question { preset, effort, .. } = &self.question;
        let logs: Vec<String> =
            self.runs.iter().map(|r| format!("{} {:08x}", r.log.name, r.log.checksum())).collect();
        let identity = Identity::new()
            .with("preset", &preset.name)
            .with_toml(&rig::to_toml(&preset.rig))
            .with("log", logs.join(", "))
            .with("columns", columns);
        let identity = self.question.identify(identity);
        Search::new(identity, problem, &preset.rig.plant, *effort)
    }

    /// Searches as [`Search::run`] does.
    ///
    /// # Errors
    ///
    /// If the logs have no windows short enough to begin with.
    pub fn drive<B>(
        &self,
        search: &mut Search,
        problem: &Problem<'_>,
        stop: Stop<'_>,
        after: impl FnMut(&Search, &str, f64) -> ControlFlow<B>,
    ) -> Outcome<ControlFlow<B>> {
        search.run(problem, self.question.window, stop, after)
    }

    /// What the search has found.
    ///
    /// # Errors
    ///
    /// If it has found nothing, or a rig that cannot be, with what was found odd about the logs: that may be
    /// why.
    pub fn answer(&self, search: &Search, problem: &Problem<'_>) -> Outcome<Answer> {
        let nothing = || Error::Failed("no descent came to an end".to_owned());
        let (found, cost) = search.best().cloned().ok_or_else(nothing)?;
        let plant = problem.plant(&found.values);
        let rig = identified(&self.question.preset.rig, plant, &self.runs).map_err(|error| {
            let told: Vec<String> = self.notes.iter().map(|note| format!("; note: {note}")).collect();
            Error::Failed(format!("{error}{}", told.concat()))
        })?;
        let (parameters, known) = parameters(problem, &found);
        Ok(Answer { rig, found, cost, descents: search.descents(), parameters, known })
    }

    /// The whole of it at once, from the first guess to the answer, unless `after` breaks it off.
    ///
    /// # Errors
    ///
    /// As [`Evidence::drive`] and [`Evidence::answer`].
    pub fn solve<B>(
        &self,
        stop: Stop<'_>,
        after: impl FnMut(&Search, &str, f64) -> ControlFlow<B>,
    ) -> Outcome<ControlFlow<B, Answer>> {
        let problem = self.problem();
        let mut search = self.search(&problem, "");
        Ok(match self.drive(&mut search, &problem, stop, after)? {
            ControlFlow::Break(why) => ControlFlow::Break(why),
            ControlFlow::Continue(()) => ControlFlow::Continue(self.answer(&search, &problem)?),
        })
    }

    /// Every log with its pitch offset \[rad\] and whether constants were fitted to it.
    pub fn compared(&self, answer: &Answer) -> Vec<(&Run, f64, Role)> {
        let trained = self.runs.iter().zip(&answer.found.offsets).map(|(run, o)| (run, *o, Role::Train));
        let offset = |run| offset_of(run, &answer.rig.plant, self.question.window);
        trained.chain(self.others.iter().map(|run| (run, offset(run), Role::Validate))).collect()
    }

    /// What is said of an answer and of all logs, `compared` with it.
    pub fn report(&self, answer: &Answer, compared: &[(&Run, f64, Role)]) -> Report {
        let Question { preset, window, effort, .. } = &self.question;
        let of_log = |(run, offset, role): &(&Run, f64, Role)| {
            let named =
                |fit| LogFit { log: run.log.name.clone(), role: *role, offset_deg: offset.to_degrees(), fit };
            fits(run, &answer.rig.plant, *offset).into_iter().map(named).collect::<Vec<_>>()
        };
        Report {
            course: Course {
                preset: preset.name.clone(),
                seed: effort.seed,
                windows: self.windows.len(),
                window_s: *window,
                cost: answer.cost,
                descents: answer.descents.clone(),
            },
            findings: Findings {
                parameters: answer.parameters.iter().chain(&self.measured).cloned().collect(),
                fits: compared.iter().flat_map(of_log).collect(),
                notes: self.notes.clone(),
            },
        }
    }
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Answer {
    /// The preset with the constants that were found.
    pub rig: Rig,
    /// The best guess.
    pub found: Guess,
    /// Its.
    pub cost: f64,
    /// Where every descent ended: costs, in the order regression, preset, search.
    pub descents: Vec<f64>,
    /// Those that were fitted, in the order of [`Evidence::free`].
    pub parameters: Vec<Parameter>,
    /// How well they are known.
    pub known: Precision,
}

/// Were constants fitted to a log, or was it kept out?
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// They were.
    Train,
    /// It was.
    Validate,
}

impl Role {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Validate => "validate",
        }
    }
}

/// How well a log is explained.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogFit {
    /// Which.
    pub log: String,
    /// Were constants fitted to it?
    pub role: Role,
    /// What its pitch reads too little.
    pub offset_deg: f64,
    /// With windows of one length.
    #[serde(flatten)]
    pub fit: Fit,
}

/// How it was searched.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Course {
    /// What was known before.
    pub preset: String,
    /// Of everything random.
    pub seed: u64,
    /// How many were fitted.
    pub windows: usize,
    /// Their length.
    pub window_s: f64,
    /// The best.
    pub cost: f64,
    /// Where every descent ended.
    pub descents: Vec<f64>,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Findings {
    /// Fitted ones, and those that tachometers show.
    pub parameters: Vec<Parameter>,
    /// Of every log, with every length of window.
    pub fits: Vec<LogFit>,
    /// What was mended, what is held and what is doubtful.
    pub notes: Vec<String>,
}

/// What is said of an identification.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// How it was searched.
    #[serde(flatten)]
    pub course: Course,
    /// What came of it.
    #[serde(flatten)]
    pub findings: Findings,
}
