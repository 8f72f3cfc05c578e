//! What is told of a comparison: a table or a document, its flights as a file, a figure, a page.

use super::part::{Flown, Head};
use super::{scenario, table};
use crate::cli::common::drawn;
use crate::cli::{print, print_json, who};
use crate::error::{Failure, Outcome};
use crate::figures;
use crate::files::output::{self, Outputs};
use crate::files::{export, figure};
use serde::Serialize;
use std::path::PathBuf;
use twinrotor::axes::PerMotor;
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::table::{Column, Table};
use twinrotor_tune::robust::{LagRow, Row, Scenes, Score};
use twinrotor_tune::tunable::AtBound;

/// Flags of `compare` and of `merge`: where it goes beside the terminal.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub(super) struct Told {
    /// Write every flight's numbers, a row each: .parquet, .npz or .csv
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    export: Option<PathBuf>,
    /// Draw how many plants cost how much with each controller (.svg or .png)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
    /// Write the comparison as a page, with its tables and figure as CSV, into this folder
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    report: Option<PathBuf>,
    /// Controller that p compares the others with, as the table names it [default: the first]
    #[arg(long, value_name = "NAME")]
    against: Option<String>,
}

impl Told {
    /// Can all of it be written?
    pub(super) fn check(&self, outputs: &mut Outputs) -> Outcome<()> {
        if let Some(path) = &self.export {
            export::check("--export", path, false)?;
            outputs.writes("--export", path)?;
        }
        drawn(self.plot.as_deref(), outputs)?;
        self.report.as_ref().map_or(Ok(()), |folder| output::check_folder("--report", folder))
    }

    /// Which of the controllers the others are held against.
    pub(super) fn reference(&self, head: &Head) -> Outcome<usize> {
        let Some(wanted) = &self.against else { return Ok(0) };
        let bare = |name: &str| name.strip_suffix(who::UNTUNED).unwrap_or(name).to_owned();
        let names = || head.controllers.iter().map(|(name, _)| name);
        names().position(|name| name == wanted || bare(name) == *wanted).ok_or_else(|| {
            let known = names().map(|name| bare(name)).collect::<Vec<_>>().join(", ");
            Failure::Input(format!("--against is '{wanted}'; allowed: one that is compared: {known}"))
        })
    }

    /// The first flag that is there: each is of scores, which a scenario's flights have none of.
    pub(super) fn of_scores(&self) -> Option<&'static str> {
        let Self { export, plot, report, .. } = self;
        let flags = [("--export", export), ("--plot", plot), ("--report", report)];
        flags.into_iter().find(|(_, path)| path.is_some()).map(|(flag, _)| flag)
    }
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    preset: &'a str,
    fidelity: Fidelity,
    plants: usize,
    spread: f64,
    lag_spread: f64,
    scenes: Scenes,
    seed: u64,
    rotor_lag: PerMotor<f64>,
    /// What p compares with.
    against: &'a str,
    controllers: Vec<Row>,
    /// What was tuned first, where something was.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    tunings: Vec<Tuned>,
}

/// A controller that was tuned before it was compared.
#[derive(Debug, Serialize)]
pub(super) struct Tuned {
    pub(super) name: &'static str,
    pub(super) rounds: usize,
    pub(super) evaluations: usize,
    /// J on the plants that it was tuned on.
    pub(super) cost: f64,
    /// Plants of these on which it fails.
    pub(super) failures: usize,
    /// What its last round has left at a bound of its box.
    pub(super) at_bounds: Vec<AtBound>,
}

impl Tuned {
    /// What says that more rounds may find less.
    pub(super) fn warnings(&self) -> String {
        let Self { name, failures, .. } = self;
        let mut told: Vec<String> =
            self.at_bounds.iter().map(|end| format!("{end} of the last round")).collect();
        if *failures > 0 {
            told.push(format!("fails on {failures} of the plants that it was tuned on"));
        }
        let told =
            told.iter().map(|what| format!("warning: {name}: {what}: more may be had with more rounds\n"));
        told.collect()
    }
}

/// What there is beside the flights.
#[derive(Debug, Default)]
pub(super) struct More {
    /// Of each controller, where there are any.
    pub(super) lags: Vec<Vec<LagRow>>,
    pub(super) tunings: Vec<Tuned>,
    /// Under the table.
    pub(super) note: String,
}

