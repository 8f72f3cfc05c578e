//! The bytes between host and board, and those of the parameter record on flash, as literals: a field or a
//! variant that changes its place changes what they mean, and fails here.
//!
//! The literals are the lines of `frames.txt`. `frames.py` writes it from a description of its own, with
//! Python's `zlib.crc32`: nothing of what is tested here has a part in them. Bytes that change on purpose
//! come with another [`twinrotor::link::VERSION`] or [`twinrotor::parameters::VERSION`].

mod messages;
mod record;

use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What the lines of `frames.txt` whose names begin with `prefix` say, by the rest of the name.
fn literals(prefix: &str) -> BTreeMap<&'static str, &'static str> {
    let lines = include_str!("frames.txt").lines().filter_map(|line| line.split_once(' '));
    lines.filter_map(|(name, digits)| Some((name.strip_prefix(prefix)?, digits))).collect()
}

/// Demands that each of `found` is its literal, and that there is one of each literal.
#[track_caller]
fn compare<'a>(prefix: &str, found: impl IntoIterator<Item = (&'a str, Vec<u8>)>) {
    let found: BTreeMap<&str, String> = found.into_iter().map(|(name, bytes)| (name, hex(&bytes))).collect();
    let expected = literals(prefix);
    assert!(!expected.is_empty());
    for (name, digits) in &expected {
        assert_eq!(found.get(name).map(String::as_str), Some(*digits), "{prefix}{name}");
    }
    assert_eq!(found.len(), expected.len(), "frames.txt has a line for each message");
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").expect("a string takes everything");
        text
    })
}

/// `first`, `first` + 1 and so on, one a call.
fn counting(first: u8) -> impl FnMut() -> f32 {
    let mut next = f32::from(first);
    move || {
        let now = next;
        next += 1.0;
        now
    }
}
