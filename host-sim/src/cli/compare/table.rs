//! A comparison as tables: on the terminal, and as a page.

use super::part::Head;
use crate::cli::tables;
use crate::error::Outcome;
use crate::files::output::Outputs;
use crate::report::{self, Grid, Picture, Section};
use std::path::Path;
use twinrotor::axes::PerAxis;
use twinrotor_plot::Figure;
use twinrotor_tune::robust::{LagRow, Row, SceneRow, Scenes};

/// What the heads of the table stand for.
const LEGEND: &str = "\
c: a flight's cost; J: its mean, and half its 90 % quantile; less is better
fail: diverged, outside the envelope, not inside 5 % in time, cut by the board;
P<: the probability of that is below this, 95 % sure
ts2: settling within 2 %; OS: overshoot; medians, or what 95 % stay below
dist, hold: error after the disturbance, before it; V/s: volts moved in holding
sat: time with a motor at its limit
";

/// That, and what p is.
fn legend(head: &Head, reference: usize) -> String {
    let against = head.controllers.get(reference).map_or("", |(name, _)| name);
    format!("{LEGEND}p: chance of such a difference to {against} (Wilcoxon, two-sided, paired by plant)\n")
}

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

pub(super) fn report(head: &Head, rows: &[Row], reference: usize) -> String {
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
        "{}: {} plants that nothing was tuned on, rig fidelity, seed {}\n{table}\n{}{beside}\
         uses:\n{}\n",
        head.preset,
        head.plants,
        head.seed,
        legend(head, reference),
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

/// The comparison as a page.
pub(super) fn page(
    head: &Head,
    rows: &[Row],
    reference: usize,
    figure: Figure,
    folder: &Path,
    outputs: &mut Outputs,
) -> Outcome<()> {
    let grid = Grid {
        name: "controllers".to_owned(),
        heads: HEADS.map(Into::into).into(),
        rows: rows.iter().map(|row| cells(row).to_vec()).collect(),
        note: legend(head, reference).trim_end().replace(";\n", "; ").replace('\n', ". "),
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
    let beside = if head.scenes == Scenes::All { ", the step and all scenes" } else { "" };
    let text = format!(
        "{} plants drawn around {} by seed {}, none of which a controller was tuned on; constants and thrust \
         within {} %, rotor lags within {} %{beside}. {}; version {}.",
        head.plants,
        head.preset,
        head.seed,
        100.0 * head.scatter.constants,
        100.0 * head.scatter.lag,
        head.command,
        env!("CARGO_PKG_VERSION")
    );
    report::write_page(&format!("Controllers on {}", head.preset), &text, &flown, folder, outputs)
}
