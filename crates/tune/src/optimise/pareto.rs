//! NSGA-II (K. Deb, A. Pratap, S. Agarwal, T. Meyarivan, IEEE Trans. Evol. Comput. 6(2), 2002): the points
//! that cannot be bettered in one objective without losing in another.

use super::genetic::{crossover, mutate};
use super::{Bounds, Draws};
use rand::{Rng, RngExt};
use serde::Serialize;

/// A point and its objectives, all to be small.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compromise {
    /// Its coordinates.
    pub position: Vec<f64>,
    /// What it costs, each way.
    pub costs: Vec<f64>,
}

/// Is `a` nowhere worse than `b` and somewhere better?
pub fn dominates(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

/// Searches `bounds` for `generations` after the first with `size` points each. `costs` gives the objectives
/// of each position, none NaN, or nothing to stop: then the generation that it is of has not been. `seen` is
/// shown the evaluations so far. The front that was found comes sorted by its first objective, with the
/// evaluations that it took.
pub fn pareto_front(
    bounds: &Bounds,
    draws: Draws,
    [size, generations]: [usize; 2],
    costs: impl Fn(&[Vec<f64>]) -> Option<Vec<Vec<f64>>>,
    mut seen: impl FnMut(usize),
) -> (Vec<Compromise>, usize) {
    let evaluated = |units: Vec<Vec<f64>>| -> Option<Vec<Compromise>> {
        let told = costs(&units.iter().map(|u| bounds.at(|k| u[k])).collect::<Vec<_>>())?;
        Some(units.into_iter().zip(told).map(|(position, costs)| Compromise { position, costs }).collect())
    };
    let uniform = |k| {
        let mut rng = draws.of_move(k);
        (0..bounds.dimension()).map(|_| rng.random()).collect()
    };
    let Some(first) = evaluated((0..size).map(uniform).collect()) else { return (Vec::new(), 0) };
    let mut people = ranked(first, size);
    let mut evaluations = size;
    for generation in 1..=generations {
        seen(evaluations);
        let child = |k| {
            let mut rng = draws.of_move(generation * size + k);
            let mut child = crossover(parent(&people, &mut rng), parent(&people, &mut rng), &mut rng);
            mutate(&mut child, &mut rng);
            child
        };
        let Some(children) = evaluated((0..size).map(child).collect()) else { break };
        evaluations += size;
        people = ranked(people.into_iter().map(|(_, p)| p).chain(children).collect(), size);
    }
    let mut front: Vec<Compromise> =
        people.into_iter().filter(|(rank, _)| *rank == 0).map(|(_, point)| point).collect();
    for point in &mut front {
        point.position = bounds.at(|k| point.position[k]);
    }
    front.sort_by(|a, b| a.costs[0].total_cmp(&b.costs[0]));
    front.dedup_by(|a, b| a.costs == b.costs);
    (front, evaluations)
}

/// The earlier of two: people are sorted by rank and room.
fn parent<'a>(people: &'a [(usize, Compromise)], rng: &mut impl Rng) -> &'a [f64] {
    let [a, b] = [rng.random_range(0..people.len()), rng.random_range(0..people.len())];
    &people[a.min(b)].1.position
}

/// The best `size` with the number of their front, those first that are dominated least and then those with
/// most room around them.
fn ranked(mut people: Vec<Compromise>, size: usize) -> Vec<(usize, Compromise)> {
    let mut kept: Vec<(usize, Compromise)> = Vec::new();
    let mut rank = 0;
    while kept.len() < size && !people.is_empty() {
        let free: Vec<bool> =
            people.iter().map(|p| !people.iter().any(|q| dominates(&q.costs, &p.costs))).collect();
        let mut flags = free.into_iter();
        let (mut front, rest): (Vec<_>, Vec<_>) =
            people.into_iter().partition(|_| flags.next().unwrap_or(true));
        let room = crowding(&front);
        let mut order: Vec<usize> = (0..front.len()).collect();
        order.sort_by(|a, b| room[*b].total_cmp(&room[*a]));
        order.truncate(size - kept.len());
        kept.extend(order.iter().map(|k| {
            (rank, std::mem::replace(&mut front[*k], Compromise { position: vec![], costs: vec![] }))
        }));
        people = rest;
        rank += 1;
    }
    kept
}

