//! Angles and rates from sampled angles by local polynomials (Savitzky and Golay, Analytical Chemistry 36,
//! 1964): a reference that looks ahead as far as it looks back, so it does not lag. No controller could have
//! it; it is what estimates are measured by.

use nalgebra::DMatrix;

/// What a local polynomial says of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Smoothed {
    /// \[rad\]
    pub angle: f64,
    /// \[rad/s\]
    pub rate: f64,
}

/// Degree of the polynomials: a cubic follows an acceleration that changes.
const DEGREE: usize = 3;

/// Fits a cubic to the samples within `reach` \[s\] of each sample, `step` \[s\] apart; near the ends to as
/// many on one side. Needs more samples than a cubic has coefficients.
pub fn smooth(samples: &[f64], step: f64, reach: f64) -> Vec<Smoothed> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive number")]
    let half = (reach / step).round() as usize;
    let width = (2 * half + 1).clamp(DEGREE + 2, samples.len());
    let last = samples.len() - width;
    let weights: Vec<[Vec<f64>; 2]> = (0..width).map(|centre| weights(width, centre, step)).collect();
    let at = |k: usize| {
        let from = k.saturating_sub(half).min(last);
        let [angle, rate] = &weights[k - from];
        let part = &samples[from..from + width];
        let sum = |weights: &[f64]| weights.iter().zip(part).map(|(w, x)| w * x).sum();
        Smoothed { angle: sum(angle), rate: sum(rate) }
    };
    (0..samples.len()).map(at).collect()
}

/// What each of `width` samples contributes to value and derivative, at sample `centre`, of the polynomial
/// nearest to them.
fn weights(width: usize, centre: usize, step: f64) -> [Vec<f64>; 2] {
    let unit = width as f64;
    let power = |row: usize, degree: usize| ((row as f64 - centre as f64) / unit).powf(degree as f64);
    let basis = DMatrix::from_fn(width, DEGREE + 1, power);
    let normal = (basis.transpose() * &basis).cholesky().expect("more samples than coefficients");
    let solution = normal.solve(&basis.transpose());
    let row = |k: usize, scale: f64| solution.row(k).iter().map(|w| w * scale).collect();
    [row(0, 1.0), row(1, 1.0 / (unit * step))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_comes_back_with_its_derivative_everywhere() {
        let t = |k: usize| 0.002 * k as f64;
        let samples: Vec<f64> =
            (0..400).map(|k| 0.3 - t(k) + 2.0 * t(k).powi(2) - 0.7 * t(k).powi(3)).collect();
        for (k, got) in smooth(&samples, 0.002, 0.06).iter().enumerate() {
            assert!((got.angle - samples[k]).abs() < 1e-9);
            assert!((got.rate - (-1.0 + 4.0 * t(k) - 2.1 * t(k).powi(2))).abs() < 1e-7, "{k}");
        }
    }

    #[test]
    fn encoder_counts_are_smoothed_away() {
        let count = std::f64::consts::TAU / 2048.0;
        let truth = |k: usize| (0.5 * (0.002 * k as f64 * 2.0).sin(), (0.002 * k as f64 * 2.0).cos());
        let samples: Vec<f64> = (0..2000).map(|k| (truth(k).0 / count).round() * count).collect();
        let smoothed = smooth(&samples, 0.002, 0.06);
        let error = smoothed.iter().enumerate().map(|(k, s)| (s.rate - truth(k).1).powi(2));
        assert!((error.sum::<f64>() / 2000.0).sqrt() < 0.012);
    }
}