/// Tells what came of it.
pub(super) fn show(
    head: &Head,
    flown: &Flown,
    more: More,
    told: &Told,
    json: bool,
    outputs: &mut Outputs,
) -> Outcome<()> {
    let More { mut lags, tunings, note } = more;
    let Told { export, plot, report: folder, .. } = told;
    let reference = told.reference(head)?;
    let scores = match flown {
        Flown::Scenario(scenario, flights) => {
            return scenario::show(head, scenario, flights, reference, json);
        }
        Flown::Steps(scores) => scores,
    };
    let rows: Vec<Row> = head
        .controllers
        .iter()
        .zip(scores)
        .enumerate()
        .map(|(k, ((name, uses), own))| {
            let row = Row::new(name, own, (k != reference).then_some(&*scores[reference]), uses.clone());
            Row { lags: lags.get_mut(k).map(std::mem::take).unwrap_or_default(), ..row }
        })
        .collect();
    if let Some(path) = export {
        let names = head.controllers.iter().map(|(name, _)| name.as_str());
        outputs.write(path, &export::bytes(&flights(names.zip(scores)), path)?);
    }
    let figure = || {
        let own = |row: &Row| format!("{}, J {:.2}", row.name, row.total);
        let named: Vec<_> = rows.iter().map(own).zip(scores.iter().map(Vec::as_slice)).collect();
        figures::costs(&format!("{}, {} plants", head.preset, head.plants), &named)
    };
    if let Some(path) = plot {
        outputs.write(path, &figure::bytes(&figure(), path)?);
    }
    if let Some(folder) = folder {
        table::page(head, &rows, reference, figure(), folder, outputs)?;
    }
    if json {
        print_json(&Document {
            preset: &head.preset,
            fidelity: Fidelity::Rig,
            plants: head.plants,
            spread: head.scatter.constants,
            lag_spread: head.scatter.lag,
            scenes: head.scenes,
            seed: head.seed,
            rotor_lag: head.rotor_lag,
            against: &head.controllers[reference].0,
            controllers: rows,
            tunings,
        })
    } else {
        print(&format!("{}{note}", table::report(head, &rows, reference)))
    }
}

type Number = fn(&Score) -> f64;

/// Every flight as a row: controller, number of the plant, the score's terms and its cost.
fn flights<'a>(controllers: impl Iterator<Item = (&'a str, &'a Vec<Score>)>) -> Table {
    let flights: Vec<(&str, usize, &Score)> = controllers
        .flat_map(|(name, scores)| scores.iter().enumerate().map(move |(k, score)| (name, k + 1, score)))
        .collect();
    let numbers: [(&str, Number); 15] = [
        ("cost", Score::cost),
        ("cost_step", Score::step_cost),
        ("settling_time_2_pitch", |s| s.settling_time.pitch),
        ("settling_time_2_yaw", |s| s.settling_time.yaw),
        ("overshoot_percent_pitch", |s| s.overshoot_percent.pitch),
        ("overshoot_percent_yaw", |s| s.overshoot_percent.yaw),
        ("disturbance_rms_deg_pitch", |s| s.disturbance_rms_deg.pitch),
        ("disturbance_rms_deg_yaw", |s| s.disturbance_rms_deg.yaw),
        ("hold_rms_deg_pitch", |s| s.hold_rms_deg.pitch),
        ("hold_rms_deg_yaw", |s| s.hold_rms_deg.yaw),
        ("voltage_variation", |s| s.voltage_variation),
        ("saturation_time", |s| s.saturation_time),
        ("diverged", |s| f64::from(u8::from(s.diverged))),
        ("failed", |s| f64::from(u8::from(s.failed))),
        ("cut", |s| f64::from(u8::from(s.cut.is_some()))),
    ];
    let mut table = Table::default();
    table.push("controller", Column::Words(flights.iter().map(|(name, ..)| (*name).to_owned()).collect()));
    table.push("plant", Column::Numbers(flights.iter().map(|(_, plant, _)| *plant as f64).collect()));
    for (name, of) in numbers {
        table.push(name, Column::Numbers(flights.iter().map(|(.., score)| of(score)).collect()));
    }
    table
}
