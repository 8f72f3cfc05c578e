//! What a GPU is given and what comes back, by a stand-in for its driver that runs the kernels' functions.

use std::sync::Arc;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::Hardware;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{RealPlant, State, presets};
use twinrotor::real::Real as _;
use twinrotor::reference::Reference;
use twinrotor::{SAMPLE_TIME, defaults};
use twinrotor_gpu::host::driver::Fault;
use twinrotor_gpu::host::stand_in::StandIn;
use twinrotor_gpu::host::{Card, written};
use twinrotor_gpu::words;
use twinrotor_sim::closed_loop::{ClosedLoop as _, RigLoop};
use twinrotor_sim::device::{Batch, Change, Device};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::judged::Rules;
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::scenario::{Disturbance, Scenario, Weight};
use twinrotor_tune::design::CATALOGUE;
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::Candidate;
use twinrotor_tune::parallel::NEVER;
use twinrotor_tune::robust::{Scenes, Trial};
use twinrotor_tune::search::Problem as _;

fn on(trial: &Trial, driver: StandIn) -> (Trial, Arc<Card<StandIn>>) {
    let card = Arc::new(Card::new(driver));
    (trial.clone().on(Some(Arc::clone(&card) as Arc<dyn Device>)), card)
}

/// Every controller's numbers and kinds, to the bit.
#[test]
fn settings_come_back_from_words_as_they_went() {
    for (name, rig) in presets::ALL {
        let ours = defaults::named(name).expect("every preset has one");
        for controller in CATALOGUE.iter().map(|(_, design)| design(&rig)).chain([ours]) {
            let settings = Settings::new(&rig, controller, SAMPLE_TIME).map(f32::from_f64);
            let words_of = written(&settings).unwrap();
            assert_eq!(words::read::<Settings<f32>>(&words_of), Ok(settings));
            let short = &words_of[..words_of.len() - 1];
            assert_eq!(words::read::<Settings<f32>>(short), Err(words::Mismatch));
        }
    }
}

/// Every preset with its own controller, and every kind of controller, on the step and on all scenes; and
/// what a board would cut of them.
#[test]
fn a_device_gives_the_scores_of_this_processor() {
    let mut cut = 0;
    for (name, rig) in presets::ALL {
        let mut trial = Trial::new(&rig, 5, 7, 1.1).flying(Scenes::All);
        // Whose tail motor turns the wrong way, a board cuts.
        let thrust = &mut trial.plants[3].plant.effectiveness;
        (thrust.tail_on_yaw, thrust.tail_on_pitch) = (-thrust.tail_on_yaw, -thrust.tail_on_pitch);
        let (device, card) = on(&trial, StandIn::default());
        let ours = defaults::named(name).expect("every preset has one");
        let rivals = CATALOGUE.iter().filter(|_| name == "aero-lab").map(|(_, design)| design(&rig));
        for controller in rivals.chain([ours]) {
            let here = trial.scores(&controller);
            cut += here.iter().filter(|score| score.cut.is_some()).count();
            assert_eq!(device.scores_until(&controller, NEVER), Some(here), "{name}, {controller:?}");
        }
        assert_eq!(card.failure(), None);
    }
    assert!(cut >= 3, "{cut} were cut");
}

/// A rig that its owner takes for another: other encoders, another envelope.
#[test]
fn a_device_flies_a_rig_that_is_taken_for_another() {
    let mut trial = Trial::new(&presets::AERO2, 4, 3, 1.2);
    trial.truth = presets::HELI;
    trial.truth.volts_limit = trial.rig.volts_limit;
    let (device, _) = on(&trial, StandIn::default());
    let here = trial.scores(&defaults::AERO2);
    assert_eq!(device.scores_until(&defaults::AERO2, NEVER), Some(here));
    // Amplifiers that give less are worn hardware, which this processor flies by itself.
    trial.truth.volts_limit = trial.rig.volts_limit.map(|v| 0.5 * v);
    let (device, card) = on(&trial, StandIn::with(1 << 20, 0));
    let here = trial.scores(&defaults::AERO2);
    assert_eq!((device.scores_until(&defaults::AERO2, NEVER), card.failure()), (Some(here), None));
}

