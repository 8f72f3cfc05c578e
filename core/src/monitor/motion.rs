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
//! Every T = [`MOTION_EVERY`] ticks; v estimated rate, θ its pitch, V_a volts applied; names as in the
//! code.
//!
//! ```text
//! v           = in pitch its mean over these T: the rate of a loop that hammers may do so in step with them
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
//! With a true model and no disturbance push = shown, and so expected = observed. The body is linearised
//! about the horizontal (cos θ = 1, sin θ = θ, no coupling of the axes): what that gets wrong lasts, and goes
//! with the load. What an axis makes of the two is in `watch.rs`.
//!
//! # What a disturbance may do
//!
//! A loop that holds against a disturbance pushes, and its rig stays where it is: by its volts alone nothing
//! tells it from a stuck encoder. What tells them apart is that a disturbance is bounded. One within ±d
//! \[rad/s²\] parts observed from expected by at most W d ∫|g| dt, whatever its course, where g is the
//! impulse response of both filters, 1/(s W + 1) and s L/(s L + 1): ∫|g| dt is twice the peak of their step
//! response, 1.47. d comes from [`DISTURBANCE_VOLTS`] at each motor, on thrust that may be quadratic, and
//! from friction. A weight and rotors that are late may do more, and are seen to (`against.rs`).

use super::against::{Late, Level};
use super::flight::Seen;
use super::watch::Watch;
use crate::axes::{PerAxis, PerMotor};
use crate::parameters::EncoderScale;
use crate::pipeline::Settings;
use crate::plant::{PlantParameters, RotorTorque, bilinear_decay, follow};
use crate::real::{Count, Mask, Real};
use crate::static_reach::SPARE;

/// \[s\] Time constant over which pushes and motion are compared.
pub const MOTION_WINDOW: f32 = 0.2;
/// \[s\] Time constant after which a push that lasts counts as a load that the model does not know.
pub const LOAD_WINDOW: f32 = 1.5;
/// Share of full voltage's push from which on a motion is expected.
pub const MOTION_PUSH: f32 = 0.2;
/// Share of the expected motion that must be observed. Generous: constants are wrong by 30 %, lags by 100 ms.
pub const MOTION_SHARE: f32 = 0.1;
/// \[V\] Largest disturbance at each motor that the loop is to hold against; where a third of the motor's
/// limit is less, that.
pub const DISTURBANCE_VOLTS: f32 = 5.0;
/// \[-\] Most that a disturbance within ±1 parts the two by: ∫|g| dt = 1.467, and 8 % for the estimated rate.
const DISTURBANCE_PEAK: f32 = 1.584;
/// \[-\] The same for a weight that comes or goes once, for the part of the thrust that can hold it. By the
/// filters alone .733, which is .587 for a weight of 80 % of the most; some more for the estimated rate.
const WEIGHT_PEAK: f32 = 0.62;
/// How many times as slow as believed rotors may be, while an axis moves against them.
pub const LATE: f32 = 3.0;
/// \[rad\] How far from where it lately was the nose has been moved, when it has.
pub const DRIFT: f32 = 0.01;
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
pub const MOTION_TICKS: u32 = 40;
/// \[ticks\] While the axis moves against its motors: as one swings until slow rotors have caught it.
pub const AGAINST_TICKS: u32 = 100;
/// \[rad\] How far above its rest pose a rig that rests nose down may still lie on its stop.
pub const STOP_MARGIN: f32 = 0.05;

/// The comparison's constants and memory; [`FlightRules`](super::FlightRules) looks at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<R: Real> {
    body: LinearBody<R>,
    /// Reaction goes with the volts that a rotor has yet to follow.
    rotors: RotorTorque<R>,
    rotor_decay: PerMotor<R>,
    keep: R,
    keep_load: R,
    /// \[s\] From one comparison to the next.
    step: R,
    /// \[rad\] Below this pitch the rig may lie on its stop.
    stop: R,
    /// \[rad/s\] Sum of the pitch rates since the last comparison.
    pitch_rates: R,
    /// \[V\] In effect.
    volts: PerMotor<R>,
    slow_rate: PerAxis<R>,
    push: PerAxis<R>,
    push_load: Load<R>,
    shown_load: Load<R>,
    late: Late<R>,
    level: Level<R>,
    watch: PerAxis<Watch<R>>,
}

