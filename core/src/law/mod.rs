//! Step 5 of the tick: from what is and what should be to the torque on each axis.

mod backstepping;

pub use backstepping::{Backstepping, Errors};

use crate::axes::PerAxis;
use crate::estimator::Estimate;
use crate::plant::RigidBody;
use crate::real::Real;
use crate::reference::Reference;

/// A control law: everything between the estimate and the torque.
pub trait ControlLaw<R: Real> {
    /// The torque [N m] that the law asks for, whether or not the motors can give it. `model` is what the law
    /// believes of the helicopter; the real one may differ.
    fn torque(
        &mut self,
        model: &RigidBody<R>,
        estimate: &Estimate<R>,
        reference: &Reference<R>,
    ) -> PerAxis<R>;
}
