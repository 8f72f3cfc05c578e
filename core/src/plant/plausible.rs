//! What a number of a rig may be: one table, a line for each number, with the unit that a value beyond its
//! range is likely to be in.
//!
//! The ranges hold every rig of this size with room to spare, and no more: a number in another unit must not
//! pass, since rates in degrees a second or volts in millivolts would put the monitors to sleep. What may be
//! left out of a plant may be zero.

use super::PlantParameters;
use super::presets::Rig;
use crate::validate::Invalid;
use core::f64::consts::TAU;

/// What one number of a rig may be.
pub struct Plausible<T> {
    /// As a preset file spells it, without the table `plant`.
    pub field: &'static str,
    /// Least and most, both allowed.
    pub range: [f64; 2],
    /// The same in words, with the unit.
    pub allowed: &'static str,
    of: fn(&T) -> Option<f64>,
    others: &'static [Other],
}

/// Another unit that a number may have been written in.
struct Other {
    /// Of the unit that is wanted, in one of this unit.
    size: f64,
    allowed: &'static str,
}

/// \[rad\] A degree.
const DEG: f64 = TAU / 360.0;

macro_rules! plausible {
    ($($field:literal: $least:literal..=$most:literal $unit:literal $(or $size:tt $other:literal)*,
       |$rig:ident| $of:expr;)*) => {
        &[$(Plausible {
            field: $field,
            range: [$least, $most],
            allowed: concat!($least, " to ", $most, " ", $unit),
            of: |$rig| $of,
            others: &[$(Other {
                size: $size,
                allowed: concat!($least, " to ", $most, " ", $unit, " (was it in ", $other, "?)"),
            }),*],
        }),*]
    };
}

/// Every constant of a plant.
pub const PLANT: &[Plausible<PlantParameters<f64>>] = plausible! {
    "mass": 0.001..=100.0 "kg" or 1e-3 "g", |plant| Some(plant.mass);
    "center_of_mass": -1.0..=1.0 "m" or 1e-3 "mm" or 1e-2 "cm", |plant| Some(plant.center_of_mass);
    "gravity": 0.0..=30.0 "m/s²" or 1e-3 "mm/s²" or 1e-2 "cm/s²", |plant| Some(plant.gravity);
    "inertia.pitch": 0.0001..=10.0 "kg m²" or 1e-4 "kg cm²" or 1e-6 "g m² or kg mm²",
        |plant| Some(plant.inertia.pitch);
    "inertia.yaw": 0.0001..=10.0 "kg m²" or 1e-4 "kg cm²" or 1e-6 "g m² or kg mm²",
        |plant| Some(plant.inertia.yaw);
    "damping.pitch": 0.0..=10.0 "N m s/rad" or 1e-3 "mN m s/rad", |plant| Some(plant.damping.pitch);
    "damping.yaw": 0.0..=10.0 "N m s/rad" or 1e-3 "mN m s/rad", |plant| Some(plant.damping.yaw);
    "stiffness": 0.0..=50.0 "N m/rad" or 1e-3 "mN m/rad", |plant| Some(plant.stiffness);
    "effectiveness.main_on_pitch": -5.0..=5.0 "N m/V" or 1e-3 "mN m/V" or 1e-6 "µN m/V",
        |plant| Some(plant.effectiveness.main_on_pitch);
    "effectiveness.tail_on_pitch": -5.0..=5.0 "N m/V" or 1e-3 "mN m/V" or 1e-6 "µN m/V",
        |plant| Some(plant.effectiveness.tail_on_pitch);
    "effectiveness.main_on_yaw": -5.0..=5.0 "N m/V" or 1e-3 "mN m/V" or 1e-6 "µN m/V",
        |plant| Some(plant.effectiveness.main_on_yaw);
    "effectiveness.tail_on_yaw": -5.0..=5.0 "N m/V" or 1e-3 "mN m/V" or 1e-6 "µN m/V",
        |plant| Some(plant.effectiveness.tail_on_yaw);
    "quadratic_effectiveness.main_on_pitch": -5.0..=5.0 "N m/V²" or 1e-3 "mN m/V²" or 1e-6 "µN m/V²",
        |plant| Some(plant.quadratic_effectiveness.main_on_pitch);
    "quadratic_effectiveness.tail_on_pitch": -5.0..=5.0 "N m/V²" or 1e-3 "mN m/V²" or 1e-6 "µN m/V²",
        |plant| Some(plant.quadratic_effectiveness.tail_on_pitch);
    "quadratic_effectiveness.main_on_yaw": -5.0..=5.0 "N m/V²" or 1e-3 "mN m/V²" or 1e-6 "µN m/V²",
        |plant| Some(plant.quadratic_effectiveness.main_on_yaw);
    "quadratic_effectiveness.tail_on_yaw": -5.0..=5.0 "N m/V²" or 1e-3 "mN m/V²" or 1e-6 "µN m/V²",
        |plant| Some(plant.quadratic_effectiveness.tail_on_yaw);
    "rotor_time_constant.main": 0.0..=2.0 "s" or 1e-3 "ms" or 1e-6 "µs",
        |plant| Some(plant.rotor_time_constant.main);
    "rotor_time_constant.tail": 0.0..=2.0 "s" or 1e-3 "ms" or 1e-6 "µs",
        |plant| Some(plant.rotor_time_constant.tail);
    "rotor_reaction.main": -1.0..=1.0 "N m s/V" or 1e-3 "mN m s/V", |plant| Some(plant.rotor_reaction.main);
    "rotor_reaction.tail": -1.0..=1.0 "N m s/V" or 1e-3 "mN m s/V", |plant| Some(plant.rotor_reaction.tail);
    "coulomb_friction.pitch": 0.0..=1.0 "N m" or 1e-3 "mN m", |plant| Some(plant.coulomb_friction.pitch);
    "coulomb_friction.yaw": 0.0..=1.0 "N m" or 1e-3 "mN m", |plant| Some(plant.coulomb_friction.yaw);
};

