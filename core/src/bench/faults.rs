//! What may be wrong with the cables of a simulated rig.

use crate::axes::{PerAxis, PerMotor};
use crate::real::Real;
use serde::{Deserialize, Serialize};

/// Faults of the wiring; none by default. They may come and go while the rig flies.
///
/// What the motors get: their own cables' faults first, then the swap. What the encoders show: swapped first,
/// then each channel's own faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Faults {
    /// Main and tail motor are swapped.
    pub motors_swapped: bool,
    /// The motor turns backwards.
    pub motor_reversed: PerMotor<bool>,
    /// The motor is not connected.
    pub motor_open: PerMotor<bool>,
    /// The pitch and the yaw encoder are swapped.
    pub encoders_swapped: bool,
    /// The encoder's two channels are swapped: it counts backwards from here on.
    pub encoder_reversed: PerAxis<bool>,
    /// The encoder is not connected: its counter stays.
    pub encoder_stuck: PerAxis<bool>,
    /// \[counts\] Added once, at the next tick, and then zero again: edges that were none, or were lost.
    pub slip: PerAxis<i32>,
    /// \[counts\] Added every tick.
    pub drift: PerAxis<i32>,
}

impl Faults {
    /// \[V\] What the motors get of the amplifiers' `volts`.
    #[inline]
    pub fn motor_volts<R: Real>(&self, volts: PerMotor<R>) -> PerMotor<R> {
        let volts = volts.zip(self.motor_reversed, |volts, reversed| if reversed { -volts } else { volts });
        let volts = volts.zip(self.motor_open, |volts, open| if open { R::zero() } else { volts });
        if self.motors_swapped { PerMotor::new(volts.tail, volts.main) } else { volts }
    }

    /// \[counts\] What the encoders' counters gain in a tick in which the shafts turned by `turned`.
    #[inline]
    pub fn counted(&mut self, turned: PerAxis<i32>) -> PerAxis<i32> {
        let turned = if self.encoders_swapped { PerAxis::new(turned.yaw, turned.pitch) } else { turned };
        let forward =
            turned.zip(self.encoder_reversed, |counts, reversed| if reversed { -counts } else { counts });
        let alive = forward.zip(self.encoder_stuck, |counts, stuck| if stuck { 0 } else { counts });
        let extra = core::mem::replace(&mut self.slip, PerAxis::both(0)).zip(self.drift, i32::wrapping_add);
        alive.zip(extra, i32::wrapping_add)
    }
}
