//! Steps 2, 4, 5 and 6 of the tick over any [`Real`]: what runs on the board, in the simulator and in the lanes of the
//! tuner. Nothing in it branches on a number, so every lane does the same.

use crate::allocation::{Allocation, Allocator};
use crate::axes::{PerAxis, PerMotor};
use crate::estimator::{Estimate, Estimator, EstimatorSettings};
use crate::gains::Gains;
use crate::law::{Backstepping, ControlLaw};
use crate::plant::presets::Rig;
use crate::plant::{Effectiveness, PlantParameters, RigidBody};
use crate::real::Real;
use crate::reference::Reference;
use crate::validate::{Invalid, positive};
use serde::{Deserialize, Serialize};

/// What a controller is made from: the user's numbers, before anything is derived from them.
///
/// Everything that the pipeline derives from them is basic arithmetic in `R`, so a board that is given the same numbers
/// derives the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settings<R> {
    /// \[s\] From tick to tick.
    pub sample_time: R,
    /// What the law believes of the helicopter, which may differ.
    pub model: PlantParameters<R>,
    /// \[N m/V\] The thrust gains that the law believes in.
    pub effectiveness: Effectiveness<R>,
    /// \[V\] Limit of each motor, either way.
    pub volts_limit: PerMotor<R>,
    /// Gains of the law.
    pub gains: Gains<R>,
    /// Where rates come from when only angles are measured.
    pub estimator: EstimatorSettings<R>,
}

impl Settings<f64> {
    /// The paper's law with these gains on a rig whose constants it knows exactly, `sample_time` in s.
    pub fn paper(rig: &Rig, gains: Gains<f64>, sample_time: f64) -> Self {
        Self {
            sample_time,
            model: rig.plant,
            effectiveness: rig.plant.effectiveness_at(rig.nominal_volts),
            volts_limit: rig.volts_limit,
            gains,
            estimator: EstimatorSettings::laboratory(100.0),
        }
    }

    /// Every number finite and usable.
    pub fn validate(&self) -> Result<(), Invalid> {
        positive("sample_time", self.sample_time)?;
        self.model.validate()?;
        self.effectiveness.validate_inverse()?;
        positive("volts_limit.main", self.volts_limit.main)?;
        positive("volts_limit.tail", self.volts_limit.tail)?;
        self.gains.validate()?;
        self.estimator.validate()
    }
}

impl<R: Copy + Real> Settings<R> {
    /// Each number through `f`, in a fixed order.
    pub fn map<U: Copy>(self, mut f: impl FnMut(R) -> U) -> Settings<U> {
        Settings {
            sample_time: f(self.sample_time),
            model: self.model.map(&mut f),
            effectiveness: self.effectiveness.map(&mut f),
            volts_limit: self.volts_limit.map(&mut f),
            gains: self.gains.map_gains(&mut f),
            estimator: self.estimator.map(&mut f),
        }
    }
}

/// A controller at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pipeline<R> {
    model: RigidBody<R>,
    estimator: Estimator<R>,
    law: Backstepping<R>,
    allocator: Allocator<R>,
}

/// What one tick came to.
#[derive(Debug, Clone, Copy)]
pub struct Command<R: Real> {
    /// What was believed.
    pub estimate: Estimate<R>,
    /// What was wanted.
    pub reference: Reference<R>,
    /// \[N m\] What the law asked for.
    pub torque: PerAxis<R>,
    /// What the motors are to do about it.
    pub allocation: Allocation<R>,
}

impl<R: Real> Command<R> {
    /// Motors off.
    pub fn idle(estimate: Estimate<R>, reference: Reference<R>) -> Self {
        Self { estimate, reference, torque: PerAxis::zero(), allocation: Allocation::none() }
    }
}

impl<R: Real> Pipeline<R> {
    /// Ready to start at `angle` [rad], at rest.
    pub fn new(settings: &Settings<R>, angle: PerAxis<R>) -> Self {
        Self {
            model: RigidBody::new(&settings.model),
            estimator: Estimator::new(&settings.estimator, angle, settings.sample_time),
            law: Backstepping::new(settings.gains),
            allocator: Allocator::new(settings.effectiveness, settings.volts_limit),
        }
    }

    /// One tick: the angles measured now [rad], the volts that act from now to the next tick, and the reference.
    #[inline(always)]
    pub fn tick(
        &mut self,
        measured: PerAxis<R>,
        applied: PerMotor<R>,
        reference: &Reference<R>,
    ) -> Command<R> {
        let estimate = self.estimate(measured, applied);
        self.act(estimate, reference)
    }

    /// The first half of [`Pipeline::tick`], for a loop that decides in between whether to act at all.
    #[inline(always)]
    pub fn estimate(&mut self, measured: PerAxis<R>, applied: PerMotor<R>) -> Estimate<R> {
        self.estimator.update(measured, applied)
    }

    /// One tick in a world where the state is known (ideal fidelity): [`Pipeline::tick`] without its estimator.
    #[inline(always)]
    pub fn act(&mut self, estimate: Estimate<R>, reference: &Reference<R>) -> Command<R> {
        let torque = self.law.torque(&self.model, &estimate, reference);
        let demand = self.allocator.demand(torque);
        Command { estimate, reference: *reference, torque, allocation: self.allocator.allocate(demand) }
    }

    /// \[V\] The limits in force.
    #[inline(always)]
    pub fn volts_limit(&self) -> PerMotor<R> {
        self.allocator.limit()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gains;
    use crate::plant::{State, presets};
    use proptest::prelude::*;

    proptest! {
        /// NaN or infinity anywhere in the input gives zero volts and a flag, never a bound.
        #[test]
        fn any_input_that_is_not_finite_is_a_fault(
            numbers in prop::array::uniform10(-2.0_f32..2.0),
            bad in prop::collection::vec(
                (0_usize..10, prop::sample::select(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY][..])), 1..5),
        ) {
            let mut x = numbers;
            for (index, value) in bad {
                x[index] = value;
            }
            let at = |i: usize| PerAxis::new(x[i], x[i + 1]);
            let reference = Reference { angle: at(0), rate: at(2), accel: at(4) };
            let estimate = Estimate::exact(State { angle: at(6), rate: at(8) });
            for (_, rig) in presets::ALL {
                let settings = Settings::paper(&rig, gains::PAPER, 1e-3).map(f32::from_f64);
                let mut pipeline = Pipeline::new(&settings, PerAxis::zero());
                let got = pipeline.act(estimate, &reference).allocation;
                prop_assert!(got.fault);
                prop_assert_eq!(got.volts, PerMotor::zero());
            }
        }

        /// Whatever is finite and of this world gives finite volts within the limits and no fault.
        #[test]
        fn sound_input_gives_volts_within_the_limits(numbers in prop::array::uniform10(-20.0_f32..20.0)) {
            let at = |i: usize| PerAxis::new(numbers[i], numbers[i + 1]);
            let reference = Reference { angle: at(0), rate: at(2), accel: at(4) };
            let estimate = Estimate::exact(State { angle: at(6), rate: at(8) });
            for (_, rig) in presets::ALL {
                let settings = Settings::paper(&rig, gains::PAPER, 1e-3).map(f32::from_f64);
                let got = Pipeline::new(&settings, PerAxis::zero()).act(estimate, &reference).allocation;
                prop_assert!(!got.fault);
                prop_assert!(got.volts.main.abs() <= settings.volts_limit.main);
                prop_assert!(got.volts.tail.abs() <= settings.volts_limit.tail);
            }
        }
    }
}
