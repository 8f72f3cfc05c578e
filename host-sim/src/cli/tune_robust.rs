//! `tune --objective robust`: any parameter of any controller, on many plants at once.

use super::common::End;
use super::tune::{Args, Request, drive};
use super::tune_report::Run;
use super::{print, print_json, tables};
use crate::error::{Failure, Outcome};
use crate::files;
use crate::files::output;
use serde::Serialize;
use std::fmt::Write;
use std::time::Instant;
use twinrotor::controller::ControllerSettings;
use twinrotor_sim::error::{at_least, known_name};
use twinrotor_sim::gains_file::{GainsFile, Provenance};
use twinrotor_sim::rig::NamedRig;
use twinrotor_tune::design::CATALOGUE;
use twinrotor_tune::robust::{self, Limit, Plan, Robust, Terms, Trial};
use twinrotor_tune::search::Search;
use twinrotor_tune::tunable::Tunable;

#[derive(Debug, Serialize)]
struct Document<'a> {
    #[serde(flatten)]
    run: Run<'a>,
    objective: &'static str,
    plants: usize,
    terms: Terms,
    failures: usize,
    gains: &'a GainsFile,
}

/// Tunes, writes and reports.
pub(super) fn run(args: &Args, request: &Request) -> Outcome<()> {
    let begun = Instant::now();
    let named = &request.named;
    let start = start(args, named)?;
    let tunable = Tunable::new(&start, &args.parameters).map_err(Failure::of_flag)?;
    at_least("--range", args.range, 1.0, true)?;
    if args.plants == 0 || args.plants > 100_000 {
        return Err(Failure::Input(format!("--plants is {}; allowed: 1 to 100000", args.plants)));
    }
    if args.rounds == 0 || args.rounds > 1_000 {
        return Err(Failure::Input(format!("--rounds is {}; allowed: 1 to 1000", args.rounds)));
    }
    let limits = args
        .at_most
        .iter()
        .map(|text| Limit::parse(text).map_err(Failure::of_flag))
        .collect::<Outcome<Vec<_>>>()?;
    let seed = args.common.seed;
    let trial = Trial::new(&named.rig, args.plants, seed, robust::allowance(&named.name, &named.rig));
    let plan = Plan { setup: request.setup, rounds: args.rounds, range: args.range, seed };
    let identity = format!(
        "{} {:?} robust {} plants {tunable:?} {plan:?} at most {:?}",
        named.name, named.rig, args.plants, args.at_most
    );
    let fresh = |identity| Search::new(identity, plan.start(tunable.names().len()));
    let mut search = args.checkpoint.resume_or(identity, Search::resume, fresh)?;
    let end = drive(args, request, &Robust::new(&trial, &tunable).within(&limits), &mut search)?;
    let best = search.best().expect("the start is evaluated first");
    let found = tunable.controller(&best.position);

    let mut file = GainsFile { controller: found, provenance: None };
    file.provenance = Some(Provenance {
        preset: named.name.clone(),
        objective: std::iter::once(format!("robust, {} plants", args.plants))
            .chain(args.at_most.iter().cloned())
            .collect::<Vec<_>>()
            .join(", "),
        algorithm: format!("{}, {} rounds", args.algorithm, args.rounds),
        seed,
        evaluations: search.evaluations(),
        cost: best.cost,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    });
    output::write(&args.out, file.to_toml().as_bytes())?;

    let before = trial.scores(&start);
    let after = trial.scores(&found);
    if args.common.json {
        print_json(&Document {
            run: Run::new(args, named, &search, 2.0 * trial.allowance, begun.elapsed().as_secs_f64()),
            objective: "robust",
            plants: args.plants,
            terms: Terms::mean(after.iter().map(robust::Score::terms)),
            failures: after.iter().filter(|s| s.failed).count(),
            gains: &file,
        })?;
    } else {
        print(&summary(args, named, &tunable, &search, &found, [&before, &after], begun))?;
    }
    if end == End::Interrupted { Err(Failure::Interrupted) } else { Ok(()) }
}

/// The controller that the search starts from: a gains file's, or a design of the catalogue.
fn start(args: &Args, named: &NamedRig) -> Outcome<ControllerSettings<f64>> {
    if let Some(path) = &args.start {
        return Ok(files::gains("--start", path)?.controller);
    }
    let design = known_name("controller", &args.controller, &CATALOGUE)?;
    Ok(design(&named.rig))
}

fn summary(
    args: &Args,
    named: &NamedRig,
    tunable: &Tunable,
    search: &Search,
    found: &ControllerSettings<f64>,
    [before, after]: [&[robust::Score]; 2],
    begun: Instant,
) -> String {
    let mut text = format!(
        "{} on preset {}, robust objective, {} plants: {} evaluations in {:.1} s\n",
        args.algorithm,
        named.name,
        args.plants,
        search.evaluations(),
        begun.elapsed().as_secs_f64()
    );
    let mut table = tables::table(&["", "start", "tuned"]);
    let found = Tunable::new(found, &args.parameters).map_or_else(|_| Vec::new(), |t| t.start().to_vec());
    for ((field, start), found) in tunable.fields().iter().zip(tunable.start()).zip(found) {
        tables::add(
            &mut table,
            [format!("{} [{}]", field.name, field.unit), format!("{start:.4}"), format!("{found:.4}")],
        );
    }
    let mean = |scores: &[robust::Score]| Terms::mean(scores.iter().map(robust::Score::terms));
    let (old, new) = (mean(before), mean(after));
    for ((name, a), (_, b)) in old.named().into_iter().zip(new.named()) {
        tables::add(&mut table, [format!("mean of term: {name}"), format!("{a:.4}"), format!("{b:.4}")]);
    }
    let costs = |scores: &[robust::Score]| scores.iter().map(robust::Score::cost).collect::<Vec<_>>();
    tables::add(
        &mut table,
        ["mean(c)".to_owned(), format!("{:.4}", old.total()), format!("{:.4}", new.total())],
    );
    tables::add(
        &mut table,
        [
            "q90(c)".to_owned(),
            format!("{:.4}", robust::quantile(&costs(before), 0.9)),
            format!("{:.4}", robust::quantile(&costs(after), 0.9)),
        ],
    );
    tables::add(
        &mut table,
        [
            "J = mean(c) + q90(c)/2".to_owned(),
            format!("{:.4}", robust::total(before)),
            format!("{:.4}", robust::total(after)),
        ],
    );
    let failures = |scores: &[robust::Score]| scores.iter().filter(|s| s.failed).count().to_string();
    tables::add(&mut table, ["failures".to_owned(), failures(before), failures(after)]);
    let _ = writeln!(text, "{table}\ngains: {}", args.out.display());
    text
}
