//! Do the encoders show the motion that the voltages should have given?
//!
//! # Important terms
//!
//! - *push* \[rad/s\]: the rate that the voltages should have given within [`MOTION_WINDOW`], by the model.
//! - *shown rate* \[rad/s\]: the estimated rate, without what is older than [`MOTION_WINDOW`].
//! - *load*: what of either lasts longer than [`LOAD_WINDOW`]: a wrong weight, a hand, a steady disturbance.
//! - *expected* and *observed* \[rad/s\]: push and shown rate without their loads. These are compared.
//! - *still*: an encoder that has not left its neighbouring counts for [`STILL_TICKS`].
//! - *stop*: what a rig that rests nose down lies on. The model does not know it; near it a push further down
//!   counts as none.
//!
//! # Equations
//!
//! Every T = [`MOTION_EVERY`] ticks; v estimated rate, θ its pitch, V_a volts applied; names as in the code.
//!
//! ```text
//! volts      <- V_a + rotor_decay (volts - V_a)               volts in effect
//! accel       = (torque(volts, V_a - volts) - D v - (m g L + K_sp θ, 0)) / I
//! push       <- keep push + T accel                           accel W/(s W + 1), W = MOTION_WINDOW
//! slow_rate  <- v + keep (slow_rate - v)
//! shown       = v - slow_rate                                 v s W/(s W + 1)
//! push_load  <- push + keep_load (push_load - push)
//! expected    = push - push_load                              wash-out s L/(s L + 1), L = LOAD_WINDOW
//! shown_load <- shown + keep_load (shown_load - shown)
//! observed    = shown - shown_load
//! ```
//!
//! With a true model push = shown, and so expected = observed. The body is linearised about the horizontal
//! (cos θ = 1, sin θ = θ, no coupling of the axes): what that gets wrong lasts, and goes with the load. An
//! axis disagrees when one of two rules says so:
//!
//! ```text
//! contradicts: |expected| > least  and  observed sign(expected) < MOTION_SHARE |expected|,
//!              MOTION_TICKS in a row                          a swapped sign, a stuck encoder
//! stuck:       still, and due > most, where                   a stuck encoder while the law holds a pose
//!              change = min(|push - push when it became still|, |expected|)
//!              due   <- due + T change if change > least, else 0
//! ```

use super::Observation;
use super::persistence::Persistence;
use crate::axes::{PerAxis, PerMotor};
use crate::parameters::Parameters;
use crate::plant::{PlantParameters, RotorTorque, bilinear_decay, follow};
use crate::real::Real;

/// \[s\] Time constant over which pushes and motion are compared.
pub const MOTION_WINDOW: f32 = 0.2;
/// \[s\] Time constant after which a push that lasts counts as a load that the model does not know.
pub const LOAD_WINDOW: f32 = 1.0;
/// Share of full voltage's push from which on a motion is expected.
pub const MOTION_PUSH: f32 = 0.2;
/// Share of the expected motion that must be observed. Generous: constants are wrong by 30 %, lags by 100 ms.
pub const MOTION_SHARE: f32 = 0.1;
/// Share of full voltage's push by which it may change while an encoder shows no motion at all.
pub const STUCK_PUSH: f32 = 0.06;
/// \[counts\] How far that should have moved an encoder. Many: lags are longer than believed, constants less.
pub const STUCK_COUNTS: f32 = 20.0;
/// Coulomb frictions by which a push may change before a body at rest must move: 2 from the friction of one
/// direction to that of the other, and half as much again.
const STICTION: f32 = 3.0;
/// \[ticks\] From when on an encoder counts as still; until then, what pushed it to where it is dies away.
pub const STILL_TICKS: u32 = 240;
/// \[ticks\] From one comparison to the next: motion is slow, a tick's time is dear.
pub const MOTION_EVERY: u32 = 4;
/// \[ticks\] How long the two must disagree.
pub const MOTION_TICKS: u32 = 100;
/// \[rad\] How far above its rest pose a rig that rests nose down may still lie on its stop.
pub const STOP_MARGIN: f32 = 0.05;

