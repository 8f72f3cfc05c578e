//! What every method must do, and what each can.

use super::tests::{bounds, rastrigin, rosenbrock, sphere};
use super::*;

fn searched(algorithm: Algorithm, evaluations: usize, seed: u64, cost: fn(&[f64]) -> f64) -> Searcher {
    let setup = Setup { algorithm, population: None, evaluations };
    let mut search = setup.start(bounds(), Draws::new(seed));
    run(&mut search, |asked| asked.iter().map(|c| cost(&c.position)).collect(), |_| true);
    search
}

fn median(algorithm: Algorithm, evaluations: usize, cost: fn(&[f64]) -> f64) -> f64 {
    let cost_of = |seed| searched(algorithm, evaluations, seed, cost).best().unwrap().cost;
    let mut found: Vec<f64> = (0..9).map(cost_of).collect();
    found.sort_by(f64::total_cmp);
    found[4]
}

fn learning() -> impl Iterator<Item = (&'static str, Algorithm)> {
    ALGORITHMS.into_iter().filter(|(_, a)| !matches!(a, Algorithm::Random | Algorithm::Sobol))
}

#[test]
fn the_budget_is_kept_to_the_last_evaluation_and_every_candidate_lies_in_the_box() {
    for (name, algorithm) in ALGORITHMS {
        let setup = Setup { algorithm, population: None, evaluations: 333 };
        let mut search = setup.start(bounds(), Draws::new(2));
        let mut inside = true;
        run(
            &mut search,
            |asked| {
                let within = |x: &f64| (-6.0..=6.0).contains(x);
                inside &= asked.iter().all(|c| c.position.len() == 4 && c.position.iter().all(within));
                asked.iter().map(|c| rastrigin(&c.position)).collect()
            },
            |_| true,
        );
        assert!(inside, "{name}");
        assert_eq!((search.evaluations(), search.budget()), (333, 333), "{name}");
    }
}

/// 3,000 evaluations on a sphere whose optimum is nowhere special: what learns beats what does not by orders
/// of magnitude.
#[test]
fn every_method_finds_the_shifted_optimum_of_the_sphere() {
    let random = median(Algorithm::Random, 3000, sphere);
    assert!(random > 0.05, "{random}");
    for (name, algorithm) in learning() {
        let found = median(algorithm, 3000, sphere);
        assert!(found < 0.2 * random, "{name} {found}, random {random}");
    }
    for exact in [Algorithm::Covariance, Algorithm::NelderMead, Algorithm::Evolution, Algorithm::FpaAdaptive]
    {
        assert!(median(exact, 3000, sphere) < 1e-8, "{exact:?}");
    }
}

/// A method with a bias towards the centre or the origin does better when the optimum is there. Only the grey
/// wolves have one, and it is the one that their formula says.
#[test]
fn no_method_but_the_wolves_does_better_when_the_optimum_is_at_the_origin() {
    let centred: fn(&[f64]) -> f64 = |x| x.iter().map(|x| x * x).sum();
    for (name, algorithm) in learning() {
        let [shifted, centred] =
            [sphere, centred].map(|cost| median(algorithm, 900, cost).max(1e-12).log10());
        if algorithm == Algorithm::Wolves {
            assert!(centred < shifted - 3.0, "{name} {centred} {shifted}");
        } else {
            assert!((centred - shifted).abs() < 1.5, "{name} {centred} {shifted}");
        }
    }
}

/// An optimum in a corner of the box, where clamped and mirrored gains end up.
#[test]
fn every_method_finds_an_optimum_in_the_corner() {
    let corner: fn(&[f64]) -> f64 = |x| x.iter().map(|x| 6.0 - x).sum();
    for (name, algorithm) in learning() {
        let found = median(algorithm, 3000, corner);
        assert!(found < 1.5, "{name} {found}");
    }
}

