//! Limits that a tuned controller must keep besides costing little: no more overshoot than this, no later
//! than that.

use super::Row;
use twinrotor_sim::error::{Error, Outcome, at_least, known_name};

type Number = fn(&Row) -> f64;

/// At most this much of one of the numbers by which controllers are compared.
#[derive(Debug, Clone, Copy)]
pub struct Limit {
    number: Number,
    most: f64,
}

/// The numbers that can be limited, as `compare --json` spells them, in its units.
const NUMBERS: [(&str, Number); 16] = [
    ("failures", |r| r.failures as f64),
    ("settling_time_2.pitch", |r| r.settling_time_2.pitch),
    ("settling_time_2.yaw", |r| r.settling_time_2.yaw),
    ("settling_p95.pitch", |r| r.settling_p95.pitch),
    ("settling_p95.yaw", |r| r.settling_p95.yaw),
    ("overshoot_p95.pitch", |r| r.overshoot_p95.pitch),
    ("overshoot_p95.yaw", |r| r.overshoot_p95.yaw),
    ("disturbance_rms_deg.pitch", |r| r.disturbance_rms_deg.pitch),
    ("disturbance_rms_deg.yaw", |r| r.disturbance_rms_deg.yaw),
    ("hold_rms_deg.pitch", |r| r.hold_rms_deg.pitch),
    ("hold_rms_deg.yaw", |r| r.hold_rms_deg.yaw),
    ("voltage_variation", |r| r.voltage_variation),
    ("saturation_time", |r| r.saturation_time),
    ("J_step", |r| r.step_total),
    ("lags.failures", |r| r.lags.iter().map(|lag| lag.failures as f64).sum()),
    ("lags.J", |r| r.lags.iter().map(|lag| lag.total).fold(0.0, f64::max)),
];

impl Limit {
    /// From `NUMBER=MOST`.
    ///
    /// # Errors
    ///
    /// If it is not of that form, or there is no such number.
    pub fn parse(text: &str) -> Outcome<Self> {
        let refuse = || Error::invalid("at_most", format_args!("'{text}'"), "such as overshoot_p95.yaw=2");
        let (name, most) = text.split_once('=').ok_or_else(refuse)?;
        let number = *known_name("at_most", name, &NUMBERS)?;
        let most = at_least(&format!("at_most {name}"), most.parse().map_err(|_| refuse())?, 0.0, false)?;
        Ok(Self { number, most })
    }

    /// By what part of itself it is exceeded, 0 if it is kept; a limit of 0 by the number that exceeds it.
    pub fn excess(&self, row: &Row) -> f64 {
        let number = (self.number)(row);
        if self.most > 0.0 { (number / self.most - 1.0).max(0.0) } else { number }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Score;
    use super::*;
    use twinrotor::axes::PerAxis;

    #[test]
    fn a_limit_is_exceeded_by_a_part_of_itself() {
        let mut score = Score::diverged(4.0);
        score.overshoot_percent = PerAxis::new(3.0, 1.0);
        let row = Row::new("it", &[score; 3], None, Vec::new());
        let excess = |text: &str| Limit::parse(text).unwrap().excess(&row);
        assert!((excess("overshoot_p95.pitch=2") - 0.5).abs() < 1e-12);
        assert_eq!(excess("overshoot_p95.yaw=2"), 0.0);
        assert_eq!(excess("failures=0"), 3.0);
        assert_eq!(excess("failures=3"), 0.0);
    }

    #[test]
    fn what_is_no_limit_is_refused() {
        for text in [
            "overshoot_p95.yaw",
            "roll=2",
            "hold_rms_deg.yaw=x",
            "hold_rms_deg.yaw=-1",
            "hold_rms_deg.yaw=NaN",
        ] {
            assert!(Limit::parse(text).unwrap_err().to_string().contains("at_most"), "{text}");
        }
    }
}
