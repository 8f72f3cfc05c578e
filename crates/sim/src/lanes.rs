//! Sixteen closed loops side by side: numbers in lanes, each bit for bit what a plain `f32` would be.
//!
//! Work is written once over [`Real`] as a [`Kernel`], and [`in_lanes`] does it with the best vector
//! instructions that the processor has, found at run time. IEEE 754 makes the bits the same with any of them:
//! no operation is fused or reordered.
//!
//! Whatever a kernel calls in its loop must be `#[inline(always)]`: a function of its own would be compiled
//! for the plainest processor. Where it is compiled for no other, in builds for tests, the largest of them
//! are functions of their own all the same: a first build would spend much of its time on their copies.

use fearless_simd::{
    Level, Select as _, Simd, SimdBase as _, SimdFloat as _, SimdMask as _, f32x16, mask32x16,
};
use std::fmt;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use twinrotor::pipeline::Settings;
use twinrotor::plant::{LaggedRotors, PlantParameters};
use twinrotor::real::{Count, Mask, ROUND_F32, Real};

/// How many closed loops run side by side. Two vectors of AVX2: while one waits for a result, the other
/// computes.
pub const LANES: usize = 16;

/// Work on [`LANES`] numbers at once.
pub trait Kernel {
    /// What comes out.
    type Output;
    /// Does it; to be `#[inline(always)]`.
    fn run<R: Real<Scalar = f32>>(self) -> Self::Output;
}

/// Does `kernel` with the best instructions that this processor has.
pub fn in_lanes<K: Kernel>(kernel: K) -> K::Output {
    in_lanes_with(Level::new(), kernel)
}

/// Does `kernel` with the instructions of `level`, or the plainest vectors of the processor where it has no
/// code for that level.
pub fn in_lanes_with<K: Kernel>(level: Level, kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        // Compiled where speed is asked for: each would be a third of what a first build costs.
        #[cfg(not(debug_assertions))]
        {
            if let Some(simd) = level.as_avx512() {
                return vectorized(simd, kernel);
            }
            if let Some(simd) = level.as_avx2() {
                return vectorized(simd, kernel);
            }
        }
        if let Some(simd) = level.as_sse2() {
            return vectorized(simd, kernel);
        }
        unreachable!("every x86-64 processor has SSE2")
    }
    // Compiled for vectors, a module has them; lanes one by one would be many times its size.
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    {
        let Some(simd) = level.as_wasm_simd128() else { unreachable!("the module is made for vectors") };
        outlined(simd, kernel)
    }
    #[cfg(not(any(target_arch = "x86_64", all(target_arch = "wasm32", target_feature = "simd128"))))]
    fearless_simd::dispatch!(level, simd => outlined(simd, kernel))
}

/// Where the vectors are every processor's, nothing else keeps a kernel from being compiled anew wherever it
/// is used.
#[cfg(not(target_arch = "x86_64"))]
#[inline(never)]
fn outlined<S: Simd, K: Kernel>(simd: S, kernel: K) -> K::Output {
    vectorized(simd, kernel)
}

/// The token is the proof that the processor has the instructions of `Lanes<S>`, which has no other user.
#[inline(always)]
fn vectorized<S: Simd, K: Kernel>(simd: S, kernel: K) -> K::Output {
    simd.vectorize(
        #[inline(always)]
        || kernel.run::<Lanes<S>>(),
    )
}

/// What computes the lanes on this processor, in words.
pub fn instruction_set() -> String {
    format!("{:?}", Level::new()).split('(').next().unwrap_or_default().to_uppercase()
}

/// [`LANES`] numbers.
#[derive(Clone, Copy)]
struct Lanes<S: Simd>(f32x16<S>);

/// [`LANES`] truth values.
#[derive(Clone, Copy)]
struct Truths<S: Simd>(mask32x16<S>);

#[expect(unsafe_code, reason = "a proof that is known to exist is not handed through every sum and product")]
#[inline(always)]
fn token<S: Simd>() -> S {
    const { assert!(size_of::<S>() == 0, "a token holds nothing") };
    // SAFETY: a token is an empty value, so any bits make one. It stands for the proof that the processor has
    // the instructions of S; `Lanes<S>`, private to this file, is only made inside `vectorized`, which was
    // given that very proof.
    unsafe { std::mem::zeroed() }
}

