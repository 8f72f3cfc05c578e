use super::*;
use crate::allocation::AllocationSettings;
use crate::command_filter::FilterSettings;
use crate::controller::{CHOICES, ControllerSettings, PARTS};
use crate::defaults;
use crate::estimator::EstimatorSettings;
use crate::law::LawSettings;
use std::collections::BTreeSet;
use std::vec::Vec;

/// Every kind of every choice, with everything else there is.
fn controllers() -> Vec<ControllerSettings<f64>> {
    let mut all = Vec::new();
    for law in LawSettings::<f64>::KINDS {
        for estimator in EstimatorSettings::<f64>::KINDS {
            for allocation in AllocationSettings::<f64>::KINDS {
                all.push(ControllerSettings {
                    law: LawSettings::named(law.name).unwrap(),
                    estimator: EstimatorSettings::named(estimator.name).unwrap(),
                    allocation: AllocationSettings::named(allocation.name).unwrap(),
                    ..defaults::AERO
                });
            }
        }
    }
    all
}

fn every_field() -> impl Iterator<Item = &'static Field> {
    let kinds = CHOICES.into_iter().flat_map(|(_, kinds)| kinds).flat_map(|kind| kind.fields);
    kinds.chain(PARTS.into_iter().flat_map(|(_, fields)| fields))
}

#[test]
fn every_field_says_what_it_is_and_offers_what_is_allowed() {
    for field in every_field() {
        let Field { name, unit, range, typical: [low, high], default, doc } = field;
        assert!(!name.is_empty() && !unit.is_empty(), "{field:?}");
        assert!(doc.ends_with(['.', '?']) && doc.len() > 10, "{name}: {doc}");
        assert!(low < high && range.allows(*high), "{field:?}");
        assert!(range.allows(*low), "{field:?}");
        assert!(range.allows(*default) || default.is_infinite(), "{field:?}");
        assert!(range.least() <= *low && *high <= range.most(), "{field:?}");
    }
}

/// By its name a number is read and written, and no other is touched.
#[test]
fn every_number_is_reached_by_its_name_alone() {
    for controller in controllers() {
        let mut names = BTreeSet::new();
        let mut before = Vec::new();
        controller.visit(|field, value| {
            assert!(names.insert(field.name), "{} twice in {controller:?}", field.name);
            before.push((field, value));
        });
        for (place, (field, old)) in before.iter().enumerate() {
            let new = if field.range == Range::Switch { 1.0 - old } else { 0.5 + old / 2.0 };
            let mut changed = controller;
            assert_eq!(changed.set(field.name, new), Ok(true), "{}", field.name);
            assert_eq!(changed.get(field.name), Some(new));
            let mut at = 0;
            changed.visit(|_, value| {
                assert_eq!(value, if at == place { new } else { before[at].1 }, "{}", field.name);
                at += 1;
            });
            let error = changed.set(field.name, f64::NAN).unwrap_err();
            assert_eq!((error.field, error.allowed), (field.name, field.range.allowed()));
            assert_eq!(changed.get(field.name), Some(new));
        }
        let mut same = controller;
        assert_eq!(same.set("roll.position", 1.0), Ok(false));
        assert_eq!(same, controller);
    }
}

/// What is out of a field's range, and nothing else, is refused, under that field's name.
#[test]
fn validation_keeps_the_tables_ranges() {
    for controller in controllers() {
        assert_eq!(controller.validate(), Ok(()));
        controller.visit(|field, _| {
            let bad = [f64::NAN, f64::INFINITY, field.range.least() - 1e-3, field.range.most() + 1e-3];
            for value in bad.into_iter().filter(|value| !field.range.allows(*value)) {
                let mut spoilt = controller;
                spoilt.change(|other, old| if other.name == field.name { value } else { old });
                if field.range != Range::Switch {
                    assert_eq!(spoilt.validate().unwrap_err().field, field.name);
                }
            }
        });
    }
    assert!(!Range::AboveZero.allows(0.0) && Range::AtLeastZero.allows(0.0));
}

/// A gains file holds these names: a controller and the table speak of the same numbers in the same order.
/// (But for matrices, whose numbers mean nothing alone.)
#[test]
fn a_map_meets_as_many_numbers_as_a_visit() {
    let is_table = |c: &ControllerSettings<f64>| !matches!(c.law, LawSettings::StateSpace(_));
    for controller in controllers().into_iter().filter(is_table) {
        let (mut mapped, mut visited) = (Vec::new(), Vec::new());
        let _ = controller.map(|value| mapped.push(value));
        controller.visit(|field, value| {
            if field.range != Range::Switch {
                visited.push(value);
            }
        });
        assert_eq!(mapped, visited);
    }
}

#[test]
fn what_is_left_out_has_no_number() {
    let mut bare = defaults::AERO;
    bare.filter = bare.filter.map(|filter| FilterSettings { damping: None, ..filter });
    bare.lead = None;
    assert_eq!(bare.get("filter.damping.yaw"), None);
    assert_eq!(bare.get("filter.reach.yaw"), defaults::AERO.get("filter.reach.yaw"));
    assert_eq!(bare.set("lead.factor", 2.0), Ok(false));
    assert_eq!(LawSettings::<f64>::named("no such law"), None);
}
