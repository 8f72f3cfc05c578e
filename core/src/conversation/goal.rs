//! Where a setpoint may be.

use crate::link::{Refusal, text};
use crate::parameters::Limits;
use crate::reference::Reference;

/// \[rad\] Largest yaw that may be asked for, either way: 100 turns. Beyond, f32 no longer tells a count of
/// an encoder from the next.
pub const YAW: f32 = 200.0 * core::f32::consts::PI;
/// \[rad/s²\] Largest acceleration of a setpoint that moves: a multiple of what any of the rigs can.
pub const ACCEL: f32 = 100.0;

/// Why `setpoint` is refused, if it leaves `limits`.
#[must_use]
pub fn outside(limits: &Limits, setpoint: &Reference<f32>) -> Option<Refusal> {
    let Reference { angle, rate, accel } = setpoint;
    let rules = [
        ("setpoint.angle.pitch", angle.pitch, limits.pitch),
        ("setpoint.angle.yaw", angle.yaw, YAW),
        ("setpoint.rate.pitch", rate.pitch, limits.rate.pitch),
        ("setpoint.rate.yaw", rate.yaw, limits.rate.yaw),
        ("setpoint.accel.pitch", accel.pitch, ACCEL),
        ("setpoint.accel.yaw", accel.yaw, ACCEL),
    ];
    // A NaN is within no range.
    let found = rules.into_iter().find(|(_, value, most)| !(-most..=*most).contains(value));
    found.map(|(field, _, most)| Refusal::Setpoint { field: text(field), low: -most, high: most })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SAMPLE_TIME;
    use crate::axes::PerAxis;
    use crate::gains;
    use crate::parameters::Parameters;
    use crate::pipeline::Settings;
    use crate::plant::presets;

    #[test]
    fn the_field_and_its_range_are_named_and_the_bounds_are_allowed() {
        let settings = Settings::paper(&presets::AERO2, gains::PAPER, SAMPLE_TIME);
        let limits = Parameters::new(&presets::AERO2, &settings).limits;
        type Place = fn(&mut Reference<f32>) -> &mut f32;
        let fields: [(&str, f32, Place); 6] = [
            ("setpoint.angle.pitch", limits.pitch, |r| &mut r.angle.pitch),
            ("setpoint.angle.yaw", YAW, |r| &mut r.angle.yaw),
            ("setpoint.rate.pitch", limits.rate.pitch, |r| &mut r.rate.pitch),
            ("setpoint.rate.yaw", limits.rate.yaw, |r| &mut r.rate.yaw),
            ("setpoint.accel.pitch", ACCEL, |r| &mut r.accel.pitch),
            ("setpoint.accel.yaw", ACCEL, |r| &mut r.accel.yaw),
        ];
        for (name, most, place) in fields {
            let with = |value: f32| {
                let mut setpoint = Reference::at_rest(PerAxis::zero());
                *place(&mut setpoint) = value;
                outside(&limits, &setpoint)
            };
            for allowed in [0.0, most, -most] {
                assert_eq!(with(allowed), None, "{name} = {allowed}");
            }
            for bad in [most * 1.001, -most * 1.001, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
                let refusal = Refusal::Setpoint { field: text(name), low: -most, high: most };
                assert_eq!(with(bad), Some(refusal), "{name} = {bad}");
            }
        }
    }
}
