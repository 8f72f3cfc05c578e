//! The simplex method of J. A. Nelder and R. Mead (Computer J. 7, 1965) with coefficients adapted to the
//! dimension (F. Gao, L. Han, Comput. Optim. Appl. 51, 2012), restarted from a random point when its simplex
//! has collapsed.

use super::generations::{Method, Turn, free, ranking};
use super::{Candidate, are_points};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// Edge of a new simplex, as a part of the cube.
const EDGE: f64 = 0.25;
/// A simplex smaller than this has collapsed.
const COLLAPSED: f64 = 1e-7;

/// What was asked for last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Stage {
    Build,
    Reflect,
    Expand,
    ContractOutside,
    ContractInside,
    Shrink,
}

/// The simplex, best corner first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct NelderMead {
    stage: Stage,
    corners: Vec<(Vec<f64>, f64)>,
    reflected: (Vec<f64>, f64),
}

impl NelderMead {
    pub(super) fn new() -> Self {
        Self { stage: Stage::Build, corners: Vec::new(), reflected: (Vec::new(), f64::INFINITY) }
    }

    /// Could a search in so many dimensions have come to this?
    pub(super) fn is_sound(&self, dimension: usize) -> bool {
        let corners: Vec<Vec<f64>> = self.corners.iter().map(|(corner, _)| corner.clone()).collect();
        let whole = are_points(&corners, dimension + 1, dimension);
        match self.stage {
            Stage::Build => true,
            Stage::Reflect | Stage::Shrink => whole,
            Stage::Expand | Stage::ContractOutside | Stage::ContractInside => {
                whole && are_points(std::slice::from_ref(&self.reflected.0), 1, dimension)
            }
        }
    }

    fn build(turn: &Turn<'_>) -> Vec<Candidate> {
        let mut rng = turn.rng(0);
        let first: Vec<f64> = (0..turn.dimension()).map(|_| rng.random()).collect();
        let mut corners = vec![first.clone()];
        for d in 0..first.len() {
            let mut corner = first.clone();
            corner[d] += if corner[d] > 0.5 { -EDGE } else { EDGE };
            corners.push(corner);
        }
        corners.into_iter().map(free).collect()
    }

    /// The point at `factor` from the middle of all corners but the worst, away from that.
    fn away(&self, factor: f64) -> Vec<f64> {
        let (worst, others) = self.corners.split_last().expect("a simplex has corners");
        let count = others.len() as f64;
        (0..others.len())
            .map(|d| {
                let middle = others.iter().map(|c| c.0[d]).sum::<f64>() / count;
                middle + factor * (middle - worst.0[d])
            })
            .collect()
    }

    /// The point at `factor` from the middle, towards or beyond the reflected point.
    fn beyond(&self, factor: f64) -> Vec<f64> {
        let others = &self.corners[..self.corners.len() - 1];
        let count = others.len() as f64;
        (0..others.len())
            .map(|d| {
                let middle = others.iter().map(|c| c.0[d]).sum::<f64>() / count;
                middle + factor * (self.reflected.0[d] - middle)
            })
            .collect()
    }

    fn size(&self) -> f64 {
        let best = &self.corners[0].0;
        self.corners.iter().flat_map(|c| c.0.iter().zip(best).map(|(a, b)| (a - b).abs())).fold(0.0, f64::max)
    }

    /// The new corner takes the place of the worst.
    fn take(&mut self, corner: (Vec<f64>, f64)) -> Stage {
        self.corners.pop();
        let place = self.corners.partition_point(|c| c.1 <= corner.1);
        self.corners.insert(place, corner);
        Stage::Reflect
    }
}

impl Method for NelderMead {
    fn propose(&mut self, turn: &Turn<'_>) -> Vec<Candidate> {
        if self.stage == Stage::Reflect && self.size() < COLLAPSED {
            self.stage = Stage::Build;
        }
        let n = turn.dimension() as f64;
        let (expansion, contraction, shrink) = (1.0 + 2.0 / n, 0.75 - 0.5 / n, 1.0 - 1.0 / n.max(2.0));
        match self.stage {
            Stage::Build => Self::build(turn),
            Stage::Reflect => vec![free(self.away(1.0))],
            Stage::Expand => vec![free(self.beyond(expansion))],
            Stage::ContractOutside => vec![free(self.beyond(contraction))],
            Stage::ContractInside => vec![free(self.away(-contraction))],
            Stage::Shrink => {
                let best = &self.corners[0].0;
                let towards = |corner: &(Vec<f64>, f64)| {
                    free(corner.0.iter().zip(best).map(|(x, b)| b + shrink * (x - b)).collect())
                };
                self.corners[1..].iter().map(towards).collect()
            }
        }
    }

    fn learn(&mut self, points: Vec<Candidate>, costs: &[f64]) {
        let mut told: Vec<(Vec<f64>, f64)> =
            points.into_iter().map(|c| c.position).zip(costs.iter().copied()).collect();
        self.stage = match self.stage {
            Stage::Build | Stage::Shrink => {
                if self.stage == Stage::Shrink {
                    told.push(self.corners[0].clone());
                }
                let costs: Vec<f64> = told.iter().map(|c| c.1).collect();
                self.corners = ranking(&costs).into_iter().map(|k| told[k].clone()).collect();
                Stage::Reflect
            }
            Stage::Reflect => {
                self.reflected = told.remove(0);
                let (cost, last) = (self.reflected.1, self.corners.len() - 1);
                if cost < self.corners[0].1 {
                    Stage::Expand
                } else if cost < self.corners[last - 1].1 {
                    self.take(self.reflected.clone())
                } else if cost < self.corners[last].1 {
                    Stage::ContractOutside
                } else {
                    Stage::ContractInside
                }
            }
            Stage::Expand => {
                let better =
                    if told[0].1 < self.reflected.1 { told.remove(0) } else { self.reflected.clone() };
                self.take(better)
            }
            Stage::ContractOutside if told[0].1 <= self.reflected.1 => self.take(told.remove(0)),
            Stage::ContractInside if told[0].1 < self.corners[self.corners.len() - 1].1 => {
                self.take(told.remove(0))
            }
            Stage::ContractOutside | Stage::ContractInside => Stage::Shrink,
        };
    }
}
