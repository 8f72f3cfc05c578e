//! Methods of search side by side: the same problem, bounds and budget, many seeds, and statistics that say
//! what the difference is worth.

mod ranks;

pub use ranks::{holm, rank_sum};

use crate::optimise::{Bounds, Candidate, Draws, Optimiser, Searcher, Setup};
use crate::parallel::NEVER;
use crate::robust::quantile;
use crate::search::Problem;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
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

    /// How many times as long as `other`, seed by seed the same start, it takes to come to `cost`, as medians
    /// of evaluations: between what 2.5 % and 97.5 % of the seeds drawn with replacement say (Efron's
    /// bootstrap). What a run does not come to counts as never; where both medians are never, anything may
    /// be.
    pub fn times_as_long(&self, other: &Self, cost: f64, seed: u64) -> [f64; 2] {
        const RESAMPLED: usize = 400;
        let mut draws = ChaCha8Rng::seed_from_u64(seed);
        let needed = |peer: &Self| -> Vec<f64> {
            let of = |run: &Run| run.evaluations_to(cost).map_or(f64::INFINITY, |n| n as f64);
            peer.runs.iter().map(of).collect()
        };
        let (own, others) = (needed(self), needed(other));
        let count = own.len().min(others.len());
        let (mut least, mut most) = (Vec::new(), Vec::new());
        for _ in 0..RESAMPLED {
            let chosen: Vec<usize> = (0..count).map(|_| draws.random_range(0..count)).collect();
            let of = |all: &[f64]| nearest(chosen.iter().map(|k| all[*k]).collect(), 0.5);
            let ratio = of(&own) / of(&others);
            least.push(if ratio.is_nan() { 0.0 } else { ratio });
            most.push(if ratio.is_nan() { f64::INFINITY } else { ratio });
        }
        [nearest(least, 0.025), nearest(most, 0.975)]
    }

    /// The run that ended lowest.
    pub fn best(&self) -> &Run {
        self.runs.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).expect("at least one seed")
    }
}

/// The value at `part` of the way through them in order: between none, since some may be infinite.
fn nearest(mut values: Vec<f64>, part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of a length")]
    let index = (part * last as f64).round() as usize;
    values.get(index).copied().unwrap_or(f64::NAN)
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
    fn how_many_times_as_long_a_method_takes_has_an_interval() {
        let of = |name: &str, evaluations: &[usize]| {
            let run = |(seed, n): (u64, &usize)| Run {
                seed,
                cost: 1.0,
                position: vec![],
                history: if *n == 0 { vec![(1, 2.0)] } else { vec![(1, 2.0), (*n, 1.0)] },
            };
            Peer { name: name.into(), runs: (0..).zip(evaluations).map(run).collect() }
        };
        let ours = of("a", &[50, 60, 55, 45, 50, 52, 58, 49]);
        let [least, most] = of("b", &[200, 300, 250, 180, 220, 240, 260, 210]).times_as_long(&ours, 1.0, 1);
        assert!(least > 3.0 && most < 6.0, "{least} {most}");
        // Half of the seeds much sooner and half much later: that leaves it open.
        let [least, most] = of("c", &[10, 10, 10, 10, 500, 500, 500, 500]).times_as_long(&ours, 1.0, 1);
        assert!(least < 0.5 && most > 8.0, "{least} {most}");
        let never = of("d", &[0; 8]);
        assert_eq!(never.times_as_long(&ours, 1.0, 1), [f64::INFINITY; 2]);
        assert_eq!(never.times_as_long(&never, 1.0, 1), [0.0, f64::INFINITY]);
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
