//! Nonsense by the thousand, from a seed: at the parsers in one process, and at the whole program. Nothing
//! may panic and nothing may hang; what is read must be usable.
//!
//! `TWINROTOR_FUZZ=1000000 cargo test --release -p host-sim --test fuzz parsers` for a million inputs to the
//! parsers, `TWINROTOR_FUZZ=10000 cargo test --release -p host-sim --test fuzz program` for ten thousand
//! runs.

mod mutate;
mod parsers;
mod program;

/// How many cases a test has, `usual` of them if nobody says otherwise.
fn cases(usual: usize) -> usize {
    std::env::var("TWINROTOR_FUZZ").map_or(usual, |n| n.parse().expect("a number"))
}
