//! What a two-rotor helicopter is made of, in numbers.

use crate::axes::{PerAxis, PerMotor};
use crate::real::Real;
use crate::validate::{Invalid, require};
use serde::{Deserialize, Serialize};

/// Torque on each axis for a volt (or a volt squared) on each motor: the matrix K of eqs (5)-(6).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Effectiveness<R> {
    /// k_pp.
    pub main_on_pitch: R,
    /// k_py.
    pub tail_on_pitch: R,
    /// k_yp.
    pub main_on_yaw: R,
    /// k_yy.
    pub tail_on_yaw: R,
}

impl<R: Real> Effectiveness<R> {
    /// All four zero.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::default_with(R::zero())
    }

    fn default_with(value: R) -> Self {
        Self { main_on_pitch: value, tail_on_pitch: value, main_on_yaw: value, tail_on_yaw: value }
    }

    /// The torque on each axis \[N m\] of `volts`: eqs (5)-(6), U = K V.
    #[inline(always)]
    pub fn torque(&self, volts: PerMotor<R>) -> PerAxis<R> {
        PerAxis {
            pitch: self.main_on_pitch * volts.main + self.tail_on_pitch * volts.tail,
            yaw: self.main_on_yaw * volts.main + self.tail_on_yaw * volts.tail,
        }
    }

    /// \[V\] The volts that give `torque` \[N m\], V = K⁻¹ U; K can be inverted.
    pub fn volts(&self, torque: PerAxis<R>) -> PerMotor<R> {
        let determinant = self.determinant();
        PerMotor {
            main: (self.tail_on_yaw * torque.pitch - self.tail_on_pitch * torque.yaw) / determinant,
            tail: (self.main_on_pitch * torque.yaw - self.main_on_yaw * torque.pitch) / determinant,
        }
    }

    /// det K.
    #[inline(always)]
    pub fn determinant(&self) -> R {
        self.main_on_pitch * self.tail_on_yaw - self.tail_on_pitch * self.main_on_yaw
    }

    /// Each entry through `f`.
    #[inline(always)]
    pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> Effectiveness<U> {
        Effectiveness {
            main_on_pitch: f(self.main_on_pitch),
            tail_on_pitch: f(self.tail_on_pitch),
            main_on_yaw: f(self.main_on_yaw),
            tail_on_yaw: f(self.tail_on_yaw),
        }
    }

    /// Each entry with its partner through `f`.
    #[inline(always)]
    pub fn zip<U, V>(self, other: Effectiveness<U>, mut f: impl FnMut(R, U) -> V) -> Effectiveness<V> {
        Effectiveness {
            main_on_pitch: f(self.main_on_pitch, other.main_on_pitch),
            tail_on_pitch: f(self.tail_on_pitch, other.tail_on_pitch),
            main_on_yaw: f(self.main_on_yaw, other.main_on_yaw),
            tail_on_yaw: f(self.tail_on_yaw, other.tail_on_yaw),
        }
    }
}

/// The constants of one helicopter: eqs (1)-(2), and beside them what real rigs show and the paper leaves
/// out. Each extra term is off when its constant is zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantParameters<R> {
    /// \[kg\] Mass of the moving body, m.
    pub mass: R,
    /// \[m\] Distance of the centre of mass in front of the pivot, L. Its weight pulls with m g L cos θ.
    pub center_of_mass: R,
    /// \[m/s²\] Gravitational acceleration, g.
    pub gravity: R,
    /// \[kg m²\] Moments of inertia I_pp, I_yy, without the m L² that eqs (1)-(2) add themselves.
    pub inertia: PerAxis<R>,
    /// \[N m s/rad\] Viscous friction D_pp, D_yy. (The paper's Table 3 prints "N/V", which cannot be.)
    pub damping: PerAxis<R>,
    /// \[N m/rad\] K_sp: a centre of mass below the pivot pulls back with K_sp sin θ. Not in the paper.
    pub stiffness: R,
    /// \[N m/V\] Torque for the volts in effect, K.
    pub effectiveness: Effectiveness<R>,
    /// \[N m/V²\] Torque for v|v| of the volts in effect: a propeller's thrust grows with the square of its
    /// speed. Not in the paper.
    pub quadratic_effectiveness: Effectiveness<R>,
    /// \[s\] Time constant with which the volts in effect follow those applied, τ; 0 for at once. Not in the
    /// paper.
    pub rotor_time_constant: PerMotor<R>,
    /// \[N m s/V\] Reaction of an accelerating rotor on the *other* axis, for each volt a second that the
    /// volts in effect change: the main rotor's on yaw, the tail rotor's on pitch. Not in the paper.
    pub rotor_reaction: PerMotor<R>,
    /// \[N m\] Coulomb friction at speed. Not in the paper.
    pub coulomb_friction: PerAxis<R>,
    /// \[kg m²\] By how much less inertia yaw has with the body upright than with it level, J_zz - J_xx of the
    /// body; less than I_yy. Not in the paper, whose body is a point.
    #[serde(default)]
    pub tilting_inertia: R,
    /// \[N m s/V\] Angular momentum of the main rotor along its axis, which tilts with the body, for each volt
    /// in effect. A rotor that gains it turns the body the other way: `rotor_reaction.main` is minus this on
    /// a rig that has both. (The tail rotor's lies along the pitch axis, which never tilts.) Not in the paper.
    #[serde(default)]
    pub rotor_momentum: R,
    /// \[-\] 1 where thrust and reaction turn yaw by cos θ of what they do on a level body, as rotors do that
    /// tilt with it; 0 where they turn it the same at any pitch, as in the paper.
    #[serde(default)]
    pub tilting_thrust: R,
}

