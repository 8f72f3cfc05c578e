//! References that run over time: steps, sinusoids and the paper's scenarios. Simulations and programs on the
//! host follow these; a board is sent one [`Reference`] after another.
//!
//! Time is an integer tick. A sinusoid's phase is a 64-bit fraction of a turn, `tick` times a step that wraps
//! around by itself, so a reference is as exact after an hour as at the start, in `f32` too (2 units in the
//! last place of its amplitude), and its argument never grows.

use crate::DEGREE;
use crate::axes::PerAxis;
use crate::real::Real;
use crate::reference::Reference;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most jumps of a stepwise profile.
pub const MAX_JUMPS: usize = 32;

/// How one axis' reference runs over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Profile<R> {
    /// One value after another, held in between.
    Steps {
        /// \[rad\] Before the first jump.
        initial: R,
        /// The tick from which on a new angle \[rad\] holds, in rising order.
        jumps: Vec<(u32, R), MAX_JUMPS>,
        /// \[ticks\] After which it starts again; 0 for never.
        period: u32,
    },
    /// offset + amplitude x sin(phase).
    Sine {
        /// \[rad\]
        offset: R,
        /// \[rad\]
        amplitude: R,
        /// \[rad/s\] ω, for the derivatives.
        frequency: R,
        /// \[2⁻⁶⁴ turn\] Phase gained in a tick.
        phase_step: u64,
        /// \[2⁻⁶⁴ turn\] Phase at tick 0.
        phase: u64,
    },
}

impl<R: Real<Scalar = R>> Profile<R> {
    /// `angle` \[rad\] from tick 0 on.
    pub fn hold(angle: f64) -> Self {
        Self::Steps { initial: R::from_f64(angle), jumps: Vec::new(), period: 0 }
    }

    /// `initial` \[rad\], then from each time \[s\] on the angle \[rad\] beside it, all over again every
    /// `period` \[s\] if that is not 0. Jumps beyond the first [`MAX_JUMPS`] are left out: callers check.
    /// Times are rounded to ticks.
    pub fn steps(initial: f64, jumps: &[(f64, f64)], period: f64, sample_time: f64) -> Self {
        Self::Steps {
            initial: R::from_f64(initial),
            jumps: jumps
                .iter()
                .take(MAX_JUMPS)
                .map(|&(time, angle)| (ticks(time, sample_time), R::from_f64(angle)))
                .collect(),
            period: ticks(period, sample_time),
        }
    }

    /// offset + amplitude sin(ω t + phase): `offset`, `amplitude`, `phase` in rad, ω = `frequency` in rad/s
    /// of at least 0, `sample_time` in s.
    pub fn sine(offset: f64, amplitude: f64, frequency: f64, phase: f64, sample_time: f64) -> Self {
        Self::Sine {
            offset: R::from_f64(offset),
            amplitude: R::from_f64(amplitude),
            frequency: R::from_f64(frequency),
            phase_step: turns(frequency * sample_time / core::f64::consts::TAU),
            phase: turns(phase / core::f64::consts::TAU),
        }
    }

    /// Angle \[rad\], rate \[rad/s\] and acceleration \[rad/s²\] at a tick.
    #[inline]
    pub fn at(&self, tick: u32) -> [R; 3] {
        match self {
            Self::Steps { initial, jumps, period } => {
                let tick = if *period == 0 { tick } else { tick % period };
                let reached = jumps.iter().rev().find(|(from, _)| *from <= tick);
                [reached.map_or(*initial, |(_, angle)| *angle), R::zero(), R::zero()]
            }
            Self::Sine { offset, amplitude, frequency, phase_step, phase } => {
                let phase = phase.wrapping_add(phase_step.wrapping_mul(u64::from(tick)));
                let (sine, cosine) = angle_of::<R>(phase).sin_cos();
                let rate = *amplitude * *frequency;
                [*offset + *amplitude * sine, rate * cosine, -(rate * *frequency) * sine]
            }
        }
    }
}

/// A number of turns as a wrapping 64-bit fraction.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the fraction is in 0..1, so the product is in 0..2^64"
)]
fn turns(turns: f64) -> u64 {
    let fraction = turns - libm::floor(turns);
    const TWO_TO_THE_64: f64 = (1_u128 << 64) as f64;
    (fraction * TWO_TO_THE_64) as u64
}

/// \[rad\] A phase as an angle in -π..π. Its upper half alone carries 2⁻³² turn, enough for `f32`; the lower
/// half serves `f64`.
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "the two halves of the phase, on purpose")]
fn angle_of<R: Real>(phase: u64) -> R {
    let upper = R::from_i32(((phase >> 32) as u32).cast_signed());
    let lower = R::from_i32(((phase as u32) >> 1).cast_signed());
    const UNIT: f64 = core::f64::consts::TAU / 4_294_967_296.0;
    upper * R::from_f64(UNIT) + lower * R::from_f64(UNIT / 2_147_483_648.0)
}

/// What both axes are to follow.
pub type Trajectory<R> = PerAxis<Profile<R>>;

