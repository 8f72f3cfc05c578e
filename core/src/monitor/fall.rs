//! How far pitch may move against its motors with nothing wrong; names as in `motion.rs`.
//!
//! Two things do that, and both are seen to. Neither lets an encoder that stands still pass.
//!
//! - Rotors up to [`LATE`] times as slow as believed: until their thrust is there, the nose falls. What such
//!   rotors would have pushed less by counts as explained for as long as the rate is against the push.
//! - A weight that is hung on or taken off: more than a disturbance by volts. It is allowed for while the
//!   rate is against the push, and while the nose is where that has brought it.
//!
//! ```text
//! slow  <- torque + slow_decay (slow - torque)
//! late  <- keep late + T (1 - 1/LATE) (torque - slow)/I       push, less that of rotors as slow as LATE τ:
//!                                                             (τ s + 1)/(LATE τ s + 1) of their torque
//! level <- θ + keep_load (level - θ)
//! drift  = θ - level
//! ```

use super::motion::{DRIFT, LATE};
use crate::real::Real;

/// Constants and memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fall<R> {
    slow_decay: R,
    /// \[1/(kg m²) s\] T (1 - 1/LATE)/I.
    gain: R,
    /// \[N m\]
    slow: R,
    /// \[rad/s\]
    late: R,
    /// \[rad\]
    level: R,
    /// \[rad/s\] By how much a weight may part what is observed from what is expected.
    weight: R,
}

impl<R: Real<Scalar = f32>> Fall<R> {
    /// `step_over_inertia` \[s/(kg m²)\].
    pub(super) fn new(slow_decay: R, step_over_inertia: R, weight: R) -> Self {
        let gain = step_over_inertia * R::splat(1.0 - 1.0 / LATE);
        Self { slow_decay, gain, slow: R::zero(), late: R::zero(), level: R::zero(), weight }
    }

    /// At this pitch \[rad\].
    pub(super) fn restart(&mut self, pitch: R) {
        *self = Self { slow: R::zero(), late: R::zero(), level: pitch, ..*self };
    }

    /// Takes the torque \[N m\] of rotors as believed.
    #[inline(always)]
    pub(super) fn push(&mut self, torque: R, keep: R) {
        self.slow = torque + (self.slow - torque) * self.slow_decay;
        self.late = self.late * keep + (torque - self.slow) * self.gain;
    }

    /// Takes a pitch \[rad\].
    #[inline(always)]
    pub(super) fn be_at(&mut self, pitch: R, keep_load: R) {
        self.level = pitch + (self.level - pitch) * keep_load;
    }

    /// \[rad/s\] By how much observed may part from expected, with `at_rest` for an axis that does not move;
    /// `down`: the push is.
    #[inline(always)]
    pub(super) fn explains(&self, at_rest: R, down: R::Mask, pitch: R, rate: R) -> R {
        let along = |x: R| R::select(down, -x, x);
        let moves = along(rate).lt(R::zero());
        let moved = along(pitch - self.level).lt(R::splat(-DRIFT));
        let late = R::select(moves, along(self.late).max(R::zero()), R::zero());
        R::select(moves | moved, self.weight, at_rest) + late
    }
}
