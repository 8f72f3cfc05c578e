//! Bytes and words that are nearly right.

use rand::{Rng, RngExt};

/// Numbers and words that programs stumble over.
pub(crate) const NASTY: [&str; 40] = [
    "nan",
    "inf",
    "-inf",
    "0",
    "-0",
    "-1",
    "1",
    "2",
    "3",
    "1e300",
    "-1e300",
    "1e-320",
    "1e39",
    "1e9",
    "-1e9",
    "0.001",
    "1e999",
    "4294967296",
    "9007199254740993",
    "9223372036854775808",
    "18446744073709551613",
    "18446744073709551615",
    "99999999999999999999",
    "true",
    "\"\"",
    "[]",
    "{}",
    "''",
    "\u{feff}",
    "\0",
    "\n",
    ",",
    ";",
    "=",
    "[",
    "]",
    "[[",
    "θ",
    "#",
    "\"\"\"",
];

/// One of these.
pub(crate) fn one_of<'a, T>(rng: &mut impl Rng, all: &'a [T]) -> &'a T {
    &all[rng.random_range(0..all.len())]
}

/// A few changes to a text or to any other bytes.
pub(crate) fn mutated(rng: &mut impl Rng, good: &[u8]) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..rng.random_range(1..5) {
        change(rng, &mut bytes);
    }
    bytes
}

fn change(rng: &mut impl Rng, bytes: &mut Vec<u8>) {
    if bytes.is_empty() {
        bytes.extend(one_of(rng, &NASTY).bytes());
        return;
    }
    let at = rng.random_range(0..bytes.len());
    let end = (at + rng.random_range(1..40)).min(bytes.len());
    match rng.random_range(0..9) {
        0 => bytes[at] ^= 1 << rng.random_range(0..8),
        1 => bytes[at] = rng.random(),
        2 => drop(bytes.drain(at..end)),
        3 => bytes.truncate(at),
        4 => {
            let part = bytes[at..end].to_vec();
            let to = rng.random_range(0..=bytes.len());
            bytes.splice(to..to, part);
        }
        5 => drop(bytes.splice(at..at, one_of(rng, &NASTY).bytes())),
        // A number, the thing that files are full of.
        6 | 7 => replace_number(rng, bytes, at),
        _ => swap_lines(rng, bytes),
    }
}

/// Puts something else where the next number is.
fn replace_number(rng: &mut impl Rng, bytes: &mut Vec<u8>, from: usize) {
    let numeric = |byte: &u8| byte.is_ascii_digit() || b".-+e".contains(byte);
    let Some(begin) = bytes[from..].iter().position(u8::is_ascii_digit).map(|k| from + k) else { return };
    let end = bytes[begin..].iter().position(|byte| !numeric(byte)).map_or(bytes.len(), |k| begin + k);
    bytes.splice(begin..end, one_of(rng, &NASTY).bytes());
}

fn swap_lines(rng: &mut impl Rng, bytes: &mut Vec<u8>) {
    let mut lines: Vec<Vec<u8>> = bytes.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    let (a, b) = (rng.random_range(0..lines.len()), rng.random_range(0..lines.len()));
    lines.swap(a, b);
    *bytes = lines.join(&b'\n');
}
