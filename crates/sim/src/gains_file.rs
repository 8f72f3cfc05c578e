//! Gains on disk.

use crate::Read;
use crate::error::{Error, Outcome};
use serde::{Deserialize, Serialize};
use twinrotor::allocation::AllocationSettings;
use twinrotor::axes::PerAxis;
use twinrotor::command_filter::FilterSettings;
use twinrotor::controller::ControllerSettings;
use twinrotor::estimator::EstimatorSettings;
use twinrotor::gains::{self, Gains};
use twinrotor::law::LawSettings;
use twinrotor::lead::Lead;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;

use crate::scenario::SAMPLE_TIME;
use crate::state_space;

/// A gains file: a controller, its numbers, and where they came from.
///
/// On disk the law's name stands under `controller` and its gains beside it (`[pitch]`, `[yaw]`);
/// `[estimator]`, `allocation`, `[filter]`, `[lead]` and `[cancellation]` follow where they are used. What is
/// left out is as the paper has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Document", into = "Document")]
pub struct GainsFile {
    /// The controller.
    pub controller: ControllerSettings<f64>,
    /// How the gains were found; nothing reads it.
    pub provenance: Option<Provenance>,
}

/// The file as it is written.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Document {
    controller: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    allocation: Option<AllocationSettings<f64>>,
    /// The law's own tables, and whatever else the file holds: the law refuses what it does not know.
    #[serde(flatten)]
    law: toml::Table,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    estimator: Option<EstimatorSettings<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    filter: Option<FilterSettings<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    lead: Option<Lead<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cancellation: Option<PerAxis<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    provenance: Option<Provenance>,
}

impl TryFrom<Document> for GainsFile {
    type Error = String;

    fn try_from(document: Document) -> Result<Self, String> {
        let law = if document.controller == state_space::NAME {
            LawSettings::StateSpace(state_space::read(document.law)?)
        } else {
            let named = toml::Table::from_iter([(document.controller, toml::Value::Table(document.law))]);
            LawSettings::deserialize(toml::Value::Table(named)).map_err(|e| e.message().to_owned())?
        };
        let paper = ControllerSettings::paper(gains::PAPER);
        let controller = ControllerSettings {
            law,
            estimator: document.estimator.unwrap_or(paper.estimator),
            filter: document.filter,
            allocation: document.allocation.unwrap_or(paper.allocation),
            lead: document.lead,
            cancellation: document.cancellation,
        };
        Ok(Self { controller, provenance: document.provenance })
    }
}

impl From<GainsFile> for Document {
    fn from(file: GainsFile) -> Self {
        let ControllerSettings { law, estimator, filter, allocation, lead, cancellation } = file.controller;
        let paper = ControllerSettings::paper(gains::PAPER);
        let tables = |law: &LawSettings<f64>| {
            let named = toml::Table::try_from(law).expect("gains are made of tables and numbers");
            match named.into_iter().next() {
                Some((_, toml::Value::Table(law))) => law,
                _ => unreachable!("a law's gains are a table under its name"),
            }
        };
        let controller = law.kind().to_owned();
        let law = match &law {
            LawSettings::StateSpace(gains) => state_space::write(gains),
            law => tables(law),
        };
        Self {
            controller,
            allocation: (allocation != paper.allocation).then_some(allocation),
            law,
            estimator: (estimator != paper.estimator).then_some(estimator),
            filter,
            lead,
            cancellation,
            provenance: file.provenance,
        }
    }
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
        Self { controller: ControllerSettings::paper(gains), provenance: None }
    }

    /// `paper`, or from the text of that name.
    ///
    /// # Errors
    ///
    /// If there is none, or the text is not one of gains that can be flown.
    pub fn load(name: &str, read: Read<'_>) -> Outcome<Self> {
        if name == "paper" { Ok(Self::paper()) } else { Self::parse(name, &read(name)?) }
    }

    /// From the text of a gains file, called `name` in what is said of it.
    ///
    /// # Errors
    ///
    /// If it is not one of gains that can be flown.
    pub fn parse(name: &str, text: &str) -> Outcome<Self> {
        let located = |error| crate::located::located(name, text).unwrap_or(error);
        let file: Self =
            crate::toml::parse(name, text).map_err(|error| blame_version(located(error), text))?;
        file.controller.validate().map_err(|e| Error::from(e).within(name))?;
        Ok(file)
    }

    /// Refuses another law than the one named, if one is.
    ///
    /// # Errors
    ///
    /// If it is another.
    pub fn require(&self, controller: Option<&str>) -> Outcome<()> {
        let own = self.controller.law.kind();
        match controller {
            Some(wanted) if wanted != own => {
                Err(Error::invalid("controller", wanted, format_args!("{own}, which the gains are of")))
            }
            _ => Ok(()),
        }
    }

    /// The gains of the paper's law, if that is the law.
    pub fn gains(&self) -> Option<Gains<f64>> {
        match self.controller.law {
            LawSettings::Backstepping(gains) => Some(gains),
            _ => None,
        }
    }

    /// As a file.
    pub fn to_toml(&self) -> String {
        crate::toml::write(self)
    }

    /// The controller that they make on a rig whose constants it knows.
    pub fn settings(&self, rig: &Rig) -> Settings<f64> {
        Settings::new(rig, self.controller, SAMPLE_TIME)
    }
}

