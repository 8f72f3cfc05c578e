//! Lanes are worth having: sixteen loops side by side take a fraction of the time of sixteen one by one. A
//! function in the loop that is not inlined, or a lane that is not a vector, costs a factor of three to ten
//! and nothing else would tell.

use std::hint::black_box;
use std::time::Instant;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::gains;
use twinrotor::plant::State;
use twinrotor::plant::presets::PAPER;
use twinrotor::real::Real;
use twinrotor_sim::closed_loop::{ClosedLoop, IdealLoop};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::lanes::LANES;
use twinrotor_sim::metrics::{Criterion, Integral};
use twinrotor_sim::scenario::{SAMPLE_TIME, Scenario};
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::Candidate;
use twinrotor_tune::search::Problem;

fn seconds(work: impl FnOnce()) -> f64 {
    let begun = Instant::now();
    work();
    begun.elapsed().as_secs_f64()
}

#[test]
fn sixteen_side_by_side_take_less_than_a_third_of_sixteen_in_turn() {
    let mut scenario = Scenario::named("step").unwrap();
    scenario.duration = 2.0;
    let references = scenario.references::<f32>();
    let settings = GainsFile::paper().settings(&PAPER).map(f32::from_f64);
    let position = gains::PAPER.to_paper_order().to_vec();
    let candidates = vec![Candidate { position, bound: f64::INFINITY }; LANES];
    let objective = Objective::new(Criterion::Ise, &PAPER, &scenario, Fidelity::Ideal, 1);
    let alone = || {
        let mut closed_loop = IdealLoop::new(&PAPER, &settings, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
        let mut integral = Integral::new(Criterion::Ise);
        for (tick, reference) in (0..).zip(&references) {
            let happened = closed_loop.tick(black_box(reference), PerMotor::zero());
            integral.add(tick, 2_000, happened.error());
        }
        black_box(integral.value(0, SAMPLE_TIME));
    };
    let together = || {
        black_box(objective.costs(black_box(&candidates)));
    };
    // Measured in turn, so that a busy machine slows both; the best of each.
    let (mut best_alone, mut best_together) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..20 {
        best_alone = seconds(|| (0..LANES).for_each(|_| alone())).min(best_alone);
        best_together = seconds(together).min(best_together);
    }
    let ratio = best_alone / best_together;
    println!("sixteen in turn / side by side: {ratio:.1}");
    assert!(ratio > 3.0, "{ratio}");
}
