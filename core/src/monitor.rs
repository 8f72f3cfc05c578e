//! What the tick itself can see going wrong: each rule with its time. (A board adds what only it can see:
//! emergency stop, amplifier's current limit, stale sensors, overrun, stack, parameters, the last reset's cause.)
//!
//! | condition | rule | time |
//! |---|---|---|
//! | `PitchJump`, `YawJump` | an encoder moved in one tick further than [`JUMP_MARGIN`] times the largest rate allows, plus [`JUMP_COUNTS`] counts | the tick it happens |
//! | `PitchMotion`, `YawMotion` | armed, and the voltages of the last [`MOTION_WINDOW`] s should have given over [`MOTION_PUSH`] of what full voltage gives, the encoder shows less than [`MOTION_SHARE`] of that or the opposite | [`MOTION_TICKS`] in a row |
//! | `AngleEnvelope` | zeroed, and pitch beyond `limits.pitch` | the tick it happens |
//! | `RateEnvelope` | an estimated rate beyond `limits.rate` | the tick it happens |
//! | `NonFinite` | estimate, reference, torque or volts hold a NaN or an infinity (those volts are zero already) | the next tick |
//! | `SupplyRange` | supply outside `limits.supply_low..=supply_high`, or not a number | [`SUPPLY_TICKS`] in a row |
//! | `CurrentLimit` | the amplifier's signal is on | [`CURRENT_TICKS`] in a row |
//! | `CommandTimeout` | armed, and no message for `limits.command_timeout` | that many ticks |

use crate::axes::{PerAxis, PerMotor};
use crate::estimator::{Estimate, bilinear_decay};
use crate::parameters::Parameters;
use crate::plant::Effectiveness;
use crate::real::Real;
use crate::supervisor::{Condition, Conditions};

/// How many times the largest rate an encoder may show in one tick.
pub const JUMP_MARGIN: f32 = 2.0;
/// \[counts\] Beyond that: quantisation, and an edge that bounces.
pub const JUMP_COUNTS: f32 = 3.0;
/// \[s\] Time constant over which pushes and motion are compared.
pub const MOTION_WINDOW: f32 = 0.2;
/// \[s\] Time constant after which a push that lasts counts as a load that the model does not know.
pub const LOAD_WINDOW: f32 = 1.0;
/// Share of full voltage's push from which on a motion is expected.
pub const MOTION_PUSH: f32 = 0.2;
/// Share of the expected motion that must be seen. Generous: constants are wrong by 30 %, lags by 100 ms.
pub const MOTION_SHARE: f32 = 0.1;
/// \[ticks\] From one comparison to the next: motion is slow, a tick's time is dear.
pub const MOTION_EVERY: u32 = 4;
/// \[ticks\] How long the two must disagree.
pub const MOTION_TICKS: u32 = 100;
/// \[rad\] How far above its rest pose a rig that rests nose down may still lie on its stop.
pub const STOP_MARGIN: f32 = 0.05;
/// \[ticks\] A supply dips for a moment whenever a motor starts.
pub const SUPPLY_TICKS: u32 = 10;
/// \[ticks\] An amplifier may limit for a moment at every step.
pub const CURRENT_TICKS: u32 = 5;

/// What the rules look at in one tick.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// \[counts\] Motion of each encoder since the last tick.
    pub moved: PerAxis<i32>,
    /// What is believed.
    pub estimate: &'a Estimate<f32>,
    /// \[V\] What acted on the motors since the last tick.
    pub applied: PerMotor<f32>,
    /// \[V\] Supply of the amplifiers.
    pub supply: f32,
    /// The amplifier says that it limits the current.
    pub current_limit: bool,
    /// \[V\] What the last tick's pipeline asked for.
    pub demand: PerMotor<f32>,
    /// The encoders have a zero.
    pub zeroed: bool,
    /// The law turns the motors.
    pub armed: bool,
    /// A message came since the last tick.
    pub heard: bool,
}

/// The rules' memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Monitor {
    limits: Bounds,
    motion: Motion,
    until_motion: u32,
    disagrees: PerAxis<bool>,
    supply: Persistence,
    current: Persistence,
    silent: u32,
}

/// Limits in the units in which a tick compares.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bounds {
    pitch: f32,
    rate: PerAxis<f32>,
    jump: PerAxis<u32>,
    supply_low: f32,
    supply_high: f32,
    command_timeout: u32,
}

