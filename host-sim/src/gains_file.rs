//! Gains on disk.

use crate::error::{Failure, Outcome};
use crate::rig::from_toml;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;
use twinrotor::estimator::EstimatorSettings;
use twinrotor::gains::{self, AxisGains, Gains};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;

use crate::scenario::SAMPLE_TIME;

/// A gains file: a controller, its numbers, and where they came from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainsFile {
    /// Which law.
    pub controller: Controller,
    /// Pitch gains.
    pub pitch: AxisGains<f64>,
    /// Yaw gains.
    pub yaw: AxisGains<f64>,
    /// Where rates come from; the filtered derivative at 100 rad/s if nothing is said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimator: Option<EstimatorSettings<f64>>,
    /// How the gains were found; nothing reads it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
}

/// The laws there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Controller {
    /// Eqs (26)-(27).
    Backstepping,
}

/// How gains were found. No dates and no durations: the same run writes the same bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// The rig.
    pub preset: String,
    /// What was minimised.
    pub objective: String,
    /// By which method.
    pub algorithm: String,
    /// From which seed.
    pub seed: u64,
    /// With how many evaluations.
    pub evaluations: usize,
    /// To what cost.
    pub cost: f64,
    /// By which version of this program.
    pub version: String,
}

impl GainsFile {
    /// The paper's Table 4.
    pub fn paper() -> Self {
        Self::backstepping(gains::PAPER)
    }

    /// The paper's law with these gains.
    pub fn backstepping(gains: Gains<f64>) -> Self {
        Self {
            controller: Controller::Backstepping,
            pitch: gains.pitch,
            yaw: gains.yaw,
            estimator: None,
            provenance: None,
        }
    }

    /// `paper`, or the file of that path.
    pub fn load(name: &str) -> Outcome<Self> {
        if name == "paper" {
            return Ok(Self::paper());
        }
        let path = Path::new(name);
        if !path.exists() {
            return Err(Failure::Input(format!(
                "--gains is '{name}'; allowed: 'paper' (Table 4) or the path of a gains file, and there is no such file"
            )));
        }
        Self::parse(name, &fs::read_to_string(path).map_err(|e| Failure::reading(path, &e))?)
    }

    fn parse(path: &str, text: &str) -> Outcome<Self> {
        let file: Self = from_toml(path, text)?;
        file.settings(&twinrotor::plant::presets::PAPER)
            .validate()
            .map_err(|e| Failure::Input(format!("{path}: {e}")))?;
        Ok(file)
    }

    /// Refuses another controller than the one named, if one is.
    pub fn require(&self, controller: Option<Controller>) -> Outcome<()> {
        match controller {
            Some(wanted) if wanted != self.controller => Err(Failure::Input(format!(
                "--controller is {wanted:?}, but the gains are of {:?}",
                self.controller
            ))),
            _ => Ok(()),
        }
    }

    /// The gains alone.
    pub fn gains(&self) -> Gains<f64> {
        Gains::new(self.pitch, self.yaw)
    }

    /// As a file.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("gains are made of tables and numbers")
    }

    /// The controller that they make on a rig whose constants it knows.
    pub fn settings(&self, rig: &Rig) -> Settings<f64> {
        let mut settings = Settings::paper(rig, self.gains(), SAMPLE_TIME);
        if let Some(estimator) = self.estimator {
            settings.estimator = estimator;
        }
        settings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_gains_survive_their_file(k in prop::array::uniform4(1e-3..1e3_f64), bandwidth in 1.0..500.0) {
            let mut file = GainsFile::backstepping(Gains::from_paper_order(k));
            file.estimator = Some(EstimatorSettings::laboratory(bandwidth));
            prop_assert_eq!(GainsFile::parse("x", &file.to_toml()).unwrap(), file);
        }

        #[test]
        fn no_text_panics(text in "\\PC*") {
            let _ = GainsFile::parse("x", &text);
        }
    }

    #[test]
    fn a_bad_file_is_told_in_one_line_with_its_field() {
        let good = GainsFile::paper().to_toml();
        let cases = [
            (good.replace("4.2", "-4.2"), "pitch.position is -4.2; allowed: a finite number above 0"),
            (good.replace("10.8", "inf"), "yaw.rate is inf"),
            (good.replace("10.8", "nan"), "yaw.rate is NaN"),
            (good.replace("rate = 10.8", "speed = 10.8"), "unknown field `speed`"),
            (good.replace("rate = 10.8", ""), "missing field `rate`"),
            (good.replace("backstepping", "backsteping"), "unknown variant `backsteping`"),
            (String::new(), "missing field `controller`"),
        ];
        for (text, expected) in cases {
            let error = GainsFile::parse("my.toml", &text).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
            assert!(!error.contains('\n') && error.starts_with("my.toml"), "{error}");
        }
    }
}
