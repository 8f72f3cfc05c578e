//! Methods of search side by side: the same problem, bounds and budget, many seeds, and statistics that say
//! what the difference is worth.

mod ranks;

pub use ranks::{holm, rank_sum};

use crate::optimise::{Bounds, Candidate, Draws, Optimiser, Searcher, Setup};
use crate::parallel::NEVER;
use crate::robust::quantile;
use crate::search::Problem;
use serde::Serialize;

/// One search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Run {
    /// Of its random numbers.
    pub seed: u64,
    /// The best cost.
    pub cost: f64,
    /// Where that is.
    pub position: Vec<f64>,
    /// Evaluations and cost at every improvement.
    pub history: Vec<(usize, f64)>,
}

impl Run {
    /// Evaluations it took to get to `cost` or below.
    pub fn evaluations_to(&self, cost: f64) -> Option<usize> {
        self.history.iter().find(|(_, c)| *c <= cost).map(|(n, _)| *n)
    }

    /// The best cost after `evaluations`.
    pub fn cost_after(&self, evaluations: usize) -> f64 {
        let before = self.history.partition_point(|(n, _)| *n <= evaluations);
        before.checked_sub(1).map_or(f64::INFINITY, |k| self.history[k].1)
    }
}

/// One method over all seeds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Peer {
    /// What it is called.
    pub name: String,
    /// One for each seed.
    pub runs: Vec<Run>,
}

/// A search under way.
struct Running {
    seed: u64,
    search: Searcher,
    history: Vec<(usize, f64)>,
}

impl Running {
    /// Is told what was asked for; how many evaluations that adds.
    fn tell(&mut self, costs: &[f64]) -> usize {
        let before = self.search.evaluations();
        self.search.tell(costs);
        // What was computed ahead and thrown away is at the end.
        let used = self.search.evaluations() - before;
        for (number, cost) in (before + 1..).zip(&costs[..used]) {
            if self.history.last().is_none_or(|(_, best)| cost < best) {
                self.history.push((number, *cost));
            }
        }
        used
    }

    fn ended(self, dimension: usize) -> Run {
        // Where every candidate diverged there is no best, and it is nowhere.
        let nowhere = || (f64::INFINITY, vec![f64::NAN; dimension]);
        let (cost, position) = self.search.best().map_or_else(nowhere, |b| (b.cost, b.position.clone()));
        Run { seed: self.seed, cost, position, history: self.history }
    }
}

impl Peer {
    /// Searches `problem` once for each of `seeds`; there must be one. All ask together, so that lanes, cores
    /// and cards get as many candidates at once as there are. `seen` is shown how many evaluations were
    /// added. Nothing where the problem has no costs any more.
    pub fn search(
        name: &str,
        setup: &Setup,
        bounds: &Bounds,
        seeds: &[u64],
        problem: &dyn Problem,
        seen: &dyn Fn(usize),
    ) -> Option<Self> {
        let start = |&seed: &u64| {
            let search = setup.start(bounds.clone(), Draws::new(seed));
            Running { seed, search, history: Vec::new() }
        };
        let mut all: Vec<Running> = seeds.iter().map(start).collect();
        loop {
            let asked: Vec<Vec<Candidate>> = all.iter_mut().map(|run| run.search.ask()).collect();
            let together = asked.concat();
            if together.is_empty() {
                break;
            }
            let costs = problem.costs_until(&together, NEVER)?;
            let mut rest = &costs[..];
            for (run, asked) in all.iter_mut().zip(&asked).filter(|(_, asked)| !asked.is_empty()) {
                let own;
                (own, rest) = rest.split_at(asked.len());
                seen(run.tell(own));
            }
        }
        let runs = all.into_iter().map(|run| run.ended(bounds.dimension())).collect();
        Some(Self { name: name.to_owned(), runs })
    }

    /// The best cost of each run.
    pub fn costs(&self) -> Vec<f64> {
        self.runs.iter().map(|r| r.cost).collect()
    }

    /// The run that ended lowest.
    pub fn best(&self) -> &Run {
        self.runs.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).expect("at least one seed")
    }
}

/// A method in numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Standing {
    /// What it is called.
    pub name: String,
    /// Of the best costs over seeds.
    pub median: f64,
    /// Between the quarter points.
    pub interquartile_range: f64,
    /// The lowest.
    pub best: f64,
    /// The highest.
    pub worst: f64,
    /// Median evaluations to within 1 % of the best cost known; none if fewer than half of the seeds got
    /// there.
    pub evaluations_to_1_percent: Option<f64>,
    /// The same to within .1 %.
    pub evaluations_to_01_percent: Option<f64>,
    /// That its costs and the first method's differ by chance (rank sum, two-sided, Holm's correction); none
    /// for the first.
    pub p_value: Option<f64>,
}

/// The lowest cost that any of them found.
pub fn best_known(peers: &[Peer]) -> f64 {
    peers.iter().flat_map(Peer::costs).fold(f64::INFINITY, f64::min)
}

/// All in numbers, compared with the first.
pub fn standings(peers: &[Peer], best_known: f64) -> Vec<Standing> {
    let first = peers.first().map(Peer::costs).unwrap_or_default();
    let raw: Vec<f64> = peers.iter().skip(1).map(|p| rank_sum(&p.costs(), &first)).collect();
    let mut corrected = std::iter::once(None).chain(holm(&raw).into_iter().map(Some));
    let mut standing = |peer: &Peer| {
        let costs = peer.costs();
        let to = |part: f64| {
            let needed =
                |r: &Run| r.evaluations_to(best_known * (1.0 + part)).map_or(f64::INFINITY, |n| n as f64);
            let median = quantile(&peer.runs.iter().map(needed).collect::<Vec<_>>(), 0.5);
            median.is_finite().then_some(median)
        };
        Standing {
            name: peer.name.clone(),
            median: quantile(&costs, 0.5),
            interquartile_range: quantile(&costs, 0.75) - quantile(&costs, 0.25),
            best: quantile(&costs, 0.0),
            worst: quantile(&costs, 1.0),
            evaluations_to_1_percent: to(0.01),
            evaluations_to_01_percent: to(0.001),
            p_value: corrected.next().flatten(),
        }
    };
    peers.iter().map(&mut standing).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peer(name: &str, costs: &[f64]) -> Peer {
        let run = |(seed, cost): (u64, &f64)| Run {
            seed,
            cost: *cost,
            position: vec![],
            history: vec![(1, 10.0 * cost), (10, 1.005 * cost), (40, *cost)],
        };
        Peer { name: name.into(), runs: (0..).zip(costs).map(run).collect() }
    }

    #[test]
    fn a_standing_is_what_the_runs_say() {
        let peers = [peer("a", &[1.0, 1.0, 1.0, 1.0, 1.2]), peer("b", &[2.0, 2.1, 2.2, 2.3, 2.4])];
        let known = best_known(&peers);
        assert_eq!(known, 1.0);
        let [a, b] = &standings(&peers, known)[..] else { panic!("two") };
        assert_eq!((a.median, a.best, a.worst, a.interquartile_range), (1.0, 1.0, 1.2, 0.0));
        assert_eq!((a.evaluations_to_1_percent, a.evaluations_to_01_percent), (Some(10.0), Some(40.0)));
        assert_eq!((b.evaluations_to_1_percent, a.p_value), (None, None));
        assert!(b.p_value.unwrap() < 0.02);
        assert_eq!(peers[0].runs[0].cost_after(9), 10.0);
        assert_eq!(peers[0].runs[0].cost_after(0), f64::INFINITY);
    }
}
