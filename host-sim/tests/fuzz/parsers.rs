//! Every kind of file at its parser, in one process.

use super::cases;
use super::mutate::{NASTY, mutated, one_of};
use embedded_storage::nor_flash::NorFlash;
use rand::Rng;
use std::fmt::Write;
use twinrotor::parameters::Parameters;
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{SLOT_SIZE, Store};
use twinrotor::plant::presets::{AERO_LAB, AERO2, PAPER};
use twinrotor_identify::log::{Columns, Log};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::rig;
use twinrotor_sim::scenario::{Now, Scenario};
use twinrotor_station::image;
use twinrotor_tune::checkpoint::{self, Identity};
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::{ALGORITHMS, Bounds, Candidate, Draws, Setup};
use twinrotor_tune::parallel::{self, Stop};
use twinrotor_tune::robust::{Limit, Plan};
use twinrotor_tune::search::{Effort, Problem, Search};

/// Inputs of each kind in an ordinary test run.
const USUAL: usize = 2_000;
/// \[s\] Scenarios longer than this are read and not made into ticks.
const LONG: f64 = 5.0;

/// `of` for every case, with random numbers of its own; how many of them it found usable.
fn usable(of: impl Fn(&mut dyn Rng) -> bool + Sync + Send) -> usize {
    let one = |k: usize| of(&mut Draws::new(2026).of_move(k));
    parallel::by_index(cases(USUAL), one).into_iter().filter(|usable| *usable).count()
}

#[test]
fn parsers_of_gains_and_rigs() {
    let good: Vec<String> = twinrotor_tune::design::CATALOGUE
        .iter()
        .map(|(_, design)| GainsFile { controller: design(&AERO2), provenance: None }.to_toml())
        .chain(["aero2", "paper"].map(|name| {
            std::fs::read_to_string(format!("{}/../gains/{name}.toml", env!("CARGO_MANIFEST_DIR"))).unwrap()
        }))
        .collect();
    let found = usable(|mut rng| {
        let text = one_of(&mut rng, &good);
        let bytes = mutated(&mut rng, text.as_bytes());
        let Ok(gains) = GainsFile::parse("g.toml", &String::from_utf8_lossy(&bytes)) else { return false };
        let parameters = Parameters::new(&AERO2, &gains.settings(&AERO2));
        image::image(&parameters).is_ok() && GainsFile::parse("g.toml", &gains.to_toml()).is_ok()
    });
    assert!(found > 0, "some changes do no harm");

    let good = [AERO_LAB, AERO2, PAPER].map(|known| rig::to_toml(&known));
    let found = usable(|mut rng| {
        let text = one_of(&mut rng, &good);
        let bytes = mutated(&mut rng, text.as_bytes());
        let Ok(rig) = rig::parse("r.toml", &String::from_utf8_lossy(&bytes)) else { return false };
        let settings = GainsFile::paper().settings(&rig);
        image::image(&Parameters::new(&rig, &settings)).is_ok()
    });
    assert!(found > 0, "some changes do no harm");
}

#[test]
fn parsers_of_scenarios() {
    let good = [
        "duration = 3.0\n[pitch.steps]\njumps = [[0.5, 5.0], [1.5, 2.0]]\nperiod = 2.5\n[yaw.sine]\n\
         amplitude_deg = 10.0\nfrequency = 1.0\n",
        "duration = 2.0\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = [[0.0, 40.0]]\n[disturbance]\n\
         volts = 1.0\nhold = 0.1\nwindow = [0.5, 1.5]\n",
        "duration = 2.0\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = []\n[[events.step]]\n\
         volts = [1.0, -2.0]\nwindow = [0.5, 1.5]\n[[events.sine]]\ntorque = [0.01, 0]\nfrequency = 5\n\
         window = [0, 2]\n[[events.weight]]\nmass = 0.02\narm = -0.2\nwindow = [1, 2]\n[[events.supply]]\n\
         volts = 12\nfall = 0.3\nwindow = [0, 1]\n[[events.thrust]]\nleft = [0.5, 0]\nwindow = [0, 2]\n\
         [start]\nrate_deg = [3, 4]\n[hardware]\nnoise_counts = [2, 3]\ndelay = 0.004\n",
    ];
    let found = usable(|mut rng| {
        let text = one_of(&mut rng, &good);
        let bytes = mutated(&mut rng, text.as_bytes());
        let Ok(scenario) = Scenario::parse("s.toml", &String::from_utf8_lossy(&bytes)) else { return false };
        if scenario.validate().is_ok() && scenario.duration <= LONG {
            let ticks = scenario.references::<f32>().len();
            assert_eq!(ticks, scenario.disturbances::<f32>(1).len());
            let sound = |now: Now| now.volts.main.is_finite() && now.supply(18.0_f64) > 0.0;
            assert!(scenario.befalls(1).take(ticks).all(sound));
        }
        true
    });
    assert!(found > 0, "some changes do no harm");
}

