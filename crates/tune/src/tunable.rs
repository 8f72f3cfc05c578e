//! A controller as a vector of numbers: any of them can be tuned.
//!
//! Parameters are called as a gains file spells them, with dots: `pitch.position`,
//! `estimator.luenberger.bandwidth.yaw`, `filter.bandwidth.pitch`. A search goes over their logarithms,
//! around a controller to start from, since a gain's range spans factors, not differences.

use toml::Value;
use twinrotor::controller::ControllerSettings;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::{Error, Outcome};

/// Which parameters of a controller are tuned, and where the search begins.
#[derive(Debug, Clone, PartialEq)]
pub struct Tunable {
    template: Value,
    names: Vec<String>,
    start: Vec<f64>,
}

impl Tunable {
    /// All parameters of `controller` that are not zero but the filter's reach, of which a single step shows
    /// nothing; or those that begin with one of `chosen` (`pitch` means all of pitch).
    ///
    /// # Errors
    ///
    /// If the controller has no parameter that begins with one of `chosen`.
    pub fn new(controller: &ControllerSettings<f64>, chosen: &[String]) -> Outcome<Self> {
        let file = GainsFile { controller: *controller, provenance: None };
        let template = Value::try_from(file).expect("gains are made of tables and numbers");
        let mut all = Vec::new();
        collect(&template, "", &mut all);
        for wanted in chosen {
            if !all.iter().any(|(name, _)| belongs(name, wanted)) {
                let known: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
                return Err(Error::invalid("parameters", format_args!("'{wanted}'"), known.join(", ")));
            }
        }
        let wanted = |name: &str| match chosen {
            [] => !belongs(name, "filter.reach"),
            _ => chosen.iter().any(|c| belongs(name, c)),
        };
        let (names, start) = all.into_iter().filter(|(name, x)| *x != 0.0 && wanted(name)).unzip();
        Ok(Self { template, names, start })
    }

    /// What the coordinates are called.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The values that the search begins with.
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// The controller at a position: the factor on each start value is exp(coordinate).
    pub fn controller(&self, position: &[f64]) -> ControllerSettings<f64> {
        let mut value = self.template.clone();
        for ((name, start), x) in self.names.iter().zip(&self.start).zip(position) {
            if let Some(number) = at(&mut value, name) {
                *number = Value::Float(start * libm::exp(*x));
            }
        }
        value.try_into::<GainsFile>().expect("other numbers in the same tables").controller
    }
}

fn belongs(name: &str, wanted: &str) -> bool {
    name.strip_prefix(wanted).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

fn collect(value: &Value, path: &str, found: &mut Vec<(String, f64)>) {
    match value {
        Value::Float(x) => found.push((path.to_owned(), *x)),
        Value::Table(table) => {
            for (key, inner) in table {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                collect(inner, &path, found);
            }
        }
        _ => {}
    }
}

fn at<'a>(value: &'a mut Value, path: &str) -> Option<&'a mut Value> {
    path.split('.').try_fold(value, |value, key| value.as_table_mut()?.get_mut(key))
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::axes::PerAxis;
    use twinrotor::command_filter::FilterSettings;
    use twinrotor::gains;

    fn filtered() -> ControllerSettings<f64> {
        let filter = Some(FilterSettings {
            bandwidth: PerAxis::new(12.0, 9.0),
            damping: None,
            advance: None,
            reach: None,
        });
        ControllerSettings { filter, ..ControllerSettings::paper(gains::PAPER) }
    }

    #[test]
    fn every_number_has_a_name_and_moves_alone() {
        let all = Tunable::new(&filtered(), &[]).unwrap();
        assert_eq!(
            all.names(),
            [
                "filter.bandwidth.pitch",
                "filter.bandwidth.yaw",
                "pitch.position",
                "pitch.rate",
                "yaw.position",
                "yaw.rate"
            ]
        );
        assert_eq!(all.controller(&[0.0; 6]), filtered());
        let moved = all.controller(&[2.0_f64.ln(), 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!((moved.filter.unwrap().bandwidth.pitch - 24.0).abs() < 1e-12);
        assert_eq!(moved.law, filtered().law);
    }

    #[test]
    fn the_filters_reach_is_tuned_when_it_is_named() {
        let filter = FilterSettings {
            bandwidth: PerAxis::both(5.0),
            damping: None,
            advance: None,
            reach: Some(PerAxis::new(0.3, 0.8)),
        };
        let reaching = ControllerSettings { filter: Some(filter), ..filtered() };
        assert!(!Tunable::new(&reaching, &[]).unwrap().names().iter().any(|name| name.contains("reach")));
        let named = Tunable::new(&reaching, &["filter.reach".into()]).unwrap();
        assert_eq!(named.names(), ["filter.reach.pitch", "filter.reach.yaw"]);
        assert_eq!(named.start(), [0.3, 0.8]);
    }

    #[test]
    fn a_part_can_be_chosen_and_an_unknown_one_is_refused() {
        let some = Tunable::new(&filtered(), &["yaw".into(), "filter.bandwidth.pitch".into()]).unwrap();
        assert_eq!(some.names(), ["filter.bandwidth.pitch", "yaw.position", "yaw.rate"]);
        let error = Tunable::new(&filtered(), &["roll".into()]).unwrap_err().to_string();
        assert!(error.contains("'roll'") && error.contains("yaw.rate"), "{error}");
    }
}