#[test]
fn the_valley_of_rosenbrock_is_for_those_that_turn_with_it() {
    for algorithm in [Algorithm::Covariance, Algorithm::NelderMead] {
        let found = median(algorithm, 4000, rosenbrock);
        assert!(found < 1e-6, "{algorithm:?} {found}");
    }
    for algorithm in [Algorithm::Evolution, Algorithm::FpaAdaptive, Algorithm::Swarm] {
        let found = median(algorithm, 8000, rosenbrock);
        assert!(found < 1.0, "{algorithm:?} {found}");
    }
}

#[test]
fn the_wells_of_rastrigin_do_not_hold_those_that_search_widely() {
    let paper = median(Algorithm::Fpa(Variant::Paper), 6000, rastrigin);
    for algorithm in [Algorithm::Genetic, Algorithm::Evolution, Algorithm::FpaAdaptive] {
        let found = median(algorithm, 6000, rastrigin);
        assert!(found < 1.5 && found < paper, "{algorithm:?} {found}, fpa-paper {paper}");
    }
}

#[test]
fn any_search_that_was_saved_goes_on_as_if_nothing_had_happened() {
    for (name, algorithm) in ALGORITHMS {
        let whole = searched(algorithm, 700, 5, rosenbrock);
        let setup = Setup { algorithm, population: None, evaluations: 700 };
        let mut saved = setup.start(bounds(), Draws::new(5));
        loop {
            let asked = saved.ask();
            if asked.is_empty() {
                break;
            }
            // Costs above the bound may be told as infinity.
            let cost = |c: &Candidate| Some(rosenbrock(&c.position)).filter(|x| *x <= c.bound);
            saved.tell(&asked.iter().map(|c| cost(c).unwrap_or(f64::INFINITY)).collect::<Vec<_>>());
            saved = postcard::from_bytes(&postcard::to_allocvec(&saved).unwrap()).unwrap();
        }
        assert_eq!(saved.best(), whole.best(), "{name}");
    }
}

#[test]
fn candidates_that_diverge_harm_nothing() {
    let half: fn(&[f64]) -> f64 = |x| if x[0] > 3.5 { f64::NAN } else { sphere(x) };
    for (name, algorithm) in learning() {
        let found = median(algorithm, 3000, half);
        assert!(found < 0.1, "{name} {found}");
    }
}

#[test]
fn rounds_go_on_from_the_best_so_far_and_within_less() {
    let setup = Setup { algorithm: Algorithm::Random, population: None, evaluations: 200 };
    let mut rounds = Rounds::new(setup, 12, 4, 6.0, 3);
    let mut costs = Vec::new();
    run(
        &mut rounds,
        |asked| asked.iter().map(|c| sphere(&c.position)).collect(),
        |o| {
            costs.push(o.best().unwrap().cost);
            true
        },
    );
    assert_eq!(costs[0], sphere(&[0.0; 4]));
    assert!(costs.windows(2).all(|w| w[1] <= w[0]));
    assert_eq!((rounds.evaluations(), rounds.budget()), (2401, 2401));
    // Even random points converge when the box follows them.
    assert!(costs.last().unwrap() < &1e-3, "{:?}", costs.last());
}

/// After some eighty rounds the reach is lost beside the last digit of what was found: that is the end.
#[test]
fn rounds_end_where_no_number_lies_between() {
    let setup = Setup { algorithm: Algorithm::Random, population: None, evaluations: 3 };
    let mut rounds = Rounds::new(setup, 1_000, 4, 6.0, 3);
    while let asked = rounds.ask()
        && !asked.is_empty()
    {
        rounds.tell(&asked.iter().map(|c| sphere(&c.position)).collect::<Vec<_>>());
    }
    let evaluations = rounds.evaluations();
    assert!((150..=400).contains(&evaluations), "{evaluations} of {}", rounds.budget());
    assert!(rounds.ask().is_empty() && rounds.best().unwrap().cost.is_finite());
}
