//! `map`: what the cost is around a controller, over two of its numbers.

use super::bench_tuners::Goal;
use super::choices;
use super::common::{Checkpoint, Common, Device, bar, drawn, no_effect, within};
use super::{print, print_json};
use crate::device::{self, Found};
use crate::error::{Failure, Outcome};
use crate::files;
use crate::files::checkpoint::Keeper;
use crate::files::export;
use crate::files::figure;
use crate::files::output::Outputs;
use crate::stop;
use serde::Serialize;
use std::path::PathBuf;
use twinrotor::gains::{self, Gains};
use twinrotor::settings::Field;
use twinrotor_plot::map::{Map, Scale};
use twinrotor_sim::error::at_least;
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::rig::{self, NamedRig};
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::table::{Column, Table};
use twinrotor_tune::checkpoint::Identity;
use twinrotor_tune::integral::Objective;
use twinrotor_tune::landscape::{Axis, Landscape};
use twinrotor_tune::optimise::Candidate;
use twinrotor_tune::parallel::NEVER;
use twinrotor_tune::robust::{self, Robust, Trial};
use twinrotor_tune::search::Problem;
use twinrotor_tune::tunable::Tunable;

/// Flights that go together: what a card takes in one launch.
const AT_ONCE: usize = 1 << 20;

/// Flags of `map`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    device: Device,
    /// Gains around which is looked: 'paper' (Table 4) or a gains file
    #[arg(long, value_name = "paper|FILE")]
    gains: String,
    /// The two numbers, by their names in the gains file: across, up
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', required = true)]
    parameters: Vec<String>,
    /// What is mapped: J on drawn plants, or the paper's ISE of its four gains in 1 to 25
    #[arg(long, default_value = "robust")]
    objective: Goal,
    /// Robust: on how many plants [default: 32]
    #[arg(long, value_name = "N")]
    plants: Option<usize>,
    /// Robust: what is flown on each plant [default: step]
    #[arg(long)]
    scenes: Option<choices::Scenes>,
    /// Robust: factor up to which each number is varied [default: 4]
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    range: Option<f64>,
    /// Cells across and up
    #[arg(long, value_name = "N", default_value_t = 50)]
    cells: usize,
    #[command(flatten)]
    checkpoint: Checkpoint,
    /// Draw it (.svg or .png)
    #[arg(long, value_name = "FILE", default_value = "map.svg", help_heading = "Output")]
    plot: PathBuf,
    /// Write every cell as a row (.parquet, .npz or .csv)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    export: Option<PathBuf>,
}

