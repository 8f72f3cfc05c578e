//! `compare`: controllers side by side on the same plants, none of which they were tuned on: the robust
//! objective's step, or any scenario ([`scenario`]).

pub(super) mod merge;
mod part;
mod scenario;

use super::common::{Common, Device, Spreads, drawn, no_effect, pair, truth, within};
use super::{choices, print, print_json, tables};
use crate::device;
use crate::error::{Failure, Outcome};
use crate::figures;
use crate::files;
use crate::files::export;
use crate::files::figure;
use crate::files::output::{self, Outputs};
use crate::report::{self, Grid, Picture, Section};
use part::{Flown, Head};
use serde::Serialize;
use std::path::{Path, PathBuf};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::controller::ControllerSettings;
use twinrotor::plant::PlantParameters;
use twinrotor_plot::Figure;
use twinrotor_sim::error::known_name;
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::is_text;
use twinrotor_sim::rig::NamedRig;
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::table::{Column, Table};
use twinrotor_tune::design::{self, CATALOGUE, Design};
use twinrotor_tune::parallel::NEVER;
use twinrotor_tune::robust::{self, Row, Scatter, SceneRow, Score, Shard, Trial, Tuning};

/// Most plants of a comparison.
const MOST_PLANTS: usize = 100_000;

/// What is told of all parts together, or done before there are any.
const NOT_OF_A_PART: [&str; 5] = ["export", "plot", "report", "tune", "json"];

/// Flags of `compare`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    device: Device,
    /// How many plants to draw around the preset
    #[arg(long, value_name = "N", default_value_t = 300)]
    plants: usize,
    #[command(flatten)]
    spreads: Spreads,
    /// What is flown on each plant; J_step is of the step alone
    #[arg(long, default_value = "step", conflicts_with = "scenario")]
    scenes: choices::Scenes,
    /// The rig's world is the only one that controllers are compared in
    #[arg(long, default_value = "rig")]
    fidelity: choices::Fidelity,
    /// Which, by name or gains file, instead of all there are; 'ours' is always there
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    controllers: Vec<String>,
    /// Fly this scenario instead of the robust objective's step: a name, or a FILE.toml of your own
    #[arg(long, conflicts_with_all = ["step", "allowance", "tune", "export", "plot", "report"])]
    scenario: Option<String>,
    /// Begin the scenario with motors that a minute of squares has warmed
    #[arg(long, requires = "scenario")]
    hot: bool,
    /// Step to fly, in degrees, both positive, instead of 15,40
    #[arg(long, value_name = "PITCH,YAW", allow_hyphen_values = true)]
    step: Option<String>,
    /// When the disturbance sets in, and half of the flight, in s, instead of what the preset allows
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    allowance: Option<f64>,
    /// True lag of both rotors, in s, in every plant, whatever the controllers believe
    #[arg(long, value_name = "S", help_heading = "Rig")]
    true_lag: Option<f64>,
    /// Rig that every plant is in truth, all of it, whatever the controllers believe; lag and disturbance are
    /// still drawn
    #[arg(long, value_name = "RIG", help_heading = "Rig")]
    true_rig: Option<String>,
    /// Folder of the tuned gains: DIR/PRESET.toml is ours, DIR/compared/PRESET/NAME.toml the others'
    #[arg(long, value_name = "DIR", default_value = "gains")]
    gains: PathBuf,
    /// Write every flight's numbers, a row each: .parquet, .npz or .csv
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    export: Option<PathBuf>,
    /// Draw how many plants cost how much with each controller (.svg or .png)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
    /// Write the comparison as a page, with its table and figure as CSV, into this folder
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    report: Option<PathBuf>,
    /// Fly one part of N of the plants and write it into --out, for 'merge': I/N, such as 3/16
    #[arg(long, value_name = "I/N", requires = "out", conflicts_with_all = NOT_OF_A_PART)]
    shard: Option<Shard>,
    /// File of the part
    #[arg(long, value_name = "PART", requires = "shard", help_heading = "Output")]
    out: Option<PathBuf>,
    /// First tune all but ours with one budget, N searches of 500 evaluations, and write the gains into the
    /// folder
    #[arg(long, value_name = "N")]
    tune: Option<usize>,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    preset: &'a str,
    fidelity: Fidelity,
    plants: usize,
    spread: f64,
    lag_spread: f64,
    scenes: robust::Scenes,
    seed: u64,
    rotor_lag: PerMotor<f64>,
    controllers: Vec<Row>,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    if args.fidelity != choices::Fidelity::Rig {
        return Err(Failure::Input("--fidelity is ideal; allowed: rig".to_owned()));
    }
    within("--plants", args.plants, 2, MOST_PLANTS)?;
    let scatter = args.spreads.scatter()?;
    let found = args.device.find()?;
    let trial = trial(args, &named, &scatter)?.on(found.device());
    let mut outputs = outputs(args, &named)?;
    if let Some(rounds) = args.tune {
        tune_all(args, &named, rounds, &scatter, &mut outputs)?;
    }
    let controllers = controllers(args, &named)?;
    let scenario = args.scenario.as_deref().map(|name| scenario::read(args, name)).transpose()?;
    let head = Head {
        preset: named.name.clone(),
        plants: args.plants,
        scatter,
        scenes: args.scenes.into(),
        seed: args.common.seed,
        rotor_lag: named.rig.plant.rotor_time_constant,
        controllers: controllers
            .iter()
            .map(|(name, controller)| {
                (name.clone(), design::uses(controller).into_iter().map(str::to_owned).collect())
            })
            .collect(),
    };
    if let (Some(shard), Some(path)) = (args.shard, &args.out) {
        let identity = part::identity(&head, &trial, &controllers, scenario.as_ref());
        let flown = fly(&trial.only(shard.range(args.plants)), &controllers, scenario.as_ref(), &found)?;
        outputs.write(path, &part::encode(&identity, &head, shard, &flown));
        return outputs.done();
    }
    let flown = fly(&trial, &controllers, scenario.as_ref(), &found)?;
    let wanted = Wanted {
        json: args.common.json,
        export: args.export.as_deref(),
        plot: args.plot.as_deref(),
        report: args.report.as_deref(),
        note: &found.note(args.plants, device::RIG_FLIGHTS),
    };
    show(&head, &flown, &wanted, &mut outputs)?;
    outputs.done()
}

