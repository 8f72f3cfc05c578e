//! `tune` on an integral of the error: the paper's law over one scenario.

use super::beside::{Beside, What};
use super::report::{document, name_of, summary};
use super::request::{Request, left};
use crate::cli::choices;
use crate::cli::common::{End, beside, no_effect, pair, refuse_in_ideal_world};
use crate::cli::{print, print_json};
use crate::device;
use crate::error::{Failure, Outcome};
use crate::figures;
use crate::files::{self, figure};
use crate::stop;
use std::path::PathBuf;
use twinrotor::gains::NAMES;
use twinrotor_sim::error::at_least;
use twinrotor_sim::flight::{self, Fidelity, Flight, Plan, Scalar};
use twinrotor_sim::gains_file::{GainsFile, Provenance};
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::scenario::Scenario;
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::{Bounds, Draws};

/// Flags that act on ise, iae and itae.
#[derive(Debug, clap::Args)]
#[group(skip)]
#[command(next_help_heading = "With --objective ise, iae or itae")]
pub(super) struct Args {
    /// What to fly: step, 1, 2, 3, 3-square, or a FILE.toml of your own [default: step]
    #[arg(long)]
    scenario: Option<String>,
    /// The paper's world or the rig's [default: ideal]
    #[arg(long)]
    fidelity: Option<choices::Fidelity>,
    /// How long each candidate flies, in s, instead of the scenario's duration
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    horizon: Option<f64>,
    /// Least and most of each gain [default: 1,25]
    #[arg(long, value_name = "LO,HI", allow_hyphen_values = true)]
    bounds: Option<String>,
    /// Where to draw both step responses (.svg or .png) [default: beside the gains, as .svg]
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
}

/// The flags, resolved.
pub(super) struct Task<'a> {
    pub(super) request: &'a Request<'a>,
    pub(super) criterion: Criterion,
    pub(super) scenario: Scenario,
    /// As it was typed.
    pub(super) scenario_name: String,
    pub(super) horizon: Option<f64>,
    pub(super) fidelity: Fidelity,
    pub(super) bounds: [f64; 2],
    pub(super) plot: PathBuf,
}

impl Args {
    /// The files that are read, by flag.
    pub(super) fn inputs(&self) -> [(&str, &str); 1] {
        [("--scenario", self.scenario.as_deref().unwrap_or_default())]
    }

    /// Refuses what the robust objective would not heed.
    pub(super) fn refuse_for_robust(&self) -> Outcome<()> {
        let robust = "with --objective robust";
        if self.scenario.is_some() {
            return Err(no_effect("--scenario", robust, "it flies a step of its own"));
        }
        if self.horizon.is_some() {
            return Err(no_effect("--horizon", robust, "how long it flies is the preset's"));
        }
        if self.bounds.is_some() {
            return Err(no_effect("--bounds", robust, "it searches within --range of where it starts"));
        }
        if self.plot.is_some() {
            return Err(no_effect("--plot", robust, "it draws nothing"));
        }
        if self.fidelity == Some(choices::Fidelity::Ideal) {
            return Err(no_effect("--fidelity ideal", robust, "its only world is the rig's"));
        }
        Ok(())
    }

    fn resolve<'a>(&self, request: &'a Request<'a>, criterion: Criterion) -> Outcome<Task<'a>> {
        let scenario_name = self.scenario.clone().unwrap_or_else(|| "step".to_owned());
        let mut scenario = files::scenario(&scenario_name)?;
        if let Some(horizon) = self.horizon {
            scenario.duration = at_least("--horizon", horizon, 0.0, true)?;
        }
        scenario.validate()?;
        let bounds = self.bounds.as_deref().map_or(Ok([1.0, 25.0]), |text| pair("--bounds", text))?;
        at_least("--bounds: the lower one", bounds[0], 0.0, true)?;
        at_least("--bounds: the upper one", bounds[1], bounds[0], true)?;
        let plot = beside(self.plot.as_deref(), request.out, &mut request.outputs.borrow_mut())?;
        let fidelity = self.fidelity.map_or(Fidelity::Ideal, Into::into);
        refuse_in_ideal_world(&scenario, fidelity)?;
        if scenario.start.hot {
            return Err(Failure::Input(format!(
                "start.hot of scenario {} is true; allowed: false, candidates fly with cold motors",
                scenario.name
            )));
        }
        let horizon = self.horizon;
        Ok(Task { request, criterion, scenario, scenario_name, horizon, fidelity, bounds, plot })
    }
}

