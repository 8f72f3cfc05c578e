//! `tune --objective robust`: any parameter of any controller, on many plants at once.

use super::beside::{Beside, What};
use super::proof::Proof;
use super::report::Run;
use super::request::{Request, left};
use crate::cli::common::{End, Spreads, no_effect, within};
use crate::cli::next::next;
use crate::cli::{choices, print, print_json, tables};
use crate::device;
use crate::error::{Failure, Outcome};
use crate::files;
use crate::stop;
use serde::Serialize;
use std::fmt::Write;
use twinrotor::controller::ControllerSettings;
use twinrotor_sim::error::{at_least, known_name};
use twinrotor_sim::gains_file::{GainsFile, Provenance};
use twinrotor_sim::scenario::SAMPLE_TIME;
use twinrotor_tune::design::CATALOGUE;
use twinrotor_tune::optimise::Candidate;
use twinrotor_tune::robust::{self, Limit, Plan, Robust, Terms, Trial};
use twinrotor_tune::search::{Problem, Search};
use twinrotor_tune::tunable::Tunable;

/// Flags that act on the robust objective.
#[derive(Debug, clap::Args)]
#[group(skip)]
#[command(next_help_heading = "With --objective robust")]
pub(super) struct Args {
    /// Which controller's design to start from [default: integral]
    #[arg(long, value_name = "NAME")]
    controller: Option<String>,
    /// Start from these gains instead
    #[arg(long, value_name = "FILE", conflicts_with = "controller")]
    start: Option<String>,
    /// Which parameters to tune, such as yaw,filter.bandwidth.pitch [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    parameters: Vec<String>,
    /// Keep a number that `compare --json` tells within a limit, such as overshoot_p95.yaw=2; 'none' for no
    /// limit at all [default: overshoot_p95.pitch=2.5,overshoot_p95.yaw=2.5,voltage_variation=135,failures=0]
    #[arg(long, value_name = "NUMBER=MOST", value_delimiter = ',')]
    at_most: Vec<String>,
    /// What is flown on each plant [default: all]
    #[arg(long)]
    scenes: Option<choices::Scenes>,
    /// On how many plants [default: 32]
    #[arg(long, value_name = "N")]
    plants: Option<usize>,
    #[command(flatten)]
    spreads: Spreads,
    /// Also fly every plant with rotor lags at these multiples of those believed, such as .2,3, for the
    /// limits 'lags.failures' and 'lags.J' (the worst of them)
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_negative_numbers = true)]
    true_lags: Vec<f64>,
    /// Searches one after the other, each around the best so far and within less [default: 4]
    #[arg(long, value_name = "N")]
    rounds: Option<usize>,
    /// Factor within which each parameter is searched at first [default: 4]
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    range: Option<f64>,
}

/// Limits that the committed gains of most presets keep, or nearly (`scripts/tune-defaults.sh`).
const LIMITS: [&str; 4] =
    ["overshoot_p95.pitch=2.5", "overshoot_p95.yaw=2.5", "voltage_variation=135", "failures=0"];

impl Args {
    /// As they are typed.
    fn limits(&self) -> Vec<String> {
        match &self.at_most[..] {
            [] => LIMITS.map(str::to_owned).to_vec(),
            [none] if none == "none" => Vec::new(),
            given => given.to_vec(),
        }
    }

    fn lags(&self) -> Outcome<Vec<f64>> {
        self.true_lags.iter().map(|lag| robust::check_multiple(*lag).map_err(Failure::of_flag)).collect()
    }

    fn told_lags(&self) -> String {
        self.true_lags.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
    }

    /// The files that are read, by flag.
    pub(super) fn inputs(&self) -> [(&str, &str); 1] {
        [("--start", self.start.as_deref().unwrap_or_default())]
    }