/// Candidates with their bounds: the same scores, and the same plants spared.
#[test]
fn a_generation_in_one_launch_is_what_one_by_one_is() {
    let trial = Trial::new(&presets::AERO2, 40, 1, 1.1);
    let cost = trial.cost(&defaults::AERO2);
    let parts = [0.1, 0.6, 1.0, 2.0, f64::INFINITY];
    let generation = parts.map(|part| (defaults::AERO2, part * cost));
    let (device, card) = on(&trial, StandIn::default());
    let here = trial.all_below(&generation, NEVER).unwrap();
    assert!(here.iter().any(|(scores, flown)| scores.is_none() && *flown < 40));
    assert_eq!(device.all_below(&generation, NEVER), Some(here));
    assert_eq!(card.driver().launches(), 1);
}

/// What does not fit goes in several launches; the scores are the same.
#[test]
fn little_memory_takes_more_launches() {
    let trial = Trial::new(&presets::PAPER, 150, 1, 1.0);
    let here = trial.scores(&defaults::PAPER);
    // With memory for about fifty plants; with less than it says it has.
    for driver in [StandIn::with(12_000, u64::MAX), StandIn::claiming(1 << 30, 12_000, u64::MAX)] {
        let (device, card) = on(&trial, driver);
        assert_eq!(device.scores_until(&defaults::PAPER, NEVER).as_ref(), Some(&here));
        assert!(card.driver().launches() > 2, "{} launches", card.driver().launches());
    }
    let (device, card) = on(&trial, StandIn::with(3_000, u64::MAX));
    assert_eq!(device.scores_until(&defaults::PAPER, NEVER), None);
    assert_eq!(card.failure(), Some(Fault::Memory));
}

/// Forty candidates from all over the bounds, of which the first ones lose early.
fn candidates(objective: &Objective) -> Vec<Candidate> {
    let position = |k: u32| (1..=4).map(|n| 1.0 + f64::from(k * 7 * n % 24)).collect::<Vec<_>>();
    let all = |bound: f64| (0..40).map(move |k| Candidate { position: position(k), bound });
    let costs = objective.costs(&all(f64::INFINITY).collect::<Vec<_>>());
    let best = costs.iter().copied().fold(f64::INFINITY, f64::min);
    all(best).take(20).chain(all(1.3 * best).skip(20)).collect()
}

/// Every integral in both worlds, with a reference that moves and volts that push: the same costs, and the
/// same ticks counted as spared.
#[test]
fn a_device_gives_the_integrals_of_this_processor() {
    let mut spared = 0;
    for (scenario, criterion) in [("step", Criterion::Ise), ("1", Criterion::Itae), ("2", Criterion::Iae)] {
        for fidelity in [Fidelity::Ideal, Fidelity::Rig] {
            let mut scenario = Scenario::named(scenario).unwrap();
            scenario.duration = 1.5;
            scenario.disturbance = Some(Disturbance { volts: 2.0, hold: 0.01, window: [0.2, 1.2] });
            let objective = || Objective::new(criterion, &presets::PAPER, &scenario, fidelity, 3);
            let card = Arc::new(Card::new(StandIn::default()));
            let here = objective();
            let device = objective().on(Some(Arc::clone(&card) as Arc<dyn Device>));
            let generation = candidates(&objective());
            assert_eq!(device.costs(&generation), here.costs(&generation));
            assert_eq!(device.effort(), here.effort());
            assert_eq!((card.driver().launches(), card.failure()), (1, None));
            spared += here.effort().skipped;
        }
    }
    assert!(spared > 1000, "{spared} ticks");
}

