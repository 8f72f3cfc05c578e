//! What is asked of `tune` whatever is minimised, resolved, and a search driven so.

use super::{Goal, Shared};
use crate::cli::common::{End, bar, within};
use crate::cli::print;
use crate::device::Found;
use crate::error::{Failure, Outcome};
use crate::files::checkpoint::Keeper;
use crate::files::output::Outputs;
use crate::stop;
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use twinrotor_sim::error::{at_least, known_name};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::rig::{self, NamedRig};
use twinrotor_tune::checkpoint::Identity;
use twinrotor_tune::optimise::{ALGORITHMS, MOST_EVALUATIONS, Searcher, Setup};
use twinrotor_tune::search::{Problem, Search};

/// How a search goes that says nothing of it.
struct Usual {
    algorithm: &'static str,
    population: Option<usize>,
    iterations: usize,
}

/// The paper's.
const INTEGRAL: Usual = Usual { algorithm: "fpa-paper", population: None, iterations: 30 };
/// That of the committed gains (`scripts/tune-defaults.sh`): 1,000 evaluations a round.
const ROBUST: Usual = Usual { algorithm: "fpa-adaptive", population: Some(25), iterations: 39 };

/// The shared flags, resolved.
pub(super) struct Request<'a> {
    pub(super) named: NamedRig,
    pub(super) setup: Setup,
    pub(super) algorithm: &'a str,
    pub(super) seed: u64,
    pub(super) json: bool,
    pub(super) out: &'a Path,
    pub(super) begun: Instant,
    /// What flies.
    pub(super) found: Found,
    /// What is read and written.
    pub(super) outputs: RefCell<Outputs>,
    /// The checkpoint, once it is written.
    kept: RefCell<Option<PathBuf>>,
    shared: &'a Shared,
    time_limit: Option<Duration>,
}

impl<'a> Request<'a> {
    /// Refuses, before any work is done, what could not be searched or written; `inputs` are the files that
    /// other flags name.
    pub(super) fn new(shared: &'a Shared, inputs: &[(&str, &str)]) -> Outcome<Self> {
        let begun = Instant::now();
        let named = shared.common.resolve()?;
        let usual = if shared.objective == Goal::Robust { &ROBUST } else { &INTEGRAL };
        let algorithm = shared.algorithm.as_deref().unwrap_or(usual.algorithm);
        let population = shared.population.or(usual.population.filter(|_| algorithm == usual.algorithm));
        let each = population.unwrap_or(50);
        let iterations = shared.iterations.unwrap_or(if population == usual.population {
            usual.iterations
        } else {
            INTEGRAL.iterations
        });
        let setup = Setup {
            algorithm: *known_name("algorithm", algorithm, &ALGORITHMS)?,
            population,
            evaluations: each.saturating_mul(iterations.saturating_add(1)),
        };
        Setup { evaluations: 1, ..setup }.validate().map_err(Failure::of_flag)?;
        within("--iterations", iterations, 0, MOST_EVALUATIONS / each - 1)?;
        let mut outputs = shared.common.outputs();
        inputs.iter().for_each(|(flag, path)| outputs.reads(flag, path));
        outputs.writes("--out", &shared.out)?;
        shared.checkpoint.check(&mut outputs)?;
        let time_limit = match shared.time_limit {
            Some(limit) => Some(Duration::try_from_secs_f64(at_least("--time-limit", limit, 0.0, true)?)),
            None => None,
        };
        let time_limit = time_limit.transpose().map_err(|e| Failure::Input(format!("--time-limit: {e}")))?;
        Ok(Self {
            found: shared.device.find()?,
            named,
            setup,
            algorithm,
            seed: shared.common.seed,
            json: shared.common.json,
            out: &shared.out,
            begun,
            outputs: RefCell::new(outputs),
            kept: RefCell::default(),
            shared,
            time_limit,
        })
    }

    /// Another lag of the rotors than the preset's.
    pub(super) fn rotor_lag(&self) -> Option<f64> {
        self.shared.common.rotor_lag
    }