/// Every other number of a rig.
pub const RIG: &[Plausible<Rig>] = plausible! {
    "volts_limit.main": 0.1..=60.0 "V" or 1e-3 "mV", |rig| Some(rig.volts_limit.main);
    "volts_limit.tail": 0.1..=60.0 "V" or 1e-3 "mV", |rig| Some(rig.volts_limit.tail);
    "supply.nominal": 0.1..=75.0 "V" or 1e-3 "mV", |rig| Some(rig.supply.nominal);
    "supply.lowest": 0.1..=75.0 "V" or 1e-3 "mV", |rig| Some(rig.supply.lowest);
    "supply.highest": 0.1..=75.0 "V" or 1e-3 "mV", |rig| Some(rig.supply.highest);
    "nominal_volts": 0.0..=60.0 "V" or 1e-3 "mV", |rig| Some(rig.nominal_volts);
    "encoder_counts.pitch": 16.0..=1000000.0 "counts a revolution",
        |rig| Some(f64::from(rig.encoder_counts.pitch));
    "encoder_counts.yaw": 16.0..=1000000.0 "counts a revolution",
        |rig| Some(f64::from(rig.encoder_counts.yaw));
    "rest_angle.pitch": -1.5707964..=1.5707964 "rad" or DEG "degrees" or 1e-3 "mrad",
        |rig| Some(rig.rest_angle.pitch);
    "rest_angle.yaw": -6.283186..=6.283186 "rad" or DEG "degrees" or 1e-3 "mrad",
        |rig| Some(rig.rest_angle.yaw);
    "envelope.pitch": 0.01..=1.5707964 "rad" or DEG "degrees" or 1e-3 "mrad", |rig| Some(rig.envelope.pitch);
    "envelope.rate.pitch": 0.1..=30.0 "rad/s" or DEG "degrees a second" or 1e-3 "mrad/s",
        |rig| Some(rig.envelope.rate.pitch);
    "envelope.rate.yaw": 0.1..=30.0 "rad/s" or DEG "degrees a second" or 1e-3 "mrad/s",
        |rig| Some(rig.envelope.rate.yaw);
    "motor.resistance": 0.01..=1000.0 "ohm" or 1e-3 "mΩ", |rig| rig.motor.map(|motor| motor.resistance);
    "motor.back_emf": 0.0001..=1.0 "V s/rad" or 1e-3 "mV s/rad", |rig| rig.motor.map(|motor| motor.back_emf);
    "motor.drag": 0.0..=0.01 "N m s/rad" or 1e-3 "mN m s/rad" or 1e-6 "µN m s/rad",
        |rig| rig.motor.map(|motor| motor.drag);
    "motor.peak_current": 0.01..=100.0 "A" or 1e-3 "mA", |rig| rig.motor.map(|motor| motor.peak_current);
    "motor.continuous_current": 0.01..=100.0 "A" or 1e-3 "mA",
        |rig| rig.motor.map(|motor| motor.continuous_current);
};