    /// Refuses what an integral of the error would not heed.
    pub(super) fn refuse_for_integral(&self) -> Outcome<()> {
        let law = "an integral of the error is of the paper's law, its four gains and one plant";
        let given = [
            ("--controller", self.controller.is_some()),
            ("--start", self.start.is_some()),
            ("--parameters", !self.parameters.is_empty()),
            ("--at-most", !self.at_most.is_empty()),
            ("--scenes", self.scenes.is_some()),
            ("--plants", self.plants.is_some()),
            ("--spread", self.spreads.spread.is_some()),
            ("--lag-spread", self.spreads.lag_spread.is_some()),
            ("--true-lags", !self.true_lags.is_empty()),
            ("--rounds", self.rounds.is_some()),
            ("--range", self.range.is_some()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((flag, _)) => Err(no_effect(flag, "without --objective robust", law)),
            None => Ok(()),
        }
    }

    /// What the start is called.
    fn told_start(&self) -> String {
        let design = || format!("the design '{}'", self.controller.as_deref().unwrap_or("integral"));
        self.start.clone().unwrap_or_else(design)
    }

    /// The controller that the search starts from: a gains file's, or a design of the catalogue.
    fn start(&self, request: &Request<'_>) -> Outcome<ControllerSettings<f64>> {
        if let Some(path) = &self.start {
            return Ok(files::gains("--start", path)?.controller);
        }
        let name = self.controller.as_deref().unwrap_or("integral");
        let design = known_name("controller", name, &CATALOGUE)?;
        Ok(design(&request.named.rig))
    }
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    #[serde(flatten)]
    run: Run<'a>,
    objective: &'static str,
    plants: usize,
    spread: f64,
    lag_spread: f64,
    scenes: robust::Scenes,
    /// Of the gains; not known of a search that was interrupted.
    terms: Option<Terms>,
    failures: Option<usize>,
    cuts: Option<usize>,
    #[serde(rename = "J_step")]
    step_total: Option<f64>,
    /// What came of flying them beyond the objective.
    proof: Option<&'a Proof>,
    #[serde(flatten)]
    beside: Option<&'a Beside>,
    gains: &'a GainsFile,
}

/// Tunes, writes and reports.
pub(super) fn run(args: &Args, request: &Request<'_>) -> Outcome<()> {
    let named = &request.named;
    let start = args.start(request)?;
    let tunable = Tunable::new(&start, &args.parameters).map_err(Failure::of_flag)?;
    let range = at_least("--range", args.range.unwrap_or(4.0), 1.0, true)?;
    let plants = within("--plants", args.plants.unwrap_or(32), 1, 100_000)?;
    let rounds = within("--rounds", args.rounds.unwrap_or(4), 1, 1_000)?;
    let limit = |text: &String| Limit::parse(text).map_err(Failure::of_flag);
    let at_most = args.limits();
    let limits = at_most.iter().map(limit).collect::<Outcome<Vec<_>>>()?;
    let scenes: robust::Scenes = args.scenes.unwrap_or(choices::Scenes::All).into();
    let lags = args.lags()?;
    let seed = request.seed;
    let scatter = args.spreads.scatter()?;
    let allowance = robust::allowance(&named.name, &named.rig);
    let here = Trial::within(&named.rig, plants, seed, allowance, &scatter).flying(scenes);
    let trial = here.clone().on(request.found.device());
    let plan = Plan { setup: request.setup, rounds, range, seed };
    let identity = request
        .identity()
        .with("objective", "robust")
        .with("plants", plants)
        .with("spread", format_args!("{}, {}", scatter.constants, scatter.lag))
        .with("true-lags", format_args!("{lags:?}"))
        .with("rounds", rounds)
        .with("range", range)
        .with("at-most", at_most.join(","))
        .with("scenes", format_args!("{scenes:?}"))
        .with("parameters", tunable.names().join(","))
        .with_toml(&GainsFile { controller: start, provenance: None }.to_toml());
    let mut search = request.begin(identity, plan.start(tunable.names().len()))?;
    let listening = stop::listen(stop::Second::Ends);
    let end = request.drive(&Robust::new(&trial, &tunable).within(&limits).with_lags(&lags), &mut search);
    let Some(best) = search.best() else { return Err(request.nothing(end)) };
    let found = tunable.controller(&best.position);

    let mut file = GainsFile { controller: found, provenance: None };
    file.provenance = Some(Provenance {
        preset: named.name.clone(),
        objective: std::iter::once(robust::objective(plants, scenes, &scatter))
            .chain((!lags.is_empty()).then(|| format!("true lags {}", args.told_lags())))
            .chain(at_most.iter().cloned())
            .collect::<Vec<_>>()
            .join(", "),
        algorithm: format!("{}, {rounds} rounds", request.algorithm),
        seed,
        evaluations: search.evaluations(),
        cost: best.cost,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    });
    let proof = Proof::of(&named.rig, &found);
    let mut outputs = request.outputs.take();
    outputs.write(request.out, file.to_toml().as_bytes());
    drop(listening);
    let document = |scores: Option<&[robust::Score]>, proof, beside| Document {
        run: Run::new(request, &search, trial.steps() as f64 * SAMPLE_TIME, search.at_bounds_of(&tunable)),
        objective: "robust",
        plants,
        spread: scatter.constants,
        lag_spread: scatter.lag,
        scenes,
        proof,
        beside,
        cuts: scores.map(|scores| scores.iter().filter(|s| s.cut.is_some()).count()),
        step_total: scores.map(robust::step_total),
        terms: scores.map(|scores| Terms::mean(scores.iter().map(robust::Score::terms))),
        failures: scores.map(|scores| scores.iter().filter(|s| s.failed).count()),
        gains: &file,
    };
    if stop::requested() || end == End::Device {
        if request.json {
            print_json(&document(None, None, None))?;
        }
        return left(request, &search, outputs);
    }

    let fly = |controller| here.scores(controller);
    let (before, after) = (fly(&start), fly(&found));
    // What was minimised, limits and all: the search begins with the start, at no other cost.
    let cost = |tunable: &Tunable| {
        let unmoved = vec![0.0; tunable.names().len()];
        let problem = Robust::new(&here, tunable).within(&limits).with_lags(&lags);
        problem.costs(&[Candidate { position: unmoved, bound: f64::INFINITY }])[0]
    };
    let mut compared = vec![(What::Start, args.told_start(), cost(&tunable))];
    match request.own() {
        Some((_, own)) if own.controller == start => {
            compared[0].1 = format!("{}, the preset's own gains", compared[0].1);
        }
        Some((name, own)) => compared.push((What::Own, name, cost(&Tunable::new(&own.controller, &[])?))),
        None => {}
    }
    let beside = Beside::new(best.cost, search.evaluations(), compared);
    if request.json {
        print_json(&document(Some(&after), Some(&proof), Some(&beside)))?;
    } else {
        let tuned =
            Tunable::new(&found, &args.parameters).map_or_else(|_| Vec::new(), |t| t.start().to_vec());
        let summary = summary(request, &tunable, &search, &tuned, [&before, &after], &beside);
        let note = request.found.note(request.generation() * plants, device::RIG_FLIGHTS);
        print(&format!("{summary}{}{}{note}", proof.text(), outputs.unwritten()))?;
    }
    outputs.done()?;
    match proof.stopped() {
        Some(why) => {
            Err(Failure::Flight(format!("{} are not to be flown as they are: {why}", request.out.display())))
        }
        None => Ok(()),
    }
}

fn summary(
    request: &Request<'_>,
    tunable: &Tunable,
    search: &Search,
    tuned: &[f64],
    [before, after]: [&[robust::Score]; 2],
    beside: &Beside,
) -> String {
    let mut text = format!(
        "{} on preset {}, robust objective, {} plants: {} evaluations in {:.1} s\n",
        request.algorithm,
        request.named.name,
        after.len(),
        search.evaluations(),
        request.begun.elapsed().as_secs_f64()
    );
    let mut table = tables::table(&["", "start", "tuned"]);
    for ((field, start), found) in tunable.fields().iter().zip(tunable.start()).zip(tuned) {
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
    let step = |scores: &[robust::Score]| format!("{:.4}", robust::step_total(scores));
    tables::add(&mut table, ["J of the step alone".to_owned(), step(before), step(after)]);
    tables::add(&mut table, ["failures".to_owned(), failures(before), failures(after)]);
    let cuts = |scores: &[robust::Score]| scores.iter().filter(|s| s.cut.is_some()).count().to_string();
    tables::add(&mut table, ["of these cut by the board".to_owned(), cuts(before), cuts(after)]);
    let _ = writeln!(text, "{table}");
    for end in search.at_bounds_of(tunable) {
        let _ = writeln!(text, "warning: {end} of the last round: more may be had with more --rounds");
    }
    let out = request.out.display();
    let minimised = beside.text("J, raised where a limit is not kept");
    let _ = writeln!(text, "{minimised}gains: {out}");
    let fly = next("fly").with("--preset", &request.named.name).with("--gains", out);
    let fly = fly.board(request.named.rig.board);
    let _ = writeln!(text, "fly it: {fly}");
    text
}