    /// What a board flies the preset with, and what that is called; a rig of one's own has none.
    pub(super) fn own(&self) -> Option<(String, GainsFile)> {
        let name = &self.named.name;
        let controller = twinrotor::defaults::named(name)?;
        Some((format!("gains/{name}.toml"), GainsFile { controller, provenance: None }))
    }

    /// About how many candidates fly at once.
    pub(super) fn generation(&self) -> usize {
        self.setup.population.unwrap_or(50)
    }

    /// What decides the outcome, whatever is minimised.
    pub(super) fn identity(&self) -> Identity {
        Identity::new()
            .with("preset", &self.named.name)
            .with_toml(&rig::to_toml(&self.named.rig))
            .with("algorithm", self.algorithm)
            .with("population", self.setup.population.map_or_else(|| "usual".to_owned(), |n| n.to_string()))
            .with("evaluations", self.setup.evaluations)
            .with("seed", self.seed)
    }

    /// A search at its beginning, or where its checkpoint left it.
    pub(super) fn begin(&self, identity: Identity, searcher: Searcher) -> Outcome<Search> {
        let begun = Search::new(identity, searcher);
        self.shared.checkpoint.resume_or(begun, |begun, bytes| begun.resume(bytes))
    }

    /// Drives a search to its end, with a bar on a terminal; `search` is as far as it came.
    pub(super) fn drive(&self, problem: &dyn Problem, search: &mut Search) -> End {
        let bar = bar(search.budget(), "{prefix} {bar:32} {pos}/{len} evaluations, best {msg}, {eta} left");
        bar.set_prefix(self.algorithm.to_owned());
        let (begun, keeper) = (Instant::now(), Keeper::new(self.shared.checkpoint.file.as_deref()));
        let limit = self.time_limit;
        let late = || limit.is_some_and(|limit| begun.elapsed() >= limit);
        let end = search.run(problem, &|| stop::requested() || late(), |search| {
            bar.set_position(search.evaluations() as u64);
            bar.set_message(format!("{:.6}", search.cost()));
            keeper.keep(|| search.checkpoint());
            if stop::requested() {
                return ControlFlow::Break(End::Interrupted);
            }
            if self.found.failure().is_some() {
                return ControlFlow::Break(End::Device);
            }
            if late() { ControlFlow::Break(End::TimeLimit) } else { ControlFlow::Continue(()) }
        });
        bar.finish_and_clear();
        keeper.keep_now(|| search.checkpoint());
        self.kept.replace(keeper.done(&mut self.outputs.borrow_mut()));
        end.break_value().unwrap_or(End::Complete)
    }

    /// Why a search ended without anything to show.
    pub(super) fn nothing(&self, end: End) -> Failure {
        match end {
            End::Complete => Failure::Run("no candidate flew to the end; nothing is written".to_owned()),
            End::TimeLimit => Failure::Run(
                "--time-limit came before the first candidate had flown to the end; no gains are written"
                    .to_owned(),
            ),
            End::Interrupted => {
                Failure::Interrupted(format!("no candidate had flown to the end yet{}", self.go_on()))
            }
            End::Device => Failure::Run(format!(
                "{}; no candidate had flown to the end yet{}",
                self.found.failure().unwrap_or_default(),
                self.go_on()
            )),
        }
    }

    /// What a search that was interrupted, or whose device has failed, has left.
    pub(super) fn broken_off(&self, search: &Search) -> Failure {
        let left = format!(
            "the best of {} evaluations, with cost {:.6}, is in {}{}",
            search.evaluations(),
            search.cost(),
            self.out.display(),
            self.go_on()
        );
        match self.found.failure() {
            Some(why) => Failure::Run(format!("{why}; {left}")),
            None => Failure::Interrupted(left),
        }
    }

    fn go_on(&self) -> String {
        let told = |path: &PathBuf| format!("; --checkpoint {} --resume goes on", path.display());
        self.kept.borrow().as_ref().map_or_else(String::new, told)
    }
}

/// The end of a search that was broken off, after what was found is written.
pub(super) fn left(request: &Request<'_>, search: &Search, outputs: Outputs) -> Outcome<()> {
    if !request.json {
        print(&outputs.unwritten())?;
    }
    outputs.done()?;
    Err(request.broken_off(search))
}