/// The hash of every tick is that of the closed loop flown by itself.
#[test]
fn a_trace_is_of_every_tick() {
    let rig = presets::AERO2;
    let trial = Trial::new(&rig, 3, 5, 1.0);
    let settings = Settings::new(&rig, defaults::AERO2, SAMPLE_TIME).map(f32::from_f64);
    let asked = Reference::at_rest(trial.step.cast());
    let batch = Batch {
        rules: Rules { goal: trial.step, envelope: rig.envelope, disturbance: 400, end: 500, hot: false },
        course: &[
            Change { tick: 0, asked: Some(asked), push: None },
            Change { tick: 400, asked: None, push: Some(1.0) },
        ],
        hardware: Hardware::of(&rig, PerAxis::both(0.5)),
        controllers: &[settings],
        plants: &trial.plants,
    };
    let alone = trial.plants.iter().map(|draw| {
        let plant = RealPlant::new(&draw.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
        let mut flown = RigLoop::new(plant, &Hardware::of(&rig, draw.encoder_phase), &settings);
        (0..500).fold(0xcbf2_9ce4_8422_2325_u64, |hash, tick| {
            let push = if tick < 400 { PerMotor::zero() } else { draw.disturbance.cast() };
            let happened = flown.tick(&asked, push);
            let State { angle, rate } = happened.state;
            let volts = happened.applied.to_array();
            [angle.to_array(), rate.to_array(), volts]
                .concat()
                .iter()
                .fold(hash, |hash, x| (hash ^ u64::from(x.to_bits())).wrapping_mul(0x100_0000_01b3))
        })
    });
    let card = Card::new(StandIn::default());
    let hashes = Some(alone.collect());
    assert_eq!(card.traces(&batch), hashes);
    // Until something else is asked for, the goal is.
    let pushed = Batch { course: &batch.course[1..], ..batch };
    assert_eq!(card.traces(&pushed), hashes);
}

/// What the controllers of a launch believe of the rig is told once for all of them.
#[test]
fn controllers_that_believe_in_different_rigs_are_refused_and_none_is_no_work() {
    let trial = Trial::new(&presets::AERO2, 2, 5, 1.0);
    let settings = |rig: &Rig| Settings::new(rig, defaults::AERO2, SAMPLE_TIME).map(f32::from_f64);
    let weaker = Rig { volts_limit: PerMotor::both(9.0), ..presets::AERO2 };
    let controllers = [settings(&presets::AERO2), settings(&weaker)];
    let (goal, envelope) = (trial.step, trial.rig.envelope);
    let batch = |controllers| Batch {
        rules: Rules { goal, envelope, disturbance: 20, end: 30, hot: false },
        course: &[],
        hardware: Hardware::of(&trial.rig, PerAxis::both(0.5)),
        controllers,
        plants: &trial.plants,
    };
    let card = Card::new(StandIn::default());
    assert_eq!(card.fly(&batch(&[]), NEVER), Some(Vec::new()));
    assert!(card.fly(&batch(&controllers[..1]), NEVER).is_some_and(|flown| flown.len() == 2));
    assert_eq!(card.fly(&batch(&controllers), NEVER), None);
    assert!(card.failure().is_some_and(|why| why.to_string().contains("believe in different rigs")));
}

/// What befalls more than volts is flown by this processor.
#[test]
fn an_integral_with_a_weight_hung_on_is_flown_here() {
    let mut scenario = Scenario::named("step").unwrap();
    scenario.duration = 1.5;
    scenario.events.weight.push(Weight { mass: 0.05, arm: 0.1, window: [0.5, 1.0] });
    let objective = || Objective::new(Criterion::Ise, &presets::AERO, &scenario, Fidelity::Rig, 3);
    let card = Arc::new(Card::new(StandIn::with(0, 0)));
    let device = objective().on(Some(Arc::clone(&card) as Arc<dyn Device>));
    let generation = candidates(&objective());
    assert_eq!(device.costs(&generation), objective().costs(&generation));
    assert_eq!(card.failure(), None);
}

/// A card that is lost in the middle of the work gives nothing more, and says why once and for all.
#[test]
fn a_lost_card_gives_nothing_and_keeps_why() {
    let trial = Trial::new(&presets::PAPER, 100, 1, 1.0);
    let (device, card) = on(&trial, StandIn::with(12_000, 1));
    for _ in 0..2 {
        assert_eq!(device.scores_until(&defaults::PAPER, NEVER), None);
        assert_eq!(card.failure().unwrap().to_string(), "the CUDA device failed: unplugged");
    }
    assert_eq!(card.driver().launches(), 1);
}

/// Who does not wait for the result gets none, and the card is as good as before.
#[test]
fn a_stop_is_heard_before_a_launch() {
    let trial = Trial::new(&presets::PAPER, 20, 1, 1.0);
    let (device, card) = on(&trial, StandIn::default());
    assert_eq!(device.scores_until(&defaults::PAPER, &|| true), None);
    assert_eq!((card.failure(), card.driver().launches()), (None, 0));
    assert!(device.scores_until(&defaults::PAPER, NEVER).is_some());
}