/// The comparison's constants and memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    body: LinearBody,
    /// Reaction goes with the volts that a rotor has yet to follow.
    rotors: RotorTorque<f32>,
    rotor_decay: PerMotor<f32>,
    keep: f32,
    keep_load: f32,
    /// \[s\] From one comparison to the next.
    step: f32,
    /// \[rad\] Below this pitch the rig may lie on its stop.
    stop: f32,
    /// \[V\] In effect.
    volts: PerMotor<f32>,
    slow_rate: PerAxis<f32>,
    push: PerAxis<f32>,
    push_load: Load,
    shown_load: Load,
    watch: PerAxis<Watch>,
}

impl Motion {
    pub(super) fn new(parameters: &Parameters) -> Self {
        let s = &parameters.settings;
        #[expect(clippy::cast_precision_loss, reason = "a small whole number")]
        let step = s.sample_time * MOTION_EVERY as f32;
        let reach = s.effectiveness.map(f32::abs).torque(s.volts_limit);
        let least = |share: f32, stiction: f32| {
            let torque = reach.scaled(share).plus(s.model.coulomb_friction.scaled(stiction));
            torque.zip(inertia(&s.model), |torque, inertia| MOTION_WINDOW * torque / inertia)
        };
        let (moving, changed) = (least(MOTION_PUSH, 1.0), least(STUCK_PUSH, STICTION));
        let most = parameters.encoders.map(|encoder| STUCK_COUNTS * encoder.angle_per_count);
        let tau = s.model.rotor_time_constant;
        let decay = |tau: f32| if tau > 0.0 { Real::max(bilinear_decay(step / tau), 0.0) } else { 0.0 };
        let reaction = s.model.rotor_reaction.zip(tau, |r, tau| if tau > 0.0 { r / tau } else { 0.0 });
        let pitch = &parameters.encoders.pitch;
        Self {
            body: LinearBody::new(&s.model),
            rotors: RotorTorque::new(&s.model, reaction),
            rotor_decay: tau.map(decay),
            keep: bilinear_decay(step / MOTION_WINDOW),
            keep_load: bilinear_decay(step / LOAD_WINDOW),
            step,
            stop: if pitch.rest_counts < 0 {
                f32::from_i32(pitch.rest_counts) * pitch.angle_per_count + STOP_MARGIN
            } else {
                f32::NEG_INFINITY
            },
            volts: PerMotor::zero(),
            slow_rate: PerAxis::zero(),
            push: PerAxis::zero(),
            push_load: Load::default(),
            shown_load: Load::default(),
            watch: PerAxis {
                pitch: Watch::new(moving.pitch, changed.pitch, most.pitch),
                yaw: Watch::new(moving.yaw, changed.yaw, most.yaw),
            },
        }
    }

    pub(super) fn restart(&mut self) {
        self.volts = PerMotor::zero();
        self.push = PerAxis::zero();
        self.push_load = Load::default();
        self.shown_load = Load::default();
        self.watch = self.watch.map(Watch::restart);
    }

    /// Of every tick.
    #[inline(always)]
    pub(super) fn moved(&mut self, counts: PerAxis<i32>) {
        let away =
            |watch: &mut Watch, counts: i32| watch.stillness.away = watch.stillness.away.wrapping_add(counts);
        away(&mut self.watch.pitch, counts.pitch);
        away(&mut self.watch.yaw, counts.yaw);
    }

    /// Of every [`MOTION_EVERY`]th.
    #[inline(always)]
    pub(super) fn disagrees(&mut self, observation: &Observation) -> PerAxis<bool> {
        let Observation { angle, rate, applied, .. } = *observation;
        self.volts = follow(self.volts, applied, self.rotor_decay);
        let torque = self.rotors.torque(self.volts, applied.minus(self.volts));
        let mut accel = self.body.accel(torque, angle.pitch, rate);
        let lies = angle.pitch < self.stop;
        if lies && accel.pitch < 0.0 {
            accel.pitch = 0.0;
        }
        self.push = self.push.scaled(self.keep).plus(accel.scaled(self.step));
        self.slow_rate = rate.plus(self.slow_rate.minus(rate).scaled(self.keep));
        let push = self.push;
        let expected = self.push_load.wash_out(push, self.keep_load);
        let observed = self.shown_load.wash_out(rate.minus(self.slow_rate), self.keep_load);
        let stuck = PerAxis {
            pitch: self.watch.pitch.stillness.is_stuck(push.pitch, expected.pitch, lies, self.step),
            yaw: self.watch.yaw.stillness.is_stuck(push.yaw, expected.yaw, false, self.step),
        };
        PerAxis {
            pitch: self.watch.pitch.contradicts(expected.pitch, observed.pitch) || stuck.pitch,
            yaw: self.watch.yaw.contradicts(expected.yaw, observed.yaw) || stuck.yaw,
        }
    }
}

