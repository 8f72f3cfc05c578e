//! What an instruction computes from its operands' bits.

/// From up to four operands' bits to the result's; what lies beyond the result's register is cut off.
pub(crate) type Meaning = fn([u64; 4]) -> u64;

fn f32_of(bits: u64) -> f32 {
    f32::from_bits(bits as u32)
}

fn f64_of(bits: u64) -> f64 {
    f64::from_bits(bits)
}

fn bits32(number: f32) -> u64 {
    u64::from(number.to_bits())
}

/// PTX's min and max: a NaN loses against a number, -0 is less than 0.
fn least(a: f32, b: f32) -> f32 {
    match (a.is_nan(), b.is_nan()) {
        (true, _) => b,
        (_, true) => a,
        _ if a.total_cmp(&b).is_lt() => a,
        _ => b,
    }
}

/// Is what `setp` compares so?
#[expect(clippy::float_cmp, reason = "it is what the instruction does")]
fn comparison(condition: &str, kind: &str) -> Option<Meaning> {
    macro_rules! float {
        ($of:ident) => {
            match condition {
                "lt" => |x| u64::from($of(x[0]) < $of(x[1])),
                "le" => |x| u64::from($of(x[0]) <= $of(x[1])),
                "gt" => |x| u64::from($of(x[0]) > $of(x[1])),
                "ge" => |x| u64::from($of(x[0]) >= $of(x[1])),
                "eq" => |x| u64::from($of(x[0]) == $of(x[1])),
                "ne" => |x| u64::from($of(x[0]) < $of(x[1]) || $of(x[0]) > $of(x[1])),
                // True with a NaN too.
                "ltu" => |x| u64::from(!($of(x[0]) >= $of(x[1]))),
                "leu" => |x| u64::from(!($of(x[0]) > $of(x[1]))),
                "gtu" => |x| u64::from(!($of(x[0]) <= $of(x[1]))),
                "geu" => |x| u64::from(!($of(x[0]) < $of(x[1]))),
                "equ" => |x| u64::from(!($of(x[0]) < $of(x[1]) || $of(x[0]) > $of(x[1]))),
                "neu" => |x| u64::from($of(x[0]) != $of(x[1])),
                "nan" => |x| u64::from($of(x[0]).is_nan() || $of(x[1]).is_nan()),
                "num" => |x| u64::from(!$of(x[0]).is_nan() && !$of(x[1]).is_nan()),
                _ => return None,
            }
        };
    }
    macro_rules! whole {
        ($t:ty) => {
            match condition {
                "lt" => |x| u64::from((x[0] as $t) < x[1] as $t),
                "le" => |x| u64::from(x[0] as $t <= x[1] as $t),
                "gt" => |x| u64::from(x[0] as $t > x[1] as $t),
                "ge" => |x| u64::from(x[0] as $t >= x[1] as $t),
                "eq" => |x| u64::from(x[0] as $t == x[1] as $t),
                "ne" => |x| u64::from(x[0] as $t != x[1] as $t),
                _ => return None,
            }
        };
    }
    Some(match kind {
        "f32" => float!(f32_of),
        "f64" => float!(f64_of),
        "s16" => whole!(i16),
        "s32" => whole!(i32),
        "s64" => whole!(i64),
        "b16" | "u16" => whole!(u16),
        "b32" | "u32" => whole!(u32),
        "b64" | "u64" => whole!(u64),
        _ => return None,
    })
}