impl<S: Simd> fmt::Debug for Lanes<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.as_slice().fmt(f)
    }
}

impl<S: Simd> fmt::Debug for Truths<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016b}", self.0.to_bitmask())
    }
}

impl<S: Simd> Default for Lanes<S> {
    #[inline(always)]
    fn default() -> Self {
        Self::splat(0.0)
    }
}

impl<S: Simd> PartialEq for Lanes<S> {
    fn eq(&self, other: &Self) -> bool {
        self.0.as_slice() == other.0.as_slice()
    }
}

macro_rules! operator {
    ($type:ident: $($trait:ident $method:ident),+) => {$(
        impl<S: Simd> $trait for $type<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    )+};
}
operator!(Lanes: Add add, Sub sub, Mul mul, Div div);
operator!(Truths: BitAnd bitand, BitOr bitor);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Simd> Not for Truths<S> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl<S: Simd> Mask for Truths<S> {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self(mask32x16::splat(token(), value))
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any_true()
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0.all_true()
    }
    #[inline(always)]
    fn lane(self, index: usize) -> bool {
        self.0.test(index)
    }
}

impl<S: Simd> Real for Lanes<S> {
    type Mask = Truths<S>;
    type Count = Self;
    type Scalar = f32;
    const LANES: usize = LANES;

    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self::splat(f32::from_f64(value))
    }
    #[inline(always)]
    fn from_i32(value: i32) -> Self {
        Self::splat(f32::from_i32(value))
    }
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(f32x16::splat(token(), value))
    }
    #[inline(always)]
    fn from_fn(f: impl FnMut(usize) -> f32) -> Self {
        Self(f32x16::from_fn(token(), f))
    }
    #[inline(always)]
    fn lane(self, index: usize) -> f32 {
        self.0[index]
    }
    #[inline(always)]
    fn to_count(self) -> Self {
        self
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[cfg_attr(debug_assertions, inline(never))]
    fn sin_cos(self) -> (Self, Self) {
        twinrotor::real::trig::sin_cos(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Truths<S> {
        Truths(self.0.simd_lt(other.0))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Truths<S> {
        Truths(self.0.simd_le(other.0))
    }
    #[inline(always)]
    fn is_finite(self) -> Truths<S> {
        self.abs().lt(Self::splat(f32::INFINITY))
    }
    #[inline(always)]
    fn select(mask: Truths<S>, yes: Self, no: Self) -> Self {
        Self(mask.0.select(yes.0, no.0))
    }
    #[inline(always)]
    fn round_small(self) -> Self {
        (self + Self::splat(ROUND_F32)) - Self::splat(ROUND_F32)
    }
}

/// Whole numbers up to 2^24: beyond, one more is no more.
impl<S: Simd> Count<Truths<S>> for Lanes<S> {
    #[inline(always)]
    fn whole(number: i32) -> Self {
        Self::from_i32(number)
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn one_more(self) -> Self {
        self + Self::one()
    }
    #[inline(always)]
    fn reaches(self, least: i32) -> Truths<S> {
        Self::from_i32(least).le(self)
    }
    #[inline(always)]
    fn exceeds(self, most: Self) -> Truths<S> {
        most.lt(Real::abs(self))
    }
    #[inline(always)]
    fn pick(mask: Truths<S>, yes: Self, no: Self) -> Self {
        Self::select(mask, yes, no)
    }
}

/// Numbers that belong together, in a fixed order, side by side: lane k is made of `rows[k]`, the last row
/// fills what lanes are left. Calling it once for each number in that order gives that number in every lane.
fn columns<R: Real<Scalar = f32>>(rows: &[Vec<f32>]) -> impl FnMut() -> R {
    let mut index = 0;
    move || {
        let number = R::from_fn(|lane| rows[lane.min(rows.len() - 1)][index]);
        index += 1;
        number
    }
}

/// Controllers' settings side by side. They may differ in numbers, not in kind.
pub fn gather<R: Real<Scalar = f32>>(settings: &[Settings<f32>]) -> Settings<R> {
    let rows: Vec<Vec<f32>> = settings.iter().map(|s| numbers(|f| _ = s.map(f))).collect();
    let mut next = columns(&rows);
    settings[0].map(|_| next())
}

/// Plants' constants side by side.
pub fn gather_plants<R: Real<Scalar = f32>>(plants: &[PlantParameters<f32>]) -> PlantParameters<R> {
    let rows: Vec<Vec<f32>> = plants.iter().map(|p| numbers(|f| _ = p.map(f))).collect();
    let mut next = columns(&rows);
    plants[0].map(|_| next())
}

/// Rotors side by side.
pub fn gather_rotors<R: Real<Scalar = f32>>(rotors: &[LaggedRotors<f32>]) -> LaggedRotors<R> {
    let rows: Vec<Vec<f32>> = rotors.iter().map(|r| numbers(|f| _ = r.map(f))).collect();
    let mut next = columns(&rows);
    rotors[0].map(|_| next())
}

/// The numbers that `visit` shows its argument.
fn numbers(visit: impl FnOnce(&mut dyn FnMut(f32) -> f32)) -> Vec<f32> {
    let mut seen = Vec::new();
    visit(&mut |x| {
        seen.push(x);
        x
    });
    seen
}

/// Every level that this processor has code for.
pub fn levels() -> Vec<Level> {
    let best = Level::new();
    #[cfg(target_arch = "x86_64")]
    let between = best.as_avx2().map(Simd::level);
    #[cfg(not(target_arch = "x86_64"))]
    let between = None;
    [best, Level::baseline()].into_iter().chain(between).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Any bit pattern: NaN, infinities, subnormals and signed zeros included.
    fn any_float() -> impl Strategy<Value = f32> {
        any::<u32>().prop_map(f32::from_bits)
    }

    /// Every operation on two numbers a lane.
    struct Everything<'a>(&'a [f32; LANES], &'a [f32; LANES]);

    fn all_of<R: Real>(a: R, b: R) -> Vec<R> {
        let (finite, less, at_most) = (a.is_finite(), a.lt(b), a.le(b));
        let (one, zero) = (R::one(), R::zero());
        let mut results =
            vec![a + b, a - b, a * b, a / b, -a, a.abs(), a.sqrt(), a.min(b), a.max(b), a.round()];
        results.extend(
            [finite, less, at_most, finite & less, less | at_most, !finite].map(|m| R::select(m, one, zero)),
        );
        let (sine, cosine) = R::select(a.abs().lt(R::from_f64(1e4)), a, zero).sin_cos();
        results.extend([sine, cosine]);
        results
    }

    impl Kernel for Everything<'_> {
        type Output = Vec<[f32; LANES]>;
        #[inline(always)]
        fn run<R: Real<Scalar = f32>>(self) -> Self::Output {
            let (a, b) = (R::from_fn(|k| self.0[k]), R::from_fn(|k| self.1[k]));
            let any = R::is_finite(a).any();
            assert_eq!(any, self.0.iter().any(|x| x.is_finite()));
            assert_eq!(a.is_finite().all(), self.0.iter().all(|x| x.is_finite()));
            assert!((0..LANES).all(|k| a.is_finite().lane(k) == self.0[k].is_finite()));
            all_of(a, b).into_iter().map(|r| std::array::from_fn(|k| r.lane(k))).collect()
        }
    }

    proptest! {
        #[test]
        fn every_operation_is_the_scalar_one(
            a in prop::array::uniform16(any_float()),
            b in prop::array::uniform16(any_float()),
            small in prop::array::uniform16(-1e4_f32..1e4),
        ) {
            for (a, b) in [(&a, &b), (&small, &a), (&small, &small)] {
                // The last is without any vectors.
                let mut results: Vec<_> =
                    levels().into_iter().map(|level| in_lanes_with(level, Everything(a, b))).collect();
                if let Level::Fallback(plain) = Level::fallback() {
                    results.push(vectorized(plain, Everything(a, b)));
                }
                for (level, lanes) in results.iter().enumerate() {
                    for k in 0..LANES {
                        for (n, (lanes, alone)) in lanes.iter().zip(all_of(a[k], b[k])).enumerate() {
                            let lane = lanes[k];
                            prop_assert!(
                                lane.to_bits() == alone.to_bits() || (lane.is_nan() && alone.is_nan()),
                                "level {level}, operation {n}, lane {k}: {lane} {alone}"
                            );
                        }
                    }
                }
            }
        }
    }
}
