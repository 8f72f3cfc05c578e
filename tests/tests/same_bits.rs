//! What was tuned is what flies: one arithmetic in plain f32, in every lane, and in the control loop of the
//! board.

use proptest::prelude::*;
use std::hint::black_box;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::gains::Gains;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{self, Rig};
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor_sim::closed_loop::{BoardLoop, ClosedLoop, Hardware, IdealLoop, RigLoop, Tick};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::lanes::{Kernel, LANES, gather, in_lanes};
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::scenario::{SAMPLE_TIME, Scenario};
use twinrotor_tune::integral::Objective;
use twinrotor_tune::optimise::Candidate;
use twinrotor_tune::search::Problem;

fn any_rig() -> impl Strategy<Value = Rig> {
    prop::sample::select(presets::ALL.to_vec()).prop_map(|(_, rig)| rig)
}

fn any_gains() -> impl Strategy<Value = GainsFile> {
    prop::array::uniform4(1.0..25.0_f64).prop_map(|k| GainsFile::backstepping(Gains::from_paper_order(k)))
}

fn any_scenario() -> impl Strategy<Value = Scenario> {
    prop::sample::select(vec!["step", "1", "2", "3", "3-square"])
        .prop_map(|name| Scenario::named(name).unwrap())
}

fn bits<R: Real<Scalar = f32>>(tick: &Tick<R>, lane: usize) -> [u32; 8] {
    let (state, volts, demand) = (tick.state, tick.applied, tick.decision.allocation.demand);
    [
        state.angle.pitch,
        state.angle.yaw,
        state.rate.pitch,
        state.rate.yaw,
        volts.main,
        volts.tail,
        demand.main,
        demand.tail,
    ]
    .map(|x| x.lane(lane).to_bits())
}

/// Flies the loop that `group` makes of all settings, side by side, and the same loops one by one, and
/// compares every tick: lane k against the k-th single loop as long as that one is `flying`. The board cuts
/// the motors of a flight that leaves its envelope, which lanes leave to whoever judges them.
struct Compared<'a, L> {
    rig: &'a Rig,
    hardware: Option<&'a Hardware>,
    settings: &'a [Settings<f32>],
    scenario: &'a Scenario,
    singles: Vec<L>,
    flying: fn(&L) -> bool,
}

impl<L: ClosedLoop<f32>> Kernel for Compared<'_, L> {
    type Output = Result<(), TestCaseError>;
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) -> Self::Output {
        let start = State::at_rest(PerAxis::zero());
        let (rig, settings) = (self.rig, gather::<R>(self.settings));
        match self.hardware {
            None => self.compare(IdealLoop::new(rig, &settings, start, SAMPLE_TIME)),
            Some(hardware) => {
                let plant = RealPlant::new(&rig.plant, start, SAMPLE_TIME);
                self.compare(RigLoop::new(plant, hardware, &settings))
            }
        }
    }
}

