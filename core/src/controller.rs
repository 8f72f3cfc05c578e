//! Everything about a controller that is a choice and not a fact of the rig: what a gains file holds.

use crate::allocation::AllocationSettings;
use crate::axes::PerAxis;
use crate::command_filter::FilterSettings;
use crate::estimator::EstimatorSettings;
use crate::gains::Gains;
use crate::law::LawSettings;
use crate::lead::Lead;
use crate::real::Real;
use crate::validate::{Invalid, both, not_negative};
use serde::{Deserialize, Serialize};

/// Law, estimator and all that may stand around them. Each part works with each other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerSettings<R> {
    /// Which law, and its gains.
    pub law: LawSettings<R>,
    /// Where rates come from when only angles are measured.
    pub estimator: EstimatorSettings<R>,
    /// What is done with a setpoint before the law sees it.
    #[serde(default = "none")]
    pub filter: Option<FilterSettings<R>>,
    /// What is done with a demand that the motors cannot meet.
    pub allocation: AllocationSettings<R>,
    /// What is done against the rotors' lag.
    #[serde(default = "none")]
    pub lead: Option<Lead<R>>,
    /// \[-\] α: how much of the estimated disturbance is cancelled, 0 to 1, on each axis.
    #[serde(default = "none")]
    pub cancellation: Option<PerAxis<R>>,
}

fn none<T>() -> Option<T> {
    None
}

impl<R: Real> ControllerSettings<R> {
    /// The paper's law and nothing else; where only angles are measured, a filtered derivative of 100 rad/s.
    #[inline(always)]
    pub fn paper(gains: Gains<R>) -> Self {
        Self {
            law: LawSettings::Backstepping(gains),
            estimator: EstimatorSettings::laboratory(R::from_f64(100.0)),
            filter: None,
            allocation: AllocationSettings::Clamp,
            lead: None,
            cancellation: None,
        }
    }

    /// Each number through `f`, in a fixed order.
    pub fn map<U: Copy>(self, mut f: impl FnMut(R) -> U) -> ControllerSettings<U> {
        ControllerSettings {
            law: self.law.map(&mut f),
            estimator: self.estimator.map(&mut f),
            filter: self.filter.map(|x| x.map(&mut f)),
            allocation: self.allocation.map(&mut f),
            lead: self.lead.map(|x| x.map(&mut f)),
            cancellation: self.cancellation.map(|x| x.map(&mut f)),
        }
    }
}

impl<R: Real<Mask = bool>> ControllerSettings<R> {
    /// Every number usable.
    ///
    /// # Errors
    /// Names the field.
    pub fn validate(&self) -> Result<(), Invalid<R>> {
        self.law.validate()?;
        self.estimator.validate()?;
        self.filter.map_or(Ok(()), |filter| filter.validate())?;
        self.allocation.validate()?;
        self.lead.map_or(Ok(()), |lead| lead.validate())?;
        self.cancellation
            .map_or(Ok(()), |share| both(["cancellation.pitch", "cancellation.yaw"], share, not_negative))
    }
}