/// A place on the map.
#[derive(Debug, Serialize)]
struct Place {
    /// Across, up.
    values: [f64; 2],
    cost: f64,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    preset: &'a str,
    objective: Goal,
    seed: u64,
    plants: Option<usize>,
    cells: usize,
    parameters: [&'static str; 2],
    from: [f64; 2],
    to: [f64; 2],
    /// The cell that costs least.
    best: Option<Place>,
    /// The given gains.
    here: Place,
}

/// What is mapped, and over what.
struct Ground<'a> {
    problem: Box<dyn Problem + 'a>,
    /// Where on it a pair of coordinates is.
    position: Box<dyn Fn([f64; 2]) -> Vec<f64> + 'a>,
    /// The value that a coordinate is.
    value: Box<dyn Fn(usize, f64) -> f64 + 'a>,
    fields: [&'static Field; 2],
    axes: [Axis; 2],
    logarithmic: bool,
    /// The coordinates of the given gains.
    here: [f64; 2],
    what: String,
    /// Flights of a candidate, and how many of them a core flies in the time of a launch.
    flights: [usize; 2],
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    within("--cells", args.cells, 2, 2_000)?;
    let file = files::gains("--gains", &args.gains)?;
    let found = args.device.find()?;
    let mut outputs = args.common.outputs();
    outputs.reads("--gains", &args.gains);
    drawn(Some(&args.plot), &mut outputs)?;
    if let Some(path) = &args.export {
        export::check("--export", path, false)?;
        outputs.writes("--export", path)?;
    }
    args.checkpoint.check(&mut outputs)?;
    match args.objective {
        Goal::Ise => {
            let gains = paper_gains(args, &file)?;
            let step = Scenario::named("step")?;
            let seed = args.common.seed;
            let problem = Objective::new(Criterion::Ise, &named.rig, &step, Fidelity::Ideal, seed);
            let ground = of_ise(args, &file, gains, problem.on(found.device()))?;
            explore(args, &named, &file, &ground, &found, outputs)
        }
        Goal::Robust => {
            let plants = within("--plants", args.plants.unwrap_or(32), 1, 100_000)?;
            let tunable = Tunable::new(&file.controller, &args.parameters)?;
            let allowance = robust::allowance(&named.name, &named.rig);
            let scenes = args.scenes.map_or(robust::Scenes::Step, Into::into);
            let trial =
                Trial::new(&named.rig, plants, args.common.seed, allowance).flying(scenes).on(found.device());
            let ground = of_j(args, &file, &trial, &tunable)?;
            explore(args, &named, &file, &ground, &found, outputs)
        }
    }
}

/// The four gains of the paper's law, which is what its ISE is of.
fn paper_gains(args: &Args, file: &GainsFile) -> Outcome<Gains<f64>> {
    let given = [
        ("--plants", args.plants.is_some(), "ISE is of one plant"),
        ("--scenes", args.scenes.is_some(), "ISE is of the step"),
        ("--range", args.range.is_some(), "gains are looked at in 1..25"),
        ("--rotor-lag", args.common.rotor_lag.is_some(), "rotors of the paper's world have none"),
    ];
    if let Some((flag, _, why)) = given.into_iter().find(|(_, given, _)| *given) {
        return Err(no_effect(flag, "with --objective ise", why));
    }
    file.gains().ok_or_else(|| {
        let why = "--gains has another law; allowed with --objective ise: gains of the paper's law";
        Failure::Input(why.to_owned())
    })
}

/// The two that were named, in their order, by their places among those of `tunable`.
fn two(args: &Args, file: &GainsFile, tunable: &Tunable) -> Outcome<[usize; 2]> {
    let place = |wanted: &String| tunable.names().iter().position(|name| name == wanted);
    if let [across, up] = &args.parameters[..]
        && across != up
        && let (Some(across), Some(up)) = (place(across), place(up))
    {
        return Ok([across, up]);
    }
    let all = Tunable::new(&file.controller, &[])?.names().join(", ");
    let given = args.parameters.join(",");
    Err(Failure::Input(format!("--parameters is {given}; allowed: two different ones of {all}")))
}

fn of_ise<'a>(args: &Args, file: &GainsFile, gains: Gains<f64>, problem: Objective) -> Outcome<Ground<'a>> {
    // By name they stand in the paper's order: pitch before yaw, position before rate.
    let tunable = Tunable::new(&file.controller, &["pitch".to_owned(), "yaw".to_owned()])?;
    let order = gains.to_paper_order();
    let [across, up] = two(args, file, &tunable)?;
    let [from, to] = gains::PAPER_BOUNDS;
    Ok(Ground {
        problem: Box::new(problem),
        position: Box::new(move |[x, y]| {
            let mut position = order.to_vec();
            position[across] = x;
            position[up] = y;
            position
        }),
        value: Box::new(|_, coordinate| coordinate),
        fields: [across, up].map(|k| tunable.fields()[k]),
        axes: [Axis { from, to, cells: args.cells }; 2],
        logarithmic: false,
        here: [order[across], order[up]],
        what: "ISE of the step".to_owned(),
        flights: [1, device::IDEAL_FLIGHTS],
    })
}

fn of_j<'a>(args: &Args, file: &GainsFile, trial: &'a Trial, tunable: &'a Tunable) -> Outcome<Ground<'a>> {
    let range = at_least("--range", args.range.unwrap_or(4.0), 1.0, true)?;
    let [across, up] = two(args, file, tunable)?;
    let reach = range.ln();
    let plants = trial.plants.len();
    Ok(Ground {
        problem: Box::new(Robust::new(trial, tunable)),
        position: Box::new(move |[x, y]| {
            let mut position = vec![0.0; tunable.names().len()];
            position[across] = x;
            position[up] = y;
            position
        }),
        value: Box::new(move |axis, coordinate| tunable.start()[[across, up][axis]] * coordinate.exp()),
        fields: [across, up].map(|k| tunable.fields()[k]),
        axes: [Axis { from: -reach, to: reach, cells: args.cells }; 2],
        logarithmic: true,
        here: [0.0; 2],
        what: format!("J on {plants} plants"),
        flights: [plants, device::RIG_FLIGHTS],
    })
}

fn explore(
    args: &Args,
    named: &NamedRig,
    file: &GainsFile,
    ground: &Ground<'_>,
    found: &Found,
    mut outputs: Outputs,
) -> Outcome<()> {
    let [x, y] = ground.fields.map(|field| field.name);
    let identity = Identity::new()
        .with("preset", &named.name)
        .with_toml(&rig::to_toml(&named.rig))
        .with_toml(&file.to_toml())
        .with("objective", &ground.what)
        .with("scenes", format_args!("{:?}", args.scenes.map_or(robust::Scenes::Step, Into::into)))
        .with("parameters", format_args!("{x},{y}"))
        .with("range", args.range.unwrap_or(4.0))
        .with("cells", args.cells)
        .with("seed", args.common.seed);
    let begun = Landscape::new(identity, ground.axes);
    let mut all = args.checkpoint.resume_or(begun, |begun, bytes| begun.resume(bytes))?;

    let listening = stop::listen(stop::Second::Ends);
    let bar = bar(all.cells(), "{bar:32} {pos}/{len} cells, {eta} left");
    let keeper = Keeper::new(args.checkpoint.file.as_deref());
    let at_once = if found.device().is_some() { AT_ONCE / ground.flights[0] } else { 1 };
    let complete = all.run(&*ground.problem, &ground.position, at_once, &stop::requested, |all| {
        bar.set_position(all.costs().len() as u64);
        keeper.keep(|| all.checkpoint());
    });
    bar.finish_and_clear();
    drop(listening);
    if !complete {
        keeper.keep_now(|| all.checkpoint());
        let go_on = keeper
            .done(&mut outputs)
            .map_or_else(String::new, |path| format!("; --checkpoint {} --resume goes on", path.display()));
        outputs.done()?;
        let left = format!("{} of {} cells are known{go_on}", all.costs().len(), all.cells());
        return Err(match found.failure() {
            Some(why) => Failure::Run(format!("{why}; {left}")),
            None => Failure::Interrupted(left),
        });
    }
    tell(args, named, ground, &all, found, outputs)
}

fn tell(
    args: &Args,
    named: &NamedRig,
    ground: &Ground<'_>,
    all: &Landscape,
    found: &Found,
    mut outputs: Outputs,
) -> Outcome<()> {
    let value = |place: [f64; 2]| [0, 1].map(|axis| (ground.value)(axis, place[axis]));
    let cost = |cell: usize| all.costs().get(cell).copied().unwrap_or(f64::NAN);
    let [across, up] = all.axes();
    let given = Candidate { position: (ground.position)(ground.here), bound: f64::INFINITY };
    let given = found.all(ground.problem.costs_until(&[given], NEVER))?;
    let here = Place { values: value(ground.here), cost: given.first().copied().unwrap_or(f64::NAN) };
    let best = all.best().map(|cell| Place { values: value(all.place(cell)), cost: cost(cell) });
    let [from, to] = [[across.from, up.from], [across.to, up.to]].map(value);
    let scale = |axis: usize| Scale {
        label: match ground.fields[axis] {
            Field { name, unit: "-" | "", .. } => (*name).to_owned(),
            Field { name, unit, .. } => format!("{name} [{unit}]"),
        },
        from: from[axis],
        to: to[axis],
        logarithmic: ground.logarithmic,
        cells: args.cells,
    };
    let mark = |place: &Place, name: &str| (place.values[0], place.values[1], name.to_owned());
    let map = Map {
        title: format!("{}: {} around {}", named.name, ground.what, args.gains),
        x: scale(0),
        y: scale(1),
        what: ground.what.clone(),
        values: all.costs().to_vec(),
        marks: best.iter().map(|best| mark(best, "least")).chain([mark(&here, "given")]).collect(),
    };
    outputs.write(&args.plot, &figure::of_svg(map.to_svg()?, &args.plot)?);
    if let Some(path) = &args.export {
        let mut table = Table::default();
        for (axis, field) in ground.fields.iter().enumerate() {
            let values = (0..all.cells()).map(|cell| value(all.place(cell))[axis]);
            table.push(field.name, Column::Numbers(values.collect()));
        }
        table.push("cost", Column::Numbers(all.costs().to_vec()));
        outputs.write(path, &export::bytes(&table, path)?);
    }
    let names = ground.fields.map(|field| field.name);
    if args.common.json {
        print_json(&Document {
            preset: &named.name,
            objective: args.objective,
            seed: args.common.seed,
            plants: (args.objective == Goal::Robust).then_some(ground.flights[0]),
            cells: args.cells,
            parameters: names,
            from,
            to,
            best,
            here,
        })?;
    } else {
        let told = |place: &Place| {
            let [x, y] = place.values;
            format!("{:.6} at {} {x:.4}, {} {y:.4}", place.cost, names[0], names[1])
        };
        let least = best.as_ref().map_or_else(|| "none is finite".to_owned(), told);
        let flights = all.cells().saturating_mul(ground.flights[0]).min(AT_ONCE);
        let note = found.note(flights, ground.flights[1]);
        print(&format!(
            "{}: {}, {} x {} cells\nleast: {least}\ngiven: {}\nmap: {}\n{note}",
            named.name,
            ground.what,
            args.cells,
            args.cells,
            told(&here),
            args.plot.display()
        ))?;
    }
    outputs.done()
}