#[test]
fn parsers_of_logs_and_columns() {
    let mut good = String::from("t,pitch,yaw,v0,v1,w0,w1,ref_pitch,ref_yaw\n");
    for k in 0..120 {
        let t = 0.01 * f64::from(k);
        let volts = if k < 60 { 6.0 } else { 9.0 };
        let _ = writeln!(
            good,
            "{t:.2},{:.5},{:.5},{volts},3,{:.1},20.0,0.1,0.2",
            0.1 * t.sin(),
            0.3 * t,
            30.0 + t
        );
    }
    let columns = ["", "t=t:ms,pitch=-pitch:deg,yaw=yaw:counts4096", "v0=v1,v1=v0,w0=w0:rpm,w1=w1:rpm"];
    let found = usable(|mut rng| {
        let spoilt = |rng: &mut dyn Rng, text: &str| mutated(&mut { rng }, text.as_bytes());
        let bytes = spoilt(rng, &good);
        let chosen = *one_of(&mut rng, &columns);
        let chosen = if rng.next_u32() % 2 == 0 {
            chosen.to_owned()
        } else {
            String::from_utf8_lossy(&spoilt(rng, chosen)).into_owned()
        };
        let Ok(columns) = Columns::parse(&chosen) else { return false };
        let Ok(log) = Log::read("l.csv", bytes.as_slice(), &columns, &AERO_LAB) else { return false };
        assert!(log.sample_time > 0.0 && log.duration().is_finite());
        assert!(log.angle.iter().all(|angle| angle.pitch.is_finite() && angle.yaw.is_finite()));
        true
    });
    assert!(found > 0, "some changes do no harm");
}

/// Costs nothing to compute, and is lowest in the middle.
struct Bowl;

impl Problem for Bowl {
    fn costs_until(&self, candidates: &[Candidate], _: Stop<'_>) -> Option<Vec<f64>> {
        Some(candidates.iter().map(|c| c.position.iter().map(|x| x * x).sum()).collect())
    }

    fn effort(&self) -> Effort {
        Effort::default()
    }
}

/// Searches of every kind at their beginning.
fn searches() -> Vec<Search> {
    let identity = || Identity::new().with("seed", 3);
    let each = |(_, algorithm): &(&str, _)| {
        let setup = Setup { algorithm: *algorithm, population: Some(6), evaluations: 60 };
        let bounds = Bounds::new(vec![[-1.0, 2.0]; 3]).unwrap();
        let plan = Plan { setup: Setup { evaluations: 20, ..setup }, rounds: 3, range: 2.0, seed: 3 };
        [Search::new(identity(), setup.start(bounds, Draws::new(3))), Search::new(identity(), plan.start(3))]
    };
    ALGORITHMS.iter().flat_map(each).collect()
}

/// Checkpoints that were changed and given the checksum that goes with it: what is taken for a state of the
/// search must lead it to its end.
#[test]
fn parsers_of_forged_checkpoints() {
    let begun = searches();
    let good: Vec<(Search, Vec<u8>)> = begun
        .iter()
        .flat_map(|search| {
            [0, 1, 2, 5].map(|exchanges| {
                let mut part = search.clone();
                let mut left = exchanges;
                let _ = part.run(&Bowl, parallel::NEVER, |_| {
                    left -= 1;
                    if left < 0 {
                        std::ops::ControlFlow::Break(())
                    } else {
                        std::ops::ControlFlow::Continue(())
                    }
                });
                (search.clone(), part.checkpoint())
            })
        })
        .collect();
    for (begun, bytes) in &good {
        assert!(begun.clone().resume(bytes).is_ok(), "what was not changed is taken");
    }
    let found = usable(|mut rng| {
        let (begun, bytes) = one_of(&mut rng, &good);
        let payload = checkpoint::payload(bytes).expect("a checkpoint");
        // Numbers of a search begin where its identity ends.
        let forged = checkpoint::with_payload(&mutated(&mut rng, payload));
        let Ok(mut search) = begun.clone().resume(&forged) else { return false };
        search.to_the_end(&Bowl);
        assert!(search.evaluations() <= search.budget());
        if let Some(best) = search.best() {
            assert!(best.position.len() == 3 && best.position.iter().all(|x| x.is_finite()));
        }
        true
    });
    assert!(found > 0, "some changes do no harm");
}

#[test]
fn parsers_of_images() {
    let parameters = Parameters::new(&AERO2, &GainsFile::paper().settings(&AERO2));
    let good = image::image(&parameters).unwrap();
    let used = good.iter().rposition(|byte| *byte != 0xFF).unwrap() + 8;
    let found = usable(|mut rng| {
        let mut bytes = mutated(&mut rng, &good[..used]);
        bytes.resize(good.len(), 0xFF);
        let mut flash = RamFlash::default();
        flash.write(0, &bytes).expect("whole words onto erased flash");
        let mut buffer = [0; SLOT_SIZE];
        let loaded = Store::new(flash, 0).load(&mut buffer);
        let Ok(Some(payload)) = loaded else { return false };
        Parameters::decode(payload).is_ok_and(|read| read.validate().is_ok())
    });
    assert!(found > 0, "what is changed beyond the record does no harm");
}

#[test]
fn parsers_of_words() {
    let good = ["overshoot_p95.yaw=2", "failures=0", "settling_p95.pitch=1.5"];
    let found = usable(|mut rng| {
        let text = one_of(&mut rng, &good);
        let bytes = mutated(&mut rng, text.as_bytes());
        let word = format!("{}={}", one_of(&mut rng, &NASTY), one_of(&mut rng, &NASTY));
        let _ = Limit::parse(&word);
        Limit::parse(&String::from_utf8_lossy(&bytes)).is_ok()
    });
    assert!(found > 0, "some changes do no harm");
    let mut step = Scenario::named("step").unwrap();
    step.duration = 0.05;
    let objective = Objective::new(Criterion::Ise, &PAPER, &step, Fidelity::Ideal, 1);
    usable(|rng| {
        let number =
            |rng: &mut dyn Rng| one_of(&mut { rng }, &NASTY).parse::<f64>().unwrap_or(4.0).abs().min(1e9);
        let position = [0; 4].map(|_| number(rng)).to_vec();
        let costs = objective.costs(&[Candidate { position, bound: f64::INFINITY }]);
        !costs[0].is_nan() || panic!("a cost is no number")
    });
}
