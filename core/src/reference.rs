//! Step 4 of the tick: where the helicopter should be, with derivatives that belong together.

use crate::axes::PerAxis;
use crate::real::Real;
use serde::{Deserialize, Serialize};

/// Where to be, and how that changes: x_d, ẋ_d, ẍ_d of eqs (26)-(27).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Reference<R> {
    /// \[rad\] θ_d, ψ_d.
    pub angle: PerAxis<R>,
    /// \[rad/s\] Its rate; zero on either side of a jump.
    pub rate: PerAxis<R>,
    /// \[rad/s²\] Its acceleration; zero on either side of a jump.
    pub accel: PerAxis<R>,
}

impl<R: Real> Reference<R> {
    /// Stay at `angle` \[rad\].
    #[inline(always)]
    pub fn at_rest(angle: PerAxis<R>) -> Self {
        Self { angle, rate: PerAxis::zero(), accel: PerAxis::zero() }
    }

    /// The same in every lane.
    #[inline(always)]
    pub fn splat(value: &Reference<R::Scalar>) -> Self {
        Self {
            angle: PerAxis::splat(value.angle),
            rate: PerAxis::splat(value.rate),
            accel: PerAxis::splat(value.accel),
        }
    }
}
