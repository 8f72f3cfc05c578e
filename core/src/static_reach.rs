//! Which pitches the motors can hold: the volts that a pose takes, and how far they go.
//!
//! At rest eqs (1)-(2) ask for a torque of m g L cos θ + K_sp sin θ about the pitch axis and none about the
//! yaw axis. [`hold_volts`] are the volts in effect that give it; what a motor may take for long is its limit
//! in volts and, where the motor is known, the volts at which its current is the continuous one:
//! V = R I_c/(1 - back-EMF's share). A pose counts as one that can be held while each motor keeps
//! [`SPARE`] of that for control.

use crate::DEGREE;
use crate::allocation::CurrentLimitSettings;
use crate::axes::{PerAxis, PerMotor};
use crate::pipeline::settings::Settings;
use crate::plant::{Effectiveness, PlantParameters, RigidBody, State};
use crate::real::{Mask, Real};
use core::fmt;

/// \[-\] Part of what a motor may take for long that holding a pose leaves for control.
pub const SPARE: f64 = 0.1;
/// \[degrees\] How far from the horizontal poses are looked at.
const FARTHEST: i32 = 60;
/// Mean of a guess and what the thrust at that guess would take: Heron's rule, which doubles its digits each
/// time once it is near.
const ROUNDS: usize = 20;

/// \[V\] In effect, that hold the pitch angle \[rad\] with no torque about the yaw axis.
pub fn hold_volts<R: Real>(model: &PlantParameters<R>, pitch: R) -> PerMotor<R> {
    let pose = State::at_rest(PerAxis::new(pitch, R::zero()));
    let torque = RigidBody::new(model).at(&pose).opposing;
    volts_for(&model.effectiveness, &model.quadratic_effectiveness, torque)
}

/// \[V\] In effect, whose thrust a v + b v|v| is `torque` \[N m\].
fn volts_for<R: Real>(a: &Effectiveness<R>, b: &Effectiveness<R>, torque: PerAxis<R>) -> PerMotor<R> {
    let curved = [b.main_on_pitch, b.tail_on_pitch, b.main_on_yaw, b.tail_on_yaw]
        .into_iter()
        .any(|b| R::zero().lt(b.abs()).any());
    if !curved {
        return a.volts(torque);
    }
    let mut volts = PerMotor::both(R::from_f64(10.0));
    for _ in 0..ROUNDS {
        let size = volts.map(Real::abs);
        let chord = Effectiveness {
            main_on_pitch: a.main_on_pitch + b.main_on_pitch * size.main,
            tail_on_pitch: a.tail_on_pitch + b.tail_on_pitch * size.tail,
            main_on_yaw: a.main_on_yaw + b.main_on_yaw * size.main,
            tail_on_yaw: a.tail_on_yaw + b.tail_on_yaw * size.tail,
        };
        volts = volts.plus(chord.volts(torque)).scaled(R::from_f64(0.5));
    }
    volts
}

/// The poses that can be held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticReach<R> {
    model: PlantParameters<R>,
    /// \[V\] What each motor may take to hold a pose.
    pub limit: PerMotor<R>,
    /// \[rad\] The lowest pitch that can be held.
    pub low: R,
    /// \[rad\] The highest one.
    pub high: R,
}

/// A pose that cannot be held, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CannotHold {
    /// \[rad\] The pitch asked for.
    pub pitch: f64,
    /// \[V\] What each motor would have to give.
    pub needs: PerMotor<f64>,
    /// \[V\] What each may give for long.
    pub limit: PerMotor<f64>,
    /// \[rad\] The nearest pitch that can be held.
    pub nearest: f64,
}

impl fmt::Display for CannotHold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pitch, needs, limit, nearest } = *self;
        write!(
            f,
            "a pitch of {:.1} deg cannot be held: it takes {:.1} V of the main motor and {:.1} V of the tail \
             motor, which may give {:.1} and {:.1} V for long; it is approached to {:.1} deg",
            pitch / DEGREE,
            needs.main,
            needs.tail,
            limit.main,
            limit.tail,
            nearest / DEGREE,
        )
    }
}

