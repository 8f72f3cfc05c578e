//! What a flight of the robust objective costs, term by term.

use super::Cut;
use super::scenes::{SCENES, SceneScore};
use serde::{Deserialize, Serialize};
use twinrotor::axes::PerAxis;

/// One flight in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// \[s\] When the error came within 2 % of the step for good, as [`twinrotor_sim::metrics::Settling`] has
    /// it; the time of the disturbance if it was outside when that came.
    pub settling_time: PerAxis<f64>,
    /// \[%\] Of the step, before the disturbance.
    pub overshoot_percent: PerAxis<f64>,
    /// \[deg\] RMS error from the disturbance to the end.
    pub disturbance_rms_deg: PerAxis<f64>,
    /// \[deg\] RMS error in the last second before the disturbance.
    pub hold_rms_deg: PerAxis<f64>,
    /// \[V/s\] Σ|ΔV| a second and motor in that second.
    pub voltage_variation: f64,
    /// \[s\] In which more was asked of at least one motor than its limit, over the whole flight.
    pub saturation_time: f64,
    /// The flights beside the step, in the order of [`SCENES`]; none where they were not asked for.
    pub scenes: [Option<SceneScore>; SCENES.len()],
    /// It went more than a turn astray, or an angle is not finite.
    pub diverged: bool,
    /// Where a board would have cut the motors, in the first flight that ends so.
    pub cut: Option<Cut>,
    /// It diverged, left the rig's envelope, also in a scene, was not inside 5 % when the disturbance came,
    /// or was cut.
    pub failed: bool,
}

/// What each term adds to the cost of a flight.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Terms {
    /// Settling times, both axes.
    pub settling: f64,
    /// .05 x overshoot, both axes.
    pub overshoot: f64,
    /// RMS error after the disturbance, both axes.
    pub disturbance: f64,
    /// .5 x RMS error while holding, both axes.
    pub hold: f64,
    /// .001 x voltage variation.
    pub variation: f64,
    /// .5 x time in saturation.
    pub saturation: f64,
    /// The scenes beside the step ([`SceneScore::cost`]).
    pub scenes: f64,
}

fn sum(both: PerAxis<f64>) -> f64 {
    both.pitch + both.yaw
}

impl Score {
    /// What a diverged flight counts as, with the disturbance at `allowance` \[s\].
    pub fn diverged(allowance: f64) -> Self {
        Self {
            settling_time: PerAxis::both(allowance),
            overshoot_percent: PerAxis::both(200.0),
            disturbance_rms_deg: PerAxis::both(50.0),
            hold_rms_deg: PerAxis::both(50.0),
            voltage_variation: 20_000.0,
            saturation_time: 0.0,
            scenes: [None; SCENES.len()],
            diverged: true,
            cut: None,
            failed: true,
        }
    }

    /// Its cost by terms.
    pub fn terms(&self) -> Terms {
        Terms {
            settling: sum(self.settling_time),
            overshoot: 0.05 * sum(self.overshoot_percent),
            disturbance: sum(self.disturbance_rms_deg),
            hold: 0.5 * sum(self.hold_rms_deg),
            variation: 0.001 * self.voltage_variation,
            saturation: 0.5 * self.saturation_time,
            scenes: self.scenes.iter().flatten().map(SceneScore::cost).sum(),
        }
    }

    /// c of the step alone.
    pub fn step_cost(&self) -> f64 {
        Terms { scenes: 0.0, ..self.terms() }.total()
    }

    /// c.
    pub fn cost(&self) -> f64 {
        self.terms().total()
    }
}

impl Terms {
    /// Their sum.
    pub fn total(&self) -> f64 {
        let step = self.settling + self.overshoot + self.disturbance;
        step + self.hold + self.variation + self.saturation + self.scenes
    }

    /// Their names and values.
    pub fn named(&self) -> [(&'static str, f64); 7] {
        [
            ("settling", self.settling),
            ("overshoot", self.overshoot),
            ("disturbance", self.disturbance),
            ("hold", self.hold),
            ("voltage variation", self.variation),
            ("saturation", self.saturation),
            ("scenes", self.scenes),
        ]
    }

    /// The mean of many.
    pub fn mean(many: impl ExactSizeIterator<Item = Self>) -> Self {
        let count = many.len() as f64;
        let mut sum = Self::default();
        for t in many {
            sum.settling += t.settling / count;
            sum.overshoot += t.overshoot / count;
            sum.disturbance += t.disturbance / count;
            sum.hold += t.hold / count;
            sum.variation += t.variation / count;
            sum.saturation += t.saturation / count;
            sum.scenes += t.scenes / count;
        }
        sum
    }
}

/// J = mean(c) + q90(c)/2.
pub fn total(scores: &[Score]) -> f64 {
    of(&scores.iter().map(Score::cost).collect::<Vec<_>>())
}

/// J of the step alone, whatever was flown beside it.
pub fn step_total(scores: &[Score]) -> f64 {
    of(&scores.iter().map(Score::step_cost).collect::<Vec<_>>())
}

/// J of these costs.
pub(super) fn of(costs: &[f64]) -> f64 {
    let mean = costs.iter().sum::<f64>() / costs.len() as f64;
    mean + 0.5 * quantile(costs, 0.9)
}

/// The value below which a part of `values` lies, straight between neighbours.
pub fn quantile(values: &[f64], part: f64) -> f64 {
    let mut values = values.to_vec();
    let place = part * (values.len() - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the slice")]
    let below = place as usize;
    let (_, &mut under, larger) = values.select_nth_unstable_by(below, f64::total_cmp);
    let over = larger.iter().copied().min_by(f64::total_cmp).unwrap_or(under);
    under + (place - below as f64) * (over - under)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_neighbours() {
        let values = [4.0, 1.0, 3.0, 2.0, 5.0];
        assert_eq!(quantile(&values, 0.5), 3.0);
        assert_eq!(quantile(&values, 0.0), 1.0);
        assert_eq!(quantile(&values, 1.0), 5.0);
        assert!((quantile(&values, 0.9) - 4.6).abs() < 1e-12);
    }

    #[test]
    fn a_diverged_flight_costs_more_than_any_that_holds() {
        assert_eq!(Score::diverged(4.0).cost(), 8.0 + 20.0 + 100.0 + 50.0 + 20.0);
    }
}
