//! What the motors' currents allow: the volts of each motor stay where its current is within bounds.
//!
//! i = (V - k_m ω)/R. In steady state the speed is in proportion to the volts, so k_m ω is a share of the
//! volts in effect, which the rotor model knows. A motor at rest takes V/R, more than it may at 24 V; a motor
//! at speed takes a quarter of that.

use super::VoltsRange;
use crate::axes::PerMotor;
use crate::plant::presets::MotorConstants;
use crate::real::Real;
use crate::validate::{Invalid, require};

/// \[s\] Over which the square of the current is averaged for the continuous limit: well below the minutes in
/// which a motor of this size warms up. No source gives one.
const HEATING_TIME: f64 = 10.0;
/// Share of the continuous limit's heat at which the peak limit begins to fall back.
const FOLD_BACK_FROM: f64 = 0.75;

settings! {
    /// A motor's limits.
    pub struct CurrentLimitSettings<R> at "motor."; and covers_continuous {
        /// Resistance of the winding.
        resistance: (R) "ohm", (above 0), typical 0.5 to 20.0, default 5.0;
        /// Back-EMF for each volt in effect: k_m²/(R d + k_m²) for a drag d.
        back_emf: (R) "-", (0 to 1), typical 0.0 to 1.0, default 0.8;
        /// Most for an instant, at least the continuous limit.
        peak: (R) "A", (above 0), typical 0.5 to 10.0, default 2.0;
        /// Most for long.
        continuous: (R) "A", (above 0), typical 0.2 to 5.0, default 1.0;
    }
}

/// The peak limit is no less than the continuous one.
fn covers_continuous<R: Real<Mask = bool>>(limit: &CurrentLimitSettings<R>) -> Result<(), Invalid<R>> {
    let peak = limit.continuous.le(limit.peak);
    require("motor.peak", limit.peak, peak, "at least the continuous current")
}

impl CurrentLimitSettings<f64> {
    /// Of a known motor.
    pub fn new(motor: &MotorConstants) -> Self {
        let square = motor.back_emf * motor.back_emf;
        Self {
            resistance: motor.resistance,
            back_emf: square / (motor.resistance * motor.drag + square),
            peak: motor.peak_current,
            continuous: motor.continuous_current,
        }
    }
}

/// The limits at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurrentLimit<R> {
    settings: CurrentLimitSettings<R>,
    /// 1/R.
    conductance: R,
    /// Of the current's square to its mean in a tick.
    share: R,
    /// 1/I_c², and what follows for the fold-back.
    per_continuous_square: R,
    /// \[A²\] Mean square of the estimated current.
    heat: PerMotor<R>,
}

impl<R: Real> CurrentLimit<R> {
    /// With cold motors; `sample_time` \[s\].
    pub fn new(settings: CurrentLimitSettings<R>, sample_time: R) -> Self {
        let continuous = settings.continuous;
        Self {
            settings,
            conductance: R::one() / settings.resistance,
            share: sample_time / R::from_f64(HEATING_TIME),
            per_continuous_square: R::one() / (continuous * continuous),
            heat: PerMotor::zero(),
        }
    }

    /// Time has passed, and the motors are cold.
    pub fn cool(&mut self) {
        self.heat = PerMotor::zero();
    }

    /// The motors are as warm as a constant current would make them in the long run whose square is `share`
    /// \[-\] of the continuous one's.
    pub fn warm(&mut self, share: R) {
        let continuous = self.settings.continuous;
        self.heat = PerMotor::both(share * (continuous * continuous));
    }

    /// Takes note of one tick with `applied` volts and `in_effect` at its end.
    #[inline(always)]
    pub fn observe(&mut self, applied: PerMotor<R>, in_effect: PerMotor<R>) {
        let back_emf = in_effect.scaled(self.settings.back_emf);
        let current = applied.minus(back_emf).scaled(self.conductance);
        self.heat = self.heat.zip(current, |heat, i| heat + self.share * (i * i - heat));
    }

    /// \[-\] Heat of the warmer motor, as a share of what the continuous limit allows.
    #[inline(always)]
    pub fn load(&self) -> R {
        self.heat.main.max(self.heat.tail) * self.per_continuous_square
    }

    /// The volts that are allowed now, within ±`limit`, with `in_effect` at the moment they begin to act.
    #[inline(always)]
    pub fn range(&self, in_effect: PerMotor<R>, limit: PerMotor<R>) -> VoltsRange<R> {
        let s = &self.settings;
        let center = in_effect.scaled(s.back_emf);
        let room = self.heat.map(
            #[inline(always)]
            |heat| {
                let spare = R::one() - heat * self.per_continuous_square;
                let whole = spare * R::from_f64(1.0 / (1.0 - FOLD_BACK_FROM));
                let most = s.continuous + (s.peak - s.continuous) * whole.clamp(R::zero(), R::one());
                s.resistance * most
            },
        );
        // What is in effect is within the limit, and there is always some room: each bound needs looking at
        // from one side.
        VoltsRange {
            low: center.minus(room).zip(
                limit,
                #[inline(always)]
                |low, limit| low.max(-limit),
            ),
            high: center.plus(room).zip(
                limit,
                #[inline(always)]
                |high, limit| high.min(limit),
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::presets;
    use crate::rotor_model::RotorModel;

    fn settings() -> CurrentLimitSettings<f64> {
        CurrentLimitSettings::new(&presets::AERO2.motor.unwrap())
    }

    #[test]
    fn a_motor_at_rest_may_have_its_peak_current_and_one_at_speed_the_full_volts() {
        let limit = CurrentLimit::new(settings(), 1e-3);
        let at_rest = limit.range(PerMotor::zero(), PerMotor::both(24.0));
        assert!((at_rest.high.main - 2.0 * 8.4).abs() < 1e-12 && at_rest.low.main == -at_rest.high.main);
        let at_speed = limit.range(PerMotor::both(15.0), PerMotor::both(24.0));
        assert_eq!(at_speed.high.tail, 24.0);
        assert!(at_speed.low.tail > -6.0);
    }

    /// Full volts for a minute: the current of a motor that follows them settles at what it may take for
    /// long.
    #[test]
    fn for_long_the_current_is_what_it_may_be_for_long() {
        let s = settings();
        let mut limit = CurrentLimit::new(s, 1e-3);
        let mut rotors = RotorModel::new(&presets::AERO2.plant, 1e-3);
        let mut current = 0.0;
        let mut peak = 0.0_f64;
        for k in 0..60_000 {
            let range = limit.range(rotors.volts(), PerMotor::both(24.0));
            // Alternating every 300 ms, where back-EMF helps least.
            let volts = if k % 600 < 300 { range.high } else { range.low };
            let i = (volts.main - s.back_emf * rotors.volts().main) / s.resistance;
            peak = peak.max(i.abs());
            rotors.advance(volts);
            limit.observe(volts, rotors.volts());
            if k >= 50_000 {
                current += i * i / 10_000.0;
            }
        }
        assert!((peak - s.peak).abs() < 1e-9);
        assert!(current.sqrt() <= 1.02 * s.continuous, "{}", current.sqrt());
    }
}