impl<R: Real<Scalar = f32>> Motion<R> {
    pub(super) fn new(s: &Settings<R>, encoders: &PerAxis<EncoderScale>) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "a small whole number")]
        let step = s.sample_time * R::splat(MOTION_EVERY as f32);
        let reach = s.effectiveness.map(R::abs).torque(s.volts_limit);
        let inertia = inertia(&s.model);
        let rate = |torque: R, inertia: R| R::splat(MOTION_WINDOW) * torque / inertia;
        let least = |share: f32, stiction: f32| {
            let friction = s.model.coulomb_friction.scaled(R::splat(stiction));
            reach.scaled(R::splat(share)).plus(friction).zip(inertia, rate)
        };
        let (moving, changed) = (least(MOTION_PUSH, 1.0), least(STUCK_PUSH, STICTION));
        let disturbed = disturbance(s);
        let weight = rate(weight(s, reach.pitch).max(disturbed.pitch), inertia.pitch);
        let disturbed = disturbed.zip(inertia, rate);
        let most = encoders.map(|encoder| R::splat(STUCK_COUNTS * encoder.angle_per_count));
        let tau = s.model.rotor_time_constant;
        let if_lagging = |tau: R, x: R| R::select(R::zero().lt(tau), x, R::zero());
        let decay = |tau: R| if_lagging(tau, bilinear_decay(step / tau).max(R::zero()));
        let slow_decay = decay(R::splat(LATE) * tau.main.max(tau.tail));
        let reaction = s.model.rotor_reaction.zip(tau, |r, tau| if_lagging(tau, r / tau));
        let pitch = &encoders.pitch;
        Self {
            body: LinearBody::new(&s.model),
            rotors: RotorTorque::new(&s.model, reaction),
            rotor_decay: tau.map(decay),
            keep: bilinear_decay(step / R::splat(MOTION_WINDOW)),
            keep_load: bilinear_decay(step / R::splat(LOAD_WINDOW)),
            step,
            stop: R::splat(if pitch.rest_counts < 0 {
                f32::from_i32(pitch.rest_counts) * pitch.angle_per_count + STOP_MARGIN
            } else {
                f32::NEG_INFINITY
            }),
            pitch_rates: R::zero(),
            volts: PerMotor::zero(),
            slow_rate: PerAxis::zero(),
            push: PerAxis::zero(),
            push_load: Load::zero(),
            shown_load: Load::zero(),
            late: Late::new(slow_decay, step, inertia),
            level: Level::new(weight),
            watch: PerAxis {
                pitch: Watch::new(moving.pitch, disturbed.pitch, changed.pitch, most.pitch),
                yaw: Watch::new(moving.yaw, disturbed.yaw, changed.yaw, most.yaw),
            },
        }
    }

    pub(super) fn restart(&mut self, pitch: R) {
        self.pitch_rates = R::zero();
        self.volts = PerMotor::zero();
        self.slow_rate = PerAxis::zero();
        self.push = PerAxis::zero();
        self.push_load = Load::zero();
        self.shown_load = Load::zero();
        self.late.restart();
        self.level.restart(pitch);
        self.watch = self.watch.map(Watch::restart);
    }

    /// Of every tick.
    #[inline(always)]
    pub(super) fn moved(&mut self, counts: PerAxis<R::Count>) {
        let (pitch, yaw) = (&mut self.watch.pitch.stillness.away, &mut self.watch.yaw.stillness.away);
        *pitch = pitch.plus(counts.pitch);
        *yaw = yaw.plus(counts.yaw);
    }

    /// Of every tick in flight.
    #[inline(always)]
    pub(super) fn turned(&mut self, pitch_rate: R) {
        self.pitch_rates = self.pitch_rates + pitch_rate;
    }

    /// Of every [`MOTION_EVERY`]th.
    #[inline(always)]
    pub(super) fn disagrees(&mut self, seen: &Seen<R>) -> PerAxis<R::Mask> {
        let Seen { angle, applied, .. } = *seen;
        #[expect(clippy::cast_precision_loss, reason = "a small whole number")]
        let share = R::splat(1.0 / MOTION_EVERY as f32);
        let rate = PerAxis::new(self.pitch_rates * share, seen.rate.yaw);
        self.pitch_rates = R::zero();
        self.volts = follow(self.volts, applied, self.rotor_decay);
        let torque = self.rotors.torque(self.volts, applied.minus(self.volts));
        let late = self.late.step(torque, self.keep);
        let drift = self.level.step(angle.pitch, self.keep_load);
        let mut accel = self.body.accel(torque, angle.pitch, rate);
        let lies = angle.pitch.lt(self.stop);
        if lies.any() {
            accel.pitch = R::select(lies & accel.pitch.lt(R::zero()), R::zero(), accel.pitch);
        }
        self.push = self.push.scaled(self.keep).plus(accel.scaled(self.step));
        self.slow_rate = rate.plus(self.slow_rate.minus(rate).scaled(self.keep));
        let push = self.push;
        let expected = self.push_load.wash_out(push, self.keep_load);
        let observed = self.shown_load.wash_out(rate.minus(self.slow_rate), self.keep_load);
        let wanted = seen.wanted.zip(angle, |wanted, angle| (wanted, angle));
        let (pitch, yaw) = (&mut self.watch.pitch, &mut self.watch.yaw);
        let nowhere = R::Mask::splat(false);
        let stuck = PerAxis {
            pitch: pitch.stillness.is_stuck(push.pitch, expected.pitch, wanted.pitch, lies, self.step),
            yaw: yaw.stillness.is_stuck(push.yaw, expected.yaw, wanted.yaw, nowhere, self.step),
        };
        let level = &self.level;
        let pitch_contradicts = pitch.contradicts(
            expected.pitch,
            observed.pitch,
            rate.pitch,
            late.pitch,
            #[inline(always)]
            |disturbed, down, moves| level.explains(disturbed, R::select(down, -drift, drift), moves),
        );
        let yaw_contradicts = yaw.contradicts(
            expected.yaw,
            observed.yaw,
            rate.yaw,
            late.yaw,
            #[inline(always)]
            |disturbed, _, _| disturbed,
        );
        PerAxis { pitch: pitch_contradicts | stuck.pitch, yaw: yaw_contradicts | stuck.yaw }
    }
}

