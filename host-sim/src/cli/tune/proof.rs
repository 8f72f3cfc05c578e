//! What a robust search has found, flown as a board flies it before it is written: beyond the objective's own
//! flights, and on encoders as coarse as they are.

use serde::Serialize;
use std::fmt::Write;
use twinrotor::axes::PerAxis;
use twinrotor::controller::ControllerSettings;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor_sim::Outcome;
use twinrotor_sim::flight::{self, Extent, Fidelity, Flight, Plan, Scalar};
use twinrotor_sim::scenario::{SAMPLE_TIME, Scenario};

/// What is flown, as scenario files have it. Reversals are those of `scenarios/reversals.toml`.
const FLIGHTS: [(&str, &str); 3] = [
    ("far step", "duration = 20\n[pitch.steps]\njumps = [[0, 25]]\n[yaw.steps]\njumps = [[0, 130]]\n"),
    ("reversals", REVERSALS),
    ("reversals with warm motors", REVERSALS),
];
const REVERSALS: &str = include_str!("../../../../scenarios/reversals.toml");
/// The step on which holding is looked at, and for how long at its end \[s\].
const HOLDING: &str = "duration = 30\n[pitch.steps]\njumps = [[0, 15]]\n[yaw.steps]\njumps = [[0, 40]]\n";
const LOOKED_AT: f64 = 8.0;
/// \[counts\] By which a loop that holds may swing, from end to end.
const MOST_COUNTS: f64 = 2.0;
/// How many times as fine the encoders may be that are tried.
const FINEST: u32 = 16;

/// One flight.
#[derive(Debug, Serialize)]
struct Flown {
    name: &'static str,
    /// Why it was none.
    stopped: Option<String>,
    #[serde(flatten)]
    extent: Option<Extent>,
    /// \[V/s\] Main and tail motor.
    voltage_variation: [f64; 2],
}

/// How a loop that holds swings about its goal.
#[derive(Debug, Serialize)]
struct Swing {
    /// \[counts\] From end to end.
    counts: PerAxis<f64>,
    /// \[counts/turn\] Encoders with which it would be at most [`MOST_COUNTS`]; none found, or none needed.
    takes: Option<PerAxis<f64>>,
}

/// All of it.
#[derive(Debug, Serialize)]
pub(super) struct Proof {
    flights: Vec<Flown>,
    holding: Option<Swing>,
}

impl Proof {
    /// Flies it.
    pub(super) fn of(rig: &Rig, controller: &ControllerSettings<f64>) -> Self {
        let settings = Settings::new(rig, *controller, SAMPLE_TIME);
        let one = |(name, text): (&'static str, &str)| {
            let mut scenario = Scenario::parse(name, text).expect("it is one");
            scenario.start.hot = name.ends_with("warm motors");
            let (stopped, extent, voltage_variation) = match fly(rig, &settings, &scenario) {
                Ok(flight) => {
                    let report = &flight.report;
                    let variation = [report.main.voltage_variation, report.tail.voltage_variation];
                    (flight.stopped(), Some(flight.extent(&rig.envelope)), variation)
                }
                Err(error) => (Some(error.to_string()), None, [0.0; 2]),
            };
            Flown { name, stopped, extent, voltage_variation }
        };
        Self { flights: FLIGHTS.map(one).into(), holding: holding(rig, &settings) }
    }

    /// Why these gains should not fly as they are, in one line.
    pub(super) fn stopped(&self) -> Option<String> {
        let bad = self.flights.iter().find(|flown| flown.stopped.is_some())?;
        Some(format!("{}: {}", bad.name, bad.stopped.as_deref().unwrap_or_default()))
    }

    /// In lines.
    pub(super) fn text(&self) -> String {
        let mut text =
            "flown once more as a board flies it, on the rig as it is believed to be:\n".to_owned();
        for flown in &self.flights {
            let what = match (&flown.stopped, &flown.extent) {
                (Some(why), _) => why.clone(),
                (None, Some(e)) => format!(
                    "kept the envelope, pitch up to {:.1} of {:.0}°; {:.0} and {:.0} V/s",
                    e.pitch_deg, e.allowed_pitch_deg, flown.voltage_variation[0], flown.voltage_variation[1]
                ),
                (None, None) => String::new(),
            };
            let _ = writeln!(text, "  {:<27} {what}", flown.name);
        }
        if let Some(Swing { counts, takes }) = &self.holding {
            let _ = writeln!(
                text,
                "  {:<27} swings by {:.0} and {:.0} counts of the encoders",
                "holding 15° and 40°", counts.pitch, counts.yaw
            );
            if counts.pitch.max(counts.yaw) > MOST_COUNTS {
                let _ = writeln!(text, "{}", coarse(takes.as_ref()));
            }
        }
        text
    }
}