impl<L: ClosedLoop<f32>> Compared<'_, L> {
    fn compare<R: Real<Scalar = f32>>(mut self, mut group: impl ClosedLoop<R>) -> Result<(), TestCaseError> {
        let references = self.scenario.references::<f32>();
        let disturbances = self.scenario.disturbances::<f32>(3);
        for (reference, disturbance) in references.iter().zip(&disturbances).take(1_000) {
            let together =
                black_box(&mut group).tick(&Reference::splat(reference), PerMotor::splat(*disturbance));
            for (lane, single) in self.singles.iter_mut().enumerate() {
                let alone = single.tick(reference, *disturbance);
                if (self.flying)(single) {
                    prop_assert_eq!(bits(&together, lane), bits(&alone, 0));
                }
            }
        }
        Ok(())
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// In the paper's world, every lane is the plain run.
    #[test]
    fn lanes_in_the_ideal_world(
        rig in any_rig(), scenario in any_scenario(), gains in prop::collection::vec(any_gains(), LANES),
    ) {
        let settings: Vec<Settings<f32>> =
            gains.iter().map(|g| g.settings(&rig).map(f32::from_f64)).collect();
        let single = |s: &Settings<f32>| IdealLoop::new(&rig, s, State::default(), SAMPLE_TIME);
        let singles = settings.iter().map(single).collect();
        let rig = &rig;
        let (settings, scenario, flying) = (&settings[..], &scenario, |_: &_| true);
        in_lanes(Compared { rig, hardware: None, settings, scenario, singles, flying })?;
    }

    /// In the rig's world, every lane is what the board's control loop does.
    #[test]
    fn lanes_in_the_rigs_world_are_the_boards_control_loop(
        rig in any_rig(), scenario in any_scenario(), gains in prop::collection::vec(any_gains(), LANES),
        phase in (0.0..1.0, 0.0..1.0),
    ) {
        let settings: Vec<Settings<f32>> =
            gains.iter().map(|g| g.settings(&rig).map(f32::from_f64)).collect();
        let hardware = Hardware::of(&rig, PerAxis::new(phase.0, phase.1));
        let single = |s: &Settings<f32>| {
            BoardLoop::new(RealPlant::new(&rig.plant, State::default(), SAMPLE_TIME), &hardware, s)
        };
        let singles = settings.iter().map(single).collect();
        let (rig, hardware) = (&rig, Some(&hardware));
        let (settings, scenario, flying) = (&settings[..], &scenario, BoardLoop::is_armed);
        in_lanes(Compared { rig, hardware, settings, scenario, singles, flying })?;
    }

    /// The pipeline over 10,000 ticks is the control loop.
    #[test]
    fn the_pipeline_is_the_control_loop(rig in any_rig(), gains in any_gains(), scenario in any_scenario()) {
        let settings = gains.settings(&rig).map(f32::from_f64);
        let hardware = Hardware::of(&rig, PerAxis::new(0.3, 0.8));
        let plant = || RealPlant::<f32>::new(&rig.plant, State::default(), SAMPLE_TIME);
        let mut board = BoardLoop::new(plant(), &hardware, &settings);
        let mut lanes = RigLoop::new(plant(), &hardware, &settings);
        let (references, disturbances) = (scenario.references::<f32>(), scenario.disturbances::<f32>(1));
        let flight = references.iter().zip(&disturbances).cycle().take(10_000);
        for (compared, (reference, disturbance)) in flight.enumerate() {
            let (a, b) = (board.tick(reference, *disturbance), lanes.tick(reference, *disturbance));
            if !board.is_armed() {
                // It left the envelope, and the board has cut the motors.
                prop_assert!(compared > 100, "cut after {compared} ticks");
                break;
            }
            prop_assert_eq!(bits(&a, 0), bits(&b, 0));
        }
    }

    /// The tuner's cost of a candidate is, to the bit, the ISE of its own flight, whoever is in the other
    /// lanes; and breaking off flights that have lost changes no verdict.
    #[test]
    fn the_tuners_cost_is_the_flights(
        rig in any_rig(), gains in prop::collection::vec(any_gains(), 1..20), rigs_world in any::<bool>(),
        part in 0.9..1.1,
    ) {
        let fidelity = if rigs_world { Fidelity::Rig } else { Fidelity::Ideal };
        let mut scenario = Scenario::named("step").unwrap();
        scenario.duration = 1.0;
        let objective = Objective::new(Criterion::Ise, &rig, &scenario, fidelity, 1);
        let asked = |bound| -> Vec<Candidate> {
            let of = |g: &GainsFile| Candidate { position: g.gains().expect("the paper's \
                law").to_paper_order().to_vec(), bound };
            gains.iter().map(of).collect()
        };
        let whole = objective.costs(&asked(f64::INFINITY));
        for (gains, cost) in gains.iter().zip(&whole) {
            let alone = objective.cost(gains);
            prop_assert_eq!(alone.to_bits(), cost.to_bits());
        }
        let bound = whole[0] * part;
        for (cut, cost) in objective.costs(&asked(bound)).iter().zip(&whole) {
            prop_assert_eq!(*cut < bound, *cost < bound);
            prop_assert!(cut.to_bits() == cost.to_bits() || cut.is_infinite());
        }
    }
}

/// The cost that the tuner prints is the ISE that `simulate` prints.
#[test]
fn the_tuners_cost_is_what_simulate_reports() {
    use twinrotor_sim::flight::{Scalar, fly};
    let setup = tests::Setup::paper("step", 5.0);
    let report = fly(&setup.plan(Fidelity::Ideal, 1), Scalar::F32).unwrap().report;
    let objective = Objective::new(Criterion::Ise, &setup.rig, &setup.scenario, Fidelity::Ideal, 1);
    assert_eq!(objective.cost(&GainsFile::paper()).to_bits(), report.ise().to_bits());
}
