//! Sine and cosine of the `f32` hot path: one routine for the board, the host and every lane.
//!
//! Candidates, compared over [-4, 4] rad on the 2.17e9 `f32` values there (every 6,553rd of them), error in
//! units in the last place of the exact value, and absolute where the value itself passes zero
//! (`cargo test -p core trig -- --nocapture` prints this table):
//!
//! | routine | sine, ulp | cosine, ulp | absolute | on a Cortex-M4F | same bits in a lane |
//! |---|---|---|---|---|---|
//! | `libm::sincosf` | 0.50 | 0.50 | 3e-8 | computes in software `f64`, ~1,240 instructions a call | only lane by lane |
//! | `micromath` | 1.8e7 | 2.1e5 | 1.1e-3 | ~30 instructions, an angle error of .06 degrees | branches: no |
//! | this polynomial | 1.43 | 1.37 | 8.2e-8 | ~45 instructions, single precision | yes: no branch |
//!
//! The polynomial wins: libm needs double precision, which the board does not have, and micromath's error
//! is a thousand times the quantisation that a test against `f64` would forgive.

use super::{Mask, Real};
use core::hint::cold_path;

/// 2/pi.
const TWO_OVER_PI: f64 = core::f64::consts::FRAC_2_PI;
/// pi/2 in three parts (Cody and Waite): the first two have few enough bits that their product with a
/// quadrant number below 2^13 is exact in `f32`.
const HALF_PI: [f64; 3] = [1.570_312_5, 4.837_512_969_970_703e-4, 7.549_789_954_891_9e-8];
/// (sin r - r)/r^3 in powers of r^2, |r| <= pi/4. Minimax coefficients of the Cephes library's `sinf`.
const SINE: [f64; 3] = [-1.666_665_461_1e-1, 8.332_160_873_6e-3, -1.951_529_589_1e-4];
/// (cos r - 1 + r^2/2)/r^4 in powers of r^2, |r| <= pi/4. Minimax coefficients of the Cephes library's
/// `cosf`.
const COSINE: [f64; 3] = [4.166_664_568_298_827e-2, -1.388_731_625_493_765e-3, 2.443_315_711_809_948e-5];

/// \[rad\] Below this magnitude, a little under pi/4, the quadrant is zero.
const FIRST_QUADRANT: f64 = 0.785;

/// Sine and cosine of `x` \[rad\] in single precision.
///
/// Good for |x| up to 8,000 rad; beyond that accuracy fades (references are reduced before they get here,
/// see [`crate::trajectory`]). NaN and infinity give NaN.
///
/// Where all lanes are in the first quadrant, as a helicopter's pitch is, nothing is reduced or exchanged.
/// The bits are those of the whole routine: with a quadrant of zero it would subtract three zeros and choose
/// what is there.
#[inline(always)]
pub fn sin_cos<R: Real>(x: R) -> (R, R) {
    if x.abs().lt(R::from_f64(FIRST_QUADRANT)).all() {
        polynomials(x)
    } else {
        cold_path();
        any_quadrant(x)
    }
}

/// Sine and cosine of |r| <= pi/4 \[rad\].
#[inline(always)]
fn polynomials<R: Real>(r: R) -> (R, R) {
    let c = R::from_f64;
    let z = r * r;
    let sine = r + r * z * (c(SINE[0]) + z * (c(SINE[1]) + z * c(SINE[2])));
    let cosine = (R::one() - c(0.5) * z) + z * z * (c(COSINE[0]) + z * (c(COSINE[1]) + z * c(COSINE[2])));
    (sine, cosine)
}

