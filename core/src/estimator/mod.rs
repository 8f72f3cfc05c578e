//! Step 2 of the tick: from measured angles to angles, rates and what disturbs them.

mod extended_state;
mod filtered_derivative;
mod luenberger;
mod observer;
#[cfg(test)]
mod tests;

pub use extended_state::extended_state;
pub use filtered_derivative::FilteredDerivative;
pub use luenberger::luenberger;
pub use observer::{BELIEVED_FRICTION_WIDTH, Observer, ObserverGains};

use crate::axes::PerAxis;
use crate::plant::{Dynamics, RigidBody, State};
use crate::real::Real;

/// What is believed of the helicopter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate<R> {
    /// \[rad\], \[rad/s\] Angles and rates.
    pub state: State<R>,
    /// \[rad/s²\] Acceleration that the model does not explain; zero from an estimator that does not look for
    /// it.
    pub disturbance: PerAxis<R>,
}

impl<R: Real> Estimate<R> {
    /// The truth, as the paper's world gives it to the law.
    #[inline(always)]
    pub fn exact(state: State<R>) -> Self {
        Self { state, disturbance: PerAxis::zero() }
    }
}

/// An estimate, and what the model says there: estimators and laws both need it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief<R> {
    /// What is believed.
    pub estimate: Estimate<R>,
    /// The model at that state.
    pub dynamics: Dynamics<R>,
    /// \[rad\] What was measured.
    pub measured: PerAxis<R>,
}

impl<R: Real> Belief<R> {
    /// With `model` taken at an estimate whose angles are those measured.
    #[inline(always)]
    pub fn new(model: &RigidBody<R>, estimate: Estimate<R>) -> Self {
        Self { estimate, dynamics: model.at(&estimate.state), measured: estimate.state.angle }
    }
}

choice! {
    /// Which estimator, and its settings.
    pub enum EstimatorSettings<R> {
        /// Measured angle; its difference through a first-order low pass.
        "filtered-derivative" FilteredDerivative { bandwidth: PerAxis<R> } by LowPass;
        /// Model and rotors, fed by the volts really applied; see [`luenberger()`].
        "luenberger" Luenberger { bandwidth: PerAxis<R> } by Poles;
        /// The same, with a disturbance that it looks for; see [`extended_state()`].
        "extended-state" ExtendedState { bandwidth: PerAxis<R> } by Poles;
        /// The same with gains worked out elsewhere, such as a stationary Kalman filter's.
        "observer" Observer { gains: PerAxis<ObserverGains<R>> } by ObserverGains<R>;
    }
}

/// The table of [`EstimatorSettings::FilteredDerivative`].
struct LowPass;

table! {
    [] [LowPass] at ("estimator.") {
        /// Bandwidth of the low pass.
        bandwidth: (PerAxis<R>) "rad/s", (above 0), typical 10.0 to 500.0, default 100.0;
    }
}

/// The table of the observers that are given by their poles.
struct Poles;

table! {
    [] [Poles] at ("estimator.") {
        /// Where the poles of the estimate's error are.
        bandwidth: (PerAxis<R>) "rad/s", (above 0), typical 5.0 to 500.0, default 50.0;
    }
}

impl<R: Real> EstimatorSettings<R> {
    /// The bandwidth of 100 rad/s that laboratories use.
    pub const fn laboratory(bandwidth: R) -> Self {
        Self::FilteredDerivative { bandwidth: PerAxis::both(bandwidth) }
    }

    /// Does it need to know which torque acts?
    pub const fn uses_model(&self) -> bool {
        !matches!(self, Self::FilteredDerivative { .. })
    }
}

/// Any estimator, at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Estimator<R> {
    /// See [`FilteredDerivative`].
    FilteredDerivative(FilteredDerivative<R>),
    /// See [`Observer`].
    Observer(Observer<R>),
}

impl<R: Real> Estimator<R> {
    /// Ready to start at `angle` \[rad\], at rest, called every `sample_time` \[s\], for a rig with this
    /// Coulomb `friction` \[N m\].
    pub fn new(
        settings: &EstimatorSettings<R>,
        friction: PerAxis<R>,
        angle: PerAxis<R>,
        sample_time: R,
    ) -> Self {
        let observer = |gains| Self::Observer(Observer::new(gains, friction, angle, sample_time));
        match *settings {
            EstimatorSettings::FilteredDerivative { bandwidth } => {
                Self::FilteredDerivative(FilteredDerivative::new(bandwidth, angle, sample_time))
            }
            EstimatorSettings::Luenberger { bandwidth } => {
                observer(bandwidth.map(|w| luenberger(w, sample_time)))
            }
            EstimatorSettings::ExtendedState { bandwidth } => {
                observer(bandwidth.map(|w| extended_state(w, sample_time)))
            }
            EstimatorSettings::Observer { gains } => observer(gains),
        }
    }

    /// What the angles measured now \[rad\] say. `torque` \[N m\] is what the motors give from now to the
    /// next tick.
    #[inline(always)]
    pub fn update(&mut self, measured: PerAxis<R>, model: &RigidBody<R>, torque: PerAxis<R>) -> Belief<R> {
        match self {
            Self::FilteredDerivative(e) => Belief::new(model, e.update(measured)),
            Self::Observer(o) => {
                let belief = Belief { measured, ..Belief::new(model, o.correct(measured)) };
                let torque = o.moving(torque, belief.estimate.state.rate);
                o.predict(&belief.estimate, belief.dynamics.accel(torque));
                belief
            }
        }
    }

    /// Starts afresh at `angle` \[rad\], at rest.
    pub fn restart(&mut self, angle: PerAxis<R>) {
        match self {
            Self::FilteredDerivative(e) => e.restart(angle),
            Self::Observer(o) => o.restart(angle),
        }
    }
}