fn coarse(takes: Option<&PerAxis<f64>>) -> String {
    let swings = "warning: a loop that holds swings by more than two counts";
    match takes {
        Some(counts) => format!(
            "{swings}: for these gains it takes encoders of {:.0} and {:.0} counts a turn; or tune with a \
             preset that has the rig's own",
            counts.pitch, counts.yaw
        ),
        None => format!("{swings}, and finer encoders do not help: tune more gently"),
    }
}

fn fly(rig: &Rig, settings: &Settings<f64>, scenario: &Scenario) -> Outcome<Flight> {
    let initial = PerAxis::zero();
    let plan = Plan { rig, truth: rig, settings, scenario, initial, fidelity: Fidelity::Rig, seed: 1 };
    flight::fly(&plan, Scalar::F32)
}

/// How it swings while it holds, and with which encoders it would not; none if it does not hold at all.
fn holding(rig: &Rig, settings: &Settings<f64>) -> Option<Swing> {
    let scenario = Scenario::parse("holding", HOLDING).expect("it is one");
    let swing = |rig: &Rig| {
        let flight = fly(rig, settings, &scenario).ok().filter(|flight| flight.stopped().is_none())?;
        let last = twinrotor::trajectory::ticks(LOOKED_AT, SAMPLE_TIME) as usize;
        let rows = &flight.rows[flight.rows.len() - last..];
        let of = |angle: fn(PerAxis<f64>) -> f64| {
            let all = || rows.iter().map(|row| angle(row.state.angle));
            all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min)
        };
        let turns = PerAxis::new(of(|a| a.pitch), of(|a| a.yaw)).scaled(1.0 / std::f64::consts::TAU);
        Some(turns.zip(rig.encoder_counts, |turns, counts| turns * f64::from(counts)))
    };
    let too_far = |counts: &PerAxis<f64>| counts.pitch.max(counts.yaw) > MOST_COUNTS;
    let counts = swing(rig)?;
    let finer = |times: u32| Rig { encoder_counts: rig.encoder_counts.map(|counts| counts * times), ..*rig };
    let mut takes = None;
    let mut times = 2;
    while too_far(&counts) && takes.is_none() && times <= FINEST {
        let rig = finer(times);
        takes = swing(&rig).filter(|counts| !too_far(counts)).map(|_| rig.encoder_counts.map(f64::from));
        times *= 2;
    }
    Some(Swing { counts, takes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::defaults;
    use twinrotor::plant::presets;

    /// What boards boot with, on each preset's encoders and on coarser ones: what the warning says is so.
    /// Prints the table of docs/tuning.md.
    #[test]
    #[expect(clippy::print_stdout, reason = "a table for whoever asks for it")]
    fn what_is_said_of_coarse_encoders_is_so_on_every_preset() {
        println!("| preset | all | half | a quarter | takes |\n|---|---|---|---|---|");
        for (name, rig) in presets::ALL {
            let controller = defaults::named(name).expect("one for every preset");
            let settings = |rig: &Rig| Settings::new(rig, controller, SAMPLE_TIME);
            let swings = [1, 2, 4].map(|part| {
                let coarse = Rig { encoder_counts: rig.encoder_counts.map(|counts| counts / part), ..rig };
                holding(&coarse, &settings(&coarse)).expect("it holds")
            });
            let most = |counts: &PerAxis<f64>| counts.pitch.max(counts.yaw);
            assert!(most(&swings[0].counts) <= MOST_COUNTS, "{name}: {:?}", swings[0]);
            for swing in &swings {
                assert_eq!(swing.takes.is_some(), most(&swing.counts) > MOST_COUNTS, "{name}: {swing:?}");
                let Some(takes) = swing.takes else { continue };
                // Encoders as it says, and no coarser ones by half, end it.
                let with = |counts: PerAxis<f64>| {
                    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts")]
                    let rig = Rig { encoder_counts: counts.map(|counts| counts as u32), ..rig };
                    most(&holding(&rig, &settings(&rig)).expect("it holds").counts)
                };
                assert!(with(takes) <= MOST_COUNTS && with(takes.scaled(0.5)) > MOST_COUNTS, "{name}");
            }
            let told = |s: &Swing| format!("{:.1}/{:.1}", s.counts.pitch, s.counts.yaw);
            let takes = swings[2].takes.map(|counts| format!("{:.0}/{:.0}", counts.pitch, counts.yaw));
            let [all, half, quarter] = swings.each_ref().map(told);
            println!("| `{name}` | {all} | {half} | {quarter} | {} |", takes.unwrap_or_default());
        }
    }
}
