//! The gains of the backstepping law, and the only place that knows the paper's order k1..k4.

use crate::axes::PerAxis;
use crate::real::Real;
use crate::validate::{Invalid, positive};
use serde::{Deserialize, Serialize};

/// The two gains of one axis. The closed loop has K_p = 1 + position x rate and K_d = position + rate, so the
/// two may be swapped without changing anything.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisGains<R> {
    /// \[1/s\] Of the angle error: μ1 (pitch), μ3 (yaw). Above 0.
    pub position: R,
    /// \[1/s\] Of the rate error: μ2 (pitch), μ4 (yaw). Above 0.
    pub rate: R,
}

/// The four gains of eqs (26)-(27).
pub type Gains<R> = PerAxis<AxisGains<R>>;

/// Table 4 of the paper: 4.2, 24.6, 2.28, 10.8.
pub const PAPER: Gains<f64> =
    Gains { pitch: AxisGains { position: 4.2, rate: 24.6 }, yaw: AxisGains { position: 2.28, rate: 10.8 } };

/// The paper's search space for each gain (Table 2).
pub const PAPER_BOUNDS: [f64; 2] = [1.0, 25.0];

/// Names of the gains in the paper's order.
pub const NAMES: [&str; 4] = ["pitch.position", "pitch.rate", "yaw.position", "yaw.rate"];

impl<R: Copy> Gains<R> {
    /// From the paper's order k1, k2, k3, k4.
    pub fn from_paper_order([k1, k2, k3, k4]: [R; 4]) -> Self {
        let axis = |position, rate| AxisGains { position, rate };
        Self::new(axis(k1, k2), axis(k3, k4))
    }

    /// In the paper's order k1, k2, k3, k4.
    pub fn to_paper_order(self) -> [R; 4] {
        let (p, y) = (self.pitch, self.yaw);
        [p.position, p.rate, y.position, y.rate]
    }

    /// Each gain through `f`.
    pub fn map_gains<U: Copy>(self, f: impl FnMut(R) -> U) -> Gains<U> {
        Gains::from_paper_order(self.to_paper_order().map(f))
    }
}

impl<R: Real<Mask = bool>> Gains<R> {
    /// Every gain finite and above zero, as the law's stability proof asks.
    ///
    /// # Errors
    ///
    /// The first gain that cannot be.
    pub fn validate(&self) -> Result<(), Invalid<R>> {
        NAMES.into_iter().zip(self.to_paper_order()).try_for_each(|(name, value)| positive(name, value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_order_is_pitch_position_pitch_rate_yaw_position_yaw_rate() {
        let g = Gains::from_paper_order([1.0, 2.0, 3.0, 4.0]);
        assert_eq!((g.pitch.position, g.pitch.rate), (1.0, 2.0));
        assert_eq!((g.yaw.position, g.yaw.rate), (3.0, 4.0));
        assert_eq!(g.to_paper_order(), [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn a_bad_gain_is_named() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            for k in 0..4 {
                let mut order = PAPER.to_paper_order();
                order[k] = bad;
                let error = Gains::from_paper_order(order).validate().unwrap_err();
                assert_eq!(error.field, NAMES[k]);
            }
        }
        assert_eq!(PAPER.validate(), Ok(()));
    }
}
