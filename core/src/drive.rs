//! Step 7 of the tick: from volts to the duty of a PWM amplifier, and the volts that this duty really gives.

use crate::axes::PerMotor;
use crate::real::Real;

/// \[Hz\] The PWM of every board: above hearing, and 20 whole periods in a tick.
pub const PWM_HZ: u32 = 20_000;

/// Compare steps from zero to full voltage, either way, of a board whose timer counts `timer_hz` times a
/// second. Centre-aligned, a period is up and down; in locked antiphase, zero volts are half of it.
pub const fn full_steps(timer_hz: u32) -> u32 {
    timer_hz / PWM_HZ / 2 / 2
}

/// A PWM amplifier for each motor: `full_steps` compare steps from zero to the supply, either way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive<R> {
    full_steps: R,
    most_steps: R,
}

/// What a motor's amplifier is told: a whole number of PWM steps, negative for reverse.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Duty<R>(R);

impl<R: Real> Drive<R> {
    /// With this many compare steps from zero to full voltage, at most 2^16.
    pub fn new(full_steps: u32) -> Self {
        Self::limited(full_steps, full_steps)
    }

    /// The same, but never more than `most_steps` either way: for bridges that cannot hold a static level.
    pub fn limited(full_steps: u32, most_steps: u32) -> Self {
        let [full_steps, most_steps] = [full_steps, most_steps].map(|steps| R::from_i32(steps.cast_signed()));
        Self { full_steps, most_steps }
    }

    /// The duty that comes nearest to `volts` from a supply of `supply` \[V\]; at most the limit either way.
    /// Zero for both motors if anything is not finite or the supply is not above zero: this is the only way
    /// to a duty.
    #[inline(always)]
    pub fn duty(&self, volts: PerMotor<R>, supply: R) -> PerMotor<Duty<R>> {
        let steps_per_volt = self.full_steps / supply;
        let steps = volts.map(
            #[inline(always)]
            |v| v * steps_per_volt,
        );
        // One NaN or infinity makes the sum one.
        let sound = (steps.main + steps.tail).is_finite() & R::zero().lt(supply);
        steps.map(
            #[inline(always)]
            |steps| {
                let steps = steps.clamp(-self.most_steps, self.most_steps).round_small();
                Duty(R::select(sound, steps, R::zero()))
            },
        )
    }

    /// \[V\] What a duty gives from a supply of `supply` \[V\].
    #[inline(always)]
    pub fn volts(&self, duty: PerMotor<Duty<R>>, supply: R) -> PerMotor<R> {
        let volts_per_step = supply / self.full_steps;
        duty.map(|d| d.0 * volts_per_step)
    }
}

impl Duty<f32> {
    /// In compare steps, negative for reverse.
    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "a whole number within ±full_steps, by construction")]
    pub fn steps(self) -> i32 {
        self.0 as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::F405;

    const PWM_STEPS: u32 = F405.pwm_steps();
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn within_half_a_step_and_never_beyond_the_supply(
            main in -60.0_f32..60.0, tail in -60.0_f32..60.0, supply in 10.0_f32..30.0,
        ) {
            let drive = Drive::<f32>::new(PWM_STEPS);
            let asked = PerMotor::new(main, tail);
            let duty = drive.duty(asked, supply);
            let given = drive.volts(duty, supply);
            for (asked, (duty, given)) in asked.to_array().into_iter().zip(
                duty.to_array().into_iter().zip(given.to_array())
            ) {
                prop_assert!(duty.steps().abs() <= 2100);
                let reachable = asked.clamp(-supply, supply);
                prop_assert!((given - reachable).abs() <= 0.5001 * supply / 2100.0);
            }
        }
    }

    #[test]
    fn a_limited_drive_never_reaches_the_full_supply_and_is_the_same_below() {
        let (full, limited) = (Drive::<f32>::new(PWM_STEPS), Drive::<f32>::limited(PWM_STEPS, 2037));
        for volts in [-40.0, -24.0, 24.0, 40.0] {
            assert_eq!(full.duty(PerMotor::both(volts), 24.0).main.steps().abs(), 2100);
            let duty = limited.duty(PerMotor::both(volts), 24.0);
            assert_eq!(duty.main.steps().abs(), 2037);
            assert_eq!(limited.volts(duty, 24.0).main.abs(), 2037.0 * (24.0 / 2100.0));
        }
        for volts in [-23.0, -0.1, 0.0, 11.0, 23.0] {
            let volts = PerMotor::both(volts);
            assert_eq!(limited.duty(volts, 24.0), full.duty(volts, 24.0));
        }
    }

    #[test]
    fn nothing_that_is_not_finite_reaches_a_duty() {
        let drive = Drive::<f32>::new(PWM_STEPS);
        let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        for b in bad {
            assert_eq!(drive.duty(PerMotor::new(b, 12.0), 24.0).main.steps(), 0);
            assert_eq!(drive.duty(PerMotor::both(12.0), b).main.steps(), 0);
        }
        for dead in [0.0, -24.0] {
            assert_eq!(drive.duty(PerMotor::both(12.0), dead).tail.steps(), 0);
        }
        assert_eq!(drive.duty(PerMotor::both(12.0), 24.0).main.steps(), 1050);
    }
}
