//! What is asked of `tune` whatever is minimised, resolved, and a search driven so.

use super::Shared;
use crate::cli::common::{End, bar};
use crate::error::{Failure, Outcome};
use crate::files::checkpoint::Keeper;
use crate::files::output;
use crate::stop;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};
use twinrotor_sim::error::{at_least, known_name};
use twinrotor_sim::rig::NamedRig;
use twinrotor_tune::optimise::{ALGORITHMS, Searcher, Setup};
use twinrotor_tune::search::{Problem, Search};

/// The shared flags, resolved.
pub(super) struct Request<'a> {
    pub(super) named: NamedRig,
    pub(super) setup: Setup,
    pub(super) algorithm: &'a str,
    pub(super) seed: u64,
    pub(super) json: bool,
    pub(super) out: &'a Path,
    pub(super) begun: Instant,
    shared: &'a Shared,
    time_limit: Option<Duration>,
}

impl<'a> Request<'a> {
    /// Refuses, before any work is done, what could not be searched or written.
    pub(super) fn new(shared: &'a Shared) -> Outcome<Self> {
        let begun = Instant::now();
        let named = shared.common.resolve()?;
        let generations = shared.iterations.saturating_add(1);
        let setup = Setup {
            algorithm: *known_name("algorithm", &shared.algorithm, &ALGORITHMS)?,
            population: shared.population,
            evaluations: shared.population.unwrap_or(50).saturating_mul(generations),
        };
        setup.validate().map_err(Failure::of_flag)?;
        output::check("--out", &shared.out)?;
        let time_limit = match shared.time_limit {
            Some(limit) => Some(Duration::try_from_secs_f64(at_least("--time-limit", limit, 0.0, true)?)),
            None => None,
        };
        let time_limit = time_limit.transpose().map_err(|e| Failure::Input(format!("--time-limit: {e}")))?;
        Ok(Self {
            named,
            setup,
            algorithm: &shared.algorithm,
            seed: shared.common.seed,
            json: shared.common.json,
            out: &shared.out,
            begun,
            shared,
            time_limit,
        })
    }

    /// A search at its beginning, or where its checkpoint left it.
    pub(super) fn begin(&self, identity: String, searcher: impl FnOnce() -> Searcher) -> Outcome<Search> {
        self.shared
            .checkpoint
            .resume_or(identity, Search::resume, |identity| Search::new(identity, searcher()))
    }

    /// Drives a search to its end, with a bar on a terminal.
    pub(super) fn drive(&self, problem: &dyn Problem, search: &mut Search) -> Outcome<End> {
        let _listening = stop::listen(stop::Second::Ends);
        let bar = bar(search.budget(), "{prefix} {bar:32} {pos}/{len} evaluations, best {msg}, {eta} left");
        bar.set_prefix(self.algorithm.to_owned());
        let (begun, keeper) = (Instant::now(), Keeper::new(self.shared.checkpoint.file.as_deref()));
        let end = search.run(problem, |search| {
            bar.set_position(search.evaluations() as u64);
            bar.set_message(format!("{:.6}", search.cost()));
            if let Err(failure) = keeper.keep(|| search.checkpoint()) {
                return ControlFlow::Break(Err(failure));
            }
            if stop::requested() {
                return ControlFlow::Break(Ok(End::Interrupted));
            }
            if self.time_limit.is_some_and(|limit| begun.elapsed() >= limit) {
                return ControlFlow::Break(Ok(End::TimeLimit));
            }
            ControlFlow::Continue(())
        });
        bar.finish_and_clear();
        let end = end.break_value().unwrap_or(Ok(End::Complete))?;
        keeper.keep_now(|| search.checkpoint())?;
        Ok(end)
    }
}
