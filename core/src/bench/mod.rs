//! One simulated rig on its bench, as its cables show it: the plant, encoders that count, a stop to rest on,
//! amplifiers with their supply, and faults of the wiring.
//!
//! Volts in, counts out, tick by tick: what a board's port to its plant reads and writes. Every simulated rig
//! is one of these: that of the tests, of the simulator's board loop, of the first-power check's prediction,
//! of the emulated board.

mod encoders;
mod faults;
mod injection;
mod simulated_rig;
mod wear;

pub use encoders::{Encoders, Hardware, counts_per_angle};
pub use faults::Faults;
pub use injection::Injection;
pub use simulated_rig::SimulatedRig;
pub use wear::{LONGEST_DELAY, Wear, Worn};

use crate::axes::{PerAxis, PerMotor};
use crate::drive::{Drive, Duty};
use crate::plant::presets::Rig;
use crate::plant::{PlantParameters, RealPlant, State};
use crate::real::Real;

/// A simulated rig; a step of its plant is a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bench<R> {
    plant: RealPlant<R>,
    encoders: Encoders<R>,
    /// \[counts\] Where the shafts are.
    position: PerAxis<i32>,
    /// \[counts\] What the encoders have counted since they were switched on.
    counted: PerAxis<i32>,
    drive: Drive<R>,
    /// \[V\] What the duties of the last [`Bench::tick`] will give.
    latched: PerMotor<R>,
    /// \[rad\] Pitch of the rest pose, where the rig's weight pulls its nose down on to something.
    rest_pitch: Option<R>,
    table: bool,
    held: bool,
    /// \[V\] Supply of the amplifiers.
    pub supply: R,
    /// \[V\] Added to the volts in effect.
    pub disturbance: PerMotor<R>,
    /// What is wrong with the cables.
    pub faults: Faults,
    /// What is worn.
    pub worn: Worn<R>,
}

impl<R: Real<Scalar = R, Mask = bool, Count = i32>> Bench<R> {
    /// A plant as it stands, on nothing, with counters that start at zero.
    pub fn new(mut plant: RealPlant<R>, hardware: &Hardware) -> Self {
        plant.set_cable(&hardware.wear.cable);
        let encoders = Encoders::new(hardware.encoder_counts, hardware.encoder_phase.cast());
        Self {
            position: encoders.counts(plant.state().angle).map(R::to_count),
            worn: Worn::new(&hardware.wear, plant.state().angle),
            plant,
            encoders,
            counted: PerAxis::both(0),
            drive: Drive::new(hardware.pwm_steps),
            latched: PerMotor::zero(),
            rest_pitch: None,
            table: false,
            held: false,
            supply: R::from_f64(hardware.supply),
            disturbance: PerMotor::zero(),
            faults: Faults::default(),
        }
    }

    /// `rig` in its rest pose, with ticks of `sample_time` \[s\]. If its weight pulls its nose down it has a
    /// stop: one of its own if it rests below the horizontal, else a table that may be
    /// [put under it](Bench::set_table).
    pub fn at_rest(rig: &Rig, sample_time: f64) -> Self {
        let plant = RealPlant::new(&rig.plant, State::at_rest(rig.rest_angle.cast()), sample_time);
        let nose_heavy = rig.plant.center_of_mass > 0.0;
        Self {
            rest_pitch: nose_heavy.then(|| R::from_f64(rig.rest_angle.pitch)),
            ..Self::new(plant, &Hardware::of(rig, PerAxis::both(0.5)))
        }
    }

    /// Something is under the rig that bears its weight in its rest pose, or is taken away. A rig that rests
    /// nose down always has its stop.
    pub fn set_table(&mut self, table: bool) {
        self.table = table;
    }

    /// Somebody catches the rig, stops its rotors, and holds it until the amplifiers are switched on.
    pub fn hold(&mut self) {
        self.held = true;
        self.steady();
    }

