//! Steps 2, 4, 5 and 6 of the tick over any [`Real`]: what runs on the board, in the simulator and in the
//! lanes of the tuner. Nothing in it branches on a number, so every lane does the same.

pub(crate) mod settings;
mod shaper;
pub use settings::Settings;

use crate::allocation::{Allocation, Allocator, CurrentLimit, VoltsRange};
use crate::axes::{PerAxis, PerMotor};
use crate::controller::ControllerSettings;
use crate::estimator::{Belief, Estimate, Estimator};
use crate::law::{ControlLaw, Law, Situation};
use crate::lead::Lead;
use crate::plant::{RigidBody, State};
use crate::real::Real;
use crate::reference::Reference;
use crate::rotor_model::RotorModel;
use shaper::Shaper;

/// A controller at work.
///
/// In this order: what every tick looks at stands before the law, which may have matrices behind what the
/// others have. A floating-point load of a Cortex-M4 reaches 1,020 bytes from one register
/// ([`ControlLoop`](crate::control_loop::ControlLoop)).
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Pipeline<R> {
    shaper: Option<Shaper<R>>,
    cancellation: Option<PerAxis<R>>,
    lead: Option<Lead<R>>,
    current_limit: Option<CurrentLimit<R>>,
    estimator: Estimator<R>,
    allocator: Allocator<R>,
    /// Where anything needs to know which volts are in effect.
    rotors: Option<RotorModel<R>>,
    model: RigidBody<R>,
    law: Law<R>,
}

/// What one tick came to.
#[derive(Debug, Clone, Copy)]
pub struct Decision<R: Real> {
    /// What was believed.
    pub estimate: Estimate<R>,
    /// \[rad\] Where the law wanted to be: the setpoint, filtered where there is a filter.
    pub reference: PerAxis<R>,
    /// What the motors are to do about it.
    pub allocation: Allocation<R>,
}

impl<R: Real> Decision<R> {
    /// Motors off.
    pub fn idle(estimate: Estimate<R>, reference: PerAxis<R>) -> Self {
        Self { estimate, reference, allocation: Allocation::none() }
    }
}

impl<R: Real> Pipeline<R> {
    /// Ready to start at `angle` \[rad\], at rest.
    pub fn new(settings: &Settings<R>, angle: PerAxis<R>) -> Self {
        let Settings { sample_time, effectiveness, controller, .. } = *settings;
        let model = RigidBody::new(&settings.model);
        let inertia = model.at(&State::default()).inertia;
        let needs_rotors = controller.estimator.uses_model()
            || controller.lead.is_some()
            || settings.current_limit.is_some();
        Self {
            model,
            rotors: needs_rotors.then(|| RotorModel::new(&settings.model, sample_time)),
            estimator: Estimator::new(
                &controller.estimator,
                settings.model.coulomb_friction,
                angle,
                sample_time,
            ),
            shaper: controller.filter.map(|filter| Shaper::new(settings, &filter, angle)),
            law: Law::new(&controller.law, effectiveness, sample_time),
            cancellation: controller.cancellation,
            lead: controller.lead,
            current_limit: settings.current_limit.map(|limit| CurrentLimit::new(limit, sample_time)),
            allocator: Allocator::new(effectiveness, settings.volts_limit)
                .limiting(&controller.allocation, inertia),
        }
    }

    /// One tick: the angles measured now \[rad\], the volts that act from now to the next tick, and the
    /// setpoint.
    #[inline(always)]
    pub fn tick(
        &mut self,
        measured: PerAxis<R>,
        applied: PerMotor<R>,
        setpoint: &Reference<R>,
    ) -> Decision<R> {
        let belief = self.believe(measured, applied);
        self.decide(belief, setpoint)
    }

    /// Starts afresh at `angle` \[rad\], at rest: as [`Pipeline::new`] from the same settings, but that
    /// rotors which turn still do, and motors which are warm still are.
    pub fn restart(&mut self, angle: PerAxis<R>) {
        self.estimator.restart(angle);
        if let Some(shaper) = &mut self.shaper {
            shaper.restart(angle);
        }
        self.law.restart();
    }