impl<R: Real<Scalar = R>> Trajectory<R> {
    /// The reference at a tick.
    #[inline]
    pub fn at(&self, tick: u32) -> Reference<R> {
        let (p, y) = (self.pitch.at(tick), self.yaw.at(tick));
        Reference {
            angle: PerAxis::new(p[0], y[0]),
            rate: PerAxis::new(p[1], y[1]),
            accel: PerAxis::new(p[2], y[2]),
        }
    }

    /// The step of section 5: 15 degrees of pitch and 40 of yaw from tick 0.
    pub fn paper_step() -> Self {
        Self::new(Profile::hold(15.0 * DEGREE), Profile::hold(40.0 * DEGREE))
    }

    /// Scenario 1 and scenario 3 as printed, eqs (32)-(33) and (36)-(37): pitch 20 degrees, yaw 40 sin(.08 t)
    /// degrees.
    pub fn paper_sine(sample_time: f64) -> Self {
        Self::new(Profile::hold(20.0 * DEGREE), Profile::sine(0.0, 40.0 * DEGREE, 0.08, 0.0, sample_time))
    }

    /// Scenario 2, eqs (34)-(35): pitch 10 degrees, yaw jumps at 8, 16, 24 and 32 s. (The text under Fig. 7
    /// says 8, 16, 23 and 30 s; the equation is followed.)
    pub fn paper_square_yaw(sample_time: f64) -> Self {
        let yaw = Profile::steps(
            0.0,
            &[(8.0, -10.0), (16.0, -5.0), (24.0, 10.0), (32.0, -20.0)]
                .map(|(time, angle)| (time, angle * DEGREE)),
            0.0,
            sample_time,
        );
        Self::new(Profile::hold(10.0 * DEGREE), yaw)
    }

    /// Scenario 3 as the text at Fig. 9 describes it, against eq. (36): a square pitch reference. The paper
    /// gives neither its levels nor its period; 20 and 10 degrees, 5 s each, are taken here. Yaw as in eq.
    /// (37).
    pub fn paper_square_pitch(sample_time: f64) -> Self {
        let pitch = Profile::steps(20.0 * DEGREE, &[(5.0, 10.0 * DEGREE)], 10.0, sample_time);
        Self::new(pitch, Self::paper_sine(sample_time).yaw)
    }
}

/// The tick nearest to a time \[s\] of at least 0.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturating is what a time out of range should do"
)]
pub fn ticks(time: f64, sample_time: f64) -> u32 {
    libm::round(time / sample_time) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DT: f64 = 1e-3;

    proptest! {
        #[test]
        fn a_sine_is_the_sine_at_any_tick(tick in any::<u32>(), frequency in 0.01..20.0, phase in -3.0..3.0) {
            let profile = Profile::<f64>::sine(0.1, 0.7, frequency, phase, DT);
            let exact = frequency * DT * f64::from(tick) + phase;
            // The phase step is a multiple of 2^-64 turn, and the exact argument itself is rounded.
            let tolerance = 1e-12 + 4.0 * f64::EPSILON * exact.abs()
                + f64::from(tick) * core::f64::consts::TAU / 2.0_f64.powi(64);
            let [angle, rate, accel] = profile.at(tick);
            prop_assert!((angle - (0.1 + 0.7 * exact.sin())).abs() < tolerance);
            prop_assert!((rate - 0.7 * frequency * exact.cos()).abs() < tolerance * frequency.max(1.0));
            prop_assert!((accel + 0.7 * frequency * frequency * exact.sin()).abs()
                < tolerance * (1.0 + frequency * frequency));
        }

        #[test]
        fn f32_does_not_drift_in_an_hour(tick in 0_u32..3_600_000) {
            let (single, double) = (Trajectory::<f32>::paper_sine(DT), Trajectory::<f64>::paper_sine(DT));
            let (s, d) = (single.at(tick), double.at(tick));
            prop_assert!((f64::from(s.angle.yaw) - d.angle.yaw).abs() < 2.5e-7);
            prop_assert!((f64::from(s.rate.yaw) - d.rate.yaw).abs() < 2e-8);
        }
    }

    #[test]
    fn scenario_2_jumps_at_the_equations_times() {
        let t = Trajectory::<f64>::paper_square_yaw(DT);
        let yaw = |tick| (t.at(tick).angle.yaw / DEGREE).round();
        let seen = [0, 7_999, 8_000, 15_999, 16_000, 23_999, 24_000, 31_999, 32_000, 40_000].map(yaw);
        assert_eq!(seen, [0.0, 0.0, -10.0, -10.0, -5.0, -5.0, 10.0, 10.0, -20.0, -20.0]);
        assert_eq!(t.at(9_000).rate, PerAxis::zero());
    }

    #[test]
    fn a_square_repeats() {
        let t = Trajectory::<f64>::paper_square_pitch(DT);
        let pitch = |tick| (t.at(tick).angle.pitch / DEGREE).round();
        let seen = [0, 4_999, 5_000, 9_999, 10_000, 15_000].map(pitch);
        assert_eq!(seen, [20.0, 20.0, 10.0, 10.0, 20.0, 10.0]);
    }
}
