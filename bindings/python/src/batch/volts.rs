//! Plants under volts, sixteen side by side.

use super::task::{Seen, TICKS, Task};
use super::world::World;
use std::any::Any;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::drive::Drive;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{LaggedRotors, PlantParameters, RealPlant, State, Thrust};
use twinrotor::real::{Mask, Real};
use twinrotor_sim::lanes::{Kernel, LANES, gather_plants, gather_rotors, in_lanes};
use twinrotor_tune::robust::Draw;

/// What flies in the lanes of one kind of vector.
struct Flying<R> {
    plant: RealPlant<R>,
    /// \[V\] What the amplifiers have latched, and give in the tick that comes.
    latched: PerMotor<R>,
}

/// The bench's rig without its wires, in lanes: bit for bit what `Bench` flies.
pub(super) struct Volts {
    rig: Rig,
    constants: Vec<PlantParameters<f32>>,
    rotors: Vec<LaggedRotors<f32>>,
    /// A [`Flying`] of this processor's vectors, whose type has no name outside of a kernel.
    flying: Option<Box<dyn Any + Send>>,
}

impl Volts {
    pub(super) fn new(task: &Task) -> Self {
        let rotors = LaggedRotors::<f32>::new(&task.rig.plant, SAMPLE_TIME);
        Self {
            rig: task.rig,
            constants: vec![task.rig.plant.map(f32::from_f64); LANES],
            rotors: vec![rotors; LANES],
            flying: None,
        }
    }
}

impl World for Volts {
    fn begin(&mut self, drawn: &[Option<Draw>; LANES]) {
        for (lane, draw) in drawn.iter().enumerate() {
            if let Some(draw) = draw {
                self.constants[lane] = draw.plant.map(f32::from_f64);
                self.rotors[lane] = LaggedRotors::new(&draw.plant, SAMPLE_TIME);
            }
        }
        in_lanes(Begin { world: self, drawn });
    }

    fn advance(&mut self, asked: &[[f32; 2]; LANES], goals: &[PerAxis<f32>; LANES]) -> [Seen; LANES] {
        in_lanes(Advance { world: self, asked, goals })
    }
}

struct Begin<'a> {
    world: &'a mut Volts,
    drawn: &'a [Option<Draw>; LANES],
}

impl Kernel for Begin<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) {
        let Self { world, drawn } = self;
        let plant = RealPlant::assemble(
            gather_plants(&world.constants),
            gather_rotors(&world.rotors),
            State::at_rest(PerAxis::zero()),
            SAMPLE_TIME,
        );
        let mut fresh = Flying::<R> { plant, latched: PerMotor::zero() };
        if let Some(running) = world.flying.as_ref().and_then(|flying| flying.downcast_ref::<Flying<R>>()) {
            let stays = R::from_fn(|lane| if drawn[lane].is_none() { 1.0 } else { 0.0 });
            let stays = R::zero().lt(stays);
            fresh.plant.go_on(stays, &running.plant);
            fresh.latched = running.latched.map(|volts| R::select(stays, volts, R::zero()));
        }
        match world.flying.as_mut().and_then(|flying| flying.downcast_mut::<Flying<R>>()) {
            Some(place) => *place = fresh,
            None => world.flying = Some(Box::new(fresh)),
        }
    }
}

struct Advance<'a> {
    world: &'a mut Volts,
    asked: &'a [[f32; 2]; LANES],
    goals: &'a [PerAxis<f32>; LANES],
}

impl Kernel for Advance<'_> {
    type Output = [Seen; LANES];
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) -> [Seen; LANES] {
        let Self { world: Volts { rig, flying, .. }, asked, goals } = self;
        let flying = flying.as_mut().and_then(|flying| flying.downcast_mut::<Flying<R>>());
        let Flying { plant, latched } = flying.expect("an episode has begun");
        let volts =
            PerMotor { main: R::from_fn(|lane| asked[lane][0]), tail: R::from_fn(|lane| asked[lane][1]) };
        let goal = PerAxis { pitch: R::from_fn(|k| goals[k].pitch), yaw: R::from_fn(|k| goals[k].yaw) };
        let drive = Drive::<R>::new(rig.board.pwm_steps());
        let supply = R::from_f64(rig.volts_limit.main.max(rig.volts_limit.tail));
        let next = drive.volts(drive.duty(volts, supply), supply);
        let most = (R::from_f64(rig.envelope.pitch), rig.envelope.rate.cast::<R>());
        let mut applied = *latched;
        let mut within = R::Mask::splat(true);
        let mut square = R::zero();
        for _ in 0..TICKS {
            applied = *latched;
            *latched = next;
            plant.advance(applied, PerMotor::zero());
            let State { angle, rate } = plant.state();
            let (pitch, yaw) = (goal.pitch - angle.pitch, goal.yaw - angle.yaw);
            square = square + (pitch * pitch + yaw * yaw);
            // What is no number is not within.
            within = within
                & angle.pitch.abs().le(most.0)
                & rate.pitch.abs().le(most.1.pitch)
                & rate.yaw.abs().le(most.1.yaw);
        }
        let State { angle, rate } = plant.state();
        let square = square * R::from_f64(1.0 / f64::from(TICKS));
        std::array::from_fn(|lane| Seen {
            angle: PerAxis::new(angle.pitch.lane(lane), angle.yaw.lane(lane)),
            rate: PerAxis::new(rate.pitch.lane(lane), rate.yaw.lane(lane)),
            volts: PerMotor::new(applied.main.lane(lane), applied.tail.lane(lane)),
            square: square.lane(lane),
            ended: !within.lane(lane),
        })
    }
}
