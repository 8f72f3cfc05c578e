use super::super::Scenes;
use super::*;
use crate::design::CATALOGUE;
use std::hint::black_box;
use twinrotor::plant::presets;
use twinrotor::reference::Reference;
use twinrotor_sim::closed_loop::{BoardLoop, ClosedLoop as _};
use twinrotor_sim::judged::HOT;
use twinrotor_sim::lanes::{in_lanes_with, levels};
use twinrotor_sim::metrics::{Metrics, Step};

/// Every lane against the board's own control loop on that plant, tick by tick.
struct Compared<'a> {
    flights: Flights<'a>,
    boards: Vec<BoardLoop>,
    name: &'a str,
}

impl Kernel for Compared<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(mut self) {
        let plants = self.flights.plants;
        let mut lanes = self.flights.closed_loop::<R>();
        let push = self.flights.disturbance::<R>();
        let course = self.flights.course;
        let mut asked = Reference::default();
        for tick in 0..course.end {
            asked = course.asked(tick).unwrap_or(asked);
            let part = course.push(tick);
            let group = part.map_or(PerMotor::zero(), |part| push.scaled(R::splat(part)));
            if course.hot && tick == 1 {
                lanes.warm(R::from_f64(HOT));
                self.boards.iter_mut().for_each(|board| board.warm(f32::from_f64(HOT)));
            }
            let together = black_box(&mut lanes).tick(&Reference::splat(&asked), group);
            for (k, board) in self.boards.iter_mut().enumerate() {
                let alone_push =
                    part.map_or(PerMotor::zero(), |part| plants[k].disturbance.cast::<f32>().scaled(part));
                let alone = board.tick(&asked, alone_push);
                let bits = |x: f32| x.to_bits();
                assert_eq!(
                    (alone.state.angle.map(bits), alone.applied.map(bits)),
                    (
                        together.state.angle.map(|x| bits(x.lane(k))),
                        together.applied.map(|x| bits(x.lane(k)))
                    ),
                    "{}, {}, plant {k}, tick {tick}",
                    self.name,
                    course.name
                );
            }
        }
    }
}

/// In every lane, with every instruction set, the drawn plant flies the step and every scene, bit for bit, as
/// it does with the board's own control loop; so does one whose rotors and body tilt.
#[test]
fn a_lane_is_the_boards_flight() {
    let mut tilting = presets::AERO_LAB;
    tilting.plant.tilting_inertia = 0.0147;
    tilting.plant.rotor_momentum = 7.1e-4;
    tilting.plant.tilting_thrust = 1.0;
    for (name, rig) in [
        ("integral", presets::PAPER),
        ("cancelling", presets::AERO_LAB),
        ("lqi", presets::AERO2),
        ("cancelling", tilting),
    ] {
        let design = CATALOGUE.iter().find(|(n, _)| *n == name).expect("it is there").1;
        let settings = Settings::new(&rig, design(&rig), SAMPLE_TIME).map(f32::from_f64);
        let trial = Trial { scenes: Scenes::All, ..Trial::new(&rig, 3, 11, 0.75) };
        for (course, level) in
            Course::all(&trial).iter().flat_map(|c| levels().into_iter().map(move |l| (c, l)))
        {
            let flights = Flights::new(&trial, course, &settings, &trial.plants);
            let boards = trial
                .plants
                .iter()
                .map(|d| {
                    let plant = RealPlant::new(&d.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
                    BoardLoop::new(plant, &Hardware::of(&rig, d.encoder_phase), &settings)
                })
                .collect();
            in_lanes_with(level, Compared { flights, boards, name });
        }
    }
}

/// What is told of a step, a plant among many, is what is told of the same flight alone: the same numbers, by
/// the same sums.
#[test]
fn a_scores_numbers_are_those_of_a_flight_alone() {
    let rig = presets::AERO2;
    let settings = Settings::new(&rig, twinrotor::defaults::AERO2, SAMPLE_TIME).map(f32::from_f64);
    let trial = Trial::new(&rig, 5, 12, 6.0);
    let course = &Course::all(&trial)[0];
    let scores = scores(&trial, &Course::all(&trial), &settings, &trial.plants, NEVER).expect("not stopped");
    for (draw, score) in trial.plants.iter().zip(scores) {
        let plant = RealPlant::new(&draw.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
        let mut board = BoardLoop::new(plant, &Hardware::of(&rig, draw.encoder_phase), &settings);
        let goal = Reference::at_rest(course.goal.cast::<f32>());
        let last = course.disturbance - 1;
        let steps = course.goal.map(|to| Some(Step { tick: 0, from: 0.0, to }));
        let mut metrics = Metrics::<f32>::new(last, steps, settings.volts_limit);
        for tick in 0..=last {
            metrics.add(tick, &board.tick(&goal, PerMotor::zero()));
        }
        let report = metrics.report(0, SAMPLE_TIME);
        let told = PerAxis { pitch: report.pitch, yaw: report.yaw };
        assert_eq!(score.settling_time.map(Some), told.map(|axis| axis.settling_time_2));
        assert_eq!(score.overshoot_percent.map(Some), told.map(|axis| axis.overshoot_percent));
        let whole = score.settling_time.map(|time| (time / SAMPLE_TIME).fract());
        assert!(whole.pitch > 0.0 || whole.yaw > 0.0, "to a part of a tick: {:?}", score.settling_time);
    }
}
