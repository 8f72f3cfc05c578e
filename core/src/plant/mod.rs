//! The helicopter: eqs (1)-(2), and what a body that is no point adds, integrated by the classical
//! fourth-order Runge-Kutta method with held volts.
//!
//! The simulator and the virtual board fly this; the law never sees it. A step is one tick of the loop or a
//! whole fraction of it.

mod body;
mod cable;
mod lag;
mod parameters;
pub mod plausible;
pub mod presets;
mod rotors;
mod tilt;

pub use body::{Dynamics, RigidBody, State};
pub use cable::Cable;
pub use lag::decay;
pub(crate) use lag::{RotorTorque, bilinear_decay, follow, tustin_decay};
pub use parameters::{Effectiveness, PlantParameters};
pub use rotors::{EffectOverStep, IdealRotors, LaggedRotors, RotorEffect, Thrust};

use crate::axes::{PerAxis, PerMotor};
use crate::compensated::Compensated;
use crate::real::{Mask, Real};
use tilt::Tilt;

/// \[rad/s\] Width of the smooth Coulomb friction: it opposes the rate by F ω/√(ω² + w²). A body held against
/// it creeps at about this rate, slower than one encoder count a second.
pub const FRICTION_WIDTH: f64 = 0.002;

/// A helicopter in motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plant<R, T> {
    body: RigidBody<R>,
    coulomb_friction: PerAxis<R>,
    has_friction: bool,
    tilt: Option<Tilt<R>>,
    /// \[N m\] What turns the body from outside.
    load: PerAxis<R>,
    has_load: bool,
    cable: Option<Cable<R>>,
    rotors: T,
    /// \[s\] Length of a step.
    step: R,
    angle: PerAxis<Compensated<R>>,
    rate: PerAxis<Compensated<R>>,
}

/// A helicopter whose rotors answer at once: the paper's.
pub type IdealPlant<R> = Plant<R, IdealRotors<R>>;
/// A helicopter with real rotors.
pub type RealPlant<R> = Plant<R, LaggedRotors<R>>;

impl<R: Real, T: Thrust<R>> Plant<R, T> {
    /// A helicopter at `state` with its rotors at rest, stepping by `step` \[s\].
    pub fn new(parameters: &PlantParameters<f64>, state: State<R>, step: f64) -> Self {
        Self::assemble(parameters.map(R::from_f64), T::new(parameters, step), state, step)
    }

    /// As [`Plant::new`], from constants that may differ from lane to lane and rotors made for them.
    pub fn assemble(parameters: PlantParameters<R>, rotors: T, state: State<R>, step: f64) -> Self {
        Self {
            body: RigidBody::new(&parameters),
            coulomb_friction: parameters.coulomb_friction,
            has_friction: has_friction(&parameters),
            tilt: Tilt::of(&parameters),
            load: PerAxis::zero(),
            has_load: false,
            cable: None,
            rotors,
            step: R::from_f64(step),
            angle: state.angle.map(Compensated::new),
            rate: state.rate.map(Compensated::new),
        }
    }

    /// Where it is now.
    #[inline(always)]
    pub fn state(&self) -> State<R> {
        State { angle: self.angle.map(Compensated::value), rate: self.rate.map(Compensated::value) }
    }

    /// Puts it at `state`; its rotors turn on.
    pub fn place(&mut self, state: State<R>) {
        self.angle = state.angle.map(Compensated::new);
        self.rate = state.rate.map(Compensated::new);
    }

    /// It becomes that of these constants, as with a weight hung on or a propeller chipped; its pose, its
    /// rates, the volts in effect and the rotors' lags stay.
    pub fn become_plant(&mut self, parameters: &PlantParameters<R>) {
        self.body = RigidBody::new(parameters);
        self.coulomb_friction = parameters.coulomb_friction;
        self.has_friction = has_friction(parameters);
        self.tilt = Tilt::of(parameters);
        self.rotors.become_plant(parameters);
    }

    /// From now on `torque` \[N m\] turns the body from outside, as a hand or a cable does.
    pub fn set_load(&mut self, torque: PerAxis<R>) {
        self.load = torque;
        let none = |x: R| x.le(R::zero()) & R::zero().le(x);
        self.has_load = !(none(torque.pitch) & none(torque.yaw)).all();
    }

    /// From now on a cable holds yaw back, if it is stiff at all.
    pub fn set_cable(&mut self, cable: &Cable<f64>) {
        let [stiffness, free] = [cable.stiffness, cable.free].map(R::from_f64);
        self.cable = (cable.stiffness > 0.0).then_some(Cable { stiffness, free });
    }