/// All controllers on all plants of the trial.
fn fly(
    trial: &Trial,
    controllers: &[(String, ControllerSettings<f64>)],
    scenario: Option<&Scenario>,
    found: &device::Found,
) -> Outcome<Flown> {
    if let Some(scenario) = scenario {
        return scenario::fly(trial, controllers, scenario);
    }
    let fly = |controller| found.all(trial.supervised(controller, NEVER));
    Ok(Flown::Steps(controllers.iter().map(|(_, controller)| fly(controller)).collect::<Outcome<_>>()?))
}

/// How it is to be told.
struct Wanted<'a> {
    json: bool,
    export: Option<&'a Path>,
    plot: Option<&'a Path>,
    report: Option<&'a Path>,
    /// Under the table.
    note: &'a str,
}

/// Tells what came of it.
fn show(head: &Head, flown: &Flown, wanted: &Wanted<'_>, outputs: &mut Outputs) -> Outcome<()> {
    let Wanted { json, export, plot, report: folder, note } = *wanted;
    let scores = match flown {
        Flown::Scenario(scenario, flights) => return scenario::show(head, scenario, flights, json),
        Flown::Steps(scores) => scores,
    };
    let rows: Vec<Row> = head
        .controllers
        .iter()
        .zip(scores)
        .enumerate()
        .map(|(k, ((name, uses), own))| Row::new(name, own, (k > 0).then_some(&*scores[0]), uses.clone()))
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
        })
    } else {
        print(&format!("{}{note}", report(head, &rows)))
    }
}

/// The comparison as a page.
fn page(head: &Head, rows: &[Row], figure: Figure, folder: &Path, outputs: &mut Outputs) -> Outcome<()> {
    let grid = Grid {
        name: "controllers".to_owned(),
        heads: HEADS.to_vec(),
        rows: rows.iter().map(|row| cells(row).to_vec()).collect(),
        note: LEGEND.replace('\n', ". "),
    };
    let caption =
        "The further to the left, the better; a curve that ends below 100 % has failed on the rest.";
    let picture = Picture { name: "costs".to_owned(), caption: caption.to_owned(), figure };
    let uses = Grid {
        name: "uses".to_owned(),
        heads: vec!["controller", "beside its law"],
        rows: rows.iter().map(|row| vec![row.name.clone(), row.uses.join(", ")]).collect(),
        note: String::new(),
    };
    let section = |title: &str| Section { title: title.to_owned(), ..Section::default() };
    let sections = [
        Section { measured: Some(grid), pictures: vec![picture], ..section("Controllers") },
        Section { measured: Some(uses), ..section("What stands around each law") },
    ];
    let text = format!(
        "{} plants drawn around {}, none of which a controller was tuned on; constants and thrust within \
         {} %, rotor lags within {} %. host-sim compare --preset {} --plants {} --seed {}, version {}.",
        head.plants,
        head.preset,
        100.0 * head.scatter.constants,
        100.0 * head.scatter.lag,
        head.preset,
        head.plants,
        head.seed,
        env!("CARGO_PKG_VERSION")
    );
    report::write_page(&format!("Controllers on {}", head.preset), &text, &sections, folder, outputs)
}