pub(super) fn run(args: &Args, request: &Request<'_>, criterion: Criterion) -> Outcome<()> {
    let task = args.resolve(request, criterion)?;
    let Task { scenario, fidelity, bounds, plot, .. } = &task;
    let named = &request.named;
    let objective =
        Objective::new(criterion, &named.rig, scenario, *fidelity, request.seed).on(request.found.device());
    let identity = request
        .identity()
        .with("objective", name_of(criterion))
        .with("bounds", format_args!("{},{}", bounds[0], bounds[1]))
        .with("fidelity", format_args!("{fidelity:?}"))
        .with("scenario", &scenario.name)
        .with("horizon", scenario.duration)
        .with("what the scenario holds", format_args!("{scenario:?}"));
    let box_of_gains = Bounds::new(vec![*bounds; NAMES.len()])?;
    let mut search = request.begin(identity, request.setup.start(box_of_gains, Draws::new(request.seed)))?;
    let listening = stop::listen(stop::Second::Ends);
    let end = request.drive(&objective, &mut search);
    let Some(best) = search.best().filter(|b| b.cost.is_finite()) else {
        return Err(request.nothing(end));
    };

    let mut found = Objective::controller(&best.position);
    found.provenance = Some(Provenance {
        preset: named.name.clone(),
        objective: name_of(criterion),
        algorithm: request.algorithm.to_owned(),
        seed: request.seed,
        evaluations: search.evaluations(),
        cost: best.cost,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    });
    let mut outputs = request.outputs.take();
    outputs.write(request.out, found.to_toml().as_bytes());
    drop(listening);
    if stop::requested() || end == End::Device {
        if request.json {
            print_json(&document(&task, &search, &found, None))?;
        }
        return left(request, &search, outputs);
    }
    let fly = |gains: &GainsFile| task.fly_in(gains, *fidelity);
    let flown = [fly(&GainsFile::paper())?, fly(&found)?];
    let pair = [("paper", &flown[0]), ("tuned", &flown[1])];
    let drawn = figures::comparison(&task.title(), pair, named.rig.volts_limit);
    outputs.write(plot, &figure::bytes(&drawn, plot)?);

    let paper = objective.cost(&GainsFile::paper());
    let mut before = vec![(What::Paper, "the paper's gains".to_owned(), paper)];
    before.extend(request.own().map(|(name, gains)| {
        let cost = task.fly_in(&gains, *fidelity).map_or(f64::INFINITY, |f| f.report.integral(criterion));
        (What::Own, name, cost)
    }));
    let beside = Beside::new(best.cost, search.evaluations(), before);
    if request.json {
        print_json(&document(&task, &search, &found, Some(&beside)))?;
    } else {
        let each_core = match fidelity {
            Fidelity::Ideal => device::IDEAL_FLIGHTS,
            Fidelity::Rig => device::RIG_FLIGHTS,
        };
        let note = request.found.note(request.generation(), each_core);
        let summary = summary(&task, &search, paper, &found, &flown, &beside);
        print(&format!("{summary}{}{note}", outputs.unwritten()))?;
    }
    outputs.done()
}

impl Task<'_> {
    /// Gains on the scenario that is tuned for.
    pub(super) fn fly_in(&self, gains: &GainsFile, fidelity: Fidelity) -> Outcome<Flight> {
        let rig = &self.request.named.rig;
        let settings = gains.settings(rig);
        let plan = Plan {
            rig,
            truth: rig,
            settings: &settings,
            scenario: &self.scenario,
            initial: self.scenario.start.angle(),
            fidelity,
            seed: self.request.seed,
        };
        Ok(flight::fly(&plan, Scalar::F32)?)
    }

    fn title(&self) -> String {
        format!(
            "{}, scenario {}: Table 4 and gains tuned by {} on {}",
            self.request.named.name,
            self.scenario.name,
            self.request.algorithm,
            name_of(self.criterion).to_uppercase()
        )
    }
}
