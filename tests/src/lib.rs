//! What the end-to-end tests share.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::pipeline::Settings;
use twinrotor::plant::State;
use twinrotor::plant::presets::{PAPER, Rig};
use twinrotor_sim::flight::{Fidelity, Plan};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::scenario::Scenario;

/// One row of a reference trajectory.
#[derive(Debug, Clone, Copy)]
pub struct GoldenRow {
    /// Which tick of 1 ms.
    pub tick: usize,
    /// Angles and rates.
    pub state: State<f64>,
    /// \[V\] As applied.
    pub volts: PerMotor<f64>,
}

/// Reads `golden/NAME.csv.gz`.
pub fn golden(name: &str) -> Vec<GoldenRow> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("golden/{name}.csv.gz"));
    let mut text = String::new();
    let file = File::open(&path).expect("the reference is part of the repository");
    flate2::read::GzDecoder::new(file).read_to_string(&mut text).expect("it is intact");
    text.lines().skip(1).map(row).collect()
}

fn row(line: &str) -> GoldenRow {
    let numbers: Vec<f64> = line.split(',').map(|x| x.trim().parse().expect("a number")).collect();
    let [t, theta, theta_dot, psi, psi_dot, main, tail] = numbers[..] else {
        panic!("seven columns: {line}");
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 40,000 ms")]
    let tick = (t * 1e3).round() as usize;
    GoldenRow {
        tick,
        state: State { angle: PerAxis::new(theta, psi), rate: PerAxis::new(theta_dot, psi_dot) },
        volts: PerMotor::new(main, tail),
    }
}

/// Something to fly in the paper's world: a rig, the law with these gains, a scenario.
#[derive(Debug)]
pub struct Setup {
    /// The machine.
    pub rig: Rig,
    /// The controller.
    pub settings: Settings<f64>,
    /// What to follow.
    pub scenario: Scenario,
}

impl Setup {
    /// The paper's helicopter with Table 4.
    pub fn paper(scenario: &str, duration: f64) -> Self {
        Self::new(&PAPER, &GainsFile::paper(), scenario, duration)
    }

    /// Any rig and gains.
    pub fn new(rig: &Rig, gains: &GainsFile, scenario: &str, duration: f64) -> Self {
        let mut scenario = Scenario::named(scenario).expect("a scenario of the paper's");
        scenario.duration = duration;
        Self { rig: *rig, settings: gains.settings(rig), scenario }
    }

    /// From the horizontal.
    pub fn plan(&self, fidelity: Fidelity, seed: u64) -> Plan<'_> {
        Plan {
            rig: &self.rig,
            truth: &self.rig,
            settings: &self.settings,
            scenario: &self.scenario,
            initial: PerAxis::new(0.0, 0.0),
            fidelity,
            seed,
        }
    }
}
