//! The plant's constants as a vector: names, units, bounds by physics, and which of them a fit may move.

use twinrotor::plant::PlantParameters;
use twinrotor_sim::{Error, Outcome};

/// How many constants a plant has.
pub const COUNT: usize = 25;

/// One constant of the plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constant {
    /// As a preset file spells it.
    pub name: &'static str,
    /// SI.
    pub unit: &'static str,
    /// Is it fitted when nothing else is said?
    pub usual: bool,
    reach: Reach,
}

/// How far from zero a constant may lie, for each kg m² of the inertia it works on: chosen to hold every rig
/// that `core/src/plant/presets.rs` knows with room to spare.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Reach {
    /// Zero to this, for each unit of pitch inertia.
    Pitch(f64),
    /// Zero to this, for each unit of yaw inertia.
    Yaw(f64),
    /// Either sign, for each unit of pitch inertia.
    PitchEither(f64),
    /// Either sign, for each unit of yaw inertia.
    YawEither(f64),
    /// What the tail motor does to pitch: of the preset's sign, for each unit of pitch inertia.
    TailOnPitch(f64),
    /// What the main motor does to yaw: of the preset's sign, for each unit of yaw inertia.
    MainOnYaw(f64),
    /// These bounds as they are.
    Plain(f64, f64),
}

const fn free(name: &'static str, unit: &'static str, reach: Reach) -> Constant {
    Constant { name, unit, usual: true, reach }
}

const fn known(name: &'static str, unit: &'static str, least: f64, most: f64) -> Constant {
    Constant { name, unit, usual: false, reach: Reach::Plain(least, most) }
}

/// Every constant, in the order of [`PlantParameters::map`].
///
/// Angles and volts give only ratios to the inertias, so inertias, mass, centre of mass and gravity are known
/// unless they are freed by name. A motor's own thrust on its own axis is positive by the sign convention.
/// What it does to the other axis has the sign that the preset gives it at usual volts, if it gives one:
/// linear and quadratic part alike, since a propeller that turns faster pushes harder.
pub const CONSTANTS: [Constant; COUNT] = [
    known("mass", "kg", 1e-3, 1e2),
    known("center_of_mass", "m", -1.0, 1.0),
    known("gravity", "m/s²", 0.0, 30.0),
    known("inertia.pitch", "kg m²", 1e-4, 10.0),
    known("inertia.yaw", "kg m²", 1e-4, 10.0),
    free("damping.pitch", "N m s/rad", Reach::Pitch(40.0)),
    free("damping.yaw", "N m s/rad", Reach::Yaw(40.0)),
    free("stiffness", "N m/rad", Reach::Pitch(100.0)),
    free("effectiveness.main_on_pitch", "N m/V", Reach::Pitch(12.0)),
    free("effectiveness.tail_on_pitch", "N m/V", Reach::TailOnPitch(12.0)),
    free("effectiveness.main_on_yaw", "N m/V", Reach::MainOnYaw(12.0)),
    free("effectiveness.tail_on_yaw", "N m/V", Reach::Yaw(12.0)),
    free("quadratic_effectiveness.main_on_pitch", "N m/V²", Reach::Pitch(1.0)),
    free("quadratic_effectiveness.tail_on_pitch", "N m/V²", Reach::TailOnPitch(1.0)),
    free("quadratic_effectiveness.main_on_yaw", "N m/V²", Reach::MainOnYaw(1.0)),
    free("quadratic_effectiveness.tail_on_yaw", "N m/V²", Reach::Yaw(1.0)),
    free("rotor_time_constant.main", "s", Reach::Plain(0.005, 0.6)),
    free("rotor_time_constant.tail", "s", Reach::Plain(0.005, 0.6)),
    free("rotor_reaction.main", "N m s/V", Reach::YawEither(1.0)),
    free("rotor_reaction.tail", "N m s/V", Reach::PitchEither(1.0)),
    free("coulomb_friction.pitch", "N m", Reach::Pitch(2.0)),
    free("coulomb_friction.yaw", "N m", Reach::Yaw(2.0)),
    Constant { usual: false, ..free("tilting_inertia", "kg m²", Reach::YawEither(0.99)) },
    Constant { usual: false, ..free("rotor_momentum", "N m s/V", Reach::YawEither(1.0)) },
    known("tilting_thrust", "", 0.0, 1.0),
];

/// \[V\] Where the sign of a thrust counts.
const USUAL_VOLTS: f64 = 10.0;

