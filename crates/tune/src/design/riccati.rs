//! Optimal gains, worked out on the host at design time.

use nalgebra::{DMatrix, Matrix3, RowVector3, Vector3};
use twinrotor::estimator::ObserverGains;

/// The stabilising solution P of AᵀP + PA - P B R⁻¹ Bᵀ P + Q = 0, by the matrix sign function of the
/// Hamiltonian (J. D. Roberts, Int. J. Control 32, 1980), and the gain R⁻¹ Bᵀ P. `None` if there is none, or
/// if the equation is not met to 1e-9 of its terms.
pub fn lqr(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    let r_inverse = r.clone().try_inverse()?;
    let g = b * &r_inverse * b.transpose();
    let mut sign = DMatrix::zeros(2 * n, 2 * n);
    sign.view_mut((0, 0), (n, n)).copy_from(a);
    sign.view_mut((0, n), (n, n)).copy_from(&-&g);
    sign.view_mut((n, 0), (n, n)).copy_from(&-q);
    sign.view_mut((n, n), (n, n)).copy_from(&-a.transpose());
    for _ in 0..200 {
        let inverse = sign.clone().try_inverse()?;
        // Scaled by the determinant, the iteration takes a dozen steps instead of fifty.
        let scale = sign.determinant().abs().powf(-1.0 / (2 * n) as f64);
        let next = (&sign * scale + inverse / scale) * 0.5;
        let change = (&next - &sign).norm() / sign.norm();
        sign = next;
        if change < 1e-15 {
            break;
        }
    }
    // (S + I) [I; P] = 0: the rows give P by least squares.
    let identity = DMatrix::identity(n, n);
    let mut left = DMatrix::zeros(2 * n, n);
    left.view_mut((0, 0), (n, n)).copy_from(&sign.view((0, n), (n, n)));
    left.view_mut((n, 0), (n, n)).copy_from(&(sign.view((n, n), (n, n)) + &identity));
    let mut right = DMatrix::zeros(2 * n, n);
    right.view_mut((0, 0), (n, n)).copy_from(&-(sign.view((0, 0), (n, n)) + &identity));
    right.view_mut((n, 0), (n, n)).copy_from(&-sign.view((n, 0), (n, n)));
    let p = left.svd(true, true).solve(&right, 1e-14).ok()?;
    let p = (&p + p.transpose()) * 0.5;
    let (ap, pgp) = (a.transpose() * &p, &p * &g * &p);
    let residual = (&ap + ap.transpose() - &pgp + q).norm();
    let scale = 2.0 * ap.norm() + pgp.norm() + q.norm();
    (residual <= 1e-9 * scale).then(|| r_inverse * b.transpose() * p)
}

/// Stationary Kalman gains of one axis for [`Observer`](twinrotor::estimator::Observer): an encoder whose
/// rounding is taken for white noise of variance count²/12, a disturbance that walks at random by `walk`
/// [rad/s² per √s], and a torque noise of `jitter` [rad/s² per √Hz]; `count` \[rad\], `sample_time` \[s\].
///
/// With no walk the disturbance stays at zero, and what is left is a Luenberger observer.
pub fn kalman(count: f64, walk: f64, jitter: f64, sample_time: f64) -> Option<ObserverGains<f64>> {
    let t = sample_time;
    let step = Matrix3::new(1.0, t, 0.5 * t * t, 0.0, 1.0, t, 0.0, 0.0, 1.0);
    let by_jitter = Vector3::new(0.5 * t * t, t, 0.0);
    let by_walk = Vector3::new(t * t * t / 6.0, 0.5 * t * t, t);
    let process = by_jitter * by_jitter.transpose() * (jitter * jitter / t)
        + by_walk * by_walk.transpose() * (walk * walk / t);
    let noise = count * count / 12.0;
    let seen = RowVector3::new(1.0, 0.0, 0.0);
    let mut expected = process;
    let mut gain = Vector3::zeros();
    for _ in 0..2_000_000 {
        let next_gain = expected.column(0) / (expected[(0, 0)] + noise);
        // Joseph's form keeps the covariance symmetric and positive.
        let left = Matrix3::identity() - next_gain * seen;
        let corrected = left * expected * left.transpose() + next_gain * next_gain.transpose() * noise;
        expected = step * corrected * step.transpose() + process;
        let change = (next_gain - gain).component_div(&next_gain.map(|x| x.abs().max(1e-12))).amax();
        gain = next_gain;
        if change < 1e-12 {
            break;
        }
    }
    let gains = ObserverGains { angle: gain[0], rate: gain[1], disturbance: gain[2] };
    [gain[0], gain[1], gain[2]].iter().all(|x| x.is_finite()).then_some(gains)
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::estimator::extended_state;

    /// A double integrator with Q = diag(q, 0), r = 1 has the gain (√q, √(2√q)).
    #[test]
    fn the_double_integrator_has_its_known_gain() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
        let q = DMatrix::from_row_slice(2, 2, &[16.0, 0.0, 0.0, 0.0]);
        let k = lqr(&a, &b, &q, &DMatrix::identity(1, 1)).unwrap();
        assert!((k[(0, 0)] - 4.0).abs() < 1e-9 && (k[(0, 1)] - 8.0_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn what_cannot_be_stabilised_has_no_gain() {
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, -1.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
        assert!(lqr(&a, &b, &DMatrix::identity(2, 2), &DMatrix::identity(1, 1)).is_none());
    }

    /// Without jitter, the stationary filter of a random walk in acceleration has its poles on Butterworth's
    /// circle of third order: l₁ ≈ 2 ωT, l₂ ≈ 2 ω² T, l₃ ≈ ω³ T for ω³ = walk/noise density.
    #[test]
    fn a_random_walk_gives_butterworths_poles() {
        let (count, t, w) = (core::f64::consts::TAU / 2880.0, 1e-3_f64, 40.0_f64);
        let walk = w.powi(3) * count / 12.0_f64.sqrt() * t.sqrt();
        let g = kalman(count, walk, 0.0, t).unwrap();
        assert!((g.angle / (2.0 * w * t) - 1.0).abs() < 0.05, "{g:?}");
        assert!((g.rate / (2.0 * w * w * t) - 1.0).abs() < 0.05, "{g:?}");
        assert!((g.disturbance / (w * w * w * t) - 1.0).abs() < 0.05, "{g:?}");
        // Of the size of an extended state observer of that bandwidth.
        let e = extended_state(w, t);
        assert!(g.disturbance / e.disturbance > 0.8 && g.disturbance / e.disturbance < 1.2);
    }
}
