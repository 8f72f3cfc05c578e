//! Conditional integration: the anti-windup of every law here that integrates.

use crate::real::Real;

/// `sum` after one tick: `increment` is added unless a voltage clipped and it would take the sum further from
/// zero.
///
/// An integral that grows while the motors give all they have means nothing, and has to be worked off as
/// overshoot.
#[inline(always)]
pub(super) fn integrated<R: Real>(sum: R, increment: R, clipped: R::Mask) -> R {
    let discharging = (sum * increment).lt(R::zero());
    sum + R::select(clipped & !discharging, R::zero(), increment)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipped_it_may_only_fall() {
        assert_eq!(integrated(1.0, 0.1, false), 1.1);
        assert_eq!(integrated(1.0, 0.1, true), 1.0);
        assert_eq!(integrated(1.0, -0.1, true), 0.9);
        assert_eq!(integrated(-1.0, 0.1, true), -0.9);
    }
}
