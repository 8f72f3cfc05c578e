//! What is told of a comparison: a table or a document, its flights as a file, a figure, a page.

use super::part::{Flown, Head};
use super::scenario;
use crate::cli::common::drawn;
use crate::cli::{print, print_json, tables};
use crate::error::Outcome;
use crate::figures;
use crate::files::output::{self, Outputs};
use crate::files::{export, figure};
use crate::report::{self, Grid, Picture, Section};
use serde::Serialize;
use std::path::{Path, PathBuf};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor_plot::Figure;
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::table::{Column, Table};
use twinrotor_tune::robust::{LagRow, Row, SceneRow, Scenes, Score};
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

    /// The first flag that is there: each is of scores, which a scenario's flights have none of.
    pub(super) fn of_scores(&self) -> Option<&'static str> {
        let Self { export, plot, report } = self;
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
    let Told { export, plot, report: folder } = told;
    let scores = match flown {
        Flown::Scenario(scenario, flights) => return scenario::show(head, scenario, flights, json),
        Flown::Steps(scores) => scores,
    };
    let rows: Vec<Row> = head
        .controllers
        .iter()
        .zip(scores)
        .enumerate()
        .map(|(k, ((name, uses), own))| {
            let row = Row::new(name, own, (k > 0).then_some(&*scores[0]), uses.clone());
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
        page(head, &rows, figure(), folder, outputs)?;
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
            controllers: rows,
            tunings,
        })
    } else {
        print(&format!("{}{note}", report(head, &rows)))
    }
}

