//! What the board's supervisor makes of flights in lanes: in which tick and for what it would cut the motors.
//!
//! The rules are the board's own ([`FlightRules`]). Of the conditions that stop motors those are here that a
//! sound rig's flight can bring about:
//!
//! - `PitchJump`, `YawJump`, `PitchMotion`, `YawMotion`, `AngleEnvelope`, `RateEnvelope`, `NonFinite`.
//!
//! The others cannot occur in one, and so they do not occur in a [`BoardLoop`](crate::closed_loop::BoardLoop)
//! in the same flight:
//!
//! - `EmergencyStop`, `CurrentLimit`, `SensorStale`: nobody presses it, no amplifier says anything, every
//!   sensor answers;
//! - `SupplyRange`, `SupplyJump`: the supply is the same in every tick, and within its range;
//! - `CommandTimeout`: the line is never silent;
//! - `TickOverrun`, `StackGuard`, `ParametersInvalid`: no tick is late and no memory too small.
//!
//! Heat ends no flight: what the motors can take limits their volts
//! ([`CurrentLimit`](twinrotor::allocation::CurrentLimit)).

use crate::closed_loop::{ARMS, Tick, limits};
use crate::fittings::Fittings;
use crate::judged::Ended;
use core::borrow::BorrowMut;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::monitor::{FlightRules, Motion, Seen, Wrong};
use twinrotor::parameters::EncoderScale;
use twinrotor::pipeline::Settings;
use twinrotor::real::{Mask, Real};
use twinrotor::supervisor::Condition;

/// Watches flights that begin level, tick by tick.
#[derive(Debug, Clone, Copy)]
pub struct Guard<R: Real, M = Motion<R>> {
    rules: FlightRules<R, M>,
    /// What the last tick showed, wanted and asked for.
    counts: PerAxis<R>,
    wanted: PerAxis<R>,
    demand: PerMotor<R>,
    ended: R::Mask,
    /// \[ticks\] When.
    at: R,
    /// The condition's number.
    condition: R,
}

impl<R: Real<Scalar = f32>> Guard<R> {
    /// Of the controllers and the sensors that fly.
    pub fn new(settings: &Settings<R>, hardware: &impl Fittings<f32>) -> Self {
        let encoders = hardware
            .angle_per_count()
            .map(|angle_per_count| EncoderScale { angle_per_count, rest_counts: 0 });
        Self {
            rules: FlightRules::new(settings, &encoders, &limits(hardware.supply())),
            counts: PerAxis::zero(),
            wanted: PerAxis::zero(),
            demand: PerMotor::zero(),
            ended: R::Mask::splat(false),
            at: R::zero(),
            condition: R::zero(),
        }
    }

    /// The same with the motions' comparison, of which most is looked at in few ticks, where `keep` puts it.
    pub fn keeping<M>(self, keep: impl FnOnce(Motion<R>) -> M) -> Guard<R, M> {
        let Self { rules, counts, wanted, demand, ended, at, condition } = self;
        Guard { rules: rules.keeping(keep), counts, wanted, demand, ended, at, condition }
    }
}

impl<R: Real<Scalar = f32>, M: BorrowMut<Motion<R>>> Guard<R, M> {
    /// What happened in this tick of the flight; the board arms in the first, 0.
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[cfg_attr(debug_assertions, inline(never))]
    pub fn see(&mut self, tick: u32, happened: &Tick<R>) {
        let decision = &happened.decision;
        if tick > 0 {
            let wrong = self.rules.check(&Seen {
                tick: tick + ARMS,
                armed: true,
                moved: happened.counts.minus(self.counts).map(R::to_count),
                angle: decision.estimate.state.angle,
                rate: decision.estimate.state.rate,
                wanted: self.wanted,
                applied: happened.logged.volts,
                demand: self.demand,
            });
            let contradicted = self.rules.contradicted();
            let now = any(&wrong, contradicted) & !self.ended;
            if now.any() {
                self.end(now, tick, &wrong, contradicted);
            }
        }
        self.counts = happened.counts;
        self.wanted = decision.reference;
        self.demand = decision.allocation.demand;
    }

    /// These flights end here, each for the first of its conditions.
    #[inline(always)]
    fn end(&mut self, now: R::Mask, tick: u32, wrong: &Wrong<R::Mask>, contradicted: PerAxis<R::Mask>) {
        core::hint::cold_path();
        let named = |condition: Condition| R::from_f64(f64::from(condition as u8));
        let mut condition = named(Condition::NonFinite);
        for (present, name) in [
            (wrong.fast.pitch | wrong.fast.yaw, Condition::RateEnvelope),
            (wrong.steep, Condition::AngleEnvelope),
            (contradicted.yaw, Condition::YawMotion),
            (contradicted.pitch, Condition::PitchMotion),
            (wrong.jumped.yaw, Condition::YawJump),
            (wrong.jumped.pitch, Condition::PitchJump),
        ] {
            condition = R::select(present, named(name), condition);
        }
        self.condition = R::select(now, condition, self.condition);
        self.at = R::select(now, R::from_f64(f64::from(tick)), self.at);
        self.ended = self.ended | now;
    }

    /// How the flight in this lane has ended, if a board would have ended it.
    pub fn ended(&self, lane: usize) -> Option<Ended> {
        let number = |x: R| x.lane(lane).to_count().unsigned_abs();
        let condition = *Condition::ALL.get(number(self.condition) as usize)?;
        self.ended.lane(lane).then(|| Ended { tick: number(self.at), condition })
    }
}

/// Is anything wrong?
#[inline(always)]
fn any<M: Mask>(wrong: &Wrong<M>, contradicted: PerAxis<M>) -> M {
    let Wrong { jumped, steep, fast, finite } = *wrong;
    let both = |of: PerAxis<M>| of.pitch | of.yaw;
    (both(jumped) | both(contradicted)) | (both(fast) | (steep | !finite))
}
