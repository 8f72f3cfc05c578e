//! One function: the square root of an `f32`, correctly rounded wherever it runs.
//!
//! IEEE 754 asks for correct rounding, so there is one answer for each argument. `libm` computes it in
//! software on ARM and on a GPU; a Cortex-M4F and a GPU have an instruction for it, which needs `unsafe` to
//! be said, and the core has none: hence this crate.

#![no_std]
#![cfg_attr(target_arch = "nvptx64", feature(asm_experimental_arch))]

/// The square root of `x`, correctly rounded; NaN below zero.
#[inline(always)]
#[must_use]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    {
        let mut bits = x.to_bits();
        #[expect(unsafe_code, reason = "an instruction that the language has no name for")]
        // SAFETY: VSQRT.F32 (ARMv7-M reference manual, A7.7.256) changes the registers declared, and flags.
        // By way of an integer register: the compiler gives assembly no others on a chip without double.
        unsafe {
            core::arch::asm!(
                "vmov s0, {bits}",
                "vsqrt.f32 s0, s0",
                "vmov {bits}, s0",
                bits = inlateout(reg) bits,
                out("s0") _,
                options(pure, nomem, nostack)
            );
        }
        f32::from_bits(bits)
    }
    #[cfg(target_arch = "nvptx64")]
    {
        let root: f32;
        #[expect(
            unsafe_code,
            reason = "an instruction that says how it rounds; the language's may approximate"
        )]
        // SAFETY: a function of its argument (PTX ISA, sqrt.rn.f32: IEEE 754, with subnormals).
        unsafe {
            core::arch::asm!(
                "sqrt.rn.f32 {root}, {x};",
                root = out(reg32) root,
                x = in(reg32) x,
                options(pure, nomem, nostack)
            );
        }
        root
    }
    #[cfg(not(any(target_arch = "nvptx64", all(target_arch = "arm", target_abi = "eabihf"))))]
    {
        libm::sqrtf(x)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    /// The square of what comes out, exact in f64, is never further off than that of a neighbour.
    #[test]
    fn it_is_correctly_rounded() {
        let arguments = (0..2_000_000_u32).map(|n| f32::from_bits(n * 1_073));
        for x in arguments.chain([0.0, -0.0, f32::MIN_POSITIVE, f32::MAX, f32::from_bits(1)]) {
            let root = super::sqrt(x);
            let reference = f64::from(x).sqrt();
            let off = |bits: u32| (f64::from(f32::from_bits(bits)) - reference).abs();
            let bits = root.to_bits();
            if x > 0.0 && x.is_finite() {
                assert!(off(bits) <= off(bits + 1) && off(bits) <= off(bits - 1), "{x:e}");
            } else if x.is_finite() {
                assert_eq!(bits, x.to_bits());
            }
        }
        assert!(super::sqrt(-1.0).is_nan() && super::sqrt(f32::NAN).is_nan());
        assert_eq!(super::sqrt(f32::INFINITY).to_bits(), f32::INFINITY.to_bits());
    }
}
