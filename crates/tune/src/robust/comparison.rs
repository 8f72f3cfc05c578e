//! Controllers side by side on the same plants.

use super::LagRow;
use super::cost::{Score, quantile, step_total, total};
use super::proportion::upper_bound;
use super::scenes::{SCENES, SceneScore};
use serde::Serialize;
use twinrotor::axes::PerAxis;

/// Quantiles of one number over plants.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// 5 % lie below.
    pub p5: f64,
    /// Half lie below.
    pub median: f64,
    /// 95 % lie below.
    pub p95: f64,
}

impl Spread {
    /// Of these values.
    pub fn of(values: &[f64]) -> Self {
        let [p5, median, p95] = [0.05, 0.5, 0.95].map(|part| quantile(values, part));
        Self { p5, median, p95 }
    }
}

/// One scene over all plants.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneRow {
    /// What it is called.
    pub name: &'static str,
    /// \[-\] RMS error in parts of the goal, median.
    pub error: PerAxis<f64>,
    /// What it adds to c, mean.
    pub cost: f64,
    /// Plants on which the rig left its envelope.
    pub failures: usize,
}

impl SceneRow {
    fn all(scores: &[Score]) -> Vec<Self> {
        let row = |(k, scene): (usize, &super::Scene)| {
            let flown: Vec<SceneScore> = scores.iter().filter_map(|score| score.scenes[k]).collect();
            let middle =
                |of: fn(&SceneScore) -> f64| quantile(&flown.iter().map(of).collect::<Vec<_>>(), 0.5);
            (!flown.is_empty()).then(|| Self {
                name: scene.name(),
                error: PerAxis::new(middle(|s| s.error.pitch), middle(|s| s.error.yaw)),
                cost: flown.iter().map(SceneScore::cost).sum::<f64>() / flown.len() as f64,
                failures: flown.iter().filter(|s| s.failed).count(),
            })
        };
        SCENES.iter().enumerate().filter_map(row).collect()
    }
}

/// One controller over all plants.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// What it is called.
    pub name: String,
    /// Plants on which it failed.
    pub failures: usize,
    /// \[-\] The probability of a failure is below this, 95 % sure ([`upper_bound`]).
    pub failure_bound: f64,
    /// Of these, on how many a board would have cut the motors.
    pub cuts: usize,
    /// mean(c) + q90(c)/2.
    #[serde(rename = "J")]
    pub total: f64,
    /// The same of the step alone, whatever was flown beside it.
    #[serde(rename = "J_step")]
    pub step_total: f64,
    /// The scenes that were flown beside it.
    pub scenes: Vec<SceneRow>,
    /// The same flights with rotors whose lag is wrong by far, where they were flown.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lags: Vec<LagRow>,
    /// c.
    pub cost: Spread,
    /// \[s\] Median.
    pub settling_time_2: PerAxis<f64>,
    /// \[s\] 95 % quantile.
    pub settling_p95: PerAxis<f64>,
    /// \[%\] 95 % quantile.
    pub overshoot_p95: PerAxis<f64>,
    /// \[deg\] Median.
    pub disturbance_rms_deg: PerAxis<f64>,
    /// \[deg\] Median.
    pub hold_rms_deg: PerAxis<f64>,
    /// \[V/s\] Median.
    pub voltage_variation: f64,
    /// \[s\] Median.
    pub saturation_time: f64,
    /// That its costs and those it is held against differ as they do by chance (Wilcoxon, two-sided, paired
    /// by plant); none for these.
    pub p_value: Option<f64>,
    /// What it has beyond its law.
    pub uses: Vec<String>,
}

impl Row {
    /// From a controller's scores and those of the one it is held against, on the same plants.
    pub fn new(name: &str, scores: &[Score], other: Option<&[Score]>, uses: Vec<String>) -> Self {
        let all = |of: &dyn Fn(&Score) -> f64| scores.iter().map(of).collect::<Vec<_>>();
        let median = |of: &dyn Fn(&Score) -> f64| quantile(&all(of), 0.5);
        let both = |part: f64, of: fn(&Score) -> PerAxis<f64>| PerAxis {
            pitch: quantile(&all(&|s| of(s).pitch), part),
            yaw: quantile(&all(&|s| of(s).yaw), part),
        };
        let costs = all(&Score::cost);
        let failures = scores.iter().filter(|s| s.failed).count();
        Self {
            name: name.to_owned(),
            failures,
            failure_bound: upper_bound(failures, scores.len()),
            cuts: scores.iter().filter(|s| s.cut.is_some()).count(),
            total: total(scores),
            step_total: step_total(scores),
            scenes: SceneRow::all(scores),
            lags: Vec::new(),
            cost: Spread::of(&costs),
            settling_time_2: both(0.5, |s| s.settling_time),
            settling_p95: both(0.95, |s| s.settling_time),
            overshoot_p95: both(0.95, |s| s.overshoot_percent),
            disturbance_rms_deg: both(0.5, |s| s.disturbance_rms_deg),
            hold_rms_deg: both(0.5, |s| s.hold_rms_deg),
            voltage_variation: median(&|s| s.voltage_variation),
            saturation_time: median(&|s| s.saturation_time),
            p_value: other.map(|other| {
                let differences: Vec<f64> = costs.iter().zip(other).map(|(c, o)| c - o.cost()).collect();
                signed_rank(&differences)
            }),
            uses,
        }
    }
}

/// Wilcoxon's signed-rank test of paired differences: the two-sided p-value by the normal approximation with
/// ties corrected and zeros left out, good from about twenty pairs on.
pub fn signed_rank(differences: &[f64]) -> f64 {
    let mut d: Vec<f64> = differences.iter().copied().filter(|x| *x != 0.0).collect();
    d.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let n = d.len() as f64;
    if d.is_empty() {
        return 1.0;
    }
    let (mut positive, mut ties, mut before) = (0.0, 0.0, 0.0);
    for group in d.chunk_by(|a, b| a.abs().total_cmp(&b.abs()).is_eq()) {
        let count = group.len() as f64;
        let rank = before + 0.5 * (count + 1.0);
        positive += rank * group.iter().filter(|x| **x > 0.0).count() as f64;
        ties += count * count * count - count;
        before += count;
    }
    let mean = n * (n + 1.0) / 4.0;
    let variance = n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - ties / 48.0;
    let z = ((positive - mean).abs() - 0.5).max(0.0) / variance.sqrt();
    libm::erfc(z / core::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against scipy.stats.wilcoxon(x, method="asymptotic", correction=True).
    #[test]
    fn signed_rank_is_as_in_the_books() {
        let x: Vec<f64> = (1..=20).map(|k| if k % 4 == 0 { -f64::from(k) } else { f64::from(k) }).collect();
        // Rank sums: negative 4 + 8 + 12 + 16 + 20 = 60, positive 150; mean 105, variance 717.5.
        let z = (45.0 - 0.5) / 717.5_f64.sqrt();
        assert!((signed_rank(&x) - libm::erfc(z / 2.0_f64.sqrt())).abs() < 1e-12);
        assert!((signed_rank(&x) - 0.0967).abs() < 5e-4);
        assert_eq!(signed_rank(&[0.0, 0.0]), 1.0);
        assert!(signed_rank(&[1.0; 40]) < 1e-8);
    }
}
