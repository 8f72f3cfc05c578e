//! Direction-preserving limiting: what is asked for beyond the volts that hold the pose is scaled down as a
//! whole, so that the axes keep their share.

use super::VoltsRange;
use crate::axes::PerMotor;
use crate::real::Real;

/// The largest s of 0 to 1 for which h + s (u - h) is within bounds, with the hold volts h first brought
/// within them.
#[inline(always)]
pub(super) fn scaled<R: Real>(demand: PerMotor<R>, hold: PerMotor<R>, range: &VoltsRange<R>) -> PerMotor<R> {
    let hold = range.clamp(hold);
    let beyond = demand.minus(hold);
    let main = share(beyond.main, hold.main, range.low.main, range.high.main);
    let tail = share(beyond.tail, hold.tail, range.low.tail, range.high.tail);
    // Clamped once more for the last bit of rounding.
    range.clamp(hold.plus(beyond.scaled(main.min(tail))))
}

/// How much of `beyond` there is room for, 0 to 1.
#[inline(always)]
fn share<R: Real>(beyond: R, hold: R, low: R, high: R) -> R {
    let room = R::select(beyond.lt(R::zero()), low - hold, high - hold);
    // At most as much as asked for: then room/beyond is at least 1 or not a number, and 1 is taken.
    let enough = beyond.abs().le(room.abs());
    R::select(enough, R::one(), room / beyond)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_direction_from_hold_is_kept_and_a_bound_is_reached(
            demand in prop::array::uniform2(-100.0..100.0), hold in prop::array::uniform2(-20.0..20.0),
        ) {
            let range = VoltsRange { low: PerMotor::both(-24.0), high: PerMotor::both(24.0) };
            let (u, h) = (PerMotor::new(demand[0], demand[1]), PerMotor::new(hold[0], hold[1]));
            let v = scaled(u, h, &range);
            let (asked, given) = (u.minus(h), v.minus(h));
            prop_assert!((asked.main * given.tail - asked.tail * given.main).abs() < 1e-9 * 1e4);
            let inside = u.main.abs() <= 24.0 && u.tail.abs() <= 24.0;
            if inside {
                prop_assert!(v.minus(u).main.abs() < 1e-12 && v.minus(u).tail.abs() < 1e-12);
            } else {
                prop_assert!((v.main.abs().max(v.tail.abs()) - 24.0).abs() < 1e-9);
            }
        }
    }
}
