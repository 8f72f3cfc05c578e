//! How sure one can be of a probability of which some cases were seen.

/// Of what is bounded, the part that the bound holds for.
pub const SURE: f64 = 0.95;
/// Bisections: the interval is halved to less than rounding.
const HALVINGS: usize = 100;

/// A probability of failure that is above the true one with a probability of [`SURE`], after `failures` of
/// `count`: the one-sided bound of C. J. Clopper and E. S. Pearson, Biometrika 26 (1934) 404-413, which is
/// the probability with which so few failures would be seen in one of twenty repetitions. About 3/count
/// where there was none.
pub fn upper_bound(failures: usize, count: usize) -> f64 {
    if failures >= count {
        return 1.0;
    }
    let (mut low, mut high) = (failures as f64 / count as f64, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if at_most(failures, count, middle) > 1.0 - SURE { low = middle } else { high = middle }
    }
    high
}

/// The probability of at most `k` of `n`, each with probability `p`.
fn at_most(k: usize, n: usize, p: f64) -> f64 {
    let (k, n) = (k as f64, n as f64);
    if p >= 1.0 {
        return 0.0;
    }
    let choose = libm::lgamma(n + 1.0) - libm::lgamma(k + 1.0) - libm::lgamma(n - k + 1.0);
    // The largest term, then each from the one above it, until they add nothing any more.
    let largest = choose + k * libm::log(p) + (n - k) * libm::log1p(-p);
    let (mut sum, mut term, mut i) = (1.0, 1.0, k);
    while i > 0.0 && term > 1e-17 * sum {
        term *= i / (n - i + 1.0) * (1.0 - p) / p;
        sum += term;
        i -= 1.0;
    }
    (libm::exp(largest) * sum).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed forms: none of n is 1 - 5 %^(1/n), all but one of n solves p^n = 95 %.
    #[test]
    fn bounds_are_those_of_the_closed_forms() {
        for n in [1, 10, 300, 10_000_000] {
            let exact = -libm::expm1(libm::log(0.05) / n as f64);
            assert!((upper_bound(0, n) / exact - 1.0).abs() < 1e-6, "{n}");
            assert_eq!(upper_bound(n, n), 1.0);
        }
        let exact = 0.95_f64.powf(1.0 / 40.0);
        assert!((upper_bound(39, 40) / exact - 1.0).abs() < 1e-9);
    }

    /// Against the sum of all terms up to k, bisected in Python's double precision.
    #[test]
    fn bounds_are_those_of_the_beta_distribution() {
        for (failures, count, expected) in
            [(3, 300, 0.025_641_39), (27, 60, 0.563_990_3), (1_000, 10_000_000, 1.053_600e-4)]
        {
            let bound = upper_bound(failures, count);
            assert!((bound / expected - 1.0).abs() < 1e-6, "{failures} of {count}: {bound}");
        }
    }

    /// What it promises: in 95 of 100 repetitions the bound is above the truth. Exact, by summing over what
    /// can be seen.
    #[test]
    fn the_bound_holds_at_least_as_often_as_it_says() {
        for p in [0.01, 0.2, 0.6] {
            let n = 50;
            let held: f64 = (0..=n)
                .filter(|k| upper_bound(*k, n) >= p)
                .map(|k| at_most(k, n, p) - k.checked_sub(1).map_or(0.0, |below| at_most(below, n, p)))
                .sum();
            assert!((SURE..1.0).contains(&held), "{p}: {held}");
        }
    }
}
