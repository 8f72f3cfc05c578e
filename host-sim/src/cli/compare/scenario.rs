//! Any scenario on drawn plants, hot or cold, each flown with the board's supervisor.

use super::Args;
use super::part::{Course, Flown, Head};
use crate::cli::{print, print_json, tables};
use crate::error::{Failure, Outcome};
use crate::{files, stop};
use serde::Serialize;
use twinrotor::controller::ControllerSettings;
use twinrotor_sim::scenario::Scenario;
use twinrotor_tune::robust::{Judged, Surveyed, Trial};

/// \[s\] Longest scenario: an interrupt is heard between flights.
const LONGEST: f64 = 300.0;

#[derive(Debug, Serialize)]
struct Document<'a> {
    preset: &'a str,
    scenario: &'a str,
    duration_s: f64,
    hot: bool,
    plants: usize,
    seed: u64,
    against: &'a str,
    controllers: &'a [Surveyed],
}

/// What is to be flown.
pub(super) fn read(args: &Args, name: &str) -> Outcome<Scenario> {
    let mut scenario = files::scenario(name)?;
    scenario.start.hot |= args.hot;
    scenario.validate()?;
    if scenario.duration > LONGEST {
        return Err(Failure::Input(format!(
            "--scenario {name} lasts {} s; allowed: at most {LONGEST} s for each plant",
            scenario.duration
        )));
    }
    Ok(scenario)
}

/// All controllers on all plants of the trial.
pub(super) fn fly(
    trial: &Trial,
    controllers: &[(String, ControllerSettings<f64>)],
    scenario: &Scenario,
) -> Outcome<Flown> {
    let listening = stop::listen(stop::Second::Ends);
    let flown: Option<Vec<Vec<Judged>>> = controllers
        .iter()
        .map(|(_, controller)| trial.survey(controller, scenario, &stop::requested))
        .collect();
    drop(listening);
    let Some(flown) = flown else {
        return Err(Failure::Interrupted("not all flights had been flown; nothing is written".to_owned()));
    };
    let (name, duration, hot) = (scenario.name.clone(), scenario.duration, scenario.start.hot);
    Ok(Flown::Scenario(Course { name, duration, hot }, flown))
}

/// Tells what came of it.
pub(super) fn show(
    head: &Head,
    course: &Course,
    flown: &[Vec<Judged>],
    reference: usize,
    json: bool,
) -> Outcome<()> {
    let rows: Vec<Surveyed> = head
        .controllers
        .iter()
        .zip(flown)
        .enumerate()
        .map(|(k, ((name, _), own))| Surveyed::new(name, own, (k != reference).then_some(&*flown[reference])))
        .collect();
    if json {
        return print_json(&Document {
            preset: &head.preset,
            scenario: &course.name,
            duration_s: course.duration,
            hot: course.hot,
            plants: head.plants,
            seed: head.seed,
            against: &head.controllers[reference].0,
            controllers: &rows,
        });
    }
    print(&report(head, course, &rows, reference))
}

fn report(head: &Head, course: &Course, rows: &[Surveyed], reference: usize) -> String {
    let mut table = tables::table(&[
        "controller",
        "fail",
        "of these cut",
        "RMS error p/y [deg]",
        "95 %",
        "both 5/50/95 %",
        "pitch 95 % [deg]",
        "V/s",
        "sat [%]",
        "p",
    ]);
    for r in rows {
        tables::add(
            &mut table,
            [
                r.name.clone(),
                r.failures.to_string(),
                r.cuts.to_string(),
                format!("{:.2}/{:.2}", r.rms_deg.pitch, r.rms_deg.yaw),
                format!("{:.2}/{:.2}", r.rms_p95.pitch, r.rms_p95.yaw),
                format!("{:.2}/{:.2}/{:.2}", r.error.p5, r.error.median, r.error.p95),
                format!("{:.1}", r.pitch_p95),
                format!("{:.0}", r.voltage_variation),
                format!("{:.1}", r.saturation_percent),
                r.p_value.map_or_else(String::new, |p| format!("{p:.1e}")),
            ],
        );
    }
    let heat = if course.hot { "warm motors" } else { "cold motors" };
    format!(
        "{}, scenario {}: {} plants that nothing was tuned on, {heat}, flown as the board does, \
         seed {}\n{table}\np: chance of such a difference to {} (Wilcoxon, two-sided, paired by plant)\n",
        head.preset, course.name, head.plants, head.seed, head.controllers[reference].0
    )
}
