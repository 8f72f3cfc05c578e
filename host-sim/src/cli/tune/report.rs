//! What `tune` reports.

use super::beside::Beside;
use super::integral::Task;
use super::request::Request;
use crate::cli::next::next;
use crate::cli::tables;
use crate::error::Outcome;
use serde::Serialize;
use std::fmt::Write;
use twinrotor::gains::{self, NAMES};
use twinrotor_sim::flight::{Fidelity, Flight};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::scenario::SAMPLE_TIME;
use twinrotor_tune::integral::Objective;
use twinrotor_tune::search::{Effort, Search};
use twinrotor_tune::tunable::AtBound;

/// As it is typed.
pub(super) fn name_of(criterion: Criterion) -> String {
    format!("{criterion:?}").to_lowercase()
}

/// A search's effort and course, of whatever objective.
#[derive(Debug, Serialize)]
pub(super) struct Run<'a> {
    algorithm: &'a str,
    preset: &'a str,
    seed: u64,
    evaluations: usize,
    cost: f64,
    wall_s: f64,
    horizon_s: f64,
    tick_s: f64,
    steps_simulated: u64,
    steps_skipped: u64,
    diverged: u64,
    history: &'a [(usize, f64)],
    /// What the search has left at a bound of its box, or of its last round's.
    at_bounds: Vec<AtBound>,
}

impl<'a> Run<'a> {
    pub(super) fn new(
        request: &'a Request<'a>,
        search: &'a Search,
        horizon_s: f64,
        at_bounds: Vec<AtBound>,
    ) -> Self {
        let Effort { simulated, skipped, diverged } = search.effort();
        Self {
            algorithm: request.algorithm,
            preset: &request.named.name,
            seed: request.seed,
            evaluations: search.evaluations(),
            cost: search.best().map_or(f64::INFINITY, |b| b.cost),
            wall_s: request.begun.elapsed().as_secs_f64(),
            horizon_s,
            tick_s: SAMPLE_TIME,
            steps_simulated: simulated,
            steps_skipped: skipped,
            diverged,
            history: search.history(),
            at_bounds,
        }
    }
}

#[derive(Debug, Serialize)]
pub(super) struct Document<'a> {
    #[serde(flatten)]
    run: Run<'a>,
    objective: Criterion,
    scenario: &'a str,
    fidelity: Fidelity,
    /// Not known of a search that was interrupted.
    #[serde(flatten)]
    beside: Option<&'a Beside>,
    gains: &'a GainsFile,
}

pub(super) fn document<'a>(
    task: &'a Task<'a>,
    search: &'a Search,
    found: &'a GainsFile,
    beside: Option<&'a Beside>,
) -> Document<'a> {
    Document {
        run: Run::new(task.request, search, task.scenario.duration, at_bounds(search)),
        objective: task.criterion,
        scenario: &task.scenario.name,
        fidelity: task.fidelity,
        beside,
        gains: found,
    }
}

pub(super) fn summary(
    task: &Task<'_>,
    search: &Search,
    paper: f64,
    found: &GainsFile,
    flown: &[Flight; 2],
    beside: &Beside,
) -> String {
    let request = task.request;
    let mut text = String::new();
    let objective_name = name_of(task.criterion).to_uppercase();
    let best = search.best().map_or(f64::INFINITY, |b| b.cost);
    let Effort { simulated, skipped, diverged } = search.effort();
    let _ = writeln!(
        text,
        "{} on preset {}, scenario {}: {} evaluations, {:.2} million steps and {:.2} million skipped, in \
         {:.2} s",
        request.algorithm,
        request.named.name,
        task.scenario.name,
        search.evaluations(),
        simulated as f64 / 1e6,
        skipped as f64 / 1e6,
        request.begun.elapsed().as_secs_f64()
    );
    if diverged > 0 {
        let _ = writeln!(text, "{diverged} candidates diverged; they cost infinity");
    }
    let mut table = tables::table(&["", "paper (Table 4)", "tuned", "change"]);
    gain_rows(&mut table, found);
    let change = |a: f64, b: f64| format!("{:+.1} %", 100.0 * (b / a - 1.0));
    tables::add(
        &mut table,
        [
            format!("{objective_name}, what was minimised"),
            format!("{paper:.6}"),
            format!("{best:.6}"),
            change(paper, best),
        ],
    );
    flight_rows(&mut table, flown);
    let _ = writeln!(text, "{table}");
    text.push_str(&beside.text(&objective_name));
    text.push_str(&bound_warnings(search));
    text.push_str(&in_the_rigs_world(task, found, &objective_name));
    let _ = writeln!(text, "gains:   {}\nfigure:  {}", request.out.display(), task.plot.display());
    let fly = next("simulate").unless("paper", "--preset", &request.named.name);
    let fly = fly.with("--gains", request.out.display()).unless("step", "--scenario", &task.scenario_name);
    let fly = fly.unless("ideal", "--fidelity", format!("{:?}", task.fidelity).to_lowercase());
    let fly = task.horizon.map_or(fly.clone(), |seconds| fly.with("--duration", seconds));
    let fly = fly.board(request.named.rig.board);
    let lag = request.rotor_lag().filter(|_| task.fidelity == Fidelity::Rig);
    let fly = lag.map_or(fly.clone(), |seconds| fly.with("--rotor-lag", seconds));
    let _ = writeln!(text, "fly it:  {fly}");
    text
}