/// The whole routine, without a branch.
#[inline(always)]
fn any_quadrant<R: Real>(x: R) -> (R, R) {
    let c = R::from_f64;
    let quadrant = (x * c(TWO_OVER_PI)).round_small();
    let r = ((x - quadrant * c(HALF_PI[0])) - quadrant * c(HALF_PI[1])) - quadrant * c(HALF_PI[2]);
    let (sine, cosine) = polynomials(r);

    // The quadrant modulo 4, as one of -2, -1, 0, 1, 2 (the two ends are the same quadrant).
    let turn = quadrant - c(4.0) * (quadrant * c(0.25)).round_small();
    let magnitude = turn.abs();
    let swapped = c(0.5).lt(magnitude) & magnitude.lt(c(1.5));
    let opposite = c(1.5).lt(magnitude);
    let s = R::select(swapped, cosine, sine);
    let k = R::select(swapped, sine, cosine);
    let sine_negative = opposite | (swapped & turn.lt(R::zero()));
    let cosine_negative = opposite | (swapped & R::zero().lt(turn));
    (R::select(sine_negative, -s, s), R::select(cosine_negative, -k, k))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::println;

    /// Worst error of a routine over [-4, 4] rad: sine and cosine in ulp of the exact value, and absolute.
    fn worst(step: usize, routine: impl Fn(f32) -> (f32, f32)) -> (f64, f64, f64) {
        let ulp = |exact: f64| {
            let near = (exact.abs() as f32).max(f32::MIN_POSITIVE);
            f64::from(f32::from_bits(near.to_bits() + 1)) - f64::from(near)
        };
        let mut w = (0.0_f64, 0.0_f64, 0.0_f64);
        for bits in (0..=4.0_f32.to_bits()).step_by(step) {
            let x = f32::from_bits(bits);
            for x in [x, -x] {
                let (s, c) = routine(x);
                let (es, ec) = f64::from(x).sin_cos();
                let (ds, dc) = ((f64::from(s) - es).abs(), (f64::from(c) - ec).abs());
                w = (w.0.max(ds / ulp(es)), w.1.max(dc / ulp(ec)), w.2.max(ds).max(dc));
            }
        }
        w
    }

    /// Every bit pattern of the first quadrant, and its two signs.
    #[test]
    fn the_short_way_gives_the_bits_of_the_whole_routine() {
        let step = if cfg!(debug_assertions) { 997 } else { 1 };
        for bits in (0..=0.786_f32.to_bits()).step_by(step) {
            let x = f32::from_bits(bits);
            for x in [x, -x] {
                let bits = |(s, c): (f32, f32)| (s.to_bits(), c.to_bits());
                assert_eq!(bits(sin_cos(x)), bits(any_quadrant(x)), "{x}");
            }
        }
    }

    #[test]
    fn candidates_compared() {
        let step = if cfg!(debug_assertions) { 6553 } else { 64 };
        let ours = worst(step, sin_cos);
        let libm = worst(step, libm::sincosf);
        let micro = worst(step, micromath_sin_cos);
        for (name, w) in [("polynomial", ours), ("libm", libm), ("micromath", micro)] {
            println!("{name:>10}: sine {:.3} ulp, cosine {:.3} ulp, absolute {:.2e}", w.0, w.1, w.2);
        }
        assert!(ours.0 < 2.0 && ours.1 < 2.0 && ours.2 < 1e-7, "{ours:?}");
        assert!(micro.2 > 1e3 * ours.2, "micromath is good enough now: compare again");
    }

    fn micromath_sin_cos(x: f32) -> (f32, f32) {
        use micromath::F32Ext;
        (F32Ext::sin(x), F32Ext::cos(x))
    }

    #[test]
    fn quadrants_and_symmetry() {
        for k in -40..=40 {
            let x = core::f64::consts::FRAC_PI_4 * f64::from(k) + 0.01;
            let (s, c) = sin_cos(x as f32);
            assert!((f64::from(s) - x.sin()).abs() < 4e-6 && (f64::from(c) - x.cos()).abs() < 4e-6);
            let (ms, mc) = sin_cos(-x as f32);
            assert_eq!((ms, mc), (-s, c));
        }
    }

    #[test]
    fn non_finite_gives_nan() {
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let (s, c) = sin_cos(x);
            assert!(s.is_nan() && c.is_nan());
        }
    }
}