/// The instruction of this name; `None` where it is not known.
pub(crate) fn meaning(name: &str) -> Option<Meaning> {
    if let Some((condition, kind)) = name.strip_prefix("setp.").and_then(|rest| rest.split_once('.')) {
        return comparison(condition, kind);
    }
    macro_rules! single {
        (|$($x:ident),+| $e:expr) => { |x| { let [$($x),+, ..] = x.map(f32_of); bits32($e) } };
    }
    macro_rules! double {
        (|$($x:ident),+| $e:expr) => { |x| { let [$($x),+, ..] = x.map(f64_of); f64::to_bits($e) } };
    }
    macro_rules! whole {
        ($t:ty, |$($x:ident),+| $e:expr) => {
            |x| { let [$($x),+, ..] = x.map(|x| x as $t); let result: $t = $e; result as u64 }
        };
    }
    Some(match name {
        "add.rn.f32" => single!(|a, b| a + b),
        "sub.rn.f32" => single!(|a, b| a - b),
        "mul.rn.f32" => single!(|a, b| a * b),
        "div.rn.f32" => single!(|a, b| a / b),
        "rcp.rn.f32" => single!(|a| 1.0 / a),
        "sqrt.rn.f32" => single!(|a| a.sqrt()),
        "min.f32" => single!(|a, b| least(a, b)),
        "max.f32" => single!(|a, b| -least(-a, -b)),
        // Of the sign alone, NaN or not.
        "abs.f32" => |x| x[0] & 0x7FFF_FFFF,
        "neg.f32" => |x| x[0] ^ 0x8000_0000,
        "add.rn.f64" => double!(|a, b| a + b),
        "sub.rn.f64" => double!(|a, b| a - b),
        "mul.rn.f64" => double!(|a, b| a * b),
        "div.rn.f64" => double!(|a, b| a / b),
        "abs.f64" => |x| x[0] & (u64::MAX >> 1),
        // The sign of the first, the magnitude of the second.
        "copysign.f32" => |x| x[0] & 0x8000_0000 | x[1] & 0x7FFF_FFFF,
        "copysign.f64" => |x| x[0] & 1 << 63 | x[1] & (u64::MAX >> 1),
        "cvt.rn.f32.f64" => |x| bits32(f64_of(x[0]) as f32),
        "cvt.f64.f32" => |x| f64::from(f32_of(x[0])).to_bits(),
        "cvt.rn.f32.s32" => |x| bits32(x[0] as i32 as f32),
        "cvt.rn.f32.u32" => |x| bits32(x[0] as u32 as f32),
        "cvt.rn.f64.u32" => |x| f64::from(x[0] as u32).to_bits(),
        "cvt.rzi.s32.f32" => |x| f32_of(x[0]) as i32 as u64,
        "add.s16" | "add.s32" | "add.s64" => |x| x[0].wrapping_add(x[1]),
        "sub.s16" | "sub.s32" | "sub.s64" => |x| x[0].wrapping_sub(x[1]),
        "neg.s32" => |x| x[0].wrapping_neg(),
        "abs.s32" => whole!(i32, |a| a.wrapping_abs()),
        "mul.lo.s32" | "mul.lo.s64" => |x| x[0].wrapping_mul(x[1]),
        "mad.lo.s32" => |x| x[0].wrapping_mul(x[1]).wrapping_add(x[2]),
        "mul.wide.u16" => |x| (x[0] & 0xFFFF) * (x[1] & 0xFFFF),
        "mul.wide.u32" => |x| (x[0] & 0xFFFF_FFFF) * (x[1] & 0xFFFF_FFFF),
        "div.u32" => whole!(u32, |a, b| a / b),
        "rem.u32" => whole!(u32, |a, b| a % b),
        "min.u32" => whole!(u32, |a, b| a.min(b)),
        "max.u32" => whole!(u32, |a, b| a.max(b)),
        "max.u64" => whole!(u64, |a, b| a.max(b)),
        "shl.b16" | "shl.b32" | "shl.b64" => |x| x[0].checked_shl(x[1] as u32).unwrap_or(0),
        "shr.u32" => |x| (x[0] & 0xFFFF_FFFF).checked_shr(x[1] as u32).unwrap_or(0),
        "shr.u64" => |x| x[0].checked_shr(x[1] as u32).unwrap_or(0),
        "bfe.u64" => |x| x[0] >> x[1] & (u64::MAX >> (64 - x[2])),
        "and.pred" | "and.b16" | "and.b32" | "and.b64" => |x| x[0] & x[1],
        "or.pred" | "or.b16" | "or.b32" | "or.b64" => |x| x[0] | x[1],
        "xor.pred" | "xor.b16" | "xor.b32" | "xor.b64" => |x| x[0] ^ x[1],
        "not.pred" | "not.b32" => |x| !x[0],
        "selp.b16" | "selp.b32" | "selp.b64" | "selp.f32" | "selp.f64" => {
            |x| if x[2] == 0 { x[1] } else { x[0] }
        }
        // Registers of all types hold bits here; those of 32 and less are zero beyond.
        "mov.pred" | "mov.b16" | "mov.b32" | "mov.u32" | "mov.b64" | "mov.u64" | "cvt.u16.u32"
        | "cvt.u32.u16" | "cvt.u32.u64" | "cvt.u64.u32" | "cvta.to.global.u64" | "cvta.shared.u64" => {
            |x| x[0]
        }
        // The two halves of what is twice as wide, the lower one first.
        "join.b64" => |x| x[0] | x[1] << 32,
        _ => return None,
    })
}
