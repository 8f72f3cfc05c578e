//! Step 2 of the tick: from measured angles to angles, rates and what disturbs them.

mod filtered_derivative;

pub use filtered_derivative::{FilteredDerivative, bilinear_decay};

use crate::axes::{PerAxis, PerMotor};
use crate::plant::State;
use crate::real::Real;
use crate::validate::{Invalid, positive};
use serde::{Deserialize, Serialize};

/// What is believed of the helicopter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate<R> {
    /// \[rad\], \[rad/s\] Angles and rates.
    pub state: State<R>,
    /// \[rad/s²\] Acceleration that the model does not explain; zero from an estimator that does not look for it.
    pub disturbance: PerAxis<R>,
}

impl<R: Real> Estimate<R> {
    /// The truth, as the paper's world gives it to the law.
    #[inline(always)]
    pub fn exact(state: State<R>) -> Self {
        Self { state, disturbance: PerAxis::zero() }
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
}

impl<R: Real> EstimatorSettings<R> {
    /// The bandwidth of 100 rad/s that laboratories use.
    pub const fn laboratory(bandwidth: R) -> Self {
        Self::FilteredDerivative { bandwidth: PerAxis::both(bandwidth) }
    }

    /// Each number through `f`.
    pub fn map<U>(self, f: impl FnMut(R) -> U) -> EstimatorSettings<U> {
        match self {
            Self::FilteredDerivative { bandwidth } => {
                EstimatorSettings::FilteredDerivative { bandwidth: bandwidth.map(f) }
            }
        }
    }
}

impl EstimatorSettings<f64> {
    /// Every number finite and above zero.
    pub fn validate(&self) -> Result<(), Invalid> {
        let Self::FilteredDerivative { bandwidth } = self;
        positive("estimator.filtered-derivative.bandwidth.pitch", bandwidth.pitch)?;
        positive("estimator.filtered-derivative.bandwidth.yaw", bandwidth.yaw)
    }
}

/// Any estimator, at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Estimator<R> {
    /// See [`FilteredDerivative`].
    FilteredDerivative(FilteredDerivative<R>),
}

impl<R: Real> Estimator<R> {
    /// Ready to start at `angle` [rad], at rest, called every `sample_time` [s].
    pub fn new(settings: &EstimatorSettings<R>, angle: PerAxis<R>, sample_time: R) -> Self {
        match *settings {
            EstimatorSettings::FilteredDerivative { bandwidth } => {
                Self::FilteredDerivative(FilteredDerivative::new(bandwidth, angle, sample_time))
            }
        }
    }

    /// What the angles measured now [rad] say. `applied` [V] acts on the rotors from now to the next tick.
    #[inline(always)]
    pub fn update(&mut self, measured: PerAxis<R>, _applied: PerMotor<R>) -> Estimate<R> {
        match self {
            Self::FilteredDerivative(e) => e.update(measured),
        }
    }
}
