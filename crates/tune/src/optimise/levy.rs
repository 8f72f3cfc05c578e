//! Lévy-stable steps by Mantegna's method.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// One step of a symmetric Lévy flight: u/|v|^(1/λ) with u ~ N(0, σ²), v ~ N(0, 1), and
/// σ = [Γ(1+λ) sin(πλ/2) / (Γ((1+λ)/2) λ 2^((λ-1)/2))]^(1/λ)
/// (R. N. Mantegna, Phys. Rev. E 49, 4677, 1994). `exponent` λ in 1..2; 1.5 is customary.
pub fn levy_step(rng: &mut impl Rng, exponent: f64) -> f64 {
    let u: f64 = StandardNormal.sample(rng);
    let v: f64 = StandardNormal.sample(rng);
    mantegna_sigma(exponent) * u / libm::pow(v.abs(), 1.0 / exponent)
}

fn mantegna_sigma(exponent: f64) -> f64 {
    let above = libm::tgamma(1.0 + exponent) * libm::sin(core::f64::consts::FRAC_PI_2 * exponent);
    let below = libm::tgamma(0.5 * (1.0 + exponent)) * exponent * libm::pow(2.0, 0.5 * (exponent - 1.0));
    libm::pow(above / below, 1.0 / exponent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimise::Draws;

    #[test]
    fn sigma_of_the_customary_exponent() {
        // The value that the literature on cuckoo search and flower pollination quotes for 1.5.
        assert!((mantegna_sigma(1.5) - 0.6966).abs() < 5e-5);
    }

    /// Symmetric, and with the power-law tail of a Lévy-stable law: P(|s| > x) falls as x^-λ.
    #[test]
    fn steps_are_symmetric_with_a_heavy_tail() {
        let mut rng = Draws::new(1).of_move(0);
        let steps: Vec<f64> = (0..400_000).map(|_| levy_step(&mut rng, 1.5)).collect();
        let beyond = |x: f64| steps.iter().filter(|s| s.abs() > x).count() as f64;
        let slope = (beyond(100.0) / beyond(10.0)).log10();
        assert!((slope + 1.5).abs() < 0.1, "slope {slope}");
        let positive = steps.iter().filter(|s| **s > 0.0).count() as f64 / steps.len() as f64;
        assert!((positive - 0.5).abs() < 0.005);
    }
}