/// The body, linearised about the horizontal.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LinearBody<R> {
    /// \[N m\] m g L.
    weight: R,
    /// \[N m/rad\] K_sp.
    stiffness: R,
    /// \[N m s/rad\]
    damping: PerAxis<R>,
    /// \[1/(kg m²)\]
    inverse_inertia: PerAxis<R>,
}

impl<R: Real> LinearBody<R> {
    fn new(model: &PlantParameters<R>) -> Self {
        Self {
            weight: model.mass * model.center_of_mass * model.gravity,
            stiffness: model.stiffness,
            damping: model.damping,
            inverse_inertia: inertia(model).map(|i| R::one() / i),
        }
    }

    /// \[rad/s²\] Of `torque` \[N m\], at that pitch \[rad\] and rate \[rad/s\].
    #[inline(always)]
    fn accel(&self, torque: PerAxis<R>, pitch: R, rate: PerAxis<R>) -> PerAxis<R> {
        let drag = self.damping.zip(rate, |d, v| d * v);
        let pull = PerAxis::new(self.weight + self.stiffness * pitch, R::zero());
        torque.minus(drag).minus(pull).zip(self.inverse_inertia, |t, i| t * i)
    }
}

/// \[N m\] What parts observed from expected as far as a disturbance by volts may.
fn disturbance<R: Real<Scalar = f32>>(settings: &Settings<R>) -> PerAxis<R> {
    let model = &settings.model;
    let volts =
        settings.volts_limit.map(|limit| R::splat(DISTURBANCE_VOLTS).min(limit * R::splat(1.0 / 3.0)));
    let linear = model.effectiveness.map(R::abs).torque(volts);
    // Added to half of the limit, where v|v| rises by the limit for each volt.
    let square = volts.zip(settings.volts_limit, |volts, limit| volts * limit);
    let quadratic = model.quadratic_effectiveness.map(R::abs).torque(square);
    linear.plus(quadratic).plus(model.coulomb_friction).scaled(R::splat(DISTURBANCE_PEAK))
}

/// \[N m\] The same of a weight, with full volts giving a torque of `reach` \[N m\] in pitch.
fn weight<R: Real<Scalar = f32>>(settings: &Settings<R>, reach: R) -> R {
    let model = &settings.model;
    let held = R::splat(1.0 - f32::from_f64(SPARE)) * reach;
    let holds = (held - model.mass * model.gravity * model.center_of_mass).max(R::zero());
    R::splat(WEIGHT_PEAK) * holds
}

/// \[kg m²\] I + m L².
fn inertia<R: Real>(model: &PlantParameters<R>) -> PerAxis<R> {
    let moment = model.mass * model.center_of_mass;
    model.inertia.map(|i| i + moment * model.center_of_mass)
}

/// What of a motion lasts: a first-order low pass.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Load<R>(PerAxis<R>);

impl<R: Real> Load<R> {
    fn zero() -> Self {
        Self(PerAxis::zero())
    }

    /// `motion` without it.
    #[inline(always)]
    fn wash_out(&mut self, motion: PerAxis<R>, keep: R) -> PerAxis<R> {
        self.0 = motion.plus(self.0.minus(motion).scaled(keep));
        motion.minus(self.0)
    }
}