    /// The rotors stand still and the motors are cold, whatever was before.
    pub fn forget_motion(&mut self) {
        if let Some(rotors) = &mut self.rotors {
            rotors.stop();
        }
        if let Some(limit) = &mut self.current_limit {
            limit.cool();
        }
    }

    /// The motors have that share \[-\] of the heat that their continuous current gives them
    /// ([`CurrentLimit::warm`]), where what they can take is known.
    pub fn warm(&mut self, share: R) {
        if let Some(limit) = &mut self.current_limit {
            limit.warm(share);
        }
    }

    /// Takes over what `from`, on the same rig, is in: where the rotors and the motors' heat are, how far the
    /// reference is on its way, and the whole of each part whose settings (`own` here, `others` there) are
    /// the same.
    pub fn inherit(&mut self, from: &Self, own: &ControllerSettings<R>, others: &ControllerSettings<R>)
    where
        R: PartialEq,
    {
        if let (Some(to), Some(from)) = (&mut self.rotors, &from.rotors) {
            *to = *from;
        }
        if let (Some(to), Some(from)) = (&mut self.current_limit, &from.current_limit) {
            *to = *from;
        }
        if own.estimator == others.estimator {
            self.estimator = from.estimator;
        }
        if let (Some(shaper), Some(from)) = (&mut self.shaper, &from.shaper) {
            shaper.continue_from(from);
        }
        if own.law == others.law {
            self.law = from.law;
        }
    }

    /// The first half of a tick: what the angles measured now \[rad\] say, with `applied` \[V\] from now to
    /// the next tick.
    #[inline(always)]
    pub fn believe(&mut self, measured: PerAxis<R>, applied: PerMotor<R>) -> Belief<R> {
        let torque = match &mut self.rotors {
            Some(rotors) => rotors.advance(applied),
            None => PerAxis::zero(),
        };
        if let (Some(limit), Some(rotors)) = (&mut self.current_limit, &self.rotors) {
            limit.observe(applied, rotors.volts());
        }
        self.estimator.update(measured, &self.model, torque)
    }

    /// The whole tick in a world where the state is known (ideal fidelity).
    #[inline(always)]
    pub fn act(&mut self, estimate: Estimate<R>, setpoint: &Reference<R>) -> Decision<R> {
        self.decide(Belief::new(&self.model, estimate), setpoint)
    }

    /// The second half of a tick: what to do about it.
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[cfg_attr(debug_assertions, inline(never))]
    pub fn decide(&mut self, belief: Belief<R>, setpoint: &Reference<R>) -> Decision<R> {
        let shaped;
        let reference = *match &mut self.shaper {
            None => setpoint,
            Some(shaper) => {
                shaped = shaper.step(setpoint, self.current_limit.as_ref(), &belief.estimate.state);
                &shaped
            }
        };
        let now = Situation::new(&self.model, belief, reference);
        let torque = self.law.torque(&now);
        let limit = self.allocator.limit();
        let (demand, range) = match &self.rotors {
            None => (self.allocator.demand(torque), VoltsRange::within(limit)),
            // What knows of the rotors, or of a disturbance, which takes an estimator that does.
            Some(rotors) => {
                let torque = match self.cancellation {
                    Some(share) => {
                        let found = share.zip(now.estimate.disturbance, |a, d| a * d);
                        torque.minus(now.dynamics.inertia.zip(found, |i, d| i * d))
                    }
                    None => torque,
                };
                let demand = self.allocator.demand(torque);
                let in_effect = rotors.volts();
                let demand = match &self.lead {
                    Some(lead) => lead.apply(demand, in_effect),
                    None => demand,
                };
                let range = match &self.current_limit {
                    Some(current) => current.range(in_effect, limit),
                    None => VoltsRange::within(limit),
                };
                (demand, range)
            }
        };
        let allocation = self.allocator.allocate(demand, &range, now.dynamics.opposing);
        self.law.settle(&now, &allocation);
        if let Some(shaper) = &mut self.shaper {
            shaper.settle(&allocation);
        }
        Decision { estimate: now.estimate, reference: now.reference.angle, allocation }
    }

