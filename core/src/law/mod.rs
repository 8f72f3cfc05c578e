//! Step 5 of the tick: from what is and what should be to the torque on each axis.

mod backstepping;
mod integral_backstepping;
mod integrator;
mod pid;
mod registry;
mod state_feedback;
mod state_space;
mod super_twisting;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod toy;

pub use backstepping::{Backstepping, Errors};
pub use integral_backstepping::{IntegralBackstepping, IntegralGains};
pub use pid::{Pid, PidGains};
pub use state_feedback::{MotorGains, StateFeedback, StateFeedbackGains};
pub use state_space::{MOST_INPUTS, MOST_STATES, Signal, StateSpace, StateSpaceGains};
pub use super_twisting::{SuperTwisting, SuperTwistingGains};

use crate::allocation::Allocation;
use crate::axes::PerAxis;
use crate::estimator::{Belief, Estimate};
use crate::gains::Gains;
use crate::plant::{Dynamics, Effectiveness, RigidBody, State};
use crate::real::Real;
use crate::reference::Reference;
use registry::laws;

/// What a law goes by in one tick.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a, R> {
    /// What the law believes of the helicopter; the real one may differ.
    pub model: &'a RigidBody<R>,
    /// The model at the estimated state.
    pub dynamics: Dynamics<R>,
    /// What is.
    pub estimate: Estimate<R>,
    /// \[rad\] What was measured.
    pub measured: PerAxis<R>,
    /// What should be.
    pub reference: Reference<R>,
}

impl<'a, R: Real> Situation<'a, R> {
    /// With what was believed by this model.
    #[inline(always)]
    pub fn new(model: &'a RigidBody<R>, belief: Belief<R>, reference: Reference<R>) -> Self {
        let Belief { estimate, dynamics, measured } = belief;
        Self { model, dynamics, estimate, measured, reference }
    }

    /// \[rad\] Reference minus estimate.
    #[inline(always)]
    pub fn angle_error(&self) -> PerAxis<R> {
        self.reference.angle.minus(self.estimate.state.angle)
    }

    /// \[rad\] Reference minus what was measured: what an integral sums. An observer that looks for no
    /// disturbance is off by d/ω² under a constant one d, and would lead an integral of its estimate to
    /// that offset.
    #[inline(always)]
    pub fn measured_error(&self) -> PerAxis<R> {
        self.reference.angle.minus(self.measured)
    }

    /// \[rad/s\] Reference minus estimate.
    #[inline(always)]
    pub fn rate_error(&self) -> PerAxis<R> {
        self.reference.rate.minus(self.estimate.state.rate)
    }

    /// \[N m\] What the model needs to be at the reference and to follow it.
    #[inline(always)]
    pub fn feed_forward(&self) -> PerAxis<R> {
        let there = State { angle: self.reference.angle, rate: self.reference.rate };
        self.model.at(&there).torque(self.reference.accel)
    }
}

/// A control law: everything between the estimate and the torque.
pub trait ControlLaw<R: Real>: Sized {
    /// What it is made from.
    type Gains;

    /// Ready to start; `sample_time` \[s\]. `effectiveness` \[N m/V\] serves laws that think in volts.
    fn start(gains: Self::Gains, effectiveness: Effectiveness<R>, sample_time: R) -> Self;

    /// The torque \[N m\] that the law asks for, whether or not the motors can give it.
    fn torque(&mut self, now: &Situation<'_, R>) -> PerAxis<R>;

    /// Has it, with these gains, an integral of the error?
    fn integrates(gains: &Self::Gains) -> R::Mask;

    /// Forgets the past, before a new start.
    #[inline(always)]
    fn restart(&mut self) {}

    /// Ends the tick: what the motors were made to do about the torque. A law that integrates does it here.
    #[inline(always)]
    fn settle(&mut self, _now: &Situation<'_, R>, _allocation: &Allocation<R>) {}
}

laws! {
    /// The paper's, eqs (26)-(27).
    "backstepping" Backstepping(Gains<R>);
    /// The paper's with an integral.
    "integral-backstepping" IntegralBackstepping(PerAxis<IntegralGains<R>>);
    /// PID for each axis.
    "pid" Pid(PerAxis<PidGains<R>>);
    /// PD, LQR, LQI in volts.
    "state-feedback" StateFeedback(StateFeedbackGains<R>);
    /// Second-order sliding mode.
    "super-twisting" SuperTwisting(PerAxis<SuperTwistingGains<R>>);
    /// Matrices that were designed elsewhere.
    "state-space" StateSpace(StateSpaceGains<R>);
}
