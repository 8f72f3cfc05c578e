//! Any scenario on drawn plants, hot or cold, each flown with the board's supervisor.

use super::Args;
use crate::cli::{print, print_json, tables};
use crate::error::{Failure, Outcome};
use crate::{files, stop};
use serde::Serialize;
use twinrotor::controller::ControllerSettings;
use twinrotor_sim::rig::NamedRig;
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
    controllers: &'a [Surveyed],
}

/// Flies and reports.
pub(super) fn run(
    args: &Args,
    name: &str,
    named: &NamedRig,
    trial: &Trial,
    controllers: &[(String, ControllerSettings<f64>)],
) -> Outcome<()> {
    let mut scenario = files::scenario(name)?;
    scenario.start.hot |= args.hot;
    scenario.validate()?;
    if scenario.duration > LONGEST {
        return Err(Failure::Input(format!(
            "--scenario {name} lasts {} s; allowed: at most {LONGEST} s for each plant",
            scenario.duration
        )));
    }
    let listening = stop::listen(stop::Second::Ends);
    let flown: Option<Vec<Vec<Judged>>> = controllers
        .iter()
        .map(|(_, controller)| trial.survey(controller, &scenario, &stop::requested))
        .collect();
    drop(listening);
    let Some(flown) = flown else {
        return Err(Failure::Interrupted("not all flights had been flown; nothing is written".to_owned()));
    };
    let rows: Vec<Surveyed> = controllers
        .iter()
        .zip(&flown)
        .enumerate()
        .map(|(k, ((name, _), own))| Surveyed::new(name, own, (k > 0).then_some(&*flown[0])))
        .collect();
    if args.common.json {
        return print_json(&Document {
            preset: &named.name,
            scenario: &scenario.name,
            duration_s: scenario.duration,
            hot: scenario.start.hot,
            plants: args.plants,
            seed: args.common.seed,
            controllers: &rows,
        });
    }
    print(&report(args, named, &scenario, &rows))
}

fn report(args: &Args, named: &NamedRig, scenario: &Scenario, rows: &[Surveyed]) -> String {
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
    let heat = if scenario.start.hot { "warm motors" } else { "cold motors" };
    format!(
        "{}, scenario {}: {} plants that nothing was tuned on, {heat}, flown as the board does, \
         seed {}\n{table}\n",
        named.name, scenario.name, args.plants, args.common.seed
    )
}
