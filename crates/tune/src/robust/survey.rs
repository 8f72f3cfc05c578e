//! A scenario on many plants, each flown as a board flies it: with its supervisor, which cuts motors.

use super::{Draw, Spread, Trial, quantile, signed_rank};
use crate::parallel::{self, Stop};
use serde::{Deserialize, Serialize};
use twinrotor::axes::PerAxis;
use twinrotor::controller::ControllerSettings;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor_sim::flight::{self, Fidelity, Flight, Plan, Scalar};
use twinrotor_sim::scenario::{SAMPLE_TIME, Scenario};

/// One plant's flight in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// \[deg\] RMS of what was asked for minus the true angle, over the whole flight.
    pub rms_deg: PerAxis<f64>,
    /// \[V/s\] Σ|ΔV| a second, the mean of both motors, over the whole flight.
    pub voltage_variation: f64,
    /// \[%\] Of the flight in which more was asked of a motor than its limit: the worse one.
    pub saturation_percent: f64,
    /// \[deg\] Largest pitch.
    pub pitch_deg: f64,
    /// The board cut the motors.
    pub cut: bool,
    /// The rig left its envelope, or nothing was left to fly.
    pub left: bool,
}

/// \[deg\] What an axis counts as that was not flown to its end by a board.
const LOST: f64 = 90.0;

impl Judged {
    fn lost(cut: bool) -> Self {
        Self {
            rms_deg: PerAxis::both(LOST),
            voltage_variation: 0.0,
            saturation_percent: 0.0,
            pitch_deg: 90.0,
            cut,
            left: true,
        }
    }

    fn of(flight: &Flight, truth: &Rig) -> Self {
        let report = &flight.report;
        let time = (flight.rows.len() - 1) as f64 * SAMPLE_TIME;
        let rms = |ise: f64| (ise / time).sqrt().to_degrees().min(LOST);
        Self {
            rms_deg: PerAxis::new(rms(report.pitch.ise), rms(report.yaw.ise)),
            voltage_variation: 0.5 * (report.main.voltage_variation + report.tail.voltage_variation),
            saturation_percent: report.main.saturation_percent.max(report.tail.saturation_percent),
            pitch_deg: flight.extent(&truth.envelope).pitch_deg.min(90.0),
            cut: flight.board.is_some_and(|board| board.condition.is_some()),
            left: flight.left_envelope.is_some(),
        }
    }

    /// Was it none?
    pub fn failed(&self) -> bool {
        self.cut || self.left
    }

    /// \[deg\] Both axes' RMS errors: what controllers are ranked by.
    pub fn error(&self) -> f64 {
        self.rms_deg.pitch + self.rms_deg.yaw
    }
}

impl Trial {
    /// `scenario` on every plant, in their order, or nothing if `stop` says so before all have flown. What is
    /// random in it differs from plant to plant and is the same for every controller.
    pub fn survey(
        &self,
        controller: &ControllerSettings<f64>,
        scenario: &Scenario,
        stop: Stop<'_>,
    ) -> Option<Vec<Judged>> {
        let settings = Settings::new(&self.rig, *controller, SAMPLE_TIME);
        let plants: Vec<(u64, &Draw)> = (self.before as u64 + 1..).zip(&self.plants).collect();
        parallel::try_map(&plants, |(seed, draw)| {
            if stop() {
                return None;
            }
            let truth = Rig { plant: draw.plant, ..self.truth };
            let plan = Plan {
                rig: &self.rig,
                truth: &truth,
                settings: &settings,
                scenario,
                initial: scenario.start.angle(),
                fidelity: Fidelity::Rig,
                seed: *seed,
            };
            // Cut or diverged while the motors were warmed, or astray without end.
            let flown = flight::fly(&plan, Scalar::F32);
            Some(
                flown
                    .map_or_else(|e| Judged::lost(e.to_string().contains("cut")), |f| Judged::of(&f, &truth)),
            )
        })
    }
}

/// One controller over all plants.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Surveyed {
    /// What it is called.
    pub name: String,
    /// Plants on which the board cut the motors or the rig left its envelope.
    pub failures: usize,
    /// Of these, on how many the board cut the motors.
    pub cuts: usize,
    /// \[deg\] RMS error of both axes together.
    pub error: Spread,
    /// \[deg\] RMS error of each axis, median.
    pub rms_deg: PerAxis<f64>,
    /// \[deg\] The same, 95 % quantile.
    pub rms_p95: PerAxis<f64>,
    /// \[deg\] Largest pitch, 95 % quantile.
    pub pitch_p95: f64,
    /// \[V/s\] Median.
    pub voltage_variation: f64,
    /// \[%\] Of the flight, median.
    pub saturation_percent: f64,
    /// That its errors and those it is held against differ as they do by chance (Wilcoxon, two-sided, paired
    /// by plant); none for these.
    pub p_value: Option<f64>,
}

impl Surveyed {
    /// From a controller's flights and those of the one it is held against, on the same plants.
    pub fn new(name: &str, flights: &[Judged], other: Option<&[Judged]>) -> Self {
        let all = |of: &dyn Fn(&Judged) -> f64| flights.iter().map(of).collect::<Vec<_>>();
        let both = |part: f64| PerAxis {
            pitch: quantile(&all(&|f| f.rms_deg.pitch), part),
            yaw: quantile(&all(&|f| f.rms_deg.yaw), part),
        };
        let errors = all(&Judged::error);
        Self {
            name: name.to_owned(),
            failures: flights.iter().filter(|f| f.failed()).count(),
            cuts: flights.iter().filter(|f| f.cut).count(),
            error: Spread::of(&errors),
            rms_deg: both(0.5),
            rms_p95: both(0.95),
            pitch_p95: quantile(&all(&|f| f.pitch_deg), 0.95),
            voltage_variation: quantile(&all(&|f| f.voltage_variation), 0.5),
            saturation_percent: quantile(&all(&|f| f.saturation_percent), 0.5),
            p_value: other.map(|other| {
                let differences: Vec<f64> = errors.iter().zip(other).map(|(e, o)| e - o.error()).collect();
                signed_rank(&differences)
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::NEVER;
    use twinrotor::defaults;
    use twinrotor::plant::presets::AERO2;

    fn scenario(more: &str) -> Scenario {
        let text =
            format!("duration = 6\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = [[0.5, 20]]\n{more}");
        Scenario::parse("it.toml", &text).unwrap()
    }

    #[test]
    fn a_push_costs_error_and_one_beyond_all_volts_is_a_failure_on_every_plant() {
        let trial = Trial::new(&AERO2, 6, 7, 4.0);
        let survey = |more: &str| {
            let flown = trial.survey(&defaults::AERO2, &scenario(more), NEVER).unwrap();
            Surveyed::new("it", &flown, None)
        };
        let calm = survey("");
        let pushed = survey("[[events.step]]\ntorque = [0.004, 0]\nwindow = [3, 6]\n");
        let hit = survey("[[events.step]]\ntorque = [2, 0]\nwindow = [3, 6]\n");
        assert_eq!((calm.failures, hit.failures), (0, 6));
        assert!(pushed.rms_deg.pitch > 2.0 * calm.rms_deg.pitch, "{pushed:?} {calm:?}");
        assert!(hit.cuts > 0 && hit.error.median > pushed.error.median);
    }

    #[test]
    fn a_survey_that_nobody_waits_for_ends() {
        let trial = Trial::new(&AERO2, 6, 7, 4.0);
        assert!(trial.survey(&defaults::AERO2, &scenario(""), &|| true).is_none());
    }
}
