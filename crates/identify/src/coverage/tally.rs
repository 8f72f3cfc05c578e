//! Verdicts counted.

use super::Verdict;
use crate::constants::Constant;
use serde::Serialize;
use twinrotor_tune::robust::quantile;

/// A study in numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Around which rigs were drawn.
    pub preset: String,
    /// What they flew.
    pub scenario: String,
    /// Of everything random.
    pub seed: u64,
    /// How many.
    pub rigs: usize,
    /// Part of the preset's constants within which they were drawn.
    pub spread: f64,
    /// The same of each rotor's lag.
    pub lag_spread: f64,
    /// Rigs without an answer.
    pub failures: Vec<Failed>,
    /// Each fitted constant.
    pub constants: Vec<Coverage>,
}

/// A rig without an answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failed {
    /// Its number, from 0.
    pub rig: usize,
    /// What was said.
    pub why: String,
}

/// One constant, over all rigs that were answered.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coverage {
    /// As a preset file spells it.
    pub name: &'static str,
    /// SI.
    pub unit: &'static str,
    /// How many intervals were printed.
    pub intervals: usize,
    /// How many of them hold the truth.
    pub held: usize,
    /// The part of them that do.
    pub coverage: Option<f64>,
    /// Between which the true part lies with 95 % (Wilson's score interval).
    pub coverage_ci95: Option<[f64; 2]>,
    /// Median width of the intervals, in the constant's unit.
    pub median_width: Option<f64>,
    /// Median distance of what was found from the truth, in the constant's unit.
    pub median_error: Option<f64>,
    /// How often the interval was narrower than the value.
    pub identifiable: usize,
    /// How often the constant was found at a bound, where it has no interval.
    pub at_bound: usize,
}

pub(super) fn failures(verdicts: &[Verdict]) -> Vec<Failed> {
    let failed = |(rig, verdict): (usize, &Verdict)| {
        verdict.as_ref().err().map(|why| Failed { rig, why: why.clone() })
    };
    verdicts.iter().enumerate().filter_map(failed).collect()
}

pub(super) fn constants(constants: &[&Constant], verdicts: &[Verdict]) -> Vec<Coverage> {
    let of = |(k, constant): (usize, &&Constant)| {
        let all: Vec<_> = verdicts.iter().flatten().map(|estimates| &estimates[k]).collect();
        let printed: Vec<_> = all.iter().filter_map(|e| e.ci95.map(|ends| (e.truth, ends))).collect();
        let held = printed.iter().filter(|(truth, [least, most])| (least..=most).contains(&truth)).count();
        let widths: Vec<f64> = printed.iter().map(|(_, [least, most])| most - least).collect();
        let errors: Vec<f64> = all.iter().map(|e| (e.value - e.truth).abs()).collect();
        let median = |numbers: &[f64]| (!numbers.is_empty()).then(|| quantile(numbers, 0.5));
        let count = printed.len();
        Coverage {
            name: constant.name,
            unit: constant.unit,
            intervals: count,
            held,
            coverage: (count > 0).then(|| held as f64 / count as f64),
            coverage_ci95: (count > 0).then(|| wilson_95(held, count)),
            median_width: median(&widths),
            median_error: median(&errors),
            identifiable: all.iter().filter(|e| e.identifiable).count(),
            at_bound: all.iter().filter(|e| e.at_bound).count(),
        }
    };
    constants.iter().enumerate().map(of).collect()
}

/// The 95 % score interval of a chance of which `held` of `count` > 0 trials came out (E. B. Wilson, J. Am.
/// Stat. Assoc. 22, 1927).
fn wilson_95(held: usize, count: usize) -> [f64; 2] {
    let (z, n, p) = (1.959_964_f64, count as f64, held as f64 / count as f64);
    let middle = p + z * z / (2.0 * n);
    let half = z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    [middle - half, middle + half].map(|end| (end / (1.0 + z * z / n)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::super::Estimate;
    use super::*;
    use crate::constants::CONSTANTS;

    /// R: binom::binom.confint(95, 100, methods = "wilson"), and of 0 of 10.
    #[test]
    fn the_score_interval_is_as_in_the_books() {
        for (held, count, ends) in [(95, 100, [0.888_249, 0.978_457]), (0, 10, [0.0, 0.277_533])] {
            for (got, expected) in wilson_95(held, count).into_iter().zip(ends) {
                assert!((got - expected).abs() < 1e-5, "{held} of {count}: {got}, not {expected}");
            }
        }
    }

    #[test]
    fn what_is_printed_is_counted() {
        let estimate = |ci95: Option<[f64; 2]>, at_bound| Estimate {
            truth: 2.0,
            value: 2.5,
            ci95,
            identifiable: ci95.is_some(),
            at_bound,
        };
        let verdicts = [
            Ok(vec![estimate(Some([1.0, 2.0]), false)]),
            Err("left the envelope".to_owned()),
            Ok(vec![estimate(Some([2.1, 2.4]), false)]),
            Ok(vec![estimate(Some([1.0, 3.0]), false)]),
            Ok(vec![estimate(None, true)]),
        ];
        let [one] = &constants(&[&CONSTANTS[7]], &verdicts)[..] else { panic!("one") };
        assert_eq!((one.name, one.intervals, one.held, one.at_bound), ("stiffness", 3, 2, 1));
        assert_eq!((one.identifiable, one.median_error, one.median_width), (3, Some(0.5), Some(1.0)));
        let failed = failures(&verdicts);
        assert_eq!(failed, [Failed { rig: 1, why: "left the envelope".to_owned() }]);
        let none = &constants(&[&CONSTANTS[7]], &verdicts[1..2])[0];
        assert_eq!((none.coverage, none.coverage_ci95, none.median_width), (None, None, None));
    }
}