impl Monitor {
    /// For these parameters; the supply counts as out of range until it has been seen within it.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let limits = &parameters.limits;
        let jump = |rate: f32, angle_per_count: f32| {
            let counts = JUMP_MARGIN * rate * parameters.settings.sample_time / angle_per_count + JUMP_COUNTS;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates, and then never trips"
            )]
            let counts = counts as u32;
            counts
        };
        Self {
            limits: Bounds {
                pitch: limits.pitch,
                rate: limits.rate,
                jump: limits.rate.zip(parameters.encoders.map(|e| e.angle_per_count), jump),
                supply_low: limits.supply_low,
                supply_high: limits.supply_high,
                command_timeout: limits.command_timeout,
            },
            motion: Motion::new(parameters),
            until_motion: MOTION_EVERY,
            disagrees: PerAxis::both(false),
            supply: Persistence { ticks: SUPPLY_TICKS },
            current: Persistence::default(),
            silent: 0,
        }
    }

    /// Arming starts afresh: no motion is expected yet, and the host has just spoken.
    pub fn restart(&mut self) {
        self.motion.restart();
        self.disagrees = PerAxis::both(false);
        self.silent = 0;
    }

    /// What is wrong in this tick.
    #[inline(always)]
    pub fn check(&mut self, seen: &Seen<'_>) -> Conditions {
        let b = &self.limits;
        let state = &seen.estimate.state;
        let jumped = seen.moved.zip(b.jump, |moved, limit| moved.unsigned_abs() > limit);
        let outside = !(seen.supply >= b.supply_low && seen.supply <= b.supply_high);
        let fast = state.rate.zip(b.rate, |rate, limit| rate.abs() > limit);
        let steep = seen.zeroed && state.angle.pitch.abs() > b.pitch;
        // One NaN or infinity makes the sum one; rates, angles and demands of this world do not overflow it.
        let sum = (state.angle.pitch + state.angle.yaw)
            + (state.rate.pitch + state.rate.yaw)
            + (seen.demand.main + seen.demand.tail);
        self.until_motion = self.until_motion.wrapping_sub(1);
        if self.until_motion == 0 {
            self.until_motion = MOTION_EVERY;
            self.disagrees = self.motion.disagrees(seen);
        }
        self.silent = if seen.heard { 0 } else { self.silent.saturating_add(1) };
        let silent = seen.armed && self.silent >= b.command_timeout;
        Conditions::NONE
            .with(Condition::PitchJump, jumped.pitch)
            .with(Condition::YawJump, jumped.yaw)
            .with(Condition::PitchMotion, seen.armed && self.disagrees.pitch)
            .with(Condition::YawMotion, seen.armed && self.disagrees.yaw)
            .with(Condition::AngleEnvelope, steep)
            .with(Condition::RateEnvelope, fast.pitch || fast.yaw)
            .with(Condition::NonFinite, !sum.is_finite())
            .with(Condition::SupplyRange, self.supply.over(outside, SUPPLY_TICKS))
            .with(Condition::CurrentLimit, self.current.over(seen.current_limit, CURRENT_TICKS))
            .with(Condition::CommandTimeout, silent)
    }
}

/// How long something has been so without a break.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Persistence {
    ticks: u32,
}

impl Persistence {
    /// Takes this tick's `now`; true from the `limit`th in a row on.
    #[inline(always)]
    fn over(&mut self, now: bool, limit: u32) -> bool {
        self.ticks = if now { self.ticks.saturating_add(1) } else { 0 };
        self.ticks >= limit
    }
}

/// Compares the rate that the voltages should have given with the rate that was seen, both through the same two wash-outs.
///
/// With the model's acceleration a, pushed = a T/(s T + 1); with the estimated rate v, shown = v s T/(s T + 1). For a true
/// model the two are the same. A second wash-out s L/(s L + 1) takes out what lasts: a wrong weight, a hand, a disturbance. A stuck encoder shows nothing, one with its sign swapped the opposite. A rig that rests
/// nose down lies on a stop which the model does not know: there, a push further down counts as none.
///
/// The model is linearised about the horizontal: what that gets wrong lasts, and is washed out as well.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Motion {
    /// \[N m\] m g L.
    weight: f32,
    /// \[N m/rad\]
    stiffness: f32,
    /// \[N m s/rad\]
    damping: PerAxis<f32>,
    /// \[1/(kg m²)\]
    inverse_inertia: PerAxis<f32>,
    linear: Effectiveness<f32>,
    quadratic: Effectiveness<f32>,
    /// \[N m/V\] On the other axis, for each volt that a rotor has yet to follow.
    reaction: PerMotor<f32>,
    rotor_decay: PerMotor<f32>,
    /// Wash-out for one tick.
    keep: f32,
    keep_load: f32,
    /// \[s\] From one comparison to the next.
    step: f32,
    /// \[rad\] Below this pitch the rig may lie on its stop.
    stop: f32,
    /// \[rad/s\] From where on a push counts.
    least: PerAxis<f32>,
    rotor_volts: PerMotor<f32>,
    slow_rate: PerAxis<f32>,
    pushed: PerAxis<f32>,
    pushed_load: Load,
    shown_load: Load,
    disagreement: PerAxis<Persistence>,
}

