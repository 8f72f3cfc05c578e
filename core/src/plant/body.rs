//! The rigid body of eqs (1)-(2): what both the plant and the law know of the helicopter.

use super::PlantParameters;
use crate::axes::PerAxis;
use crate::real::Real;

/// Angles and rates of the body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State<R> {
    /// \[rad\] θ, ψ.
    pub angle: PerAxis<R>,
    /// \[rad/s\] θ̇, ψ̇.
    pub rate: PerAxis<R>,
}

impl<R: Real> State<R> {
    /// At rest at `angle` \[rad\].
    #[inline(always)]
    pub fn at_rest(angle: PerAxis<R>) -> Self {
        Self { angle, rate: PerAxis::zero() }
    }

    /// Are all four numbers finite?
    #[inline(always)]
    pub fn is_finite(&self) -> R::Mask {
        self.angle.pitch.is_finite()
            & self.angle.yaw.is_finite()
            & self.rate.pitch.is_finite()
            & self.rate.yaw.is_finite()
    }
}

/// The constants of eqs (1)-(2), combined as the equations use them, for a body that may be more than a point:
/// yaw has the inertia I_yy + m L² cos² θ - J sin² θ, J = `tilting_inertia`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidBody<R> {
    /// \[N m\] m g L.
    weight_torque: R,
    /// \[N m/rad\] K_sp.
    stiffness: R,
    /// \[kg m²\] m L² + J: what yaw gains by cos² θ, and so what the Coriolis torques go with.
    coupling: R,
    /// \[kg m²\] I_pp + m L², and yaw's upright, I_yy - J.
    inertia: PerAxis<R>,
    /// \[N m s/rad\] D_pp, D_yy.
    damping: PerAxis<R>,
}

/// What eqs (1)-(2) say at one state: M q̈ = torque - opposing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dynamics<R> {
    /// \[kg m²\] I_pp + m L², I_yy + m L² cos² θ - J sin² θ.
    pub inertia: PerAxis<R>,
    /// \[N m\] Gravity, viscous friction and Coriolis torque, as they oppose motion.
    pub opposing: PerAxis<R>,
}

impl<R: Real> RigidBody<R> {
    /// From the plant's constants.
    pub fn new(parameters: &PlantParameters<R>) -> Self {
        let moment = parameters.mass * parameters.center_of_mass;
        let square = moment * parameters.center_of_mass;
        let tilting = parameters.tilting_inertia;
        Self {
            weight_torque: moment * parameters.gravity,
            stiffness: parameters.stiffness,
            coupling: square + tilting,
            inertia: PerAxis {
                pitch: parameters.inertia.pitch + square,
                yaw: parameters.inertia.yaw - tilting,
            },
            damping: parameters.damping,
        }
    }

    /// Eqs (1)-(2) at `state`, with K_sp sin θ beside the paper's m g L cos θ.
    #[inline(always)]
    pub fn at(&self, state: &State<R>) -> Dynamics<R> {
        self.pitched(state.angle.pitch.sin_cos(), state.rate)
    }

    /// The same with sine and cosine of the pitch at hand.
    #[inline(always)]
    pub(super) fn pitched(&self, (sine, cosine): (R, R), rate: PerAxis<R>) -> Dynamics<R> {
        let coriolis = self.coupling * rate.yaw * sine * cosine;
        Dynamics {
            inertia: PerAxis {
                pitch: self.inertia.pitch,
                yaw: self.inertia.yaw + self.coupling * (cosine * cosine),
            },
            opposing: PerAxis {
                pitch: self.weight_torque * cosine
                    + self.stiffness * sine
                    + self.damping.pitch * rate.pitch
                    + coriolis * rate.yaw,
                yaw: self.damping.yaw * rate.yaw - (coriolis + coriolis) * rate.pitch,
            },
        }
    }
}

impl<R: Real> Dynamics<R> {
    /// \[rad/s²\] q̈ for a torque \[N m\]: eqs (3)-(4).
    #[inline(always)]
    pub fn accel(&self, torque: PerAxis<R>) -> PerAxis<R> {
        PerAxis {
            pitch: (torque.pitch - self.opposing.pitch) / self.inertia.pitch,
            yaw: (torque.yaw - self.opposing.yaw) / self.inertia.yaw,
        }
    }

    /// \[N m\] The torque that gives an acceleration \[rad/s²\]: eqs (3)-(4) the other way round.
    #[inline(always)]
    pub fn torque(&self, accel: PerAxis<R>) -> PerAxis<R> {
        PerAxis {
            pitch: self.inertia.pitch * accel.pitch + self.opposing.pitch,
            yaw: self.inertia.yaw * accel.yaw + self.opposing.yaw,
        }
    }
}
