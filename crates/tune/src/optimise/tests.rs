use super::*;

pub(super) fn sphere(x: &[f64]) -> f64 {
    x.iter().zip([3.0, -2.0, 0.5, 4.1]).map(|(x, o)| (x - o) * (x - o)).sum()
}

/// Optimum moved from (1, 1, ..) by a shift, so that a bias towards the origin or the centre shows.
pub(super) fn rosenbrock(x: &[f64]) -> f64 {
    let y: Vec<f64> = x.iter().map(|x| x - 1.3).collect();
    y.windows(2).map(|w| 100.0 * (w[1] - w[0] * w[0]).powi(2) + (1.0 - w[0]).powi(2)).sum()
}

pub(super) fn rastrigin(x: &[f64]) -> f64 {
    let of = |x: &f64, o: f64| {
        let z = x - o;
        z * z + 10.0 * (1.0 - (core::f64::consts::TAU * z).cos())
    };
    x.iter().zip([1.7, -2.6, 0.4, 3.3]).map(|(x, o)| of(x, o)).sum()
}

pub(super) fn bounds() -> Bounds {
    Bounds::new(vec![[-6.0, 6.0]; 4]).unwrap()
}

fn settings(variant: Variant, iterations: usize) -> FpaSettings {
    FpaSettings { evaluations: 50 * (iterations + 1), ..FpaSettings::published(variant) }
}

fn minimised(settings: FpaSettings, seed: u64, cost: fn(&[f64]) -> f64) -> FlowerPollination {
    let mut fpa = FlowerPollination::new(settings, bounds(), Draws::new(seed));
    run(&mut fpa, |asked| asked.iter().map(|c| cost(&c.position)).collect(), |_| true);
    fpa
}

fn median(variant: Variant, iterations: usize, cost: fn(&[f64]) -> f64) -> f64 {
    let mut found: Vec<f64> = (0..9)
        .map(|seed| minimised(settings(variant, iterations), seed, cost).best().unwrap().cost)
        .collect();
    found.sort_by(f64::total_cmp);
    found[4]
}

#[test]
fn finds_the_shifted_optimum_of_the_sphere() {
    assert!(median(Variant::Paper, 100, sphere) < 1e-12);
    assert!(median(Variant::Yang, 400, sphere) < 1e-3);
    assert!(median(Variant::Demo, 400, sphere) < 1e-3);
}

#[test]
fn finds_the_shifted_valley_of_rosenbrock() {
    for variant in [Variant::Paper, Variant::Yang, Variant::Demo] {
        let found = median(variant, 1000, rosenbrock);
        assert!(found < 1.0, "{variant:?} {found}");
    }
}

/// Rastrigin's wells trap the paper's form, which contracts on its best flower: the three differ as their
/// moves say they must.
#[test]
fn on_rastrigin_the_wide_searching_forms_win() {
    let [paper, yang, demo] =
        [Variant::Paper, Variant::Yang, Variant::Demo].map(|v| median(v, 600, rastrigin));
    assert!(demo < 0.5, "demo {demo}");
    assert!(yang < paper, "yang {yang} paper {paper}");
    assert!(paper < 10.0, "paper {paper}");
}

