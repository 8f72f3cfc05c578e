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
use crate::validate::{Invalid, both, positive};
use serde::{Deserialize, Serialize};

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
}

impl<R: Real> Belief<R> {
    /// With `model` taken at the estimate.
    #[inline(always)]
    pub fn new(model: &RigidBody<R>, estimate: Estimate<R>) -> Self {
        Self { estimate, dynamics: model.at(&estimate.state) }
    }
}

/// Which estimator, and its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum EstimatorSettings<R> {
    /// Measured angle; its difference through a first-order low pass.
    FilteredDerivative {
        /// \[rad/s\] Bandwidth of the low pass, above 0.
        bandwidth: PerAxis<R>,
    },
    /// Model and rotors, fed by the volts really applied; see [`luenberger()`].
    Luenberger {
        /// \[rad/s\] Where the error's poles are, above 0.
        bandwidth: PerAxis<R>,
    },
    /// The same, with a disturbance that it looks for; see [`extended_state()`].
    ExtendedState {
        /// \[rad/s\] Where the error's poles are, above 0.
        bandwidth: PerAxis<R>,
    },
    /// The same with gains worked out elsewhere, such as a stationary Kalman filter's.
    Observer {
        /// l₁, l₂, l₃ of each axis.
        gains: PerAxis<ObserverGains<R>>,
    },
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

    /// Each number through `f`.
    pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> EstimatorSettings<U> {
        match self {
            Self::FilteredDerivative { bandwidth } => {
                EstimatorSettings::FilteredDerivative { bandwidth: bandwidth.map(f) }
            }
            Self::Luenberger { bandwidth } => EstimatorSettings::Luenberger { bandwidth: bandwidth.map(f) },
            Self::ExtendedState { bandwidth } => {
                EstimatorSettings::ExtendedState { bandwidth: bandwidth.map(f) }
            }
            Self::Observer { gains } => EstimatorSettings::Observer { gains: gains.map(|g| g.map(&mut f)) },
        }
    }
}

impl<R: Real<Mask = bool>> EstimatorSettings<R> {
    /// Every number usable.
    ///
    /// # Errors
    /// Names the field.
    pub fn validate(&self) -> Result<(), Invalid<R>> {
        match *self {
            Self::FilteredDerivative { bandwidth }
            | Self::Luenberger { bandwidth }
            | Self::ExtendedState { bandwidth } => {
                both(["estimator.bandwidth.pitch", "estimator.bandwidth.yaw"], bandwidth, positive)
            }
            Self::Observer { gains } => {
                gains.pitch.validate([
                    "estimator.gains.pitch.angle",
                    "estimator.gains.pitch.rate",
                    "estimator.gains.pitch.disturbance",
                ])?;
                gains.yaw.validate([
                    "estimator.gains.yaw.angle",
                    "estimator.gains.yaw.rate",
                    "estimator.gains.yaw.disturbance",
                ])
            }
        }
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
                let belief = Belief::new(model, o.correct(measured));
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