    /// The same on the cable of `other`.
    #[must_use]
    pub(crate) fn on_cable_of(self, other: &Self) -> Self {
        Self { cable: other.cable, ..self }
    }

    /// One step with `volts` held and `disturbance` \[V\] added to the volts in effect.
    #[inline(always)]
    pub fn advance(&mut self, volts: PerMotor<R>, disturbance: PerMotor<R>) {
        let [begin, middle, end] = self.rotors.over_step(volts, disturbance);
        let h = self.step;
        let half = R::from_f64(0.5) * h;
        let x = self.state();

        let a1 = self.accel(&x, begin);
        let x2 = moved(&x, &x.rate, &a1, half);
        let a2 = self.accel(&x2, middle);
        let x3 = moved(&x, &x2.rate, &a2, half);
        let a3 = self.accel(&x3, middle);
        let x4 = moved(&x, &x3.rate, &a3, h);
        let a4 = self.accel(&x4, end);

        let sixth = h * R::from_f64(1.0 / 6.0);
        let two = R::from_f64(2.0);
        let mean = |k1: R, k2: R, k3: R, k4: R| sixth * ((k1 + k4) + two * (k2 + k3));
        let (angle, rate) = (&mut self.angle, &mut self.rate);
        angle.pitch.add(mean(x.rate.pitch, x2.rate.pitch, x3.rate.pitch, x4.rate.pitch));
        angle.yaw.add(mean(x.rate.yaw, x2.rate.yaw, x3.rate.yaw, x4.rate.yaw));
        rate.pitch.add(mean(a1.pitch, a2.pitch, a3.pitch, a4.pitch));
        rate.yaw.add(mean(a1.yaw, a2.yaw, a3.yaw, a4.yaw));
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    #[cfg_attr(debug_assertions, inline(never))]
    fn accel(&self, state: &State<R>, effect: RotorEffect<R>) -> PerAxis<R> {
        let pitched = state.angle.pitch.sin_cos();
        let torque = match &self.tilt {
            Some(tilt) => tilt.torque(effect, pitched, state.rate),
            None => effect.torque,
        };
        let torque = if self.has_friction { torque.minus(self.friction(state.rate)) } else { torque };
        let torque = if self.has_load { torque.plus(self.load) } else { torque };
        let torque = match &self.cable {
            Some(cable) => PerAxis { yaw: torque.yaw + cable.torque(state.angle.yaw), ..torque },
            None => torque,
        };
        self.body.pitched(pitched, state.rate).accel(torque)
    }

    #[inline(always)]
    fn friction(&self, rate: PerAxis<R>) -> PerAxis<R> {
        let width = R::from_f64(FRICTION_WIDTH);
        self.coulomb_friction.zip(
            rate,
            #[inline(always)]
            |f, w| f * w / (w * w + width * width).sqrt(),
        )
    }
}

impl<R: Real> RealPlant<R> {
    /// In the lanes of `which` it goes on where `other` is: pose, rates and what the rotors do, to the bit.
    pub fn go_on(&mut self, which: R::Mask, other: &Self) {
        let sums = |own: PerAxis<Compensated<R>>, others: PerAxis<Compensated<R>>| {
            own.zip(others, |own, others| Compensated::select(which, others, own))
        };
        self.angle = sums(self.angle, other.angle);
        self.rate = sums(self.rate, other.rate);
        let volts = self.rotors.volts.zip(other.rotors.volts, |own, others| R::select(which, others, own));
        self.rotors.volts = volts;
    }

    /// Its rotors turn at once as they do when `volts` \[V\] have been applied for long.
    pub fn set_rotors(&mut self, volts: PerMotor<R>) {
        self.rotors.volts = volts;
    }

    /// \[V\] The volts in effect at its rotors, which follow those at the motors.
    pub fn rotor_volts(&self) -> PerMotor<R> {
        self.rotors.volts
    }
}

fn has_friction<R: Real>(parameters: &PlantParameters<R>) -> bool {
    let friction = parameters.coulomb_friction;
    (R::zero().lt(friction.pitch) | R::zero().lt(friction.yaw)).any()
}

/// `state` moved on for `time` at the given rates and accelerations.
#[inline(always)]
fn moved<R: Real>(state: &State<R>, rate: &PerAxis<R>, accel: &PerAxis<R>, time: R) -> State<R> {
    State { angle: state.angle.plus(rate.scaled(time)), rate: state.rate.plus(accel.scaled(time)) }
}

#[cfg(test)]
mod tests;
