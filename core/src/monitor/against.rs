//! How far an axis may move against its motors with nothing wrong; names as in `motion.rs`.
//!
//! Two things do that, and both are seen to. Neither lets an encoder that stands still pass.
//!
//! - Rotors up to [`LATE`] times as slow as believed: until their thrust is there, the nose falls by its
//!   weight, and a swing goes on that they were to catch. What such rotors would have pushed less by counts
//!   as explained while the rate is against the push.
//! - A weight that is hung on or taken off: in pitch more than a disturbance by volts. It is allowed for
//!   while the rate is against the push, and while the nose is where that has brought it.
//!
//! ```text
//! slow  <- torque + slow_decay (slow - torque)
//! late  <- keep late + T (1 - 1/LATE) (torque - slow)/I       push, less that of rotors as slow as LATE τ:
//!                                                             (τ s + 1)/(LATE τ s + 1) of their torque
//! level <- θ + keep_load (level - θ)
//! drift  = θ - level
//! ```

use super::motion::{DRIFT, LATE};
use crate::axes::PerAxis;
use crate::real::Real;

/// What rotors are late by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Late<R> {
    slow_decay: R,
    /// \[s/(kg m²)\] T (1 - 1/LATE)/I.
    gain: PerAxis<R>,
    /// \[N m\]
    slow: PerAxis<R>,
    /// \[rad/s\]
    push: PerAxis<R>,
}

impl<R: Real<Scalar = f32>> Late<R> {
    /// With T \[s\] from one torque to the next, on these inertias \[kg m²\].
    pub(super) fn new(slow_decay: R, step: R, inertia: PerAxis<R>) -> Self {
        let gain = inertia.map(|inertia| step * R::splat(1.0 - 1.0 / LATE) / inertia);
        Self { slow_decay, gain, slow: PerAxis::zero(), push: PerAxis::zero() }
    }

    pub(super) fn restart(&mut self) {
        self.slow = PerAxis::zero();
        self.push = PerAxis::zero();
    }

    /// Takes the torque \[N m\] of rotors as believed; gives `late` \[rad/s\].
    #[inline(always)]
    pub(super) fn step(&mut self, torque: PerAxis<R>, keep: R) -> PerAxis<R> {
        self.slow = torque.plus(self.slow.minus(torque).scaled(self.slow_decay));
        let missing = torque.minus(self.slow).zip(self.gain, |torque, gain| torque * gain);
        self.push = self.push.scaled(keep).plus(missing);
        self.push
    }
}

/// Where the nose lately was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Level<R> {
    /// \[rad\]
    level: R,
    /// \[rad/s\] By how much a weight may part what is observed from what is expected.
    weight: R,
}

impl<R: Real<Scalar = f32>> Level<R> {
    pub(super) fn new(weight: R) -> Self {
        Self { level: R::zero(), weight }
    }

    /// At this pitch \[rad\].
    pub(super) fn restart(&mut self, pitch: R) {
        self.level = pitch;
    }

    /// Takes a pitch \[rad\]; gives `drift` \[rad\].
    #[inline(always)]
    pub(super) fn step(&mut self, pitch: R, keep_load: R) -> R {
        self.level = pitch + (self.level - pitch) * keep_load;
        pitch - self.level
    }

    /// \[rad/s\] By how much observed may part from expected where a disturbance by volts explains
    /// `disturbed`; `along` is the drift as the push goes, and the axis `moves` against it.
    #[inline(always)]
    pub(super) fn explains(&self, disturbed: R, along: R, moves: R::Mask) -> R {
        R::select(moves | along.lt(R::splat(-DRIFT)), self.weight, disturbed)
    }
}