/// The body, linearised about the horizontal.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LinearBody {
    /// \[N m\] m g L.
    weight: f32,
    /// \[N m/rad\] K_sp.
    stiffness: f32,
    /// \[N m s/rad\]
    damping: PerAxis<f32>,
    /// \[1/(kg m²)\]
    inverse_inertia: PerAxis<f32>,
}

impl LinearBody {
    fn new(model: &PlantParameters<f32>) -> Self {
        Self {
            weight: model.mass * model.center_of_mass * model.gravity,
            stiffness: model.stiffness,
            damping: model.damping,
            inverse_inertia: inertia(model).map(|i| 1.0 / i),
        }
    }

    /// \[rad/s²\] Of `torque` \[N m\], at that pitch \[rad\] and rate \[rad/s\].
    #[inline(always)]
    fn accel(&self, torque: PerAxis<f32>, pitch: f32, rate: PerAxis<f32>) -> PerAxis<f32> {
        let drag = self.damping.zip(rate, |d, v| d * v);
        let pull = PerAxis::new(self.weight + self.stiffness * pitch, 0.0);
        torque.minus(drag).minus(pull).zip(self.inverse_inertia, |t, i| t * i)
    }
}

/// \[kg m²\] I + m L².
fn inertia(model: &PlantParameters<f32>) -> PerAxis<f32> {
    let moment = model.mass * model.center_of_mass;
    model.inertia.map(|i| i + moment * model.center_of_mass)
}

/// The two rules of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Watch {
    /// \[rad/s\] From where on an expected rate counts.
    least: f32,
    disagreement: Persistence,
    stillness: Stillness,
}

impl Watch {
    fn new(least: f32, least_change: f32, most: f32) -> Self {
        let stillness = Stillness {
            away: 0,
            still: Persistence::default(),
            push: 0.0,
            least: least_change,
            due: 0.0,
            most,
        };
        Self { least, disagreement: Persistence::default(), stillness }
    }

    fn restart(self) -> Self {
        let stillness = Stillness { away: 0, still: Persistence::default(), due: 0.0, ..self.stillness };
        Self { disagreement: Persistence::default(), stillness, ..self }
    }

    /// Less than its share of the expected motion, in its direction.
    #[inline(always)]
    fn contradicts(&mut self, expected: f32, observed: f32) -> bool {
        let (size, along) = if expected < 0.0 { (-expected, -observed) } else { (expected, observed) };
        let contradicts = size > self.least && along < MOTION_SHARE * size;
        self.disagreement.over(contradicts, MOTION_TICKS / MOTION_EVERY)
    }
}

/// An encoder that does not move, and what it should have moved by.
///
/// A load that the model does not know (a weight, a hand, a disturbance) does not change with the push; so a
/// change of the push moves even a loaded axis, and less of it is enough than for a comparison of rates.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stillness {
    /// \[counts\] How far the encoder is from where it has been still.
    away: i32,
    still: Persistence,
    /// \[rad/s\] The push when it became still.
    push: f32,
    /// \[rad/s\] From where on a change of the push counts.
    least: f32,
    /// \[rad\] How far that should have moved the axis.
    due: f32,
    /// \[rad\] When that is too far.
    most: f32,
}

impl Stillness {
    /// True once the axis should have moved too far. `lies`: on its stop, where being still is no wonder.
    #[inline(always)]
    fn is_stuck(&mut self, push: f32, expected: f32, lies: bool, step: f32) -> bool {
        let near = self.away.unsigned_abs() <= 1;
        if !near {
            self.away = 0;
        }
        if !self.still.over(near && !lies, STILL_TICKS / MOTION_EVERY) {
            self.push = push;
        }
        let change = Real::min((push - self.push).abs(), expected.abs());
        self.due = if change > self.least { self.due + change * step } else { 0.0 };
        self.due > self.most
    }
}

/// What of a motion lasts: a first-order low pass.
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
