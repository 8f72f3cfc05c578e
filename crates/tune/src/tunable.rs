//! A controller as a vector of numbers: any of them can be tuned.
//!
//! Parameters have the names of the core's table of settings: `pitch.position`, `estimator.bandwidth.yaw`,
//! `filter.bandwidth.pitch`. A search goes over their logarithms, around a controller to start from, since a
//! gain's range spans factors, not differences.

use crate::optimise::{Reached, Side};
use serde::Serialize;
use std::fmt;
use twinrotor::controller::ControllerSettings;
use twinrotor::gains;
use twinrotor::settings::{Field, Range};
use twinrotor_sim::{Error, Outcome};

/// A parameter that a search has left at a bound of the box it searched last: what is beyond it, no search
/// has seen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AtBound {
    /// What it is called.
    pub name: String,
    /// Its value, in its own unit.
    pub value: f64,
    /// At which end of the box.
    pub side: Side,
    /// That end, in the same unit.
    pub bound: f64,
}

impl fmt::Display for AtBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = match self.side {
            Side::Least => "lower",
            Side::Most => "upper",
        };
        write!(f, "{} = {:.4} at the {side} bound {:.4}", self.name, self.value, self.bound)
    }
}

/// Which parameters of a controller are tuned, and where the search begins.
#[derive(Debug, Clone, PartialEq)]
pub struct Tunable {
    template: ControllerSettings<f64>,
    fields: Vec<&'static Field>,
    start: Vec<f64>,
}

impl Tunable {
    /// All parameters of `controller` that are not zero, or those that begin with one of `chosen` (`pitch`
    /// means all of pitch). Only tuned when they are named: the filter's reach, of which a single step shows
    /// nothing, and the estimator where it is the laboratories'.
    ///
    /// # Errors
    ///
    /// If the controller has no parameter that begins with one of `chosen`, or none at all.
    pub fn new(controller: &ControllerSettings<f64>, chosen: &[String]) -> Outcome<Self> {
        let mut all = Vec::new();
        controller.visit(|field, value| {
            if field.range != Range::Switch {
                all.push((field, value));
            }
        });
        all.sort_by_key(|(field, _)| field.name);
        for wanted in chosen {
            if !all.iter().any(|(field, _)| belongs(field.name, wanted)) {
                let known: Vec<&str> = all.iter().map(|(field, _)| field.name).collect();
                return Err(Error::invalid("parameters", format_args!("'{wanted}'"), known.join(", ")));
            }
        }
        let given = controller.estimator == ControllerSettings::paper(gains::PAPER).estimator;
        let wanted = |name: &str| match chosen {
            [] => !(belongs(name, "filter.reach") || given && belongs(name, "estimator")),
            _ => chosen.iter().any(|c| belongs(name, c)),
        };
        let (fields, start): (Vec<_>, _) =
            all.into_iter().filter(|(field, x)| *x != 0.0 && wanted(field.name)).unzip();
        if fields.is_empty() {
            let why = "one with a number that can be searched, which matrices have not";
            return Err(Error::invalid("controller", controller.law.kind(), why));
        }
        Ok(Self { template: *controller, fields, start })
    }

    /// What the coordinates are: name, unit, range.
    pub fn fields(&self) -> &[&'static Field] {
        &self.fields
    }

    /// What the coordinates are called.
    pub fn names(&self) -> Vec<&'static str> {
        self.fields.iter().map(|field| field.name).collect()
    }

    /// The values that the search begins with.
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// What was reached at `position`, in the parameters' own names and units.
    pub fn at_bounds(&self, reached: &[Reached], position: &[f64]) -> Vec<AtBound> {
        let told = |r: &Reached| {
            let (field, start) = (self.fields.get(r.coordinate)?, self.start.get(r.coordinate)?);
            let value = start * libm::exp(*position.get(r.coordinate)?);
            let bound = start * libm::exp(r.bound);
            // The factor's upper end is the lower end of a number below zero.
            let side = match r.side {
                Side::Most if *start < 0.0 => Side::Least,
                Side::Least if *start < 0.0 => Side::Most,
                side => side,
            };
            Some(AtBound { name: field.name.to_owned(), value, side, bound })
        };
        reached.iter().filter_map(told).collect()
    }

    /// The controller at a position: the factor on each start value is exp(coordinate).
    pub fn controller(&self, position: &[f64]) -> ControllerSettings<f64> {
        let mut controller = self.template;
        controller.change(|field, value| {
            let coordinate = self.fields.binary_search_by_key(&field.name, |f| f.name);
            let factor = coordinate.ok().and_then(|k| position.get(k)).map(|x| libm::exp(*x));
            factor.map_or(value, |factor| value * factor)
        });
        controller
    }
}

fn belongs(name: &str, wanted: &str) -> bool {
    name.strip_prefix(wanted).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::axes::PerAxis;
    use twinrotor::command_filter::FilterSettings;
    use twinrotor::gains;
    use twinrotor::law::{LawSettings, StateSpaceGains};

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

    /// What stands around matrices can be tuned; they themselves are what they were designed to be.
    #[test]
    fn matrices_are_not_searched() {
        let law = LawSettings::StateSpace(StateSpaceGains::none());
        let filtered = Tunable::new(&ControllerSettings { law, ..filtered() }, &[]).unwrap();
        assert_eq!(filtered.names(), ["filter.bandwidth.pitch", "filter.bandwidth.yaw"]);
        assert_eq!(filtered.controller(&[1.0, 1.0]).law, law);
        let alone = ControllerSettings { law, ..ControllerSettings::paper(gains::PAPER) };
        let told = Tunable::new(&alone, &[]).unwrap_err().to_string();
        assert!(told.starts_with("controller is state-space; allowed: one with a number"), "{told}");
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
    fn the_upper_end_of_a_number_below_zero_is_its_lesser_size() {
        let rig = twinrotor::plant::presets::PAPER;
        let (_, lqr) = crate::design::CATALOGUE.iter().find(|(name, _)| *name == "lqr").unwrap();
        let tunable = Tunable::new(&lqr(&rig), &["angle.main".into()]).unwrap();
        let start = tunable.start();
        let both = crate::optimise::Bounds::new(vec![[-1.0, 1.0]; 2]).unwrap();
        for (position, grows) in [([1.0, 1.0], true), ([-1.0, -1.0], false)] {
            let ends = tunable.at_bounds(&both.reached(&position), &position);
            assert_eq!(ends.len(), 2);
            for (end, start) in ends.iter().zip(start) {
                let most = (*start > 0.0) == grows;
                assert_eq!(end.side, if most { Side::Most } else { Side::Least }, "{end} from {start}");
            }
        }
        assert!(start.iter().any(|x| *x < 0.0) && start.iter().any(|x| *x > 0.0), "{start:?}");
    }

    #[test]
    fn a_part_can_be_chosen_and_an_unknown_one_is_refused() {
        let some = Tunable::new(&filtered(), &["yaw".into(), "filter.bandwidth.pitch".into()]).unwrap();
        assert_eq!(some.names(), ["filter.bandwidth.pitch", "yaw.position", "yaw.rate"]);
        let error = Tunable::new(&filtered(), &["roll".into()]).unwrap_err().to_string();
        assert!(error.contains("'roll'") && error.contains("yaw.rate"), "{error}");
    }
}