/// Beside what is wrong with a file, that another version of this program wrote it, if one did: such a file
/// is made anew.
fn blame_version(error: Error, text: &str) -> Error {
    let table: toml::Table = toml::from_str(text).unwrap_or_default();
    let written = table.get("provenance").and_then(|p| p.get("version")).and_then(toml::Value::as_str);
    match written {
        Some(written) if written != VERSION => Error::Unusable(format!(
            "{error}; version {written} wrote this file and version {VERSION} reads it: tune it anew"
        )),
        _ => error,
    }
}

/// Of this program.
const VERSION: &str = env!("CARGO_PKG_VERSION");

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_gains_survive_their_file(k in prop::array::uniform4(1e-3..1e3_f64), bandwidth in 1.0..500.0) {
            let mut file = GainsFile::backstepping(Gains::from_paper_order(k));
            file.controller.estimator = EstimatorSettings::laboratory(bandwidth);
            file.controller.allocation = AllocationSettings::Weighted { pitch_weight: 1.5 };
            file.controller.lead = Some(Lead { factor: 0.1 + bandwidth / 100.0 });
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

    /// Written before the filter had a damping, an advance and a reach: it flies as it did.
    #[test]
    fn a_file_of_a_former_version_is_read() {
        let text = "controller = \"integral-backstepping\"
            [allocation.weighted]\npitch_weight = 0.7
            [pitch]\nintegral = 2.0\nposition = 16.8\nrate = 8.0\nweight = 2.3
            [yaw]\nintegral = 9.7\nposition = 2.8\nrate = 16.3\nweight = 5.9
            [estimator.extended-state.bandwidth]\npitch = 12.0\nyaw = 19.0
            [filter.bandwidth]\npitch = 8.3\nyaw = 4.6
            [lead]\nfactor = 0.77
            [cancellation]\npitch = 0.52\nyaw = 0.11
            [provenance]\npreset = \"aero-lab\"\nobjective = \"robust\"\nalgorithm = \"fpa-yang\"
            seed = 1\nevaluations = 2001\ncost = 5.0\nversion = \"0.1.0\"";
        let filter = GainsFile::parse("old.toml", text).unwrap().controller.filter.unwrap();
        assert_eq!(filter.bandwidth, PerAxis::new(8.3, 4.6));
        assert_eq!((filter.damping, filter.advance, filter.reach), (None, None, None));
    }

    #[test]
    fn a_file_that_only_another_version_can_read_says_so() {
        let text = "controller = \"backstepping\"\n[pitch]\nk1 = 4.2\n[provenance]\npreset = \"paper\"
            objective = \"ise\"\nalgorithm = \"fpa-paper\"\nseed = 1\nevaluations = 1\ncost = 1.0
            version = \"0.0.9\"";
        let error = GainsFile::parse("old.toml", text).unwrap_err().to_string();
        assert!(error.contains("k1") && !error.contains('\n'), "{error}");
        assert!(
            error.contains("version 0.0.9 wrote this file") && error.ends_with("tune it anew"),
            "{error}"
        );
    }

    /// What a board boots with is what the committed files say, bit for bit.
    #[test]
    fn the_boards_defaults_are_the_committed_files() {
        for (name, controller) in twinrotor::defaults::ALL {
            let path = format!("{}/../../gains/{name}.toml", env!("CARGO_MANIFEST_DIR"));
            let file = GainsFile::parse(&path, &std::fs::read_to_string(&path).unwrap()).unwrap();
            assert_eq!(file.controller, controller, "{name}");
            assert_eq!(file.provenance.unwrap().preset, name);
        }
    }

    /// Reading and writing changes no byte of a committed file, and the table knows every number in it.
    #[test]
    fn every_committed_file_is_written_as_it_was_read() {
        let mut folders = vec![std::path::PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../gains"))];
        let mut files = 0;
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                let text = std::fs::read_to_string(&path).unwrap();
                let text: String = text.split_inclusive('\n').filter(|line| !line.starts_with('#')).collect();
                let file = GainsFile::parse("x", &text).unwrap();
                assert_eq!(file.to_toml(), text, "{}", path.display());
                let controller = file.controller;
                controller.visit(|field, value| {
                    assert!(controller.get(field.name) == Some(value) && field.range.allows(value));
                });
                files += 1;
            }
        }
        assert!(files > 60, "{files}");
    }
}
