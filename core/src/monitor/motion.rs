//! Whether the encoders show the motion that the voltages should have given.

use super::Observation;
use super::persistence::Persistence;
use crate::axes::{PerAxis, PerMotor};
use crate::estimator::bilinear_decay;
use crate::parameters::Parameters;
use crate::plant::Effectiveness;
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
/// In friction's own size: what a push may change by before a body at rest moves, from one way to the other,
/// and half as much again.
const STICTION: f32 = 3.0;
/// \[ticks\] From when on an encoder counts as still; until then, what pushed it to where it is dies away.
pub const STILL_TICKS: u32 = 240;
/// \[ticks\] From one comparison to the next: motion is slow, a tick's time is dear.
pub const MOTION_EVERY: u32 = 4;
/// \[ticks\] How long the two must disagree.
pub const MOTION_TICKS: u32 = 100;
/// \[rad\] How far above its rest pose a rig that rests nose down may still lie on its stop.
pub const STOP_MARGIN: f32 = 0.05;

/// Compares the rate that the voltages should have given with the rate that was seen, both through the same
/// two wash-outs.
///
/// With the model's acceleration a, pushed = a T/(s T + 1); with the estimated rate v, shown = v s T/(s T +
/// 1). For a true model the two are the same. A second wash-out s L/(s L + 1) takes out what lasts: a wrong
/// weight, a hand, a disturbance. A stuck encoder shows nothing, one with its sign swapped the opposite. A
/// rig that rests nose down lies on a stop which the model does not know: there, a push further down counts
/// as none.
///
/// The model is linearised about the horizontal: what that gets wrong lasts, and is washed out as well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
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
    rotor_volts: PerMotor<f32>,
    slow_rate: PerAxis<f32>,
    pushed: PerAxis<f32>,
    pushed_load: Load,
    shown_load: Load,
    watch: PerAxis<Watch>,
}

impl Motion {
    pub(super) fn new(parameters: &Parameters) -> Self {
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
        let least = |share: f32, stiction: f32| {
            let torque = reach.scaled(share).plus(s.model.coulomb_friction.scaled(stiction));
            torque.zip(inertia, |torque, inertia| MOTION_WINDOW * torque / inertia)
        };
        let (moving, still) = (least(MOTION_PUSH, 1.0), least(STUCK_PUSH, STICTION));
        let watch = |moving: f32, still: f32, angle_per_count: f32| Watch {
            least: moving,
            disagreement: Persistence::default(),
            stillness: Stillness {
                away: 0,
                still: Persistence::default(),
                push: 0.0,
                least: still,
                due: 0.0,
                most: STUCK_COUNTS * angle_per_count,
            },
        };
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
            rotor_volts: PerMotor::zero(),
            slow_rate: PerAxis::zero(),
            pushed: PerAxis::zero(),
            pushed_load: Load::default(),
            shown_load: Load::default(),
            watch: PerAxis {
                pitch: watch(moving.pitch, still.pitch, parameters.encoders.pitch.angle_per_count),
                yaw: watch(moving.yaw, still.yaw, parameters.encoders.yaw.angle_per_count),
            },
        }
    }

    pub(super) fn restart(&mut self) {
        self.rotor_volts = PerMotor::zero();
        self.pushed = PerAxis::zero();
        self.pushed_load = Load::default();
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
    pub(super) fn disagrees(&mut self, observed: &Observation<'_>) -> PerAxis<bool> {
        let state = &observed.estimate.state;
        let rate = state.rate;
        let missing = self.rotor_volts.minus(observed.applied);
        self.rotor_volts = observed.applied.plus(missing.zip(self.rotor_decay, |m, d| m * d));
        let (acting, behind) = (self.rotor_volts, observed.applied.minus(self.rotor_volts));
        let reaction = PerAxis::new(self.reaction.tail * behind.tail, self.reaction.main * behind.main);
        let thrust = self.linear.torque(acting).plus(self.quadratic.torque(acting.map(|v| v * v.abs())));
        let torque = thrust.plus(reaction);
        let drag = self.damping.zip(rate, |d, v| d * v);
        let pull = PerAxis::new(self.weight + self.stiffness * state.angle.pitch, 0.0);
        let mut accel = torque.minus(drag).minus(pull).zip(self.inverse_inertia, |t, i| t * i);
        let lies = state.angle.pitch < self.stop;
        if lies && accel.pitch < 0.0 {
            accel.pitch = 0.0;
        }
        self.slow_rate = rate.plus(self.slow_rate.minus(rate).scaled(self.keep));
        self.pushed = self.pushed.scaled(self.keep).plus(accel.scaled(self.step));
        let push = self.pushed;
        let pushed = self.pushed_load.wash_out(self.pushed, self.keep_load);
        let shown = self.shown_load.wash_out(rate.minus(self.slow_rate), self.keep_load);
        let stuck = PerAxis {
            pitch: self.watch.pitch.stillness.is_stuck(push.pitch, pushed.pitch, lies, self.step),
            yaw: self.watch.yaw.stillness.is_stuck(push.yaw, pushed.yaw, false, self.step),
        };
        PerAxis {
            pitch: self.watch.pitch.contradicts(pushed.pitch, shown.pitch) || stuck.pitch,
            yaw: self.watch.yaw.contradicts(pushed.yaw, shown.yaw) || stuck.yaw,
        }
    }
}

/// What one axis was pushed to do, against what its encoder shows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Watch {
    /// \[rad/s\] From where on a push counts.
    least: f32,
    disagreement: Persistence,
    stillness: Stillness,
}

impl Watch {
    fn restart(self) -> Self {
        let stillness = Stillness { away: 0, still: Persistence::default(), due: 0.0, ..self.stillness };
        Self { disagreement: Persistence::default(), stillness, ..self }
    }

    /// Less than its due share of motion in its direction.
    #[inline(always)]
    fn contradicts(&mut self, pushed: f32, shown: f32) -> bool {
        let (due, along) = if pushed < 0.0 { (-pushed, -shown) } else { (pushed, shown) };
        let contradicts = due > self.least && along < MOTION_SHARE * due;
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
    fn is_stuck(&mut self, push: f32, pushed: f32, lies: bool, step: f32) -> bool {
        let near = self.away.unsigned_abs() <= 1;
        if !near {
            self.away = 0;
        }
        if !self.still.over(near && !lies, STILL_TICKS / MOTION_EVERY) {
            self.push = push;
        }
        let change = Real::min((push - self.push).abs(), pushed.abs());
        self.due = if change > self.least { self.due + change * step } else { 0.0 };
        self.due > self.most
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
