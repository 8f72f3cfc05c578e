//! Step 6 of the tick: from torque to motor volts, and what the motors cannot give.

mod current_limit;
mod scaling;
mod weighted;

pub use current_limit::{CurrentLimit, CurrentLimitSettings};

use crate::axes::{PerAxis, PerMotor};
use crate::plant::Effectiveness;
use crate::real::Real;
use weighted::Weighted;

choice! {
    /// What becomes of a demand that the motors cannot meet.
    pub enum AllocationSettings<R> {
        /// Each motor's volts limited on their own, as the paper does.
        "clamp" Clamp by ();
        /// Both scaled down together, towards the volts that hold the pose.
        "scale" Scale by ();
        /// The volts that come nearest to the accelerations asked for.
        "weighted" Weighted { pitch_weight: R } by Weight;
    }
}

/// The table of [`AllocationSettings::Weighted`].
struct Weight;

table! {
    [] [Weight] at ("allocation.") {
        /// How much more an error of pitch acceleration counts than one of yaw.
        pitch_weight: (R) "-", (above 0), typical 0.1 to 5.0, default 1.5;
    }
}

/// The volts that are allowed at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoltsRange<R> {
    /// \[V\] Least of each motor.
    pub low: PerMotor<R>,
    /// \[V\] Most of each motor.
    pub high: PerMotor<R>,
}

impl<R: Real> VoltsRange<R> {
    /// ±`limit` \[V\].
    #[inline(always)]
    pub fn within(limit: PerMotor<R>) -> Self {
        Self { low: limit.map(|v| -v), high: limit }
    }

    #[inline(always)]
    fn clamp(&self, volts: PerMotor<R>) -> PerMotor<R> {
        PerMotor {
            main: volts.main.clamp(self.low.main, self.high.main),
            tail: volts.tail.clamp(self.low.tail, self.high.tail),
        }
    }
}

/// What comes of a torque request.
#[derive(Debug, Clone, Copy)]
pub struct Allocation<R: Real> {
    /// \[V\] To be applied: within the limits, finite, and zero on a fault.
    pub volts: PerMotor<R>,
    /// \[V\] What the torque asked for would have taken. Not finite on a fault.
    pub demand: PerMotor<R>,
}

impl<R: Real> Allocation<R> {
    /// Nothing asked for, nothing given.
    pub fn none() -> Self {
        Self { volts: PerMotor::zero(), demand: PerMotor::zero() }
    }

    /// Was something that went into this tick NaN or infinite? Then there are no volts.
    #[inline(always)]
    pub fn fault(&self) -> R::Mask {
        !finite(self.demand)
    }

    /// Was more asked of a motor than its limit allows?
    #[inline(always)]
    pub fn saturated(&self, limit: PerMotor<R>) -> PerMotor<R::Mask> {
        self.demand.zip(limit, |v, limit| limit.lt(v.abs()))
    }

    /// Did a motor get other volts than were asked for, whatever the reason?
    #[inline(always)]
    pub fn clipped(&self) -> R::Mask {
        let missing = self.demand.minus(self.volts).map(Real::abs);
        R::zero().lt(missing.main + missing.tail)
    }
}

/// Are both? One NaN or infinity makes the sum one.
#[inline(always)]
fn finite<R: Real>(volts: PerMotor<R>) -> R::Mask {
    (volts.main + volts.tail).is_finite()
}

/// V = K⁻¹ U by the determinant, which is eqs (28)-(29) without their divisions by k_pp and k_yy, and hard
/// limits on the motors' volts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allocator<R> {
    effectiveness: Effectiveness<R>,
    inverse_determinant: R,
    limit: PerMotor<R>,
    method: Method<R>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(u8)]
enum Method<R> {
    Scale,
    Weighted(Weighted<R>),
    Clamp,
}

impl<R: Real> Allocator<R> {
    /// For thrust gains K \[N m/V\] with a determinant other than zero, and each motor's volts limited to
    /// ±`limit` on their own.
    pub fn new(effectiveness: Effectiveness<R>, limit: PerMotor<R>) -> Self {
        Self {
            effectiveness,
            inverse_determinant: R::one() / effectiveness.determinant(),
            limit,
            method: Method::Clamp,
        }
    }

    /// The same, limiting as `settings` say; `inertia` \[kg m²\].
    pub fn limiting(self, settings: &AllocationSettings<R>, inertia: PerAxis<R>) -> Self {
        let method = match *settings {
            AllocationSettings::Clamp => Method::Clamp,
            AllocationSettings::Scale => Method::Scale,
            AllocationSettings::Weighted { pitch_weight } => {
                Method::Weighted(Weighted::new(&self.effectiveness, inertia, pitch_weight))
            }
        };
        Self { method, ..self }
    }

    /// \[V\] The limits.
    #[inline(always)]
    pub fn limit(&self) -> PerMotor<R> {
        self.limit
    }

