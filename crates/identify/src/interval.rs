//! How well each constant is known: 95 % intervals, and which constants the logs say nothing about.
//!
//! Errors within a window hang together, so their number says little; windows are far less dependent. The
//! covariance is the cluster-robust sandwich with windows as clusters, each window's residuals enlarged by
//! what the fit took from them (CR3: Bell and McCaffrey, Survey Methodology 28, 2002), which is the jackknife
//! over windows and errs on the side of caution. Where there are fewer than [`CLUSTERS_AN_UNKNOWN`] windows
//! for each unknown, windows are split into equal parts until there are as many. Parts of a window do hang
//! together, so quantiles are Student's for as many degrees of freedom as there are whole windows beyond
//! unknowns.

use super::problem::{Block, Problem};
use nalgebra::{DMatrix, DVector};

/// What is known of the constants of a fit.
#[derive(Debug, Clone)]
pub struct Precision {
    /// Half the width of each free constant's 95 % interval; infinite where nothing is known.
    pub half_width: Vec<f64>,
    /// Does the constant lie at one of its bounds? Then it has no interval.
    pub at_bound: Vec<bool>,
    /// Of free constants and offsets, as the errors are; what is not known at all is zero there.
    pub covariance: DMatrix<f64>,
    /// Information JᵀJ over the mean square of the residuals: what one more experiment adds to.
    pub information: DMatrix<f64>,
    /// Mean square of the weighted residuals.
    pub mean_square: f64,
}

/// Fewer clusters than this for each unknown say little of how they scatter.
pub const CLUSTERS_AN_UNKNOWN: usize = 3;
/// Degrees of freedom where there are hardly more windows than unknowns: fewer would make every interval
/// useless, and with these nine in ten hold the truth (the study is a test of [`super`]).
const FEWEST_DEGREES: usize = 4;
/// Nearer to a bound than this part of the range: the bound holds it.
const AT_BOUND: f64 = 3e-6;
/// Directions in which the scaled information is below this part of the largest are taken for unknown.
const UNKNOWN: f64 = 1e-10;

/// From the windows at the best guess, with derivatives.
pub fn precision(problem: &Problem<'_>, values: &[f64], blocks: &[Block]) -> Precision {
    let free = problem.free().len();
    let unknowns = free + problem.runs();
    let at_bound: Vec<bool> = values
        .iter()
        .zip(problem.bounds())
        .map(|(v, [least, most])| (v - least).min(most - v) < AT_BOUND * (most - least))
        .collect();
    let raw = blocks
        .iter()
        .fold(DMatrix::zeros(unknowns, unknowns), |sum, b| sum + b.jacobian.transpose() * &b.jacobian);
    let told: Vec<usize> = (0..unknowns)
        .filter(|k| !at_bound.get(*k).copied().unwrap_or(false) && raw[(*k, *k)] > 0.0)
        .collect();
    let clusters = clusters(blocks, &told);

    // In units in which each column has length 1, so that small and large constants are told apart from
    // unknown ones.
    let scale = DVector::from_iterator(told.len(), told.iter().map(|k| raw[(*k, *k)].sqrt()));
    let scaled =
        DMatrix::from_fn(told.len(), told.len(), |i, j| raw[(told[i], told[j])] / (scale[i] * scale[j]));
    let eigen = scaled.symmetric_eigen();
    let most = eigen.eigenvalues.max();
    let mut inverse = DMatrix::zeros(told.len(), told.len());
    let mut lost = vec![false; told.len()];
    for (k, value) in eigen.eigenvalues.iter().enumerate() {
        let direction = eigen.eigenvectors.column(k);
        if *value > UNKNOWN * most {
            inverse += direction * direction.transpose() / *value;
        } else {
            direction.iter().zip(&mut lost).for_each(|(x, lost)| *lost |= x.abs() > 0.1);
        }
    }
    let unscale =
        |m: &DMatrix<f64>| DMatrix::from_fn(told.len(), told.len(), |i, j| m[(i, j)] / (scale[i] * scale[j]));
    let bread = unscale(&inverse);

    let mut filling = DMatrix::zeros(told.len(), told.len());
    for (jacobian, residuals) in &clusters {
        let score = leave_out(jacobian, residuals, &bread);
        filling += &score * score.transpose();
    }
    let count = clusters.len() as f64;
    let small = (count - 1.0) / count;
    let sandwich = &bread * filling * &bread * small;

    let squares: f64 = blocks.iter().map(|b| b.residuals.norm_squared()).sum();
    let residuals: usize = blocks.iter().map(|b| b.residuals.len()).sum();
    let quantile = student_95(blocks.len().saturating_sub(unknowns).max(FEWEST_DEGREES));
    let mut half_width = vec![f64::INFINITY; free];
    let mut covariance = DMatrix::zeros(unknowns, unknowns);
    for (i, k) in told.iter().enumerate() {
        for (j, l) in told.iter().enumerate() {
            covariance[(*k, *l)] = sandwich[(i, j)];
        }
        if *k < free && !lost[i] {
            half_width[*k] = quantile * sandwich[(i, i)].max(0.0).sqrt();
        }
    }
    let mean_square = squares / residuals as f64;
    Precision { half_width, at_bound, covariance, information: raw / mean_square, mean_square }
}