/// \[kg m\] m L of a body whose weight is balanced on the pivot: a microgram at a metre.
const LEAST_MOMENT: f64 = 1e-9;
/// \[kg m²\] m L² of a body all of whose weight is at the pivot.
const LEAST_SQUARE: f64 = 1e-12;

impl<R: Real> PlantParameters<R> {
    /// The same helicopter whose rotors give this part of their thrust, 1 for all of it: a chipped propeller,
    /// a tired motor.
    pub fn with_thrust(&self, part: PerMotor<R>) -> Self {
        let of = |k: Effectiveness<R>| Effectiveness {
            main_on_pitch: k.main_on_pitch * part.main,
            tail_on_pitch: k.tail_on_pitch * part.tail,
            main_on_yaw: k.main_on_yaw * part.main,
            tail_on_yaw: k.tail_on_yaw * part.tail,
        };
        Self {
            effectiveness: of(self.effectiveness),
            quadratic_effectiveness: of(self.quadratic_effectiveness),
            ..*self
        }
    }

    /// Torque for each volt at `volts`, on the chord of the thrust curve: what a linear law takes for K.
    #[inline(always)]
    pub fn effectiveness_at(&self, volts: R) -> Effectiveness<R> {
        self.effectiveness.zip(self.quadratic_effectiveness, |a, b| a + b * volts.abs())
    }

    /// The same helicopter as the paper would see it: eqs (1)-(2) alone, no rotor lag, no reaction torque, no
    /// Coulomb friction, no terms of an extended body, thrust proportional to volts with the slope it has at
    /// `volts`.
    #[inline(always)]
    pub fn ideal(&self, volts: R) -> Self {
        Self {
            effectiveness: self.effectiveness_at(volts),
            quadratic_effectiveness: Effectiveness::zero(),
            rotor_time_constant: PerMotor::zero(),
            rotor_reaction: PerMotor::zero(),
            coulomb_friction: PerAxis::zero(),
            tilting_inertia: R::zero(),
            rotor_momentum: R::zero(),
            tilting_thrust: R::zero(),
            ..*self
        }
    }

    /// The same helicopter with a weight of `mass` \[kg\] hung on `arm` \[m\] in front of the pivot: as eqs
    /// (1)-(2) have only one point mass m at L, the one with both moments, m L and m L². A negative `arm` is
    /// behind the pivot.
    pub fn with_weight(&self, mass: R, arm: R) -> Self {
        let moment = self.mass * self.center_of_mass + mass * arm;
        // What balances on the pivot keeps a moment that nobody could measure, or L would be infinite.
        let balanced = moment.abs().lt(R::from_f64(LEAST_MOMENT));
        let moment = R::select(balanced, R::from_f64(LEAST_MOMENT), moment);
        let square = self.mass * self.center_of_mass * self.center_of_mass + mass * arm * arm;
        let square = square.max(R::from_f64(LEAST_SQUARE));
        Self { mass: moment * moment / square, center_of_mass: square / moment, ..*self }
    }

    /// Each constant through `f`.
    #[inline(always)]
    pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> PlantParameters<U> {
        PlantParameters {
            mass: f(self.mass),
            center_of_mass: f(self.center_of_mass),
            gravity: f(self.gravity),
            inertia: self.inertia.map(&mut f),
            damping: self.damping.map(&mut f),
            stiffness: f(self.stiffness),
            effectiveness: self.effectiveness.map(&mut f),
            quadratic_effectiveness: self.quadratic_effectiveness.map(&mut f),
            rotor_time_constant: self.rotor_time_constant.map(&mut f),
            rotor_reaction: self.rotor_reaction.map(&mut f),
            coulomb_friction: self.coulomb_friction.map(&mut f),
            tilting_inertia: f(self.tilting_inertia),
            rotor_momentum: f(self.rotor_momentum),
            tilting_thrust: f(self.tilting_thrust),
        }
    }
}

impl Effectiveness<f64> {
    /// Can every torque be had from some volts? |det K| must be at least a thousandth of what its two
    /// products would give if they did not cancel; otherwise V = K⁻¹ U asks for a thousand times the volts.
    ///
    /// # Errors
    /// If it is less.
    pub fn validate_inverse(&self) -> Result<(), Invalid> {
        let scale =
            (self.main_on_pitch * self.tail_on_yaw).abs() + (self.tail_on_pitch * self.main_on_yaw).abs();
        let determinant = self.determinant();
        require(
            "effectiveness (determinant)",
            determinant,
            determinant.abs() > 1e-3 * scale,
            "a matrix of thrust gains that can be inverted (determinant other than 0)",
        )
    }
}
