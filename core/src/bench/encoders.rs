//! What the encoders of a simulated rig show of its true angles.

use super::Wear;
use crate::axes::PerAxis;
use crate::plant::presets::Rig;
use crate::real::Real;

/// The sensors and amplifiers of a real rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hardware {
    /// Counts a revolution.
    pub encoder_counts: PerAxis<u32>,
    /// \[counts\] 0..1: where between two counts the angle zero lies; .5 for in the middle of count zero.
    pub encoder_phase: PerAxis<f64>,
    /// Compare steps between zero and full voltage.
    pub pwm_steps: u32,
    /// \[V\] Supply of the amplifiers.
    pub supply: f64,
    /// Counts a revolution as the controller has them: another number than the encoder's misreads every
    /// angle.
    pub believed_counts: PerAxis<u32>,
    /// What is worn.
    pub wear: Wear,
}

impl Hardware {
    /// `rig`'s, with a supply that just reaches the larger voltage limit.
    pub fn of(rig: &Rig, encoder_phase: PerAxis<f64>) -> Self {
        Self {
            encoder_counts: rig.encoder_counts,
            encoder_phase,
            pwm_steps: rig.board.pwm_steps(),
            supply: rig.volts_limit.main.max(rig.volts_limit.tail),
            believed_counts: rig.encoder_counts,
            wear: Wear::default(),
        }
    }

    /// The same of a rig that is taken for `belief`: its board reckons with the counts of that one, and its
    /// amplifiers give at most `truth`'s volts.
    #[must_use]
    pub fn taken_for(self, belief: &Rig, truth: &Rig) -> Self {
        let less = truth.volts_limit.main < belief.volts_limit.main
            || truth.volts_limit.tail < belief.volts_limit.tail;
        Self {
            believed_counts: belief.encoder_counts,
            pwm_steps: belief.board.pwm_steps(),
            wear: Wear { limit: if less { Some(truth.volts_limit) } else { self.wear.limit }, ..self.wear },
            ..self
        }
    }
}

/// \[counts/rad\] Of an encoder with that many counts a revolution.
pub fn counts_per_angle<R: Real>(counts: u32) -> R {
    R::from_f64(f64::from(counts) / core::f64::consts::TAU)
}

/// Two ideal encoders: scale, phase and rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encoders<R> {
    /// \[counts/rad\]
    counts_per_angle: PerAxis<R>,
    /// \[counts\] -.5...5: the phase, seen from the middle of a count.
    phase: PerAxis<R>,
}

impl<R: Real> Encoders<R> {
    /// With these counts a revolution, and with a phase \[counts, 0..1\] that may differ from lane to lane.
    pub fn new(counts_per_turn: PerAxis<u32>, phase: PerAxis<R>) -> Self {
        Self::scaled(counts_per_turn.map(counts_per_angle), phase)
    }

    /// The same with its scale \[counts/rad\] at hand.
    #[inline(always)]
    pub fn scaled(counts_per_angle: PerAxis<R>, phase: PerAxis<R>) -> Self {
        Self { counts_per_angle, phase: phase.map(|p| p - R::from_f64(0.5)) }
    }

    /// Whole counts from zero at true angles \[rad\].
    #[inline(always)]
    pub fn counts(&self, angle: PerAxis<R>) -> PerAxis<R> {
        let exact = angle.zip(self.counts_per_angle, |a, c| a * c);
        exact.plus(self.phase).map(
            #[inline(always)]
            |c| c.round(),
        )
    }
}
