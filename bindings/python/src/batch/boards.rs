//! Plants under the board's controller, one after the other: with its supervisor, whose rules branch, or the
//! same loop without it.

use super::task::{Seen, TICKS};
use super::world::World;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::Hardware;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::supervisor::ArmState;
use twinrotor_sim::closed_loop::{BoardLoop, ClosedLoop, RigLoop};
use twinrotor_sim::lanes::LANES;
use twinrotor_tune::robust::Draw;

/// A loop for each lane; none where none has begun.
pub(super) struct Boards {
    rig: Rig,
    believed: Rig,
    settings: Settings<f32>,
    supervised: bool,
    loops: [Option<Box<dyn ClosedLoop<f32> + Send>>; LANES],
}

impl Boards {
    pub(super) fn new(rig: &Rig, believed: &Rig, settings: &Settings<f32>, supervised: bool) -> Self {
        Self {
            rig: *rig,
            believed: *believed,
            settings: *settings,
            supervised,
            loops: [const { None }; LANES],
        }
    }
}

impl World for Boards {
    fn begin(&mut self, drawn: &[Option<Draw>; LANES]) {
        for (flying, draw) in self.loops.iter_mut().zip(drawn) {
            let Some(draw) = draw else { continue };
            let plant = RealPlant::new(&draw.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
            let hardware = Hardware::of(&self.rig, draw.encoder_phase).taken_for(&self.believed, &self.rig);
            *flying = Some(if self.supervised {
                Box::new(BoardLoop::new(plant, &hardware, &self.settings))
            } else {
                Box::new(RigLoop::new(plant, &hardware, &self.settings))
            });
        }
    }

    fn advance(&mut self, asked: &[[f32; 2]; LANES], goals: &[PerAxis<f32>; LANES]) -> [Seen; LANES] {
        let mut seen = [Seen::default(); LANES];
        for (lane, flying) in self.loops.iter_mut().enumerate() {
            if let Some(flying) = flying {
                seen[lane] = flown(flying.as_mut(), &self.rig, asked[lane], goals[lane]);
            }
        }
        seen
    }
}

/// A loop flies on.
fn flown(flying: &mut dyn ClosedLoop<f32>, rig: &Rig, asked: [f32; 2], goal: PerAxis<f32>) -> Seen {
    let setpoint = Reference::at_rest(PerAxis::new(asked[0], asked[1]));
    let (pitch, rates) = (f32::from_f64(rig.envelope.pitch), rig.envelope.rate.cast::<f32>());
    let mut seen = Seen::default();
    for _ in 0..TICKS {
        let tick = flying.tick(&setpoint, PerMotor::zero());
        let State { angle, rate } = tick.state;
        let missing = goal.minus(angle);
        let within =
            angle.pitch.abs() <= pitch && rate.pitch.abs() <= rates.pitch && rate.yaw.abs() <= rates.yaw;
        seen = Seen {
            angle,
            rate,
            volts: tick.applied,
            square: seen.square + (missing.pitch * missing.pitch + missing.yaw * missing.yaw),
            ended: seen.ended || !within || matches!(flying.arm_state(), Some(ArmState::Fault(_))),
        };
    }
    Seen { square: seen.square * f32::from_f64(1.0 / f64::from(TICKS)), ..seen }
}