/// Rows that stand together: windows, or equal parts of them where there are few; with the columns that are
/// known of.
fn clusters(blocks: &[Block], told: &[usize]) -> Vec<(DMatrix<f64>, DVector<f64>)> {
    let parts = (CLUSTERS_AN_UNKNOWN * told.len()).div_ceil(blocks.len().max(1)).max(1);
    let split = |block: &Block| {
        let rows = block.residuals.len();
        let jacobian = block.jacobian.select_columns(told);
        let part = |k: usize| {
            let (from, to) = (k * rows / parts, (k + 1) * rows / parts);
            (jacobian.rows(from, to - from).into_owned(), block.residuals.rows(from, to - from).into_owned())
        };
        (0..parts).map(part).filter(|(j, _)| j.nrows() > 0).collect::<Vec<_>>()
    };
    blocks.iter().flat_map(split).collect()
}

/// Jᵀ(I - H)⁻¹ r of one cluster, H = J B Jᵀ: by (I - J B Jᵀ)⁻¹ r = r + J B (I - JᵀJ B)⁻¹ Jᵀr, as small as
/// there are unknowns.
fn leave_out(jacobian: &DMatrix<f64>, residuals: &DVector<f64>, bread: &DMatrix<f64>) -> DVector<f64> {
    let own = jacobian.transpose() * jacobian;
    let score = jacobian.transpose() * residuals;
    let unknowns = own.nrows();
    let rest = DMatrix::identity(unknowns, unknowns) - &own * bread;
    // Jᵀ(I - H)⁻¹ r = (I - JᵀJ B)⁻¹ Jᵀ r.
    let svd = rest.svd(true, true);
    svd.solve(&score, 1e-6).unwrap_or(score)
}

/// The 97.5 % quantile of Student's distribution (Cornish-Fisher expansion: Abramowitz and Stegun 26.7.5),
/// right to a percent from 3 degrees of freedom on.
pub fn student_95(degrees: usize) -> f64 {
    match degrees {
        0 | 1 => 12.706,
        2 => 4.303,
        _ => {
            let (z, n) = (1.959_964_f64, degrees as f64);
            let (z3, z5, z7) = (z.powi(3), z.powi(5), z.powi(7));
            z + (z3 + z) / (4.0 * n)
                + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
                + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n.powi(3))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the table in every textbook.
    #[test]
    fn students_quantiles() {
        for (degrees, quantile) in
            [(1, 12.706), (2, 4.303), (3, 3.182), (5, 2.571), (10, 2.228), (30, 2.042), (120, 1.980)]
        {
            assert!(
                (student_95(degrees) / quantile - 1.0_f64).abs() < 0.01,
                "{degrees} {}",
                student_95(degrees)
            );
        }
    }

    /// Leaving a window out by the formula is leaving it out.
    #[test]
    fn the_formula_for_leaving_out_is_the_long_way_round() {
        let jacobian = DMatrix::from_fn(6, 2, |i, j| (1.0 + i as f64).powi(j as i32 + 1) * 0.1);
        let residuals = DVector::from_fn(6, |i, _| ((i * i) as f64).sin());
        let bread = (jacobian.transpose() * &jacobian * 3.0).try_inverse().unwrap();
        let hat = &jacobian * &bread * jacobian.transpose();
        let long = jacobian.transpose() * (DMatrix::identity(6, 6) - hat).try_inverse().unwrap() * &residuals;
        let short = leave_out(&jacobian, &residuals, &bread);
        assert!((long - short).norm() < 1e-9);
    }
}
