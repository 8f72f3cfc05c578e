//! What a pipeline is made from.

use crate::allocation::CurrentLimitSettings;
use crate::axes::PerMotor;
use crate::controller::ControllerSettings;
use crate::gains::Gains;
use crate::plant::presets::Rig;
use crate::plant::{Effectiveness, PlantParameters};
use crate::real::Real;
use crate::validate::{Invalid, positive};
use serde::{Deserialize, Serialize};

/// What a controller is made from: the rig as it is believed to be, and the user's choices, before anything
/// is derived from them.
///
/// Everything that the pipeline derives from them is basic arithmetic in `R`, so a board that is given the
/// same numbers derives the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, bound(deserialize = "R: Deserialize<'de> + Default"))]
pub struct Settings<R> {
    /// \[s\] From tick to tick.
    pub sample_time: R,
    /// What the law believes of the helicopter, which may differ.
    pub model: PlantParameters<R>,
    /// \[N m/V\] The thrust gains that the law believes in.
    pub effectiveness: Effectiveness<R>,
    /// \[V\] Limit of each motor, either way.
    pub volts_limit: PerMotor<R>,
    /// What the motors' currents allow, where the motors are known.
    pub current_limit: Option<CurrentLimitSettings<R>>,
    /// Law, gains and what stands around them.
    pub controller: ControllerSettings<R>,
}

impl Settings<f64> {
    /// This controller on a rig whose constants it knows exactly, `sample_time` in s.
    pub fn new(rig: &Rig, controller: ControllerSettings<f64>, sample_time: f64) -> Self {
        Self {
            sample_time,
            model: rig.plant,
            effectiveness: rig.plant.effectiveness_at(rig.nominal_volts),
            volts_limit: rig.volts_limit,
            current_limit: rig.motor.as_ref().map(CurrentLimitSettings::new),
            controller,
        }
    }

    /// The paper's law with these gains, alone with the limits on the volts, `sample_time` in s.
    pub fn paper(rig: &Rig, gains: Gains<f64>, sample_time: f64) -> Self {
        Self { current_limit: None, ..Self::new(rig, ControllerSettings::paper(gains), sample_time) }
    }
}

impl Settings<f64> {
    /// Every number usable.
    ///
    /// # Errors
    /// Names the field.
    pub fn validate(&self) -> Result<(), Invalid> {
        positive("sample_time", self.sample_time)?;
        self.model.validate()?;
        self.effectiveness.validate_inverse()?;
        positive("volts_limit.main", self.volts_limit.main)?;
        positive("volts_limit.tail", self.volts_limit.tail)?;
        self.current_limit.map_or(Ok(()), |limit| limit.validate())?;
        self.controller.validate()
    }
}

impl<R: Real> Settings<R> {
    /// Each number through `f`, in a fixed order.
    pub fn map<U: Copy>(self, mut f: impl FnMut(R) -> U) -> Settings<U> {
        Settings {
            sample_time: f(self.sample_time),
            model: self.model.map(&mut f),
            effectiveness: self.effectiveness.map(&mut f),
            volts_limit: self.volts_limit.map(&mut f),
            current_limit: self.current_limit.map(|x| x.map(&mut f)),
            controller: self.controller.map(&mut f),
        }
    }

    /// The same for the paper's world, whose rotors answer at once: without what only makes sense with rotors
    /// that do not.
    pub fn for_ideal_rotors(self) -> Self {
        Self {
            current_limit: None,
            controller: ControllerSettings { lead: None, cancellation: None, ..self.controller },
            ..self
        }
    }
}