    /// \[N m\] What of the torque asked for `allocation` does not give.
    pub fn unallocated_torque(&self, allocation: &Allocation<R>) -> PerAxis<R> {
        self.allocator.unallocated_torque(allocation)
    }

    /// The law, at work.
    pub fn law(&self) -> &Law<R> {
        &self.law
    }

    /// \[V\] The limits in force.
    #[inline(always)]
    pub fn volts_limit(&self) -> PerMotor<R> {
        self.allocator.limit()
    }
}

/// The two halves of a tick, one copy of the instructions each, for callers who need them rarely.
impl Pipeline<f32> {
    /// See [`Pipeline::believe`].
    #[inline(never)]
    pub fn believe_once(&mut self, measured: PerAxis<f32>, applied: PerMotor<f32>) -> Belief<f32> {
        self.believe(measured, applied)
    }

    /// See [`Pipeline::decide`].
    #[inline(never)]
    pub fn decide_once(&mut self, belief: Belief<f32>, setpoint: &Reference<f32>) -> Decision<f32> {
        self.decide(belief, setpoint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::{EstimatorSettings, luenberger};
    use crate::plant::{RealPlant, State, presets};
    use crate::{defaults, gains};
    use proptest::prelude::*;

    #[test]
    fn a_restart_is_a_new_start_but_for_what_motors_do_not_forget() {
        for (name, rig) in presets::ALL {
            let controller = defaults::named(name).expect("a controller for every preset");
            let settings = Settings::new(&rig, controller, 1e-3).map(f32::from_f64);
            let start = PerAxis::new(0.1, -0.3);
            let mut pipeline = Pipeline::new(&settings, PerAxis::zero());
            for _ in 0..100 {
                let volts = PerMotor::new(5.0, -4.0);
                pipeline.tick(PerAxis::new(0.2, 0.4), volts, &Reference::at_rest(PerAxis::both(0.5)));
            }
            let (turning, warm) = (pipeline.rotors, pipeline.current_limit);
            pipeline.restart(start);
            let new = Pipeline::new(&settings, start);
            assert_eq!(pipeline, Pipeline { rotors: turning, current_limit: warm, ..new });
            assert!(turning != new.rotors && (warm.is_none() || warm != new.current_limit));
        }
    }

    /// No offset under a constant disturbance, whichever estimator. (Mean of the last second; exact angles.)
    #[test]
    fn an_integral_leaves_no_offset_with_any_observer() {
        let bandwidth = PerAxis::both(20.0);
        let gains = PerAxis::both(luenberger(20.0, 1e-3));
        for estimator in [
            EstimatorSettings::FilteredDerivative { bandwidth: PerAxis::both(100.0) },
            EstimatorSettings::Luenberger { bandwidth },
            EstimatorSettings::ExtendedState { bandwidth },
            EstimatorSettings::Observer { gains },
        ] {
            let mut rig = presets::AERO_LAB;
            rig.plant.coulomb_friction = PerAxis::zero();
            let controller = ControllerSettings { estimator, ..defaults::AERO_LAB };
            let settings = Settings::new(&rig, controller, 1e-3);
            let mut pipeline = Pipeline::new(&settings, PerAxis::zero());
            let mut plant = RealPlant::<f64>::new(&rig.plant, State::default(), 1e-3);
            let (mut volts, mut sum) = (PerMotor::zero(), PerAxis::zero());
            for tick in 0..80_000 {
                let angle = plant.state().angle;
                let decision = pipeline.tick(angle, volts, &Reference::default());
                plant.advance(volts, PerMotor::new(3.0, -2.0));
                volts = decision.allocation.volts;
                if tick >= 79_000 {
                    sum = sum.plus(angle);
                }
            }
            let mean = sum.scaled(1e-3).map(f64::abs);
            assert!(mean.pitch < 1e-6 && mean.yaw < 1e-6, "{estimator:?}: {mean:?} rad");
        }
    }

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
                prop_assert!(got.fault());
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
                prop_assert!(!got.fault());
                prop_assert!(got.volts.main.abs() <= settings.volts_limit.main);
                prop_assert!(got.volts.tail.abs() <= settings.volts_limit.tail);
            }
        }
    }
}