impl<R: Real> StaticReach<R> {
    /// Of a rig as it is believed to be: the connected range of pitches about the horizontal or, where that
    /// cannot be held itself, the nearest range below it.
    pub fn new(settings: &Settings<R>) -> Self {
        let model = settings.model;
        let for_long =
            |limit: R| R::from_f64(1.0 - SPARE) * continuous(settings.current_limit.as_ref()).min(limit);
        let limit = settings.volts_limit.map(for_long);
        let can = |pitch: R| {
            let volts = hold_volts(&model, pitch).map(Real::abs);
            volts.main.le(limit.main) & volts.tail.le(limit.tail)
        };
        let level = can(R::zero());
        let none = R::Mask::splat(false);
        // Downwards: the first pitch that can be held, and the last one before one that cannot.
        let (mut begun, mut ended, mut top, mut low) = (none, none, R::zero(), R::zero());
        let (mut up, mut high) = (level, R::zero());
        for degree in 0..=FARTHEST {
            let pitch = R::from_i32(degree) * R::from_f64(DEGREE);
            let held = can(-pitch) & !ended;
            top = R::select(held & !begun, -pitch, top);
            low = R::select(held, -pitch, low);
            ended = ended | (begun & !held);
            begun = begun | held;
            up = up & can(pitch);
            high = R::select(up, pitch, high);
        }
        Self { model, limit, low, high: R::select(level, high, top) }
    }
}

impl StaticReach<f64> {
    /// The volts in effect that hold a pitch \[rad\].
    ///
    /// # Errors
    /// Says what it would take, what there is, and the nearest pitch that can be held.
    pub fn can_hold(&self, pitch: f64) -> Result<PerMotor<f64>, CannotHold> {
        let needs = hold_volts(&self.model, pitch);
        let nearest = Real::clamp(pitch, self.low, self.high);
        if (pitch - nearest).abs() < DEGREE
            && needs.main.abs() <= self.limit.main
            && needs.tail.abs() <= self.limit.tail
        {
            return Ok(needs);
        }
        Err(CannotHold { pitch, needs, limit: self.limit, nearest })
    }
}

/// \[V\] At which a motor that follows takes its continuous current.
fn continuous<R: Real>(motor: Option<&CurrentLimitSettings<R>>) -> R {
    motor.map_or(R::from_f64(f64::INFINITY), |m| m.resistance * m.continuous / (R::one() - m.back_emf))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::defaults;
    use crate::plant::presets::{self, Rig};

    fn reach(rig: &Rig) -> StaticReach<f64> {
        StaticReach::new(&Settings::new(rig, defaults::ALL[0].1, 1e-3))
    }

    /// Newton's second law at rest, with the plant's own thrust.
    #[test]
    fn the_volts_that_hold_a_pose_balance_it() {
        for (name, rig) in presets::ALL {
            let p = &rig.plant;
            for degrees in [-30.0, 0.0, 15.0, 25.0] {
                let pitch = degrees * DEGREE;
                let volts = hold_volts(p, pitch);
                let squares = volts.map(|v| v * v.abs());
                let torque = p.effectiveness.torque(volts).plus(p.quadratic_effectiveness.torque(squares));
                let weight = p.mass * p.gravity * p.center_of_mass * pitch.cos() + p.stiffness * pitch.sin();
                assert!((torque.pitch - weight).abs() < 1e-8, "{name} {degrees} {volts:?}");
                assert!(torque.yaw.abs() < 1e-8, "{name} {degrees} {volts:?}");
            }
        }
    }

    #[test]
    fn what_is_flown_can_be_held_on_every_preset() {
        for (name, rig) in presets::ALL {
            let reach = reach(&rig);
            for degrees in [-25.0, 0.0, 25.0] {
                assert!(reach.can_hold(degrees * DEGREE).is_ok(), "{name} {degrees} {reach:?}");
            }
        }
    }

    /// The review's rigs: ±6 V on `aero-lab`, a centre of mass 2 mm ahead on `aero2`.
    #[test]
    fn what_cannot_be_held_is_told_with_its_numbers() {
        let weak = Rig { volts_limit: PerMotor::both(6.0), ..presets::AERO_LAB };
        let told = reach(&weak).can_hold(15.0 * DEGREE).unwrap_err();
        assert!(told.needs.main > 6.0 && told.limit.main == 5.4);
        assert!(told.nearest > 0.0 && told.nearest < 12.0 * DEGREE);
        assert!(reach(&weak).can_hold(told.nearest).is_ok());
        let mut heavy = presets::AERO2;
        heavy.plant.center_of_mass = 0.002;
        assert!(reach(&heavy).can_hold(0.0).is_err());
    }

    /// A helicopter that hangs nose down and cannot be lifted to the horizontal stays below it.
    #[test]
    fn below_a_level_that_cannot_be_held_is_a_range_that_can() {
        let weak = Rig { volts_limit: PerMotor::new(11.0, 15.0), ..presets::HELI };
        let StaticReach { low, high, .. } = reach(&weak);
        assert!(low < high && high < 0.0);
        assert!(reach(&weak).can_hold(0.5 * (low + high)).is_ok());
    }
}