impl Motion {
    fn new(parameters: &Parameters) -> Self {
        let s = &parameters.settings;
        #[expect(clippy::cast_precision_loss, reason = "a small whole number")]
        let step = s.sample_time * MOTION_EVERY as f32;
        let k = &s.effectiveness;
        let reach = k.map(f32::abs).torque(s.volts_limit);
        let moment = s.model.mass * s.model.center_of_mass;
        let inertia = s.model.inertia.map(|i| i + moment * s.model.center_of_mass);
        let pitch = &parameters.encoders.pitch;
        let tau = s.model.rotor_time_constant;
        let decay = |tau: f32| if tau > 0.0 { Real::max(bilinear_decay(step / tau), 0.0) } else { 0.0 };
        let least = reach.zip(inertia, |torque, inertia| MOTION_PUSH * MOTION_WINDOW * torque / inertia);
        Self {
            weight: moment * s.model.gravity,
            stiffness: s.model.stiffness,
            damping: s.model.damping,
            inverse_inertia: inertia.map(|i| 1.0 / i),
            linear: s.model.effectiveness,
            quadratic: s.model.quadratic_effectiveness,
            reaction: s.model.rotor_reaction.zip(tau, |r, tau| if tau > 0.0 { r / tau } else { 0.0 }),
            rotor_decay: tau.map(decay),
            keep: bilinear_decay(step / MOTION_WINDOW),
            keep_load: bilinear_decay(step / LOAD_WINDOW),
            step,
            stop: if pitch.rest_counts < 0 {
                f32::from_i32(pitch.rest_counts) * pitch.angle_per_count + STOP_MARGIN
            } else {
                f32::NEG_INFINITY
            },
            least: least.zip(s.model.coulomb_friction.zip(inertia, |f, i| f / i), |least, friction| {
                least + MOTION_WINDOW * friction
            }),
            rotor_volts: PerMotor::zero(),
            slow_rate: PerAxis::zero(),
            pushed: PerAxis::zero(),
            pushed_load: Load::default(),
            shown_load: Load::default(),
            disagreement: PerAxis::both(Persistence::default()),
        }
    }

    fn restart(&mut self) {
        self.rotor_volts = PerMotor::zero();
        self.pushed = PerAxis::zero();
        self.pushed_load = Load::default();
        self.shown_load = Load::default();
        self.disagreement = PerAxis::both(Persistence::default());
    }

    #[inline(always)]
    fn disagrees(&mut self, seen: &Seen<'_>) -> PerAxis<bool> {
        let state = &seen.estimate.state;
        let rate = state.rate;
        let missing = self.rotor_volts.minus(seen.applied);
        self.rotor_volts = seen.applied.plus(missing.zip(self.rotor_decay, |m, d| m * d));
        let (acting, behind) = (self.rotor_volts, seen.applied.minus(self.rotor_volts));
        let reaction = PerAxis::new(self.reaction.tail * behind.tail, self.reaction.main * behind.main);
        let thrust = self.linear.torque(acting).plus(self.quadratic.torque(acting.map(|v| v * v.abs())));
        let torque = thrust.plus(reaction);
        let drag = self.damping.zip(rate, |d, v| d * v);
        let pull = PerAxis::new(self.weight + self.stiffness * state.angle.pitch, 0.0);
        let mut accel = torque.minus(drag).minus(pull).zip(self.inverse_inertia, |t, i| t * i);
        if state.angle.pitch < self.stop && accel.pitch < 0.0 {
            accel.pitch = 0.0;
        }
        self.slow_rate = rate.plus(self.slow_rate.minus(rate).scaled(self.keep));
        self.pushed = self.pushed.scaled(self.keep).plus(accel.scaled(self.step));
        let pushed = self.pushed_load.wash_out(self.pushed, self.keep_load);
        let shown = self.shown_load.wash_out(rate.minus(self.slow_rate), self.keep_load);
        PerAxis {
            pitch: self
                .disagreement
                .pitch
                .over(contradicts(pushed.pitch, shown.pitch, self.least.pitch), MOTION_TICKS / MOTION_EVERY),
            yaw: self
                .disagreement
                .yaw
                .over(contradicts(pushed.yaw, shown.yaw, self.least.yaw), MOTION_TICKS / MOTION_EVERY),
        }
    }
}

/// What of a motion lasts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Load(PerAxis<f32>);

impl Load {
    /// `motion` without it.
    #[inline(always)]
    fn wash_out(&mut self, motion: PerAxis<f32>, keep: f32) -> PerAxis<f32> {
        self.0 = motion.plus(self.0.minus(motion).scaled(keep));
        motion.minus(self.0)
    }
}

/// A push over `least`, and less than its due share of motion in its direction.
#[inline(always)]
fn contradicts(pushed: f32, shown: f32, least: f32) -> bool {
    let (push, along) = if pushed < 0.0 { (-pushed, -shown) } else { (pushed, shown) };
    push > least && along < MOTION_SHARE * push
}
