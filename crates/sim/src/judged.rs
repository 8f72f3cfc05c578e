//! A flight of the robust objective, tick by tick: what is asked for, what befalls it, and the sums that it
//! is judged by.
//!
//! One copy for the lanes of the tuner and for a GPU's threads, over any [`Real`] in single precision.

use crate::closed_loop::{ClosedLoop, RigLoop, Tick};
use crate::guard::Guard;
use core::borrow::BorrowMut;
use serde::{Deserialize, Serialize};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::monitor::Motion;
use twinrotor::plant::presets::Envelope;
use twinrotor::real::{Mask, Real};
use twinrotor::reference::Reference;
use twinrotor::supervisor::Condition;

use crate::metrics::{Overshoot, Settling};

/// \[rad\] An error beyond which a flight has diverged: a turn.
const DIVERGED: f64 = core::f64::consts::TAU;
/// \[ticks\] The second before the disturbance, in which holding is judged.
pub const HOLD: u32 = 1000;
/// Share of the heat of the continuous current with which motors are hot.
pub const HOT: f64 = 0.9;

/// What happens in a flight, asked tick by tick from 0 on.
pub trait Course {
    /// What is asked for from this tick on, where that changes.
    fn asked(&mut self, tick: u32) -> Option<Reference<f32>>;

    /// \[-\] What pushes in this tick, in parts of the plant's disturbance; `None` for nothing.
    fn push(&mut self, tick: u32) -> Option<f32>;
}

/// What a flight is judged by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// \[rad\] Where to.
    pub goal: PerAxis<f64>,
    /// Where the rig may be.
    pub envelope: Envelope,
    /// \[ticks\] From here on errors are summed as those after a disturbance.
    pub disturbance: u32,
    /// The first tick after the flight.
    pub end: u32,
    /// With hot motors from the second tick on; the board arms in the first.
    pub hot: bool,
}

/// [`Rules`] as ticks compare with them: the same numbers in every lane, and in every thread of a GPU.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// \[rad\] Where to.
    goal: PerAxis<f32>,
    /// 1 for a goal that lies upwards, -1 for one downwards.
    direction: PerAxis<f32>,
    /// \[rad\] 2 % and 5 % of the goal.
    band_2: PerAxis<f32>,
    band_5: PerAxis<f32>,
    /// \[rad\], \[rad/s\] The envelope.
    pitch: f32,
    rate: PerAxis<f32>,
    disturbance: u32,
    end: u32,
    hot: bool,
}

impl Rules {
    /// What ticks compare with.
    pub fn bounds(&self) -> Bounds {
        let band = |part: f64| self.goal.map(|g| f32::from_f64(part * g.abs()));
        Bounds {
            goal: self.goal.cast(),
            direction: self.goal.map(|g| f32::from_f64(g.signum())),
            band_2: band(0.02),
            band_5: band(0.05),
            pitch: f32::from_f64(self.envelope.pitch),
            rate: self.envelope.rate.cast(),
            disturbance: self.disturbance,
            end: self.end,
            hot: self.hot,
        }
    }
}

/// The sums of a flight in every lane.
#[derive(Debug, Clone, Copy)]
pub struct Sums<R: Real, M = Motion<R>> {
    settling_2: PerAxis<Settling<R>>,
    overshoot: PerAxis<Overshoot<R>>,
    hold_squares: PerAxis<R>,
    disturbed_squares: PerAxis<R>,
    variation: R,
    saturated: R,
    outside_5: R::Mask,
    left_envelope: R::Mask,
    diverged: R::Mask,
    volts: PerMotor<R>,
    guard: Guard<R, M>,
}

/// The sums of one flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flown {
    /// Into 2 % of the goal before the disturbance.
    pub settling_2: PerAxis<Settling<f32>>,
    /// \[rad\] Most beyond the goal before the disturbance.
    pub overshoot: PerAxis<f32>,
    /// \[rad²\] Squared errors in the [`HOLD`] ticks before the disturbance.
    pub hold_squares: PerAxis<f32>,
    /// \[rad²\] Squared errors from the disturbance on.
    pub disturbed_squares: PerAxis<f32>,
    /// \[V\] By which the motors' volts changed while holding.
    pub variation: f32,
    /// \[ticks\] With more asked of a motor than its limit.
    pub saturated: f32,
    /// Beyond 5 % of the goal in the last tick before the disturbance.
    pub outside_5: bool,
    /// It left its envelope.
    pub left_envelope: bool,
    /// More than a turn astray, or an angle not finite.
    pub diverged: bool,
    /// Where a board would have ended it.
    pub ended: Option<Ended>,
}