/// The comparison as a page.
fn page(head: &Head, rows: &[Row], figure: Figure, folder: &Path, outputs: &mut Outputs) -> Outcome<()> {
    let grid = Grid {
        name: "controllers".to_owned(),
        heads: HEADS.map(Into::into).into(),
        rows: rows.iter().map(|row| cells(row).to_vec()).collect(),
        note: LEGEND.replace('\n', ". "),
    };
    let caption =
        "The further to the left, the better; a curve that ends below 100 % has failed on the rest.";
    let picture = Picture { name: "costs".to_owned(), caption: caption.to_owned(), figure };
    let uses = Grid {
        name: "uses".to_owned(),
        heads: ["controller", "beside its law"].map(Into::into).into(),
        rows: rows.iter().map(|row| vec![row.name.clone(), row.uses.join(", ")]).collect(),
        note: String::new(),
    };
    let section = |title: &str| Section { title: title.to_owned(), ..Section::default() };
    let sections = [
        Section { measured: vec![grid], pictures: vec![picture], ..section("Controllers") },
        Section { measured: scenes(rows).into_iter().collect(), ..section("Scenes beside the step") },
        Section {
            measured: wrong_lags(rows).into_iter().collect(),
            ..section("Lags that are not those believed")
        },
        Section { measured: vec![uses], ..section("What stands around each law") },
    ];
    let flown = sections.iter().filter(|section| !section.measured.is_empty()).cloned().collect::<Vec<_>>();
    let all = if head.scenes == Scenes::All { " --scenes all" } else { "" };
    let text = format!(
        "{} plants drawn around {}, none of which a controller was tuned on; constants and thrust within \
         {} %, rotor lags within {} %. host-sim compare --preset {} --plants {} --seed {}{all}, \
         version {}.",
        head.plants,
        head.preset,
        100.0 * head.scatter.constants,
        100.0 * head.scatter.lag,
        head.preset,
        head.plants,
        head.seed,
        env!("CARGO_PKG_VERSION")
    );
    report::write_page(&format!("Controllers on {}", head.preset), &text, &flown, folder, outputs)
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

/// What the heads of the table stand for.
const LEGEND: &str = "\
c: a flight's cost; J: its mean, and half its 90 % quantile; less is better
fail: diverged, outside the envelope, not inside 5 % in time, cut by the board;
P<: the probability of that is below this, 95 % sure
ts2: settling within 2 %; OS: overshoot; medians, or what 95 % stay below
dist, hold: error after the disturbance, before it; V/s: volts moved in holding
sat: time with a motor at its limit; p: chance of such a difference to the first
";

/// The heads of the table.
const HEADS: [&str; 14] = [
    "controller",
    "J",
    "fail",
    "P<",
    "cut",
    "c 5/50/95 %",
    "ts2 p/y [s]",
    "ts2 95 %",
    "OS 95 % p/y",
    "dist RMS p/y [deg]",
    "hold RMS p/y [deg]",
    "V/s",
    "sat [s]",
    "p",
];

/// A controller's row.
fn cells(r: &Row) -> [String; HEADS.len()] {
    let pair = |v: PerAxis<f64>, digits: usize| format!("{:.digits$}/{:.digits$}", v.pitch, v.yaw);
    [
        r.name.clone(),
        format!("{:.3}", r.total),
        r.failures.to_string(),
        format!("{:.1e}", r.failure_bound),
        r.cuts.to_string(),
        format!("{:.2}/{:.2}/{:.2}", r.cost.p5, r.cost.median, r.cost.p95),
        pair(r.settling_time_2, 2),
        pair(r.settling_p95, 2),
        pair(r.overshoot_p95, 1),
        pair(r.disturbance_rms_deg, 3),
        pair(r.hold_rms_deg, 3),
        format!("{:.0}", r.voltage_variation),
        format!("{:.2}", r.saturation_time),
        r.p_value.map_or_else(String::new, |p| format!("{p:.1e}")),
    ]
}

fn report(head: &Head, rows: &[Row]) -> String {
    let mut table = tables::table(&HEADS);
    for r in rows {
        tables::add(&mut table, cells(r));
    }
    let told = |what: &str, grid: Option<Grid>| {
        grid.map_or_else(String::new, |Grid { heads, rows, note, .. }| {
            let mut table = tables::table(&heads.iter().map(|head| &**head).collect::<Vec<_>>());
            rows.into_iter().for_each(|row| tables::add(&mut table, row));
            format!("{what}: {}\n{table}\n", note.replace("; (", ";\n("))
        })
    };
    let beside = told("scenes", scenes(rows)) + &told("true lags", wrong_lags(rows));
    let uses: Vec<String> = rows.iter().map(|r| tables::listed(&format!("  {}:", r.name), &r.uses)).collect();
    format!(
        "{}: {} plants that nothing was tuned on, rig fidelity, seed {}\n{table}\n{LEGEND}{beside}\
         uses:\n{}\n",
        head.preset,
        head.plants,
        head.seed,
        uses.join("\n")
    )
}

/// What the scenes beside the step came to, if any was flown.
fn scenes(rows: &[Row]) -> Option<Grid> {
    let names: Vec<&'static str> = rows.first()?.scenes.iter().map(|scene| scene.name).collect();
    if names.is_empty() {
        return None;
    }
    let cell = |scene: &SceneRow| {
        let failures = if scene.failures > 0 { format!(" ({})", scene.failures) } else { String::new() };
        format!("{:.3}: {:.2}/{:.2}{failures}", scene.cost, scene.error.pitch, scene.error.yaw)
    };
    let row = |row: &Row| {
        let step = [row.name.clone(), format!("{:.3}", row.step_total)];
        step.into_iter().chain(row.scenes.iter().map(cell)).collect()
    };
    Some(Grid {
        name: "scenes".to_owned(),
        heads: ["controller", "J of the step alone"].into_iter().chain(names).map(Into::into).collect(),
        rows: rows.iter().map(row).collect(),
        note:
            "what each adds to c, mean; RMS error p/y in parts of the goal, median; (flights that left the \
               envelope)"
                .to_owned(),
    })
}

/// What came of lags that are wrong, if any was flown.
fn wrong_lags(rows: &[Row]) -> Option<Grid> {
    let multiples: Vec<String> = rows.first()?.lags.iter().map(|lag| format!("x{}", lag.multiple)).collect();
    if multiples.is_empty() {
        return None;
    }
    let cell = |lag: &LagRow| format!("{:.2} ({})", lag.total, lag.failures);
    let row = |row: &Row| std::iter::once(row.name.clone()).chain(row.lags.iter().map(cell)).collect();
    Some(Grid {
        name: "lags".to_owned(),
        heads: std::iter::once("controller".into()).chain(multiples.into_iter().map(Into::into)).collect(),
        rows: rows.iter().map(row).collect(),
        note: "both rotors at that many times the lag believed; J, and how many failed".to_owned(),
    })
}
