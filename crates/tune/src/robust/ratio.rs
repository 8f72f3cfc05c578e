//! How much better one way of tuning a controller is than another: on the same plants, tuned more than once.

use super::{Score, quantile};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Times that the plants are drawn anew for an interval.
const RESAMPLED: usize = 400;

/// A measure of a controller over plants, all of whose scores it is given; less is better.
pub type Measure = fn(&[Score]) -> f64;

/// One in parts of another, in some measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratio {
    /// The measure of the one, the median over tunings.
    pub one: f64,
    /// That of the other.
    pub other: f64,
    /// The one in parts of the other: the least of all tunings' 2.5 % quantiles, and the greatest of their
    /// 97.5 % quantiles, over plants drawn with replacement (Efron's bootstrap, paired by plant).
    pub interval: [f64; 2],
}

impl Ratio {
    /// Both with the scores of each tuning, on the same plants.
    pub fn new(one: &[Vec<Score>], other: &[Vec<Score>], measure: Measure, seed: u64) -> Self {
        let mut draws = ChaCha8Rng::seed_from_u64(seed);
        let mut interval = [f64::INFINITY, 0.0_f64];
        for (a, b) in one.iter().zip(other) {
            let mut once = || {
                let chosen: Vec<usize> = a.iter().map(|_| draws.random_range(0..a.len())).collect();
                let of = |all: &[Score]| measure(&chosen.iter().map(|k| all[*k]).collect::<Vec<_>>());
                of(a) / of(b)
            };
            let ratios: Vec<f64> = (0..RESAMPLED).map(|_| once()).collect();
            interval[0] = interval[0].min(quantile(&ratios, 0.025));
            interval[1] = interval[1].max(quantile(&ratios, 0.975));
        }
        let median = |all: &[Vec<Score>]| quantile(&all.iter().map(|s| measure(s)).collect::<Vec<_>>(), 0.5);
        Self { one: median(one), other: median(other), interval }
    }

    /// Is the one less than `part` of the other? None if the interval holds `part`.
    pub fn is_below(&self, part: f64) -> Option<bool> {
        let [least, most] = self.interval;
        if most < part {
            Some(true)
        } else if least > part {
            Some(false)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::axes::PerAxis;

    fn scores(middle: f64) -> Vec<Score> {
        let score = |k: i32| Score {
            settling_time: PerAxis::both(0.0),
            overshoot_percent: PerAxis::both(0.0),
            disturbance_rms_deg: PerAxis::both(0.0),
            hold_rms_deg: PerAxis::both(0.0),
            voltage_variation: 0.0,
            saturation_time: middle + 0.01 * f64::from(k % 7),
            scenes: [None; super::super::SCENES.len()],
            diverged: false,
            cut: None,
            failed: false,
        };
        (0..60).map(score).collect()
    }

    fn below(one: &[f64], other: &[f64]) -> Option<bool> {
        let all = |middles: &[f64]| middles.iter().map(|m| scores(*m)).collect::<Vec<_>>();
        let sum: Measure = |scores| scores.iter().map(|s| s.saturation_time).sum();
        Ratio::new(&all(one), &all(other), sum, 1).is_below(0.95)
    }

    #[test]
    fn what_tunings_or_plants_do_not_tell_apart_stays_open() {
        assert_eq!(below(&[1.0, 1.1], &[2.0, 2.0]), Some(true));
        assert_eq!(below(&[2.0, 1.9], &[1.0, 1.0]), Some(false));
        assert_eq!(below(&[1.0, 2.0], &[1.5, 1.5]), None, "one tuning each way");
        // A tenth better on the average, by half of the plants alone.
        let uneven: Vec<Score> = (0..60)
            .zip(scores(0.0))
            .map(|(k, score)| Score { saturation_time: if k % 2 == 0 { 0.2 } else { 1.6 }, ..score })
            .collect();
        let sum: Measure = |scores| scores.iter().map(|s| s.saturation_time).sum();
        let other = Ratio::new(&[uneven], &[scores(1.0)], sum, 1);
        assert!(other.one < 0.95 * other.other && other.is_below(0.95).is_none(), "{other:?}");
    }
}