fn gain_rows(table: &mut tables::Table, found: &GainsFile) {
    let (paper, tuned) =
        (gains::PAPER.to_paper_order(), found.gains().expect("the paper's law").to_paper_order());
    for (k, name) in NAMES.iter().enumerate() {
        tables::add(
            table,
            [
                format!("k{} {name} [1/s]", k + 1),
                format!("{:.3}", paper[k]),
                format!("{:.3}", tuned[k]),
                String::new(),
            ],
        );
    }
}

fn flight_rows(table: &mut tables::Table, flown: &[Flight; 2]) {
    let mut row = |name: &str, of: &dyn Fn(&Flight) -> String| {
        tables::add(table, [name.to_owned(), of(&flown[0]), of(&flown[1]), String::new()]);
    };
    row("settling 2 %, pitch [s]", &|f| tables::seconds(f.report.pitch.settling_time_2));
    row("settling 2 %, yaw [s]", &|f| tables::seconds(f.report.yaw.settling_time_2));
    row("overshoot, pitch [%]", &|f| tables::percent(f.report.pitch.overshoot_percent));
    row("overshoot, yaw [%]", &|f| tables::percent(f.report.yaw.overshoot_percent));
    row("main motor beyond its limit [ms]", &|f| format!("{:.0}", 1e3 * f.report.main.saturation_time));
    row("tail motor beyond its limit [ms]", &|f| format!("{:.0}", 1e3 * f.report.tail.saturation_time));
    row("peak demand, main [V]", &|f| format!("{:.1}", f.report.main.peak_demand));
    row("peak demand, tail [V]", &|f| format!("{:.1}", f.report.tail.peak_demand));
}

/// The gains that the search has left at a bound of its box.
fn at_bounds(search: &Search) -> Vec<AtBound> {
    search.best().map_or_else(Vec::new, |best| Objective::at_bounds(&search.reached(), &best.position))
}

fn bound_warnings(search: &Search) -> String {
    let warning = |AtBound { name, value, bound, .. }: AtBound| {
        format!(
            "warning: {name} = {value:.3} lies at the bound {bound}: the objective wants more than the \
             bounds allow\n"
        )
    };
    at_bounds(search).into_iter().map(warning).collect()
}

/// The same two sets of gains with what an objective in the paper's world does not see.
fn in_the_rigs_world(task: &Task<'_>, found: &GainsFile, objective_name: &str) -> String {
    if task.fidelity == Fidelity::Rig {
        return String::new();
    }
    let mut text = format!(
        "\nWhat {objective_name} in the paper's world does not see: the same gains in the rig's (--fidelity \
         rig: rotor lag {} s, encoder counts, estimated rates, one tick of delay)\n",
        task.request.named.rig.plant.rotor_time_constant.main
    );
    let flights = [GainsFile::paper(), found.clone()].map(|g| task.fly_in(&g, Fidelity::Rig));
    let cell = |f: &Outcome<Flight>, of: &dyn Fn(&Flight) -> String| match f {
        Ok(flight) => of(flight),
        Err(_) => "diverges".to_owned(),
    };
    let mut table = tables::table(&["", "paper (Table 4)", "tuned"]);
    let mut row = |name: &str, of: &dyn Fn(&Flight) -> String| {
        tables::add(&mut table, [name.to_owned(), cell(&flights[0], of), cell(&flights[1], of)]);
    };
    row("settling 2 %, pitch / yaw [s]", &|f| {
        format!(
            "{} / {}",
            tables::seconds(f.report.pitch.settling_time_2),
            tables::seconds(f.report.yaw.settling_time_2)
        )
    });
    row("overshoot, pitch / yaw [%]", &|f| {
        format!(
            "{} / {}",
            tables::percent(f.report.pitch.overshoot_percent),
            tables::percent(f.report.yaw.overshoot_percent)
        )
    });
    row("motors beyond their limits [ms]", &|f| {
        format!("{:.0}", 1e3 * (f.report.main.saturation_time + f.report.tail.saturation_time))
    });
    let _ = writeln!(text, "{table}");
    text
}