/// What is read and written.
fn outputs(args: &Args, named: &NamedRig) -> Outcome<Outputs> {
    let mut outputs = args.common.outputs();
    outputs.reads("--scenario", args.scenario.as_deref().unwrap_or_default());
    outputs.reads("--true-rig", args.true_rig.as_deref().unwrap_or_default());
    outputs.reads("--gains", ours_path(args, named));
    for name in args.controllers.iter().filter(|name| is_text(name)) {
        outputs.reads("--controllers", name);
    }
    if let Some(rounds) = args.tune {
        within("--tune", rounds, 1, 1_000)?;
        for (name, _) in tuned(args) {
            let path = compared_path(args, named, name);
            output::check_folder("--gains", path.parent().unwrap_or(&args.gains))?;
            outputs.writes("--gains", &path)?;
        }
    }
    if let Some(path) = &args.export {
        export::check("--export", path, false)?;
        outputs.writes("--export", path)?;
    }
    told(args.plot.as_deref(), args.report.as_deref(), &mut outputs)?;
    if let Some(path) = &args.out {
        outputs.writes("--out", path)?;
    }
    Ok(outputs)
}

/// Where figure and page go.
fn told(plot: Option<&Path>, report: Option<&Path>, outputs: &mut Outputs) -> Outcome<()> {
    drawn(plot, outputs)?;
    if let Some(folder) = report {
        output::check_folder("--report", folder)?;
        for file in ["index.html", "controllers.csv", "costs.csv", "uses.csv"] {
            outputs.writes("--report", &folder.join(file))?;
        }
    }
    Ok(())
}