/// How much room each point of a front has: the sides of the box that its neighbours span.
fn crowding(front: &[Compromise]) -> Vec<f64> {
    let mut room = vec![0.0; front.len()];
    for objective in 0..front.first().map_or(0, |p| p.costs.len()) {
        let cost = |k: usize| front[k].costs[objective];
        let mut order: Vec<usize> = (0..front.len()).collect();
        order.sort_by(|a, b| cost(*a).total_cmp(&cost(*b)));
        let (first, last) = (order[0], order[order.len() - 1]);
        let range = (cost(last) - cost(first)).max(f64::MIN_POSITIVE);
        room[first] = f64::INFINITY;
        room[last] = f64::INFINITY;
        for w in order.windows(3) {
            room[w[1]] += (cost(w[2]) - cost(w[0])) / range;
        }
    }
    room
}

/// The point of a front that is nearest to the best of every objective, each scaled to its range over the
/// front.
pub fn knee(front: &[Compromise]) -> usize {
    let objectives = front.first().map_or(0, |p| p.costs.len());
    let range = |k: usize| {
        front
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.costs[k]), h.max(p.costs[k])))
    };
    let ranges: Vec<(f64, f64)> = (0..objectives).map(range).collect();
    let far = |p: &Compromise| {
        let part = |(c, (low, high)): (&f64, &(f64, f64))| (c - low) / (high - low).max(f64::MIN_POSITIVE);
        p.costs.iter().zip(&ranges).map(|x| part(x).powi(2)).sum::<f64>()
    };
    (0..front.len()).min_by(|a, b| far(&front[*a]).total_cmp(&far(&front[*b]))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Schaffer's problem: x² and (x - 2)² are both smallest for some x in 0..2, and the front is √f1 + √f2 =
    /// 2.
    #[test]
    fn the_front_of_schaffers_problem_is_found_and_filled() {
        let bounds = Bounds::new(vec![[-20.0, 30.0]]).unwrap();
        let costs =
            |all: &[Vec<f64>]| Some(all.iter().map(|x| vec![x[0] * x[0], (x[0] - 2.0).powi(2)]).collect());
        let (front, evaluations) = pareto_front(&bounds, Draws::new(1), [40, 60], costs, |_| {});
        assert_eq!(evaluations, 40 * 61);
        assert!(front.len() > 30, "{}", front.len());
        for p in &front {
            let sum = p.costs[0].sqrt() + p.costs[1].sqrt();
            assert!((sum - 2.0).abs() < 0.02, "{p:?}");
        }
        let widest = front.windows(2).map(|w| w[1].position[0] - w[0].position[0]).fold(0.0, f64::max);
        assert!(
            front[0].costs[0] < 0.01 && front.last().unwrap().costs[1] < 0.01 && widest < 0.25,
            "{widest}"
        );
        // Both objectives are alike there, so the knee lies in the middle.
        let knee = &front[knee(&front)];
        assert!((knee.position[0] - 1.0).abs() < 0.2, "{knee:?}");
    }

    /// A generation that was broken off counts for nothing, and what was there before it is kept.
    #[test]
    fn a_search_that_is_stopped_says_how_far_it_came() {
        let bounds = Bounds::new(vec![[0.0, 1.0]]).unwrap();
        let turns = std::cell::Cell::new(0);
        let search = |stop_at: usize| {
            turns.set(0);
            let costs = |all: &[Vec<f64>]| {
                turns.set(turns.get() + 1);
                let costs = all.iter().map(|x| vec![x[0], 1.0 - x[0]]).collect();
                (turns.get() < stop_at).then_some(costs)
            };
            pareto_front(&bounds, Draws::new(3), [10, 5], costs, |_| {})
        };
        assert_eq!(search(1), (Vec::new(), 0));
        let (front, evaluations) = search(4);
        assert_eq!(evaluations, 30);
        let whole = pareto_front(
            &bounds,
            Draws::new(3),
            [10, 2],
            |all| Some(all.iter().map(|x| vec![x[0], 1.0 - x[0]]).collect()),
            |_| {},
        );
        assert_eq!((front, evaluations), whole);
    }

    #[test]
    fn nothing_on_a_front_dominates_anything_else_on_it() {
        let bounds = Bounds::new(vec![[0.0, 1.0]; 3]).unwrap();
        let costs = |all: &[Vec<f64>]| {
            let of = |x: &Vec<f64>| vec![x[0], x[1], (1.0 - x[0]).powi(2) + (1.0 - x[1]).powi(2) + x[2]];
            Some(all.iter().map(of).collect())
        };
        let (front, _) = pareto_front(&bounds, Draws::new(2), [30, 20], costs, |_| {});
        assert!(front.len() > 10);
        for (i, p) in front.iter().enumerate() {
            assert!(front.iter().enumerate().all(|(j, q)| i == j || !dominates(&q.costs, &p.costs)));
        }
    }
}
