//! The gains of the backstepping law, and the only place that knows the paper's order k1..k4.
//!
//! With an exact model and no limit, each axis is s² + (μ_a + μ_b) s + (1 + μ_a μ_b) = 0: two poles near the
//! two gains, since the law is computed torque with a PD.
//!
//! ```
//! let twinrotor::gains::AxisGains { position, rate } = twinrotor::gains::PAPER.pitch;
//! let (damping, stiffness) = (position + rate, 1.0 + position * rate);
//! let apart = (damping * damping - 4.0 * stiffness).sqrt();
//! let poles = [(apart - damping) / 2.0, (-apart - damping) / 2.0]; // [1/s]
//! assert!((poles[0] + 4.249).abs() < 1e-3 && (poles[1] + 24.551).abs() < 1e-3, "{poles:?}");
//! ```

use crate::axes::PerAxis;

settings! {
    /// The two gains of one axis. The closed loop has K_p = 1 + position x rate and K_d = position + rate, so
    /// the two may be swapped without changing anything.
    #[derive(Default)]
    pub struct AxisGains<R> at "pitch.", "yaw." {
        /// Of the angle error: μ1 (pitch), μ3 (yaw).
        position: (R) "1/s", (above 0), typical 1.0 to 25.0, default 4.0;
        /// Of the rate error: μ2 (pitch), μ4 (yaw).
        rate: (R) "1/s", (above 0), typical 1.0 to 25.0, default 10.0;
    }
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::LawSettings;

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
                let error = LawSettings::Backstepping(Gains::from_paper_order(order)).validate().unwrap_err();
                assert_eq!(error.field, NAMES[k]);
            }
        }
        assert_eq!(LawSettings::Backstepping(PAPER).validate(), Ok(()));
    }
}
