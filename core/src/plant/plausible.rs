//! What a number of a rig may be: one table, a line for each number, with the unit that a value beyond its
//! range is likely to be in.
//!
//! The ranges hold every rig of this size with room to spare, and no more: a number in another unit must not
//! pass, since rates in degrees a second or volts in millivolts would put the monitors to sleep. What may be
//! left out of a plant may be zero.

use super::PlantParameters;
use super::presets::Rig;
use crate::validate::{Invalid, require};
use core::f64::consts::TAU;

/// What one number of a rig may be.
pub struct Plausible<T> {
    /// As a preset file spells it, without the table `plant`.
    pub field: &'static str,
    /// Least and most, both allowed.
    pub range: [f64; 2],
    /// The same in words, with the unit.
    pub allowed: &'static str,
    /// What it is, in a line.
    pub doc: &'static str,
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
       $doc:literal, |$rig:ident| $of:expr;)*) => {
        &[$(Plausible {
            field: $field,
            range: [$least, $most],
            allowed: concat!($least, " to ", $most, " ", $unit),
            doc: $doc,
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
    "mass": 0.001..=100.0 "kg" or 1e-3 "g",
        "mass that moves",
        |plant| Some(plant.mass);
    "center_of_mass": -1.0..=1.0 "m" or 1e-3 "mm" or 1e-2 "cm",
        "from the pivot to the mass's centre, ahead of it; l of eq. (1)",
        |plant| Some(plant.center_of_mass);
    "gravity": 0.0..=30.0 "m/s²" or 1e-3 "mm/s²" or 1e-2 "cm/s²",
        "acceleration of free fall",
        |plant| Some(plant.gravity);
    "inertia.pitch": 0.0001..=10.0 "kg m²" or 1e-4 "kg cm²" or 1e-6 "g m² or kg mm²",
        "J of the pitch axis, without m l²",
        |plant| Some(plant.inertia.pitch);
    "inertia.yaw": 0.0001..=10.0 "kg m²" or 1e-4 "kg cm²" or 1e-6 "g m² or kg mm²",
        "J of the yaw axis, without m l²",
        |plant| Some(plant.inertia.yaw);
    "damping.pitch": 0.0..=10.0 "N m s/rad" or 1e-3 "mN m s/rad",
        "viscous damping D about pitch",
        |plant| Some(plant.damping.pitch);
    "damping.yaw": 0.0..=10.0 "N m s/rad" or 1e-3 "mN m s/rad",
        "viscous damping D about yaw",
        |plant| Some(plant.damping.yaw);
    "stiffness": 0.0..=50.0 "N m/rad" or 1e-3 "mN m/rad",
        "of the body about pitch, zero where it is level",
        |plant| Some(plant.stiffness);
    "effectiveness.main_on_pitch": -5.0..=5.0 "N m/V" or 1e-3 "mN m/V" or 1e-6 "µN m/V",
        "k_pp of eq. (5)",
        |plant| Some(plant.effectiveness.main_on_pitch);
    "effectiveness.tail_on_pitch": -5.0..=5.0 "N m/V" or 1e-3 "mN m/V" or 1e-6 "µN m/V",
        "k_py of eq. (5)",
        |plant| Some(plant.effectiveness.tail_on_pitch);
    "effectiveness.main_on_yaw": -5.0..=5.0 "N m/V" or 1e-3 "mN m/V" or 1e-6 "µN m/V",
        "k_yp of eq. (6)",
        |plant| Some(plant.effectiveness.main_on_yaw);
    "effectiveness.tail_on_yaw": -5.0..=5.0 "N m/V" or 1e-3 "mN m/V" or 1e-6 "µN m/V",
        "k_yy of eq. (6)",
        |plant| Some(plant.effectiveness.tail_on_yaw);
    "quadratic_effectiveness.main_on_pitch": -5.0..=5.0 "N m/V²" or 1e-3 "mN m/V²" or 1e-6 "µN m/V²",
        "of a volt squared with its sign: thrust grows faster than volts",
        |plant| Some(plant.quadratic_effectiveness.main_on_pitch);
    "quadratic_effectiveness.tail_on_pitch": -5.0..=5.0 "N m/V²" or 1e-3 "mN m/V²" or 1e-6 "µN m/V²",
        "the same, tail motor",
        |plant| Some(plant.quadratic_effectiveness.tail_on_pitch);
    "quadratic_effectiveness.main_on_yaw": -5.0..=5.0 "N m/V²" or 1e-3 "mN m/V²" or 1e-6 "µN m/V²",
        "the same, on yaw",
        |plant| Some(plant.quadratic_effectiveness.main_on_yaw);
    "quadratic_effectiveness.tail_on_yaw": -5.0..=5.0 "N m/V²" or 1e-3 "mN m/V²" or 1e-6 "µN m/V²",
        "the same, tail motor on yaw",
        |plant| Some(plant.quadratic_effectiveness.tail_on_yaw);
    "rotor_time_constant.main": 0.0..=2.0 "s" or 1e-3 "ms" or 1e-6 "µs",
        "lag of the main rotor's thrust behind its volts, 0 for none",
        |plant| Some(plant.rotor_time_constant.main);
    "rotor_time_constant.tail": 0.0..=2.0 "s" or 1e-3 "ms" or 1e-6 "µs",
        "lag of the tail rotor",
        |plant| Some(plant.rotor_time_constant.tail);
    "rotor_reaction.main": -1.0..=1.0 "N m s/V" or 1e-3 "mN m s/V",
        "torque on yaw as the main rotor speeds up, for each V/s at the rotor",
        |plant| Some(plant.rotor_reaction.main);
    "rotor_reaction.tail": -1.0..=1.0 "N m s/V" or 1e-3 "mN m s/V",
        "torque on pitch as the tail rotor speeds up",
        |plant| Some(plant.rotor_reaction.tail);
    "coulomb_friction.pitch": 0.0..=1.0 "N m" or 1e-3 "mN m",
        "dry friction about pitch",
        |plant| Some(plant.coulomb_friction.pitch);
    "coulomb_friction.yaw": 0.0..=1.0 "N m" or 1e-3 "mN m",
        "dry friction about yaw",
        |plant| Some(plant.coulomb_friction.yaw);
    "tilting_inertia": -10.0..=10.0 "kg m²" or 1e-4 "kg cm²" or 1e-6 "g m² or kg mm²",
        "by how much less inertia yaw has with the body upright, J_zz - J_xx of the body, below inertia.yaw; may be left out (0)",
        |plant| Some(plant.tilting_inertia);
    "rotor_momentum": -1.0..=1.0 "N m s/V" or 1e-3 "mN m s/V",
        "angular momentum of the main rotor for each volt in effect; minus rotor_reaction.main where both are known; may be left out (0)",
        |plant| Some(plant.rotor_momentum);
    "tilting_thrust": 0.0..=1.0 "(no unit)",
        "1 where thrust and reaction turn yaw by cos θ of what they do on a level body, 0 where by all of it; may be left out (0)",
        |plant| Some(plant.tilting_thrust);
};

/// Every other number of a rig.
pub const RIG: &[Plausible<Rig>] = plausible! {
    "volts_limit.main": 0.1..=60.0 "V" or 1e-3 "mV",
        "most that the main motor may get, either way",
        |rig| Some(rig.volts_limit.main);
    "volts_limit.tail": 0.1..=60.0 "V" or 1e-3 "mV",
        "most that the tail motor may get",
        |rig| Some(rig.volts_limit.tail);
    "supply.nominal": 0.1..=75.0 "V" or 1e-3 "mV",
        "the amplifiers' supply as it should be; the table may be left out (24, 16, 29)",
        |rig| Some(rig.supply.nominal);
    "supply.lowest": 0.1..=75.0 "V" or 1e-3 "mV",
        "least with which the motors may turn",
        |rig| Some(rig.supply.lowest);
    "supply.highest": 0.1..=75.0 "V" or 1e-3 "mV",
        "most with which the motors may turn",
        |rig| Some(rig.supply.highest);
    "nominal_volts": 0.0..=60.0 "V" or 1e-3 "mV",
        "where the slope of the thrust curve is taken for a law that thinks it straight",
        |rig| Some(rig.nominal_volts);
    "encoder_counts.pitch": 16.0..=1000000.0 "counts a revolution",
        "all four edges counted",
        |rig| Some(f64::from(rig.encoder_counts.pitch));
    "encoder_counts.yaw": 16.0..=1000000.0 "counts a revolution",
        "all four edges counted",
        |rig| Some(f64::from(rig.encoder_counts.yaw));
    "rest_angle.pitch": -1.5707964..=1.5707964 "rad" or DEG "degrees" or 1e-3 "mrad",
        "where it lies with the motors off, from the horizontal",
        |rig| Some(rig.rest_angle.pitch);
    "rest_angle.yaw": -6.283186..=6.283186 "rad" or DEG "degrees" or 1e-3 "mrad",
        "where yaw is zeroed",
        |rig| Some(rig.rest_angle.yaw);
    "envelope.pitch": 0.01..=1.5707964 "rad" or DEG "degrees" or 1e-3 "mrad",
        "largest pitch either way; beyond it the motors are cut",
        |rig| Some(rig.envelope.pitch);
    "envelope.rate.pitch": 0.1..=30.0 "rad/s" or DEG "degrees a second" or 1e-3 "mrad/s",
        "fastest pitch; beyond it the motors are cut",
        |rig| Some(rig.envelope.rate.pitch);
    "envelope.rate.yaw": 0.1..=30.0 "rad/s" or DEG "degrees a second" or 1e-3 "mrad/s",
        "fastest yaw; beyond it the motors are cut",
        |rig| Some(rig.envelope.rate.yaw);
    "motor.resistance": 0.01..=1000.0 "ohm" or 1e-3 "mΩ",
        "at the terminals; the table `motor` may be left out where it is not known",
        |rig| rig.motor.map(|motor| motor.resistance);
    "motor.back_emf": 0.0001..=1.0 "V s/rad" or 1e-3 "mV s/rad",
        "back-EMF constant, in numbers also N m/A",
        |rig| rig.motor.map(|motor| motor.back_emf);
    "motor.drag": 0.0..=0.01 "N m s/rad" or 1e-3 "mN m s/rad" or 1e-6 "µN m s/rad",
        "torque that the turning propeller takes for each rad/s",
        |rig| rig.motor.map(|motor| motor.drag);
    "motor.peak_current": 0.01..=100.0 "A" or 1e-3 "mA",
        "most for an instant",
        |rig| rig.motor.map(|motor| motor.peak_current);
    "motor.continuous_current": 0.01..=100.0 "A" or 1e-3 "mA",
        "most for long",
        |rig| rig.motor.map(|motor| motor.continuous_current);
};

impl PlantParameters<f64> {
    /// Every constant within its range, and yaw with some inertia at any pitch.
    ///
    /// # Errors
    /// Names the first that is not.
    pub fn validate(&self) -> Result<(), Invalid> {
        check(PLANT, self)?;
        let Self { tilting_inertia, inertia, .. } = *self;
        require(
            "tilting_inertia",
            tilting_inertia,
            tilting_inertia < inertia.yaw,
            "below inertia.yaw, in kg m²",
        )
    }
}

/// Every number of `table` within its range?
pub(super) fn check<T>(table: &[Plausible<T>], of: &T) -> Result<(), Invalid> {
    table.iter().try_for_each(|number| (number.of)(of).map_or(Ok(()), |value| number.check(value)))
}

impl<T> Plausible<T> {
    /// What this number is in a rig; `None` where it is not given.
    pub fn value(&self, of: &T) -> Option<f64> {
        (self.of)(of)
    }

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
