//! What a problem costs over two of its coordinates, cell by cell: the ground that a search walks on.

use crate::checkpoint::{self, Identity};
use crate::optimise::Candidate;
use crate::parallel::Stop;
use crate::search::Problem;
use serde::{Deserialize, Serialize};
use twinrotor_sim::Outcome;

/// Cells side by side along a coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Where the first one begins.
    pub from: f64,
    /// Where the last one ends.
    pub to: f64,
    /// How many there are.
    pub cells: usize,
}

impl Axis {
    /// In the middle of the cell of this number.
    pub fn middle(&self, cell: usize) -> f64 {
        self.from + (self.to - self.from) * (cell as f64 + 0.5) / self.cells as f64
    }
}

/// The costs of all cells, or of as many as are known yet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Landscape {
    identity: Identity,
    /// Across and up.
    axes: [Axis; 2],
    /// Row by row, the lowest first.
    costs: Vec<f64>,
}

impl Landscape {
    /// Of which nothing is known yet.
    pub fn new(identity: Identity, axes: [Axis; 2]) -> Self {
        Self { identity, axes, costs: Vec::new() }
    }

    /// This one, of which nothing is known yet, as it stood when [`Landscape::checkpoint`] was asked.
    ///
    /// # Errors
    ///
    /// If the bytes are damaged, of another version or of another run.
    pub fn resume(self, bytes: &[u8]) -> Outcome<Self> {
        let then: Self = checkpoint::decode(bytes, &self.identity)?;
        let fits = then.identity == self.identity
            && then.axes == self.axes
            && then.costs.len() <= self.cells()
            && then.costs.len().is_multiple_of(self.axes[0].cells);
        if fits { Ok(then) } else { Err(checkpoint::damaged()) }
    }

    /// Where it stands, for [`Landscape::resume`].
    pub fn checkpoint(&self) -> Vec<u8> {
        checkpoint::encode(&self.identity, self)
    }

    /// How many cells there are.
    pub fn cells(&self) -> usize {
        self.axes[0].cells * self.axes[1].cells
    }

    /// Across and up.
    pub fn axes(&self) -> &[Axis; 2] {
        &self.axes
    }

    /// What is known, row by row, the lowest first.
    pub fn costs(&self) -> &[f64] {
        &self.costs
    }

    /// The coordinates in the middle of the cell of this number.
    pub fn place(&self, cell: usize) -> [f64; 2] {
        let [across, up] = self.axes;
        [across.middle(cell % across.cells), up.middle(cell / across.cells)]
    }

    /// The cell that costs least of those that are known; none where no cost is finite.
    pub fn best(&self) -> Option<usize> {
        let known = self.costs.iter().enumerate().filter(|(_, cost)| cost.is_finite());
        known.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(cell, _)| cell)
    }

    /// Row by row to the end, about `at_once` cells together, each at the `position` of its coordinates;
    /// `after` sees where it stands in between. False where `stop` said so, or the problem has no more costs.
    pub fn run(
        &mut self,
        problem: &dyn Problem,
        position: impl Fn([f64; 2]) -> Vec<f64>,
        at_once: usize,
        stop: Stop<'_>,
        mut after: impl FnMut(&Self),
    ) -> bool {
        let row = self.axes[0].cells;
        let rows = (at_once / row).max(1);
        while self.costs.len() < self.cells() {
            let these = self.costs.len()..(self.costs.len() + rows * row).min(self.cells());
            let candidate = |cell| Candidate { position: position(self.place(cell)), bound: f64::INFINITY };
            let candidates: Vec<Candidate> = these.map(candidate).collect();
            let Some(costs) = problem.costs_until(&candidates, stop) else { return false };
            self.costs.extend(costs);
            after(self);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::NEVER;
    use crate::search::Effort;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// A bowl, with its lowest point at (1, -2), that is gone after so many questions.
    struct Bowl(AtomicUsize);

    impl Problem for Bowl {
        fn costs_until(&self, candidates: &[Candidate], _: Stop<'_>) -> Option<Vec<f64>> {
            self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1)).ok()?;
            let cost = |c: &Candidate| (c.position[0] - 1.0).powi(2) + (c.position[1] + 2.0).powi(2);
            Some(candidates.iter().map(cost).collect())
        }

        fn effort(&self) -> Effort {
            Effort::default()
        }
    }

    fn bowl(questions: usize) -> Bowl {
        Bowl(AtomicUsize::new(questions))
    }

    fn fresh() -> Landscape {
        let axes = [Axis { from: 0.0, to: 4.0, cells: 8 }, Axis { from: -3.0, to: 0.0, cells: 5 }];
        Landscape::new(Identity::new().with("bowl", 1), axes)
    }

    #[test]
    fn every_cell_costs_what_its_middle_does_and_the_lowest_is_nearest_the_bottom() {
        let mut all = fresh();
        assert!(all.run(&bowl(99), |place| place.to_vec(), 1, NEVER, |_| {}));
        assert_eq!(all.costs().len(), 40);
        for (cell, cost) in all.costs().iter().enumerate() {
            let [x, y] = all.place(cell);
            assert_eq!(*cost, (x - 1.0).powi(2) + (y + 2.0).powi(2));
        }
        let [x, y] = all.place(all.best().unwrap());
        assert!((x - 1.0).abs() <= 0.25 && (y + 2.0).abs() <= 0.3, "{x} {y}");
        let ends = [all.place(0), all.place(39)].map(|[x, y]| [x - 2.0, y + 1.5].map(|d| (1e9 * d).round()));
        assert_eq!(ends, [[-1.75e9, -1.2e9], [1.75e9, 1.2e9]], "the middles of the first and the last");
    }

    #[test]
    fn a_landscape_that_was_broken_off_goes_on_to_the_same_end_however_many_cells_fly_together() {
        let mut straight = fresh();
        assert!(straight.run(&bowl(1), |place| place.to_vec(), 1000, NEVER, |_| {}));
        let mut broken = fresh();
        let mut kept = Vec::new();
        assert!(!broken.run(&bowl(2), |place| place.to_vec(), 1, NEVER, |now| kept = now.checkpoint()));
        let mut resumed = fresh().resume(&kept).unwrap();
        assert_eq!(resumed.costs().len(), 16);
        assert!(resumed.run(&bowl(99), |place| place.to_vec(), 17, NEVER, |_| {}));
        assert_eq!(resumed, straight);
        let other = Landscape::new(Identity::new().with("bowl", 2), *straight.axes());
        assert!(other.resume(&kept).unwrap_err().to_string().contains("bowl is 1 there, 2 here"));
    }
}
