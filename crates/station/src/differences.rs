//! In what two parameter records differ, by name.

use std::collections::BTreeMap;
use std::fmt;
use toml::{Table, Value};
use twinrotor::parameters::Parameters;

/// A value that is not the same here and on the board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// Its name, as the record spells it: `settings.controller.law.pitch.position`.
    pub name: String,
    /// What is asked for.
    pub here: String,
    /// What the board has.
    pub there: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, here, there } = self;
        write!(f, "{name}: {here} here, {there} on the board")
    }
}

/// Every difference but for whether the wiring has been checked, which the board alone knows. In the order of
/// the names.
#[must_use]
pub fn differences(here: &Parameters, there: &Parameters) -> Vec<Difference> {
    let there = Parameters { checked: here.checked, ..*there };
    let (here, there) = (leaves(here), leaves(&there));
    let names = here.keys().chain(there.keys().filter(|name| !here.contains_key(*name)));
    let value = |leaves: &BTreeMap<String, String>, name| {
        leaves.get(name).map_or_else(|| "none".to_owned(), Clone::clone)
    };
    let pairs = names.map(|name| Difference {
        name: name.clone(),
        here: value(&here, name),
        there: value(&there, name),
    });
    let mut different: Vec<Difference> = pairs.filter(|pair| pair.here != pair.there).collect();
    different.sort_by(|a, b| a.name.cmp(&b.name));
    different
}

/// How many values a record has, but for whether the wiring has been checked.
#[must_use]
pub fn settings(parameters: &Parameters) -> usize {
    leaves(parameters).keys().filter(|name| *name != "checked").count()
}

/// Every value of a record by its name. What is not there is left out.
fn leaves(parameters: &Parameters) -> BTreeMap<String, String> {
    let mut leaves = BTreeMap::new();
    let table = Table::try_from(parameters).expect("a record is made of tables and numbers");
    collect("", &Value::Table(table), &mut leaves);
    leaves
}

fn collect(name: &str, value: &Value, leaves: &mut BTreeMap<String, String>) {
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                let dot = if name.is_empty() { "" } else { "." };
                collect(&format!("{name}{dot}{key}"), value, leaves);
            }
        }
        // As short as the board's own f32 is.
        #[expect(clippy::cast_possible_truncation, reason = "it was an f32")]
        Value::Float(number) => drop(leaves.insert(name.to_owned(), (*number as f32).to_string())),
        other => drop(leaves.insert(name.to_owned(), other.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::allocation::AllocationSettings;
    use twinrotor::axes::PerAxis;
    use twinrotor::defaults;
    use twinrotor::law::LawSettings;
    use twinrotor::pipeline::Settings;
    use twinrotor::plant::presets::AERO2;
    use twinrotor::{SAMPLE_TIME, gains};

    fn parameters() -> Parameters {
        Parameters::new(&AERO2, &Settings::new(&AERO2, defaults::AERO2, SAMPLE_TIME))
    }

    #[test]
    fn the_same_record_does_not_differ_whether_it_was_checked_or_not() {
        let checked = Parameters { checked: true, ..parameters() };
        assert_eq!(differences(&parameters(), &checked), []);
    }

    #[test]
    fn no_more_can_differ_than_there_are() {
        let mut other = parameters();
        other.settings = other.settings.map(|x| 1.5 * x);
        let (different, all) = (differences(&parameters(), &other).len(), settings(&parameters()));
        assert!(different > 30 && different < all, "{different} of {all}");
    }

    #[test]
    fn each_value_that_differs_is_named_with_both() {
        let mut other = parameters();
        other.limits.command_timeout = 250;
        other.encoders.yaw.rest_counts = -3;
        other.settings.controller.allocation = AllocationSettings::Clamp;
        let told: Vec<String> = differences(&parameters(), &other).iter().map(ToString::to_string).collect();
        assert!(told.contains(&"limits.command_timeout: 500 here, 250 on the board".to_owned()), "{told:?}");
        assert!(told.contains(&"encoders.yaw.rest_counts: 0 here, -3 on the board".to_owned()), "{told:?}");
        assert!(told.iter().any(|line| line.starts_with("settings.controller.allocation")), "{told:?}");
    }

    #[test]
    fn another_law_differs_in_what_only_one_of_them_has() {
        let mut paper = parameters();
        paper.settings.controller.law = LawSettings::Backstepping(gains::PAPER).map(|x: f64| x as f32);
        paper.settings.controller.cancellation = Some(PerAxis::both(0.5));
        let different = differences(&parameters(), &paper);
        assert!(different.iter().any(|d| d.here == "none") && different.iter().any(|d| d.there == "none"));
        assert!(different.iter().any(|d| d.name.contains("cancellation.pitch") && d.there == "0.5"));
    }
}
