//! A law that was designed elsewhere, as matrices: an LQG regulator, an H∞ controller, a PID with filters,
//! whatever a design program calls a state space and samples at the board's tick.
//!
//! In tick k, with inputs u that are chosen by name ([`Signal`]) and volts y beside the trim,
//!
//! y = C x + D u, each |y| at most its saturation,
//! x⁺ = A x + B u + L (given - asked),
//!
//! where the last term is what the motors really got beyond what was asked for: zero unless something clips.
//! With L the input column of an observer's model the observer sees the true volts; with any other L it is
//! back-calculation. Where a file gives no L, the state stays as it is in every tick in which volts clip and
//! the step would ask for more of what could not be given: conditional integration, for any state.
//!
//! With feed-forward, V = y + K⁻¹ (torque of the model at the reference): y is around the equilibrium, as a
//! design that is linearised there means it. Without, y is the volts.

mod gains;
#[cfg(test)]
mod tests;

pub use gains::{MOST_INPUTS, MOST_STATES, Signal, StateSpaceGains};

use super::{ControlLaw, Situation};
use crate::allocation::Allocation;
use crate::axes::{PerAxis, PerMotor};
use crate::plant::{Effectiveness, RigidBody, State};
use crate::real::{Mask, Real};
use crate::reference::Reference;

/// What the law goes by in a tick. A copy: what only this law passes on by its place would have to lie in
/// memory for every law.
struct Seen<'a, R> {
    model: &'a RigidBody<R>,
    measured: PerAxis<R>,
    rate: PerAxis<R>,
    reference: Reference<R>,
}

/// The law at work. What is always used stands first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateSpace<R> {
    effectiveness: Effectiveness<R>,
    /// u of this tick.
    input: [R; MOST_INPUTS],
    /// \[V\] What the law's own saturation took from the outputs in this tick, negative where they were
    /// positive.
    cut: PerMotor<R>,
    /// x.
    state: [R; MOST_STATES],
    gains: StateSpaceGains<R>,
}

/// `from` and a row times a column, in the order of the row, all of it: what a law does not have is zero.
/// (Four at a time, of which there is a whole number in each row: a board's compiler, told to be brief,
/// unrolls nothing by itself.)
#[inline(always)]
fn product<R: Real, const N: usize>(from: R, row: &[R; N], column: &[R; N]) -> R {
    const { assert!(N.is_multiple_of(4)) };
    let (rows, columns) = (row.as_chunks::<4>().0, column.as_chunks::<4>().0);
    rows.iter().zip(columns).fold(
        from,
        #[inline(always)]
        |sum, ([a, b, c, d], [p, q, r, s])| sum + *a * *p + *b * *q + *c * *r + *d * *s,
    )
}

impl<R: Real> StateSpace<R> {
    /// With all states zero. The volts are handed on as the torque that `effectiveness` makes of them.
    pub fn new(gains: StateSpaceGains<R>, effectiveness: Effectiveness<R>) -> Self {
        Self {
            gains,
            effectiveness,
            state: [R::zero(); MOST_STATES],
            input: [R::zero(); MOST_INPUTS],
            cut: PerMotor::zero(),
        }
    }

    /// x, those states that there are.
    pub fn state(&self) -> &[R] {
        self.state.get(..self.gains.order()).unwrap_or_default()
    }

    #[inline(always)]
    fn output(&self, row: &[R; MOST_STATES], through: &[R; MOST_INPUTS]) -> R {
        product(product(R::zero(), row, &self.state), through, &self.input)
    }

    /// (Apart on the board, whose tick has no room for more than the law that flies.)
    #[cfg_attr(target_os = "none", cold, inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn act(&mut self, seen: &Seen<'_, R>) -> PerAxis<R> {
        // Where there are none, none is read, and none takes room.
        if MOST_STATES == 0 {
            return PerAxis::zero();
        }
        for (input, signal) in self.input.iter_mut().zip(self.gains.signals()) {
            *input = signal.of(seen);
        }
        let asked = PerMotor {
            main: self.output(&self.gains.c.main, &self.gains.d.main),
            tail: self.output(&self.gains.c.tail, &self.gains.d.tail),
        };
        let given = asked.zip(
            self.gains.saturation,
            // What is not finite stays so: it must come out as a fault, and never as full volts.
            #[inline(always)]
            |volts, most| R::select(volts.is_finite(), volts.clamp(-most, most), volts),
        );
        self.cut = given.minus(asked);
        let feedback = self.effectiveness.torque(given);
        if self.gains.feed_forward {
            let there = State { angle: seen.reference.angle, rate: seen.reference.rate };
            seen.model.at(&there).torque(seen.reference.accel).plus(feedback)
        } else {
            feedback
        }
    }

    /// A tick further; `missing` \[V\] is what the motors got beyond what was asked for.
    #[cfg_attr(target_os = "none", cold, inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn advance(&mut self, missing: PerMotor<R>) {
        if MOST_STATES == 0 {
            return;
        }
        let order = self.gains.order();
        let mut next = [R::zero(); MOST_STATES];
        for ((next, row), through) in next.iter_mut().zip(&self.gains.a).zip(&self.gains.b).take(order) {
            *next = product(product(R::zero(), row, &self.state), through, &self.input);
        }
        if self.gains.corrected {
            for (next, gain) in next.iter_mut().zip(&self.gains.anti_windup).take(order) {
                *next = *next + (gain.main * missing.main + gain.tail * missing.tail);
            }
            self.state = next;
            return;
        }
        // (Where nothing clips this multiplies by zero: nothing here branches on a number.)
        let mut step = [R::zero(); MOST_STATES];
        for ((step, next), now) in step.iter_mut().zip(&next).zip(&self.state) {
            *step = *next - *now;
        }
        let further = PerMotor {
            main: product(R::zero(), &self.gains.c.main, &step),
            tail: product(R::zero(), &self.gains.c.tail, &step),
        };
        let worse = (further.main * missing.main + further.tail * missing.tail).lt(R::zero());
        for (now, next) in self.state.iter_mut().zip(next) {
            *now = R::select(worse, *now, next);
        }
    }
}

impl<R: Real> ControlLaw<R> for StateSpace<R> {
    type Gains = StateSpaceGains<R>;

    fn start(gains: Self::Gains, effectiveness: Effectiveness<R>, _sample_time: R) -> Self {
        Self::new(gains, effectiveness)
    }

    /// Whether a pole of A is an integral's is not looked for.
    fn integrates(_gains: &Self::Gains) -> R::Mask {
        R::Mask::splat(false)
    }

    #[inline(always)]
    fn torque(&mut self, now: &Situation<'_, R>) -> PerAxis<R> {
        self.act(&Seen {
            model: now.model,
            measured: now.measured,
            rate: now.estimate.state.rate,
            reference: now.reference,
        })
    }

    #[inline(always)]
    fn restart(&mut self) {
        self.state = [R::zero(); MOST_STATES];
        self.input = [R::zero(); MOST_INPUTS];
        self.cut = PerMotor::zero();
    }

    #[inline(always)]
    fn settle(&mut self, _now: &Situation<'_, R>, allocation: &Allocation<R>) {
        self.advance(allocation.volts.minus(allocation.demand).plus(self.cut));
    }
}