impl Constant {
    /// Least and most that physics allows on a rig with this plant's inertias.
    pub fn bounds(&self, plant: &PlantParameters<f64>) -> [f64; 2] {
        let weight = plant.mass * plant.center_of_mass * plant.center_of_mass;
        let inertia = plant.inertia.map(|i| i + weight);
        let across = |sign: f64, most: f64| {
            [if sign > 0.0 { 0.0 } else { -most }, if sign < 0.0 { 0.0 } else { most }]
        };
        let usual = plant.effectiveness_at(USUAL_VOLTS);
        match self.reach {
            Reach::TailOnPitch(most) => across(usual.tail_on_pitch, most * inertia.pitch),
            Reach::MainOnYaw(most) => across(usual.main_on_yaw, most * inertia.yaw),
            Reach::Pitch(most) => [0.0, most * inertia.pitch],
            Reach::Yaw(most) => [0.0, most * inertia.yaw],
            Reach::PitchEither(most) => [-most * inertia.pitch, most * inertia.pitch],
            Reach::YawEither(most) => [-most * inertia.yaw, most * inertia.yaw],
            Reach::Plain(least, most) => [least, most],
        }
    }
}

/// The constants of a plant.
pub fn to_array(plant: &PlantParameters<f64>) -> [f64; COUNT] {
    let mut values = [0.0; COUNT];
    let mut next = values.iter_mut();
    plant.map(|value| {
        if let Some(place) = next.next() {
            *place = value;
        }
    });
    values
}

/// The plant with these constants.
pub fn from_array(values: &[f64; COUNT]) -> PlantParameters<f64> {
    let mut next = values.iter();
    let any = twinrotor::plant::presets::PAPER.plant;
    any.map(|_| *next.next().expect("a plant has as many constants as the table"))
}

/// Which constants are fitted: the usual ones, and those of `freed`, without those of `fixed`. A name stands
/// for itself and for what begins with it and a dot.
///
/// # Errors
///
/// If there is no such constant, or nothing is left to fit.
pub fn chosen(freed: &[String], fixed: &[String]) -> Outcome<Vec<usize>> {
    let matches = |name: &str, wanted: &String| {
        name.strip_prefix(wanted.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    for (field, wanted) in freed.iter().map(|w| ("free", w)).chain(fixed.iter().map(|w| ("fix", w))) {
        if !CONSTANTS.iter().any(|c| matches(c.name, wanted)) {
            let names: Vec<&str> = CONSTANTS.iter().map(|c| c.name).collect();
            return Err(Error::invalid(field, format_args!("'{wanted}'"), names.join(", ")));
        }
    }
    let any = |list: &[String], name: &str| list.iter().any(|wanted| matches(name, wanted));
    let is_chosen = |c: &Constant| (c.usual || any(freed, c.name)) && !any(fixed, c.name);
    let chosen: Vec<usize> = (0..COUNT).filter(|k| is_chosen(&CONSTANTS[*k])).collect();
    if chosen.is_empty() {
        return Err(Error::invalid("fix", "all that is free", "to leave at least one constant free"));
    }
    Ok(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::plant::presets;

    /// The table's order is the plant's: each name leads to the field of that name in a preset file.
    #[test]
    fn each_name_is_its_field() {
        for (k, constant) in CONSTANTS.iter().enumerate() {
            let mut values = to_array(&presets::AERO_LAB.plant);
            values[k] = 0.123;
            let plant = toml::Value::try_from(from_array(&values)).unwrap();
            let field = constant.name.split('.').fold(&plant, |value, key| &value[key]);
            assert_eq!(field.as_float(), Some(0.123), "{}", constant.name);
        }
    }

    #[test]
    fn every_preset_lies_within_the_bounds() {
        for (name, rig) in presets::ALL {
            for (constant, value) in CONSTANTS.iter().zip(to_array(&rig.plant)) {
                let [least, most] = constant.bounds(&rig.plant);
                let free = constant.name.starts_with("rotor_time_constant") && value == 0.0;
                assert!(free || (least..=most).contains(&value), "{name} {} {value}", constant.name);
            }
        }
    }

    #[test]
    fn constants_are_chosen_by_name_or_group() {
        let names = |list: Vec<usize>| list.into_iter().map(|k| CONSTANTS[k].name).collect::<Vec<_>>();
        let fixed = ["effectiveness".to_owned(), "rotor_time_constant.tail".to_owned()];
        let got = names(chosen(&["inertia.yaw".to_owned()], &fixed).unwrap());
        assert!(got.contains(&"inertia.yaw") && got.contains(&"quadratic_effectiveness.main_on_yaw"));
        assert!(
            !got.iter().any(|n| n.starts_with("effectiveness")) && !got.contains(&"rotor_time_constant.tail")
        );
        let error = chosen(&[], &["thrust".to_owned()]).unwrap_err().to_string();
        assert!(error.contains("fix is 'thrust'") && error.contains("stiffness"), "{error}");
    }
}
