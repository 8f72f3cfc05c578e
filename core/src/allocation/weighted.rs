//! The volts within their bounds that come nearest to the acceleration asked for: a weighted quadratic
//! programme in two unknowns, solved exactly.
//!
//! Minimise f(V) = (w row₁(K)(V - u)/I_p)² + (row₂(K)(V - u)/I_y)² over the box. f is a strictly convex
//! quadratic with its free minimum at the demand u. If u is inside the box it is the solution. Otherwise the
//! solution lies on an edge that u violates: from a point that touches none of those, a step towards u would
//! stay inside and lower f. So of the box's four edges at most two are candidates, the one that the main
//! motor's demand is beyond and the one that the tail motor's is; on each, f is a parabola in the other
//! voltage. The better of the two is taken, without a branch.

use super::VoltsRange;
use crate::axes::{PerAxis, PerMotor};
use crate::plant::Effectiveness;
use crate::real::Real;

/// The programme's constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Weighted<R> {
    /// Half the Hessian of f.
    main_main: R,
    main_tail: R,
    tail_tail: R,
    /// How the best tail voltage moves with the main one, and the other way round.
    tail_by_main: R,
    main_by_tail: R,
}

impl<R: Real> Weighted<R> {
    /// For thrust gains \[N m/V\], inertia \[kg m²\] and w \[-\].
    pub(super) fn new(k: &Effectiveness<R>, inertia: PerAxis<R>, pitch_weight: R) -> Self {
        let pitch = [k.main_on_pitch, k.tail_on_pitch].map(|k| k * pitch_weight / inertia.pitch);
        let yaw = [k.main_on_yaw, k.tail_on_yaw].map(|k| k / inertia.yaw);
        let ([pm, pt], [ym, yt]) = (pitch, yaw);
        let main_main = pm * pm + ym * ym;
        let main_tail = pm * pt + ym * yt;
        let tail_tail = pt * pt + yt * yt;
        Self {
            main_main,
            main_tail,
            tail_tail,
            tail_by_main: main_tail / tail_tail,
            main_by_tail: main_tail / main_main,
        }
    }

    /// f, with the distance from the demand.
    #[inline(always)]
    fn cost(&self, d: PerMotor<R>) -> R {
        let cross = self.main_tail * d.main * d.tail;
        self.main_main * d.main * d.main + (cross + cross) + self.tail_tail * d.tail * d.tail
    }

    #[inline(always)]
    pub(super) fn solve(&self, u: PerMotor<R>, range: &VoltsRange<R>) -> PerMotor<R> {
        let bounded = range.clamp(u);
        // The main motor at its bound (or where it was asked to be), the tail motor making the best of it;
        // and the reverse.
        let off_main = bounded.main - u.main;
        let off_tail = bounded.tail - u.tail;
        let tail = (u.tail - self.tail_by_main * off_main).clamp(range.low.tail, range.high.tail);
        let main = (u.main - self.main_by_tail * off_tail).clamp(range.low.main, range.high.main);
        let one = PerMotor::new(bounded.main, tail);
        let other = PerMotor::new(main, bounded.tail);
        let first_is_better = self.cost(one.minus(u)).le(self.cost(other.minus(u)));
        one.zip(other, |a, b| R::select(first_is_better, a, b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::presets;
    use proptest::prelude::*;

    /// First-order optimality on the box, which for a convex f is optimality: the gradient vanishes in a free
    /// voltage and presses against the bound in a bounded one.
    fn is_optimal(w: &Weighted<f64>, u: PerMotor<f64>, v: PerMotor<f64>, range: &VoltsRange<f64>) -> bool {
        let d = v.minus(u);
        let slope = PerMotor::new(
            w.main_main * d.main + w.main_tail * d.tail,
            w.main_tail * d.main + w.tail_tail * d.tail,
        );
        let scale = w.cost(PerMotor::both(1.0)) + w.main_main + w.tail_tail;
        let fits = |slope: f64, v: f64, low: f64, high: f64| {
            let tolerance = 1e-9 * scale * (1.0 + u.main.abs() + u.tail.abs());
            (low..=high).contains(&v)
                && (slope.abs() <= tolerance
                    || (v == low && slope >= -tolerance)
                    || (v == high && slope <= tolerance))
        };
        fits(slope.main, v.main, range.low.main, range.high.main)
            && fits(slope.tail, v.tail, range.low.tail, range.high.tail)
    }

    proptest! {
        #[test]
        fn the_solution_is_optimal(
            main in -200.0..200.0, tail in -200.0..200.0, weight in 0.1..10.0,
            low in prop::array::uniform2(-24.0..0.0), high in prop::array::uniform2(0.0..24.0),
        ) {
            let [low, high] = [low, high].map(|[main, tail]| PerMotor::new(main, tail));
            let range = VoltsRange { low, high };
            let u = PerMotor::new(main, tail);
            for (_, rig) in presets::ALL {
                let k = rig.plant.effectiveness_at(rig.nominal_volts);
                let w = Weighted::new(&k, rig.plant.inertia, weight);
                let v = w.solve(u, &range);
                prop_assert!(is_optimal(&w, u, v, &range), "{u:?} {v:?} {range:?}");
            }
        }

        #[test]
        fn what_is_possible_is_given_as_asked(main in -23.9..23.9, tail in -23.9..23.9) {
            let range = VoltsRange { low: PerMotor::both(-24.0), high: PerMotor::both(24.0) };
            let u = PerMotor::new(main, tail);
            let w = Weighted::new(&presets::PAPER.plant.effectiveness, presets::PAPER.plant.inertia, 1.3);
            prop_assert_eq!(w.solve(u, &range), u);
        }
    }
}
