//! Many plants in lanes, through one scene.

use crate::scenes::{HEATING, Scene};
use std::hint::black_box;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{LaggedRotors, RealPlant, State, Thrust};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::trajectory::ticks;
use twinrotor_sim::closed_loop::{ClosedLoop, Hardware, RigLoop};
use twinrotor_sim::lanes::{Kernel, LANES, gather_plants, gather_rotors, in_lanes};
use twinrotor_tune::robust::Draw;

/// \[s\] At level, after the scene; in its last third the rig must be at rest.
const REST: f64 = 30.0;

/// One flight in numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct After {
    /// \[deg\] Largest angles.
    pub(crate) peak: PerAxis<f64>,
    /// \[rad/s\] Largest rates.
    pub(crate) rate: PerAxis<f64>,
    /// \[deg\] Largest error, once 30 s or two periods are over.
    pub(crate) error: PerAxis<f64>,
    /// \[deg\] Standard deviation in the last 10 s of rest.
    pub(crate) rms: PerAxis<f64>,
}

/// Flies `scene` on every plant.
pub(crate) fn fly(rig: &Rig, settings: &Settings<f32>, plants: &[Draw], scene: &Scene) -> Vec<After> {
    plants.chunks(LANES).flat_map(|plants| in_lanes(Flights { rig, settings, plants, scene })).collect()
}

struct Flights<'a> {
    rig: &'a Rig,
    settings: &'a Settings<f32>,
    plants: &'a [Draw],
    scene: &'a Scene,
}

impl Kernel for Flights<'_> {
    type Output = Vec<After>;

    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) -> Vec<After> {
        let mut closed_loop = self.closed_loop::<R>();
        let warm = if self.scene.hot { ticks(HEATING.seconds, SAMPLE_TIME) } else { 0 };
        let end = warm + ticks(self.scene.seconds, SAMPLE_TIME);
        let skipped = warm + ticks(f64::max(30.0, 2.0 / self.scene.hertz), SAMPLE_TIME);
        let rest = end + ticks(REST, SAMPLE_TIME);
        let still = rest - ticks(REST / 3.0, SAMPLE_TIME);
        let (heating, scene) = (HEATING.trajectory(), self.scene.trajectory());

        let zero = PerAxis::both(R::zero());
        let (mut peak, mut rate, mut error, mut sum, mut square) = (zero, zero, zero, zero, zero);
        let larger = |most: PerAxis<R>, now: PerAxis<R>| most.zip(now, |most, now| most.max(now.abs()));
        for tick in 0..rest {
            let wanted = if tick < warm {
                heating.at(tick)
            } else if tick < end {
                scene.at(tick - warm)
            } else {
                Reference::at_rest(PerAxis::zero())
            };
            let now = black_box(&mut closed_loop).tick(&Reference::splat(&wanted), PerMotor::zero());
            peak = larger(peak, now.state.angle);
            rate = larger(rate, now.state.rate);
            if (skipped..end).contains(&tick) {
                error = larger(error, now.error());
            }
            if tick >= still {
                sum = sum.plus(now.state.angle);
                square = square.plus(now.state.angle.map(|angle| angle * angle));
            }
        }
        let n = f64::from(rest - still);
        let of = |value: PerAxis<R>, lane: usize| value.map(|value| f64::from(value.lane(lane)));
        let degrees = |value: PerAxis<R>, lane: usize| of(value, lane).map(f64::to_degrees);
        (0..self.plants.len())
            .map(|lane| After {
                peak: degrees(peak, lane),
                rate: of(rate, lane),
                error: degrees(error, lane),
                rms: of(sum, lane).zip(of(square, lane), |sum, square| {
                    (square / n - (sum / n) * (sum / n)).max(0.0).sqrt().to_degrees()
                }),
            })
            .collect()
    }
}

impl Flights<'_> {
    #[inline(always)]
    fn closed_loop<R: Real<Scalar = f32>>(&self) -> RigLoop<R> {
        let constants: Vec<_> = self.plants.iter().map(|draw| draw.plant.map(f32::from_f64)).collect();
        let rotors: Vec<_> =
            self.plants.iter().map(|draw| LaggedRotors::<f32>::new(&draw.plant, SAMPLE_TIME)).collect();
        let plant = RealPlant::assemble(
            gather_plants(&constants),
            gather_rotors(&rotors),
            State::at_rest(PerAxis::zero()),
            SAMPLE_TIME,
        );
        let last = self.plants.len() - 1;
        let phase = |of: fn(&Draw) -> f64| R::from_fn(|lane| f32::from_f64(of(&self.plants[lane.min(last)])));
        let phase = PerAxis { pitch: phase(|d| d.encoder_phase.pitch), yaw: phase(|d| d.encoder_phase.yaw) };
        let hardware = Hardware::of(self.rig, PerAxis::both(0.5));
        RigLoop::assemble(plant, &hardware, phase, &self.settings.map(R::splat))
    }
}
