//! The rules that a flight can break on a rig and a board with nothing wrong: over any [`Real`], so that the
//! tuner's lanes are watched as the board watches itself.

use super::motion::{MOTION_EVERY, Motion};
use crate::axes::{PerAxis, PerMotor};
use crate::parameters::{EncoderScale, Limits};
use crate::pipeline::Settings;
use crate::real::{Count, Mask, Real};
use core::borrow::BorrowMut;

/// How many times the largest rate an encoder may show in one tick.
pub const JUMP_MARGIN: f32 = 2.0;
/// \[counts\] Beyond that: quantisation, and an edge that bounces.
pub const JUMP_COUNTS: f32 = 3.0;

/// What a flight shows in one tick.
#[derive(Debug, Clone, Copy)]
pub struct Seen<R: Real> {
    /// Which tick it is, counted from the board's boot.
    pub tick: u32,
    /// The law turns the motors. Only then is motion compared.
    pub armed: bool,
    /// \[counts\] Motion of each encoder since the last tick.
    pub moved: PerAxis<R::Count>,
    /// \[rad\] Estimated angles.
    pub angle: PerAxis<R>,
    /// \[rad/s\] Estimated rates.
    pub rate: PerAxis<R>,
    /// \[rad\] Where the last tick wanted to be.
    pub wanted: PerAxis<R>,
    /// \[V\] What acted on the motors since the last tick.
    pub applied: PerMotor<R>,
    /// \[V\] What the last tick's pipeline asked for.
    pub demand: PerMotor<R>,
}

/// What is wrong with it.
#[derive(Debug, Clone, Copy)]
pub struct Wrong<M> {
    /// An encoder moved further than the rig can.
    pub jumped: PerAxis<M>,
    /// Pitch is outside the envelope.
    pub steep: M,
    /// A rate is.
    pub fast: PerAxis<M>,
    /// No NaN and no infinity turned up.
    pub finite: M,
}

/// The rules, their limits and their memory: what every tick looks at first. Most of a [`Motion`] only every
/// [`MOTION_EVERY`]th does, so `M` may be where there is more room: a GPU has few registers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct FlightRules<R: Real, M = Motion<R>> {
    /// \[rad\]
    pitch: R,
    /// \[rad/s\]
    rate: PerAxis<R>,
    /// \[counts\] In a tick.
    jump: PerAxis<R::Count>,
    contradicted: PerAxis<R::Mask>,
    motion: M,
}

impl<R: Real<Scalar = f32>> FlightRules<R> {
    /// For what the controller believes, encoders and limits.
    #[must_use]
    pub fn new(settings: &Settings<R>, encoders: &PerAxis<EncoderScale>, limits: &Limits) -> Self {
        let sample_time = settings.sample_time.lane(0);
        let jump = |rate: f32, encoder: EncoderScale| {
            let counts = JUMP_MARGIN * rate * sample_time / encoder.angle_per_count + JUMP_COUNTS;
            #[expect(clippy::cast_possible_truncation, reason = "saturates, and then never trips")]
            let counts = counts as i32;
            R::Count::whole(counts)
        };
        Self {
            pitch: R::splat(limits.pitch),
            rate: limits.rate.map(R::splat),
            jump: limits.rate.zip(*encoders, jump),
            motion: Motion::new(settings, encoders),
            contradicted: PerAxis::both(R::Mask::splat(false)),
        }
    }

    /// The same with the motions' comparison where `keep` puts it.
    pub fn keeping<M>(self, keep: impl FnOnce(Motion<R>) -> M) -> FlightRules<R, M> {
        let Self { pitch, rate, jump, contradicted, motion } = self;
        FlightRules { pitch, rate, jump, contradicted, motion: keep(motion) }
    }
}

impl<R: Real<Scalar = f32>, M: BorrowMut<Motion<R>>> FlightRules<R, M> {
    /// Arming and the check start afresh, at this pitch \[rad\]: no motion is expected yet.
    pub fn restart(&mut self, pitch: R) {
        self.motion.borrow_mut().restart(pitch);
        self.contradicted = PerAxis::both(R::Mask::splat(false));
    }

    /// The law no longer turns the motors.
    pub fn end(&mut self) {
        self.contradicted = PerAxis::both(R::Mask::splat(false));
    }

    /// What is wrong in this tick.
    #[inline(always)]
    pub fn check(&mut self, seen: &Seen<R>) -> Wrong<R::Mask> {
        let Seen { moved, angle, rate, demand, .. } = *seen;
        let mut jumped = PerAxis::both(R::Mask::splat(false));
        // Most ticks of a board move neither; of many lanes one always moves.
        if R::LANES > 1 || moved != PerAxis::both(R::Count::whole(0)) {
            jumped = moved.zip(self.jump, R::Count::exceeds);
            self.motion.borrow_mut().moved(moved);
        }
        let fast = rate.zip(self.rate, |rate, limit| limit.lt(rate.abs()));
        let steep = self.pitch.lt(angle.pitch.abs());
        // One NaN or infinity makes the sum one; rates, angles and demands of this world do not overflow it.
        let sum = (angle.pitch + angle.yaw) + (rate.pitch + rate.yaw) + (demand.main + demand.tail);
        // In flight alone: the tick that arms is the longest.
        if seen.armed {
            self.motion.borrow_mut().turned(rate.pitch);
            if seen.tick % MOTION_EVERY == MOTION_EVERY - 1 {
                self.contradicted = self.motion.borrow_mut().disagrees(seen);
            }
        }
        Wrong { jumped, steep, fast, finite: sum.is_finite() }
    }

    /// The encoders do not show what the volts must have moved, whether it is the law that gave them or not:
    /// at the last comparison, which was in flight.
    #[inline(always)]
    pub fn contradicted(&self) -> PerAxis<R::Mask> {
        self.contradicted
    }
}
