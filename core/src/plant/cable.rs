//! A cable between the turning body and its stand, which yaw winds up.

use crate::real::Real;

/// Pulls yaw back to where it was laid with -k (ψ - what of it is free).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cable<R> {
    /// \[N m/rad\] k, 0 or more; 0 for no cable.
    pub stiffness: R,
    /// \[rad\] How far yaw turns either way before the cable is taut, 0 or more.
    pub free: R,
}

impl<R: Real> Cable<R> {
    /// \[N m\] On yaw at `angle` \[rad\].
    #[inline(always)]
    pub(super) fn torque(&self, angle: R) -> R {
        let slack = angle.max(-self.free).min(self.free);
        -(self.stiffness * (angle - slack))
    }
}