impl<R: Real<Scalar = f32>, M: BorrowMut<Motion<R>>> Sums<R, M> {
    fn new(bounds: &Bounds, guard: Guard<R, M>) -> Self {
        let zero = PerAxis::both(R::zero());
        let none = R::Mask::splat(false);
        Self {
            settling_2: PerAxis::splat(bounds.band_2).map(Settling::new),
            overshoot: PerAxis::splat(bounds.direction).map(Overshoot::towards),
            hold_squares: zero,
            disturbed_squares: zero,
            variation: R::zero(),
            saturated: R::zero(),
            outside_5: none,
            left_envelope: none,
            diverged: none,
            volts: PerMotor::zero(),
            guard,
        }
    }

    /// Those of the flight in this lane.
    pub fn lane(&self, lane: usize) -> Flown {
        let of = |x: R| x.lane(lane);
        Flown {
            settling_2: self.settling_2.map(|settling| settling.lane(lane)),
            overshoot: self.overshoot.map(|overshoot| of(overshoot.most)),
            hold_squares: self.hold_squares.map(of),
            disturbed_squares: self.disturbed_squares.map(of),
            variation: of(self.variation),
            saturated: of(self.saturated),
            outside_5: self.outside_5.lane(lane),
            left_envelope: self.left_envelope.lane(lane),
            diverged: self.diverged.lane(lane),
            ended: self.guard.ended(lane),
        }
    }
}

/// Flies to the end, unless `watch`, which is shown every tick, says that nobody waits for it. The motors'
/// `limit` \[V\] is what the controller knows, `disturbance` \[V\] what the course's pushes are parts of;
/// `guard` says what a board would have made of it.
#[inline(always)]
pub fn fly<R: Real<Scalar = f32>, M: BorrowMut<Motion<R>>>(
    mut closed_loop: RigLoop<R>,
    guard: Guard<R, M>,
    limit: PerMotor<R>,
    disturbance: PerMotor<R>,
    bounds: &Bounds,
    mut course: impl Course,
    mut watch: impl FnMut(u32, &Tick<R>) -> bool,
) -> Option<Sums<R, M>> {
    let mut reference = Reference::at_rest(PerAxis::splat(bounds.goal));
    let band_5: PerAxis<R> = PerAxis::splat(bounds.band_5);
    let mut s = Sums::new(bounds, guard);
    for tick in 0..bounds.end {
        if let Some(asked) = course.asked(tick) {
            reference = Reference::splat(&asked);
        }
        let push = match course.push(tick) {
            Some(part) => disturbance.scaled(R::splat(part)),
            None => PerMotor::zero(),
        };
        if bounds.hot && tick == 1 {
            closed_loop.warm(R::from_f64(HOT));
        }
        let disturbed = tick >= bounds.disturbance;
        let happened = hidden(&mut closed_loop).tick(&reference, push);
        if !watch(tick, &happened) {
            return None;
        }
        s.guard.see(tick, &happened);
        let error = happened.error();
        let square = error.map(|e| e * e);
        if disturbed {
            s.disturbed_squares = s.disturbed_squares.plus(square);
        } else {
            let now = R::from_f64(f64::from(tick));
            s.settling_2.pitch.add(now, error.pitch.abs());
            s.settling_2.yaw.add(now, error.yaw.abs());
            s.overshoot.pitch.add(error.pitch);
            s.overshoot.yaw.add(error.yaw);
            let outside = error.zip(band_5, |e, band| band.lt(e.abs()));
            s.outside_5 = outside.pitch | outside.yaw;
            if tick + HOLD >= bounds.disturbance {
                s.hold_squares = s.hold_squares.plus(square);
                let change = happened.applied.zip(s.volts, |v, before| (v - before).abs());
                s.variation = s.variation + (change.main + change.tail);
            }
        }
        s.volts = happened.applied;
        let over = happened.decision.allocation.saturated(limit);
        s.saturated = s.saturated + R::select(over.main | over.tail, R::one(), R::zero());
        let state = &happened.state;
        let far = |e: R| !e.abs().lt(R::from_f64(DIVERGED));
        s.diverged = s.diverged | far(error.pitch) | far(error.yaw);
        let beyond = |x: R, most: f32| R::splat(most).lt(x.abs());
        s.left_envelope = s.left_envelope
            | beyond(state.angle.pitch, bounds.pitch)
            | beyond(state.rate.pitch, bounds.rate.pitch)
            | beyond(state.rate.yaw, bounds.rate.yaw);
    }
    Some(s)
}

/// A flight that the board ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ended {
    /// In which tick.
    pub tick: u32,
    /// What the motors were cut for.
    pub condition: Condition,
}

/// Hidden from the optimiser: it would compile the loop once for every combination of laws, estimators and
/// allocations. On a GPU, where what is hidden would not stay in registers, it is not.
#[inline(always)]
fn hidden<T>(of: &mut T) -> &mut T {
    #[cfg(target_arch = "nvptx64")]
    {
        of
    }
    #[cfg(not(target_arch = "nvptx64"))]
    {
        core::hint::black_box(of)
    }
}
