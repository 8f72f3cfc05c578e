//! Search that learns nothing: what any method must beat.

use super::Candidate;
use super::generations::{Method, Turn, free};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// Points spread over the box, whatever they cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Samples {
    /// Independent and uniform.
    Random,
    /// Sobol's sequence, Owen-scrambled by the seed (B. Burley, JCGT 9(4), 2020; crate `sobol_burley`).
    Sobol,
}

/// Points at a time: any number gives the same points.
const AT_A_TIME: usize = 64;

impl Method for Samples {
    fn propose(&mut self, turn: &Turn<'_>) -> Vec<Candidate> {
        match self {
            Self::Random => turn.uniform(AT_A_TIME),
            Self::Sobol => {
                let scramble: u32 = turn.draws.of_move(0).random();
                let coordinate = |index: usize, d: usize| {
                    let number = |n: usize| u32::try_from(n % (1 << 16)).unwrap_or_default();
                    f64::from(sobol_burley::sample(number(index), number(d), scramble))
                };
                (0..AT_A_TIME)
                    .map(|k| free((0..turn.dimension()).map(|d| coordinate(turn.done + k, d)).collect()))
                    .collect()
            }
        }
    }

    fn learn(&mut self, _points: Vec<Candidate>, _costs: &[f64]) {}
}
