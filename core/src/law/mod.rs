//! Step 5 of the tick: from what is and what should be to the torque on each axis.

mod backstepping;
mod integral_backstepping;
mod integrator;
mod pid;
mod settings;
mod state_feedback;
mod super_twisting;
#[cfg(test)]
mod tests;

pub use backstepping::{Backstepping, Errors};
pub use integral_backstepping::{IntegralBackstepping, IntegralGains};
pub use pid::{Pid, PidGains};
pub use settings::LawSettings;
pub use state_feedback::{MotorGains, StateFeedback, StateFeedbackGains};
pub use super_twisting::{SuperTwisting, SuperTwistingGains};

use crate::allocation::Allocation;
use crate::axes::PerAxis;
use crate::estimator::{Belief, Estimate};
use crate::plant::{Dynamics, Effectiveness, RigidBody, State};
use crate::real::Real;
use crate::reference::Reference;

/// What a law goes by in one tick.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a, R> {
    /// What the law believes of the helicopter; the real one may differ.
    pub model: &'a RigidBody<R>,
    /// The model at the estimated state.
    pub dynamics: Dynamics<R>,
    /// What is.
    pub estimate: Estimate<R>,
    /// What should be.
    pub reference: Reference<R>,
}

impl<'a, R: Real> Situation<'a, R> {
    /// With what was believed by this model.
    #[inline(always)]
    pub fn new(model: &'a RigidBody<R>, belief: Belief<R>, reference: Reference<R>) -> Self {
        Self { model, dynamics: belief.dynamics, estimate: belief.estimate, reference }
    }

    /// \[rad\] Reference minus estimate.
    #[inline(always)]
    pub fn angle_error(&self) -> PerAxis<R> {
        self.reference.angle.minus(self.estimate.state.angle)
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
pub trait ControlLaw<R: Real> {
    /// The torque \[N m\] that the law asks for, whether or not the motors can give it.
    fn torque(&mut self, now: &Situation<'_, R>) -> PerAxis<R>;

    /// Forgets the past, before a new start.
    #[inline(always)]
    fn restart(&mut self) {}

    /// Ends the tick: what the motors were made to do about the torque. A law that integrates does it here.
    #[inline(always)]
    fn settle(&mut self, _now: &Situation<'_, R>, _allocation: &Allocation<R>) {}
}

/// Any law, at work. (The tag in a place of its own saves the tick from decoding it.)
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(u8)]
pub enum Law<R> {
    /// See [`Backstepping`].
    Backstepping(Backstepping<R>),
    /// See [`IntegralBackstepping`].
    IntegralBackstepping(IntegralBackstepping<R>),
    /// See [`Pid`].
    Pid(Pid<R>),
    /// See [`StateFeedback`].
    StateFeedback(StateFeedback<R>),
    /// See [`SuperTwisting`].
    SuperTwisting(SuperTwisting<R>),
}

impl<R: Real> Law<R> {
    /// Ready to start; `sample_time` \[s\]. `effectiveness` \[N m/V\] serves laws that think in volts.
    pub fn new(settings: &LawSettings<R>, effectiveness: Effectiveness<R>, sample_time: R) -> Self {
        match *settings {
            LawSettings::Backstepping(gains) => Self::Backstepping(Backstepping::new(gains)),
            LawSettings::IntegralBackstepping(gains) => {
                Self::IntegralBackstepping(IntegralBackstepping::new(gains, sample_time))
            }
            LawSettings::Pid(gains) => Self::Pid(Pid::new(gains, sample_time)),
            LawSettings::StateFeedback(gains) => {
                Self::StateFeedback(StateFeedback::new(gains, effectiveness, sample_time))
            }
            LawSettings::SuperTwisting(gains) => Self::SuperTwisting(SuperTwisting::new(gains, sample_time)),
        }
    }
}

impl<R: Real> ControlLaw<R> for Law<R> {
    #[inline(always)]
    fn torque(&mut self, now: &Situation<'_, R>) -> PerAxis<R> {
        match self {
            Self::Backstepping(law) => law.torque(now),
            Self::IntegralBackstepping(law) => law.torque(now),
            Self::Pid(law) => law.torque(now),
            Self::StateFeedback(law) => law.torque(now),
            Self::SuperTwisting(law) => law.torque(now),
        }
    }

    #[inline(always)]
    fn restart(&mut self) {
        match self {
            Self::Backstepping(law) => law.restart(),
            Self::IntegralBackstepping(law) => law.restart(),
            Self::Pid(law) => law.restart(),
            Self::StateFeedback(law) => law.restart(),
            Self::SuperTwisting(law) => law.restart(),
        }
    }

    #[inline(always)]
    fn settle(&mut self, now: &Situation<'_, R>, allocation: &Allocation<R>) {
        match self {
            Self::Backstepping(law) => law.settle(now, allocation),
            Self::IntegralBackstepping(law) => law.settle(now, allocation),
            Self::Pid(law) => law.settle(now, allocation),
            Self::StateFeedback(law) => law.settle(now, allocation),
            Self::SuperTwisting(law) => law.settle(now, allocation),
        }
    }
}