impl PlantParameters<f64> {
    /// Every constant within its range.
    ///
    /// # Errors
    /// Names the first that is not.
    pub fn validate(&self) -> Result<(), Invalid> {
        check(PLANT, self)
    }
}

/// Every number of `table` within its range?
pub(super) fn check<T>(table: &[Plausible<T>], of: &T) -> Result<(), Invalid> {
    table.iter().try_for_each(|number| (number.of)(of).map_or(Ok(()), |value| number.check(value)))
}

impl<T> Plausible<T> {
    fn check(&self, value: f64) -> Result<(), Invalid> {
        let [least, most] = self.range;
        let within = |value: f64| (least..=most).contains(&value);
        if within(value) {
            return Ok(());
        }
        let other = self.others.iter().find(|other| value.is_finite() && within(value * other.size));
        Err(Invalid { field: self.field, value, allowed: other.map_or(self.allowed, |other| other.allowed) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::presets::{AERO, AERO_LAB, HELI};

    #[test]
    fn a_number_in_another_unit_is_refused_with_that_unit() {
        let refusal = |change: &dyn Fn(&mut Rig)| {
            let mut rig = AERO;
            change(&mut rig);
            rig.validate().unwrap_err()
        };
        type Case<'a> = (&'a dyn Fn(&mut Rig), &'a str, &'a str);
        let cases: [Case<'_>; 9] = [
            (&|rig| rig.envelope.rate.yaw = 573.0, "envelope.rate.yaw", "degrees a second"),
            (&|rig| rig.rest_angle.pitch = -40.5, "rest_angle.pitch", "degrees"),
            (&|rig| rig.plant.rotor_time_constant.tail = 160.0, "rotor_time_constant.tail", "ms"),
            (&|rig| rig.volts_limit.main = 18_000.0, "volts_limit.main", "mV"),
            (&|rig| rig.nominal_volts = 10_000.0, "nominal_volts", "mV"),
            (&|rig| rig.plant.mass = 1075.0, "mass", "g"),
            (&|rig| rig.plant.inertia.pitch = 219.0, "inertia.pitch", "kg cm²"),
            (&|rig| rig.plant.center_of_mass = 186.0, "center_of_mass", "mm"),
            (
                &|rig| {
                    rig.motor =
                        rig.motor.map(|m| crate::plant::presets::MotorConstants { peak_current: 2000.0, ..m })
                },
                "motor.peak_current",
                "mA",
            ),
        ];
        for (change, field, unit) in cases {
            let Invalid { field: found, allowed, .. } = refusal(change);
            assert_eq!(found, field);
            assert!(allowed.contains(unit) && allowed.contains(" to "), "{allowed}");
        }
    }

    fn ends<T>(number: &Plausible<T>) {
        let [least, most] = number.range;
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, least - 1.0, most * 1.01 + 1.0, 1e300] {
            assert!(number.check(value).is_err(), "{} {value}", number.field);
        }
        assert!(number.check(least).is_ok() && number.check(most).is_ok());
    }

    /// A rate, a rest pose or a supply that no rig has must not reach a board, whatever its unit.
    #[test]
    fn what_would_put_a_monitor_to_sleep_is_refused() {
        PLANT.iter().for_each(ends);
        RIG.iter().for_each(ends);
        let mut beyond = HELI;
        beyond.rest_angle.pitch = -0.9;
        assert_eq!(beyond.validate().unwrap_err().field, "rest_angle.pitch");
        let mut high = AERO_LAB;
        high.nominal_volts = 30.0;
        assert_eq!(high.validate().unwrap_err().field, "nominal_volts");
    }
}
