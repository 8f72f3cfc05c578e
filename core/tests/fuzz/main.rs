//! Nonsense by the million, counted: at the decoder of the link, at the conversation with the loop behind it,
//! at the parameter record. Nothing may panic, no message may be dealt with twice, and no motor may turn
//! without an `Arm` or a `Check` of this boot.
//!
//! A million inputs each, or as many as `TWINROTOR_FUZZ` says:
//! `TWINROTOR_FUZZ=100000000 cargo test --release -p core --test fuzz`.

mod conversation;
mod decoder;
mod record;

use twinrotor::parameters::Parameters;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets;
use twinrotor::{SAMPLE_TIME, defaults};

const INPUTS: u64 = 1_000_000;

/// How many inputs each target gets.
fn inputs() -> u64 {
    std::env::var("TWINROTOR_FUZZ").map_or(INPUTS, |n| n.parse().expect("a number"))
}

/// SplitMix64: every seed is a good one.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }

    /// One in so many.
    fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    fn index(&mut self, length: usize) -> usize {
        usize::try_from(self.below(length as u64)).expect("below a usize")
    }

    #[expect(clippy::cast_possible_truncation, reason = "any bits are wanted")]
    fn byte(&mut self) -> u8 {
        self.next() as u8
    }

    #[expect(clippy::cast_possible_truncation, reason = "any bits are wanted")]
    fn word(&mut self) -> u32 {
        self.next() as u32
    }

    /// Any bits, or a number of this world.
    fn float(&mut self) -> f32 {
        if self.one_in(4) { f32::from_bits(self.word()) } else { self.word() as f32 / 4e9 - 0.5 }
    }
}

/// What a board flies that was flashed well.
fn sound() -> Parameters {
    let settings = Settings::new(&presets::AERO2, defaults::AERO2, SAMPLE_TIME);
    Parameters { checked: true, ..Parameters::new(&presets::AERO2, &settings) }
}
