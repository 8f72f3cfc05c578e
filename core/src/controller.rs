//! Everything about a controller that is a choice and not a fact of the rig: what a gains file holds.

use crate::allocation::{AllocationSettings, CurrentLimitSettings};
use crate::axes::PerAxis;
use crate::command_filter::FilterSettings;
use crate::estimator::EstimatorSettings;
use crate::gains::Gains;
use crate::law::LawSettings;
use crate::lead::Lead;
use crate::real::Real;
use crate::settings::{Field, Kind, Table, change, check};
use crate::validate::Invalid;
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

/// The table of [`ControllerSettings::cancellation`].
pub(crate) struct Cancellation;

table! {
    [] [Cancellation] at ("") {
        /// α: how much of the estimated disturbance is cancelled.
        cancellation: (PerAxis<R>) "-", (at least 0), typical 0.0 to 1.0, default 0.0;
    }
}

/// Where a controller has one of several kinds: the name of the choice, and its kinds.
pub const CHOICES: [(&str, &[Kind]); 3] = [
    ("law", LawSettings::<f64>::KINDS),
    ("estimator", EstimatorSettings::<f64>::KINDS),
    ("allocation", AllocationSettings::<f64>::KINDS),
];

/// What a controller may have or not: the part's name, and its numbers.
pub const PARTS: [(&str, &[Field]); 4] = [
    ("filter", FilterSettings::<f64>::FIELDS),
    ("lead", Lead::<f64>::FIELDS),
    ("cancellation", Cancellation::FIELDS),
    ("motor", CurrentLimitSettings::<f64>::FIELDS),
];

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
    pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> ControllerSettings<U> {
        ControllerSettings {
            law: self.law.map(&mut f),
            estimator: self.estimator.map(&mut f),
            filter: self.filter.map(|x| x.map(&mut f)),
            allocation: self.allocation.map(&mut f),
            lead: self.lead.map(|x| x.map(&mut f)),
            cancellation: self.cancellation.map(|x| x.map(&mut f)),
        }
    }

    /// Replaces each number by what `f` makes of it and its field, in the order of the tables. What is not
    /// there is left out.
    pub fn change(&mut self, mut f: impl FnMut(&'static Field, R) -> R) {
        let fields = self.law.fields();
        change(&mut self.law, fields, &mut f);
        let fields = self.estimator.fields();
        change(&mut self.estimator, fields, &mut f);
        if let Some(filter) = &mut self.filter {
            change(filter, FilterSettings::<R>::FIELDS, &mut f);
        }
        let fields = self.allocation.fields();
        change(&mut self.allocation, fields, &mut f);
        if let Some(lead) = &mut self.lead {
            change(lead, Lead::<R>::FIELDS, &mut f);
        }
        change(&mut self.cancellation, Cancellation::FIELDS, &mut f);
    }

    /// Shows each number with its field, in the order of the tables. What is not there is left out.
    pub fn visit(&self, mut f: impl FnMut(&'static Field, R)) {
        let mut copy = *self;
        copy.change(|field, value| {
            f(field, value);
            value
        });
    }

    /// The number of this name, if this controller has it.
    pub fn get(&self, name: &str) -> Option<R> {
        let mut found = None;
        self.visit(|field, value| {
            if field.name == name {
                found = Some(value);
            }
        });
        found
    }
}

impl<R: Real<Mask = bool>> ControllerSettings<R> {
    /// Sets the number of this name. Gives whether this controller has it.
    ///
    /// # Errors
    /// Names the field and what is allowed, and changes nothing.
    pub fn set(&mut self, name: &str, value: R) -> Result<bool, Invalid<R>> {
        let (mut known, mut outcome) = (false, Ok(()));
        self.change(|field, old| {
            if field.name != name {
                return old;
            }
            known = true;
            if field.range.allows(value) {
                return value;
            }
            outcome = Err(Invalid { field: field.name, value, allowed: field.range.allowed() });
            old
        });
        outcome.map(|()| known)
    }

    /// Every number allowed.
    ///
    /// # Errors
    /// Names the field.
    pub fn validate(&self) -> Result<(), Invalid<R>> {
        self.law.validate()?;
        if let LawSettings::StateSpace(gains) = &self.law {
            gains.validate()?;
        }
        self.estimator.validate()?;
        self.filter.map_or(Ok(()), |filter| filter.validate())?;
        self.allocation.validate()?;
        self.lead.map_or(Ok(()), |lead| lead.validate())?;
        check(&self.cancellation, Cancellation::RULES)
    }
}
