//! Random numbers that depend on the seed and on which move they are for, and on nothing else.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

/// A seed, as a source of independent random streams: one for each move of a search. A move's draws are the
/// same whatever costs came before it, however often it is planned anew, and after a restart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Draws {
    seed: u64,
}

impl Draws {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// The stream of move `index` (ChaCha with 8 rounds, whose streams are independent by construction).
    pub fn of_move(&self, index: usize) -> impl Rng + use<> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(index as u64);
        rng
    }
}