/// The plants to fly, and how.
fn trial(args: &Args, named: &NamedRig, scatter: &Scatter) -> Outcome<Trial> {
    let allowance = match args.allowance {
        Some(allowance) if (1.0..=120.0).contains(&allowance) => allowance,
        Some(allowance) => {
            return Err(Failure::Input(format!("--allowance is {allowance}; allowed: 1 to 120 s")));
        }
        None => robust::allowance(&named.name, &named.rig),
    };
    let seed = args.common.seed.wrapping_add(robust::UNSEEN);
    let mut trial =
        Trial::within(&named.rig, args.plants, seed, allowance, scatter).flying(args.scenes.into());
    if let Some(text) = &args.step {
        let [pitch, yaw] = pair("--step", text)?;
        if !(pitch > 0.0 && pitch <= 90.0 && yaw > 0.0 && yaw <= 360.0) {
            return Err(Failure::Input(format!("--step is {text}; allowed: above 0 to 90,360 degrees")));
        }
        trial.step = PerAxis::new(pitch, yaw).map(f64::to_radians);
    }
    trial.truth = truth(args.true_rig.as_deref(), args.true_lag, named)?;
    let plant = trial.truth.plant;
    for draw in &mut trial.plants {
        if args.true_rig.is_some() {
            let rotor_time_constant = draw.plant.rotor_time_constant;
            draw.plant = PlantParameters { rotor_time_constant, ..plant };
        }
        if args.true_lag.is_some() {
            draw.plant.rotor_time_constant = plant.rotor_time_constant;
        }
    }
    if args.true_rig.is_some() && args.spreads.spread.is_some() {
        return Err(no_effect("--spread", "with --true-rig", "every plant is that rig"));
    }
    if args.true_lag.is_some() && args.spreads.lag_spread.is_some() {
        return Err(no_effect("--lag-spread", "with --true-lag", "every rotor has that lag"));
    }
    Ok(trial)
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

fn ours_path(args: &Args, named: &NamedRig) -> PathBuf {
    args.gains.join(format!("{}.toml", file_stem(named)))
}

fn compared_path(args: &Args, named: &NamedRig, name: &str) -> PathBuf {
    args.gains.join("compared").join(file_stem(named)).join(format!("{name}.toml"))
}

fn file_stem(named: &NamedRig) -> String {
    Path::new(&named.name)
        .file_stem()
        .map_or_else(|| named.name.clone(), |s| s.to_string_lossy().into_owned())
}

/// Ours first, then what was asked for, or all. What has no tuned gains, as on a rig of one's own, flies as
/// it was designed and is marked so.
fn controllers(args: &Args, named: &NamedRig) -> Outcome<Vec<(String, ControllerSettings<f64>)>> {
    let load =
        |path: &Path| Ok::<_, Failure>(files::gains("--gains", &path.display().to_string())?.controller);
    let tuned_or_designed = |path: &Path, shown: &str, design: &str| {
        if path.exists() {
            return Ok((shown.to_owned(), load(path)?));
        }
        let design = known_name("controller", design, &CATALOGUE)?;
        Ok::<_, Failure>((format!("{shown} (untuned)"), design(&named.rig)))
    };
    let mut list = vec![tuned_or_designed(&ours_path(args, named), "ours", "integral")?];
    let asked: Vec<String> = if args.controllers.is_empty() {
        CATALOGUE.map(|(name, _)| name.to_owned()).to_vec()
    } else {
        args.controllers.iter().filter(|name| *name != "ours").cloned().collect()
    };
    for name in asked {
        list.push(if name == "paper" {
            (name, GainsFile::paper().controller)
        } else if is_text(&name) {
            let controller = load(Path::new(&name))?;
            (name, controller)
        } else {
            tuned_or_designed(&compared_path(args, named, &name), &name, &name)?
        });
    }
    Ok(list)
}

/// Tunes every kind of controller with the same budget on the same plants, and writes their gains. What flies
/// by default has had more.
fn tune_all(
    args: &Args,
    named: &NamedRig,
    rounds: usize,
    scatter: &Scatter,
    outputs: &mut Outputs,
) -> Outcome<()> {
    let tuning = Tuning::standard(named, rounds, args.common.seed, scatter);
    for (name, design) in tuned(args) {
        outputs.write(&compared_path(args, named, name), tuning.run(design)?.to_toml().as_bytes());
    }
    Ok(())
}

/// What is tuned for the comparison.
fn tuned(args: &Args) -> impl Iterator<Item = (&'static str, Design)> {
    let wanted = |name: &str| args.controllers.is_empty() || args.controllers.iter().any(|c| c == name);
    CATALOGUE.into_iter().filter(move |(name, _)| *name != "paper" && wanted(name))
}

/// What the heads of the table stand for.
const LEGEND: &str = "\
c: a flight's cost; J: its mean, and half its 90 % quantile; less is better
fail: diverged, outside the envelope, not inside 5 % in time, or cut by the board
ts2: settling within 2 %; OS: overshoot; medians, or the value that 95 % stay below
dist, hold: error after the disturbance, and before; V/s: volts moved while holding
sat: time with a motor at its limit; p: chance of such a difference to the first
";

/// The heads of the table.
const HEADS: [&str; 13] = [
    "controller",
    "J",
    "fail",
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
    let pair =
        |v: twinrotor::axes::PerAxis<f64>, digits: usize| format!("{:.digits$}/{:.digits$}", v.pitch, v.yaw);
    [
        r.name.clone(),
        format!("{:.3}", r.total),
        r.failures.to_string(),
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
    let beside = if head.scenes == robust::Scenes::All { scenes(rows) } else { String::new() };
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

/// What the scenes beside the step came to.
fn scenes(rows: &[Row]) -> String {
    let names = rows.first().map_or(&[][..], |row| &row.scenes).iter().map(|scene| scene.name);
    let heads: Vec<&str> = ["controller", "J of the step alone"].into_iter().chain(names).collect();
    let mut table = tables::table(&heads);
    for row in rows {
        let cell = |scene: &SceneRow| {
            let failures = if scene.failures > 0 { format!(" ({})", scene.failures) } else { String::new() };
            format!("{:.3}: {:.2}/{:.2}{failures}", scene.cost, scene.error.pitch, scene.error.yaw)
        };
        let step = [row.name.clone(), format!("{:.3}", row.step_total)];
        tables::add(&mut table, step.into_iter().chain(row.scenes.iter().map(cell)));
    }
    format!(
        "scenes: what each adds to c, mean; RMS error p/y in parts of the goal, median; (flights that left \
         the envelope)\n{table}\n"
    )
}