    /// Somebody stops the rig and its rotors with a hand, and lets go.
    pub fn steady(&mut self) {
        self.plant.place(State::at_rest(self.plant.state().angle));
        self.plant.set_rotors(PerMotor::zero());
    }

    /// It is worn from now on as `wear` says.
    pub fn set_wear(&mut self, wear: &Wear) {
        self.worn = Worn::new(wear, self.plant.state().angle);
        self.plant.set_cable(&wear.cable);
    }

    /// The same rig around another plant.
    #[must_use]
    pub fn with_plant(self, plant: RealPlant<R>) -> Self {
        Self { plant, ..self }
    }

    /// Its plant becomes that of these constants, as with a weight hung on or taken off.
    pub fn become_plant(&mut self, parameters: &PlantParameters<R>) {
        self.plant.become_plant(parameters);
    }

    /// From now on `torque` \[N m\] turns the body from outside.
    pub fn set_load(&mut self, torque: PerAxis<R>) {
        self.plant.set_load(torque);
    }

    /// Where the rig truly is.
    pub fn state(&self) -> State<R> {
        self.plant.state()
    }

    /// \[V\] The volts in effect at its rotors.
    pub fn rotor_volts(&self) -> PerMotor<R> {
        self.plant.rotor_volts()
    }

    /// \[counts\] Whole counts of both shafts, from the horizontal, whatever the encoders show.
    pub fn position(&self) -> PerAxis<i32> {
        self.position
    }

    /// \[counts\] What the encoders have counted since they were switched on.
    pub fn counted(&self) -> PerAxis<i32> {
        self.counted
    }

    /// \[counts\] What is read of the encoders since they were switched on: noise and all.
    pub fn shown(&self) -> PerAxis<i32> {
        let noise = self.worn.shown(PerAxis::zero()).map(R::to_count);
        self.counted.zip(noise, i32::wrapping_add)
    }

    /// What counters of 16 bits show.
    pub fn counters(&self) -> PerAxis<u32> {
        self.shown().map(|count| count.cast_unsigned() & 0xFFFF)
    }

    /// \[V\] What amplifiers that are enabled give in the tick that comes.
    pub fn latched(&self) -> PerMotor<R> {
        self.latched
    }

    /// A tick passes with `volts` \[V\] from the amplifiers, which are `enabled` or not. Answers what turned
    /// motors that are wired rightly.
    pub fn advance(&mut self, volts: PerMotor<R>, enabled: bool) -> PerMotor<R> {
        self.held &= !enabled;
        let driven = self.worn.driven(volts);
        if !self.held {
            self.plant.advance(self.faults.motor_volts(driven), self.disturbance);
            self.rest_on_stop();
        }
        self.count();
        driven
    }

    /// A tick passes at whose beginning the PWM latches the duties of the tick before: `duty` acts from the
    /// next one on. Amplifiers that are not `enabled` give nothing at once. Answers what
    /// [`advance`](Bench::advance) does.
    pub fn tick(&mut self, duty: PerMotor<Duty<R>>, enabled: bool) -> PerMotor<R> {
        let volts = if enabled { self.latched } else { PerMotor::zero() };
        self.latched = self.drive.volts(duty, self.supply);
        self.advance(volts, enabled)
    }

    fn rest_on_stop(&mut self) {
        let Some(lowest) = self.rest_pitch else { return };
        let mut body = self.plant.state();
        if (self.table || lowest.lt(R::zero())) && body.angle.pitch.lt(lowest) {
            body.angle.pitch = lowest;
            body.rate.pitch = R::zero();
            self.plant.place(body);
        }
    }

    fn count(&mut self) {
        let seen = self.worn.seen(self.plant.state().angle);
        let position = self.encoders.counts(seen).map(R::to_count);
        let turned = position.zip(self.position, i32::wrapping_sub);
        self.position = position;
        self.counted = self.counted.zip(self.faults.counted(turned), i32::wrapping_add);
    }
}

#[cfg(test)]
mod tests;
