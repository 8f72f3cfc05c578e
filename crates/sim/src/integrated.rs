//! A flight of which the integral of the error counts, tick by tick: one copy for the lanes of the tuner and
//! for a GPU's threads, over any [`Real`] in single precision.

use crate::closed_loop::ClosedLoop;
use crate::metrics::{Criterion, Integral};
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::real::Real;
use twinrotor::reference::Reference;

/// A cost must exceed its bound by this part before a flight is broken off. A compensated sum of terms that
/// are not negative can sink by a few units in its last place, 1e-7 of it, and not more.
const SURELY: f64 = 1.0 + 1e-6;
/// \[ticks\] From one look at the sums to the next.
pub const LOOK_EVERY: u32 = 64;

/// The cost so far in a lane: both axes' integrals.
#[inline(always)]
pub fn cost<R: Real>(integral: &Integral<R>, lane: usize) -> f64 {
    let PerAxis { pitch, yaw } = integral.value(lane, SAMPLE_TIME);
    pitch + yaw
}

/// Is it sure to be above `bound` in the end, by a look in this tick?
#[inline(always)]
pub fn has_lost<R: Real>(integral: &Integral<R>, lane: usize, bound: f64) -> bool {
    cost(integral, lane) > bound * SURELY
}

/// Is this a tick to look at the sums in?
#[inline(always)]
pub fn is_look(tick: u32) -> bool {
    tick % LOOK_EVERY == LOOK_EVERY - 1
}

/// Flies `ticks` ticks, or until `goes_on` says no after one, and how many there were. `happens` does to the
/// loop what befalls it in a tick, and gives what is asked for and the disturbance \[V\].
#[inline(always)]
pub fn integrate<R: Real<Scalar = f32>, L: ClosedLoop<R>>(
    mut closed_loop: L,
    criterion: Criterion,
    ticks: u32,
    mut happens: impl FnMut(u32, &mut L) -> (Reference<f32>, PerMotor<R>),
    mut goes_on: impl FnMut(u32, &Integral<R>) -> bool,
) -> (Integral<R>, u32) {
    let mut integral = Integral::<R>::new(criterion);
    let last = ticks.saturating_sub(1);
    for tick in 0..ticks {
        let (reference, volts) = happens(tick, &mut closed_loop);
        let happened = closed_loop.tick(&Reference::splat(&reference), volts);
        integral.add(tick, last, happened.error());
        if !goes_on(tick, &integral) {
            return (integral, tick + 1);
        }
    }
    (integral, ticks)
}