    /// \[V\] The volts that give `torque` \[N m\] exactly: eqs (28)-(29).
    #[inline(always)]
    pub fn demand(&self, torque: PerAxis<R>) -> PerMotor<R> {
        let k = &self.effectiveness;
        PerMotor {
            main: (k.tail_on_yaw * torque.pitch - k.tail_on_pitch * torque.yaw) * self.inverse_determinant,
            tail: (k.main_on_pitch * torque.yaw - k.main_on_yaw * torque.pitch) * self.inverse_determinant,
        }
    }

    /// The volts for `demand` within `range`. `hold` is the torque that keeps the pose \[N m\].
    ///
    /// A NaN or an infinity in anything that led here ends as one in the demand (no operation on the way
    /// drops them), and in the sum of both; then both motors get zero: a clamp would turn it into a full
    /// voltage.
    #[inline(always)]
    pub fn allocate(&self, demand: PerMotor<R>, range: &VoltsRange<R>, hold: PerAxis<R>) -> Allocation<R> {
        let sound = finite(demand);
        let volts = match &self.method {
            Method::Clamp => range.clamp(demand),
            Method::Scale => scaling::scaled(demand, self.demand(hold), range),
            Method::Weighted(weighted) => weighted.solve(demand, range),
        };
        let volts = volts.map(
            #[inline(always)]
            |v| R::select(sound, v, R::zero()),
        );
        Allocation { volts, demand }
    }

    /// \[N m\] What of the torque asked for the volts of `allocation` do not give; zero on a fault, where
    /// nothing sensible was asked.
    #[inline(always)]
    pub fn unallocated_torque(&self, allocation: &Allocation<R>) -> PerAxis<R> {
        let missing = self.effectiveness.torque(allocation.demand.minus(allocation.volts));
        missing.map(|t| R::select(allocation.fault(), R::zero(), t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::presets;
    use proptest::prelude::*;

    const METHODS: [AllocationSettings<f64>; 3] = [
        AllocationSettings::Clamp,
        AllocationSettings::Scale,
        AllocationSettings::Weighted { pitch_weight: 1.3 },
    ];

    fn allocator(rig: &presets::Rig, method: &AllocationSettings<f64>) -> Allocator<f64> {
        let k = rig.plant.effectiveness_at(rig.nominal_volts);
        Allocator::new(k, rig.volts_limit).limiting(method, rig.plant.inertia)
    }

    proptest! {
        #[test]
        fn demand_is_eqs_28_and_29(pitch in -0.5..0.5, yaw in -0.5..0.5) {
            for (_, rig) in presets::ALL {
                let k = rig.plant.effectiveness_at(rig.nominal_volts);
                let (kpp, kpy, kyp, kyy) = (k.main_on_pitch, k.tail_on_pitch, k.main_on_yaw, k.tail_on_yaw);
                let main = (pitch - kpy * yaw / kyy) / (kpp - kyp * kpy / kyy);
                let tail = (yaw - kyp * pitch / kpp) / (kyy - kpy * kyp / kpp);
                let v = allocator(&rig, &METHODS[0]).demand(PerAxis::new(pitch, yaw));
                prop_assert!((v.main - main).abs() <= 1e-10 * (1.0 + main.abs()));
                prop_assert!((v.tail - tail).abs() <= 1e-10 * (1.0 + tail.abs()));
            }
        }

        #[test]
        fn what_is_given_and_what_is_not_make_what_was_asked(pitch in -2.0..2.0, yaw in -2.0..2.0) {
            for ((_, rig), method) in presets::ALL.into_iter().flat_map(|r| METHODS.map(|m| (r, m))) {
                let k = rig.plant.effectiveness_at(rig.nominal_volts);
                let a = allocator(&rig, &method);
                let asked = PerAxis::new(pitch, yaw);
                let got = a.allocate(a.demand(asked), &VoltsRange::within(rig.volts_limit), PerAxis::zero());
                let sum = k.torque(got.volts).plus(a.unallocated_torque(&got));
                prop_assert!((sum.pitch - pitch).abs() < 1e-12 && (sum.yaw - yaw).abs() < 1e-12);
                prop_assert!(got.volts.main.abs() <= rig.volts_limit.main);
                prop_assert!(got.volts.tail.abs() <= rig.volts_limit.tail);
                let over = got.saturated(rig.volts_limit);
                prop_assert_eq!(over.main || over.tail, got.clipped());
                prop_assert_eq!(got.clipped(), a.unallocated_torque(&got) != PerAxis::zero());
            }
        }
    }

    #[test]
    fn a_demand_that_is_not_finite_gives_zero_and_a_fault_never_a_bound() {
        let range = VoltsRange::within(presets::PAPER.volts_limit);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let demands = [PerMotor::new(bad, 1.0), PerMotor::new(1.0, bad)];
            for (demand, method) in demands.into_iter().flat_map(|d| METHODS.map(|m| (d, m))) {
                let got = allocator(&presets::PAPER, &method).allocate(demand, &range, PerAxis::zero());
                assert!(got.fault());
                assert_eq!(got.volts, PerMotor::zero());
                let allocator = allocator(&presets::PAPER, &method);
                assert_eq!(allocator.unallocated_torque(&got), PerAxis::zero());
            }
        }
    }
}
