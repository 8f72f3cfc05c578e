//! Step 6 of the tick: from torque to motor volts, and what the motors cannot give.

use crate::axes::{PerAxis, PerMotor};
use crate::plant::Effectiveness;
use crate::real::{Mask, Real};

/// What comes of a torque request.
#[derive(Debug, Clone, Copy)]
pub struct Allocation<R: Real> {
    /// \[V\] To be applied: within the limits, finite, and zero on a fault.
    pub volts: PerMotor<R>,
    /// \[V\] What the torque asked for would have taken. Not finite on a fault.
    pub demand: PerMotor<R>,
    /// \[N m\] Torque asked for that these volts do not give; zero on a fault, where nothing sensible was asked.
    pub unallocated_torque: PerAxis<R>,
    /// Something that went into this tick was NaN or infinite: no volts.
    pub fault: R::Mask,
}

impl<R: Real> Allocation<R> {
    /// Nothing asked for, nothing given.
    pub fn none() -> Self {
        Self {
            volts: PerMotor::zero(),
            demand: PerMotor::zero(),
            unallocated_torque: PerAxis::zero(),
            fault: R::Mask::splat(false),
        }
    }

    /// Was more asked of a motor than its limit allows?
    #[inline(always)]
    pub fn saturated(&self, limit: PerMotor<R>) -> PerMotor<R::Mask> {
        self.demand.zip(limit, |v, limit| limit.lt(v.abs()))
    }
}

/// V = K⁻¹ U by the determinant, which is eqs (28)-(29) without their divisions by k_pp and k_yy, and a hard limit
/// on each motor's volts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allocator<R> {
    effectiveness: Effectiveness<R>,
    inverse_determinant: R,
    limit: PerMotor<R>,
}

impl<R: Real> Allocator<R> {
    /// For thrust gains K [N m/V] with a determinant other than zero, and volts within ±`limit`.
    pub fn new(effectiveness: Effectiveness<R>, limit: PerMotor<R>) -> Self {
        Self { effectiveness, inverse_determinant: R::one() / effectiveness.determinant(), limit }
    }

    /// \[V\] The limits.
    #[inline(always)]
    pub fn limit(&self) -> PerMotor<R> {
        self.limit
    }

    /// \[V\] The volts that give `torque` [N m] exactly: eqs (28)-(29).
    #[inline(always)]
    pub fn demand(&self, torque: PerAxis<R>) -> PerMotor<R> {
        let k = &self.effectiveness;
        PerMotor {
            main: (k.tail_on_yaw * torque.pitch - k.tail_on_pitch * torque.yaw) * self.inverse_determinant,
            tail: (k.main_on_pitch * torque.yaw - k.main_on_yaw * torque.pitch) * self.inverse_determinant,
        }
    }

    /// Each motor's volts limited on its own.
    ///
    /// A NaN or an infinity in anything that led here ends as one in the demand (no operation on the way drops
    /// them), and then both motors get zero: a clamp would turn it into a full voltage.
    #[inline(always)]
    pub fn allocate(&self, demand: PerMotor<R>) -> Allocation<R> {
        let sound = demand.main.is_finite() & demand.tail.is_finite();
        let volts = demand.zip(self.limit, |v, limit| R::select(sound, v.clamp(-limit, limit), R::zero()));
        let missing = self.effectiveness.torque(demand.minus(volts));
        Allocation {
            volts,
            demand,
            unallocated_torque: missing.map(|t| R::select(sound, t, R::zero())),
            fault: !sound,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::presets;
    use proptest::prelude::*;

    fn allocator(rig: &presets::Rig) -> Allocator<f64> {
        let k = rig.plant.effectiveness_at(rig.nominal_volts);
        Allocator::new(k, rig.volts_limit)
    }

    proptest! {
        #[test]
        fn demand_is_eqs_28_and_29(pitch in -0.5..0.5, yaw in -0.5..0.5) {
            for (_, rig) in presets::ALL {
                let k = rig.plant.effectiveness_at(rig.nominal_volts);
                let (kpp, kpy, kyp, kyy) = (k.main_on_pitch, k.tail_on_pitch, k.main_on_yaw, k.tail_on_yaw);
                let main = (pitch - kpy * yaw / kyy) / (kpp - kyp * kpy / kyy);
                let tail = (yaw - kyp * pitch / kpp) / (kyy - kpy * kyp / kpp);
                let v = allocator(&rig).demand(PerAxis::new(pitch, yaw));
                prop_assert!((v.main - main).abs() <= 1e-10 * (1.0 + main.abs()));
                prop_assert!((v.tail - tail).abs() <= 1e-10 * (1.0 + tail.abs()));
            }
        }

        #[test]
        fn what_is_given_and_what_is_not_make_what_was_asked(pitch in -2.0..2.0, yaw in -2.0..2.0) {
            for (_, rig) in presets::ALL {
                let k = rig.plant.effectiveness_at(rig.nominal_volts);
                let a = allocator(&rig);
                let asked = PerAxis::new(pitch, yaw);
                let got = a.allocate(a.demand(asked));
                let sum = k.torque(got.volts).plus(got.unallocated_torque);
                prop_assert!((sum.pitch - pitch).abs() < 1e-12 && (sum.yaw - yaw).abs() < 1e-12);
                prop_assert!(got.volts.main.abs() <= rig.volts_limit.main);
                prop_assert!(got.volts.tail.abs() <= rig.volts_limit.tail);
                let over = got.saturated(rig.volts_limit);
                prop_assert_eq!(over.main || over.tail, got.unallocated_torque != PerAxis::zero());
            }
        }
    }

    #[test]
    fn a_demand_that_is_not_finite_gives_zero_and_a_fault_never_a_bound() {
        let a = allocator(&presets::PAPER);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for demand in [PerMotor::new(bad, 1.0), PerMotor::new(1.0, bad)] {
                let got = a.allocate(demand);
                assert!(got.fault);
                assert_eq!(got.volts, PerMotor::zero());
                assert_eq!(got.unallocated_torque, PerAxis::zero());
            }
        }
    }
}