/// A plain transcription of Fig. 4, one flower after another: planning ahead changes nothing.
fn fig_4(seed: u64, iterations: usize, cost: fn(&[f64]) -> f64) -> (Best, Vec<f64>) {
    use rand::RngExt;
    let (size, draws, bounds) = (50, Draws::new(seed), bounds());
    let mut flowers: Vec<Vec<f64>> = Vec::new();
    let mut best = Best { position: vec![], cost: f64::INFINITY };
    let mut history = vec![];
    let mut number = 0;
    for _ in 0..size {
        let mut rng = draws.of_move(number);
        let x: Vec<f64> = (0..4).map(|_| -6.0 + 12.0 * rng.random::<f64>()).collect();
        if cost(&x) < best.cost {
            best = Best { cost: cost(&x), position: x.clone() };
        }
        flowers.push(x);
        history.push(best.cost);
        number += 1;
    }
    for _ in 0..iterations {
        for i in 0..size {
            let mut rng = draws.of_move(number);
            let r: f64 = rng.random();
            let _epsilon: f64 = rng.random();
            let j = rng.random_range(0..size);
            let k = rng.random_range(0..size - 1);
            let k = if k < j { k } else { k + 1 };
            let levy: Vec<f64> = (0..4).map(|_| levy_step(&mut rng, 1.5)).collect();
            let g = &best.position;
            let mut x: Vec<f64> = (0..4)
                .map(|d| {
                    if r < 0.03 {
                        g[d] + 0.5 * levy[d] * (flowers[i][d] - g[d])
                    } else {
                        g[d] + 0.5 * (flowers[j][d] - flowers[k][d])
                    }
                })
                .collect();
            bounds.clip(&mut x);
            if cost(&x) < best.cost {
                best = Best { cost: cost(&x), position: x.clone() };
            }
            flowers[i] = x;
            history.push(best.cost);
            number += 1;
        }
    }
    (best, history)
}

#[test]
fn planning_ahead_gives_exactly_the_sequential_search_of_fig_4() {
    for seed in 0..20 {
        let (best, history) = fig_4(seed, 30, rastrigin);
        let mut fpa = FlowerPollination::new(settings(Variant::Paper, 30), bounds(), Draws::new(seed));
        let mut improvements = vec![];
        run(
            &mut fpa,
            |asked| asked.iter().map(|c| rastrigin(&c.position)).collect(),
            |o| {
                improvements.push((o.evaluations(), o.best().unwrap().cost));
                true
            },
        );
        assert_eq!(fpa.best(), Some(&best));
        assert_eq!(fpa.evaluations(), 1550);
        for (evaluations, cost) in improvements {
            assert_eq!(history[evaluations - 1], cost);
        }
    }
}

#[test]
fn costs_that_are_told_as_infinity_beyond_the_bound_change_nothing() {
    for variant in [Variant::Paper, Variant::Yang, Variant::Demo] {
        let whole = minimised(settings(variant, 60), 3, rosenbrock);
        let mut cut = FlowerPollination::new(settings(variant, 60), bounds(), Draws::new(3));
        let costs = |asked: &[Candidate]| {
            let cost = |c: &Candidate| Some(rosenbrock(&c.position)).filter(|x| *x <= c.bound);
            asked.iter().map(|c| cost(c).unwrap_or(f64::INFINITY)).collect()
        };
        run(&mut cut, costs, |_| true);
        assert_eq!(cut.best(), whole.best());
    }
}

#[test]
fn a_search_that_was_saved_goes_on_as_if_nothing_had_happened() {
    let whole = minimised(settings(Variant::Demo, 40), 5, rastrigin);
    let mut saved = FlowerPollination::new(settings(Variant::Demo, 40), bounds(), Draws::new(5));
    loop {
        let asked = saved.ask();
        if asked.is_empty() {
            break;
        }
        saved.tell(&asked.iter().map(|c| rastrigin(&c.position)).collect::<Vec<_>>());
        saved = postcard::from_bytes(&postcard::to_allocvec(&saved).unwrap()).unwrap();
    }
    assert_eq!(saved.best(), whole.best());
}

#[test]
fn a_cost_that_is_nan_never_wins() {
    let mut fpa = FlowerPollination::new(settings(Variant::Paper, 5), bounds(), Draws::new(1));
    run(
        &mut fpa,
        |asked| {
            asked.iter().map(|c| if c.position[0] > 0.0 { f64::NAN } else { sphere(&c.position) }).collect()
        },
        |_| true,
    );
    assert!(fpa.best().unwrap().cost.is_finite() && fpa.best().unwrap().position[0] <= 0.0);
}

#[test]
fn bounds_upside_down_are_named() {
    for bad in [[5.0, 1.0], [2.0, 2.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
        let error = Bounds::new(vec![[0.0, 1.0], bad]).unwrap_err().to_string();
        assert!(error.contains("coordinate 2"), "{error}");
    }
}
