//! The rigs: every constant with its unit and its source.
//!
//! Published constants of these machines differ by factors, so each preset says whose they are. Gains do not
//! carry from one to another.

use super::{Effectiveness, PlantParameters, State, plausible};
use crate::DEGREE;
use crate::axes::{PerAxis, PerMotor};
use crate::board::{self, Board};
use crate::validate::{Invalid, positive, require};
use serde::{Deserialize, Serialize};

/// A machine: its plant, and what the controller must know of its sensors, motors and limits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rig {
    /// The helicopter itself.
    pub plant: PlantParameters<f64>,
    /// \[V\] Most that may be applied to each motor, either way.
    pub volts_limit: PerMotor<f64>,
    /// What feeds the amplifiers. Not the motors' limit: an amplifier gives them a part of it.
    #[serde(default = "laboratory_supply")]
    pub supply: Supply,
    /// \[V\] At which the slope of the thrust curve is taken for a law that thinks it straight.
    pub nominal_volts: f64,
    /// Encoder counts a revolution, all four edges counted.
    pub encoder_counts: PerAxis<u32>,
    /// The board that flies it, from outside: no file of a rig has one. In files of before there were boards
    /// stands how many steps its PWM has, which is read over.
    #[serde(rename = "pwm_steps", default, skip_serializing, deserialize_with = "former_pwm_steps")]
    pub board: Board,
    /// \[rad\] Where it lies with the motors off, seen from the horizontal.
    pub rest_angle: PerAxis<f64>,
    /// What it must not leave.
    pub envelope: Envelope,
    /// The motors, where they are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor: Option<MotorConstants>,
}

/// What a file of before there were boards says, a number that was allowed then: it is the board's now.
fn former_pwm_steps<'de, D: serde::Deserializer<'de>>(file: D) -> Result<Board, D::Error> {
    match u32::deserialize(file)? {
        16..=65_535 => Ok(Board::default()),
        steps => Err(serde::de::Error::custom(format_args!(
            "pwm_steps is {steps}; allowed: 16 to 65535 (or leave it out, the board knows it)"
        ))),
    }
}

/// The amplifiers' supply.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Supply {
    /// \[V\] As it should be.
    pub nominal: f64,
    /// \[V\] Least with which the motors may turn; an amplifier never counts on less.
    pub lowest: f64,
    /// \[V\] Most with which the motors may turn.
    pub highest: f64,
}

/// 24 V, as the power amplifiers of all these rigs have it (user manuals of Aero and Aero 2: 24 V DC), or a
/// laboratory's supply of 18 V, which is the most that an Aero 2's motors should get; a tenth and a fifth of
/// tolerance.
const SUPPLY: Supply = Supply { nominal: 24.0, lowest: 16.0, highest: 29.0 };

const fn laboratory_supply() -> Supply {
    SUPPLY
}

/// Bounds of safe motion; beyond them the motors are cut.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Envelope {
    /// \[rad\] Largest pitch from the horizontal, either way.
    pub pitch: f64,
    /// \[rad/s\] Largest rate about each axis.
    pub rate: PerAxis<f64>,
}

impl Envelope {
    /// Is this state within it?
    pub fn holds(&self, state: &State<f64>) -> bool {
        let rate = state.rate;
        state.angle.pitch.abs() <= self.pitch
            && rate.pitch.abs() <= self.rate.pitch
            && rate.yaw.abs() <= self.rate.yaw
    }
}

/// A brushed DC motor that turns a rotor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotorConstants {
    /// \[ohm\] Terminal resistance.
    pub resistance: f64,
    /// \[V s/rad\] Back-EMF constant, numerically also N m/A.
    pub back_emf: f64,
    /// \[N m s/rad\] Torque that the turning propeller takes for each rad/s.
    pub drag: f64,
    /// \[A\] Most for an instant.
    pub peak_current: f64,
    /// \[A\] Most for long.
    pub continuous_current: f64,
}

/// 40 degrees: the pitch at which laboratories that run these rigs cut the motors.
const PITCH_ENVELOPE: f64 = 40.0 * DEGREE;
/// \[rad/s\] Twice the fastest rate of a time-optimal step of 15 and 40 degrees within 24 V.
const RATE_ENVELOPE: PerAxis<f64> = PerAxis::new(10.0, 10.0);

const NO_EFFECTIVENESS: Effectiveness<f64> =
    Effectiveness { main_on_pitch: 0.0, tail_on_pitch: 0.0, main_on_yaw: 0.0, tail_on_yaw: 0.0 };

/// Motor of the Aero and the Aero 2 (Aero 2 user manual: R 8.4 ohm, k_m .042 V s/rad, 2 A peak, .5 A
/// continuous; propeller drag 8e-5 N m s/rad).
const AERO_MOTOR: MotorConstants = MotorConstants {
    resistance: 8.4,
    back_emf: 0.042,
    drag: 8e-5,
    peak_current: 2.0,
    continuous_current: 0.5,
};

/// Table 3 as printed, limits ±24 V (section 5). In the rig's world, what the paper is silent on: the
/// encoders of the Aero 2 (user manual: 2880 and 4096 counts) and a rotor lag of .05 s (an estimate from R
/// and k_m of the Aero's motor; measured ones are three times as long).
///
/// k_pp = .022 is ten to twenty times the manufacturer's .0011 and most likely a misprint; see
/// [`PAPER_FIXED`].
pub const PAPER: Rig = Rig {
    plant: PlantParameters {
        mass: 1.075,
        center_of_mass: 0.002,
        gravity: 9.8,
        inertia: PerAxis::new(0.0215, 0.0237),
        damping: PerAxis::new(0.0071, 0.022),
        stiffness: 0.0,
        effectiveness: Effectiveness {
            main_on_pitch: 0.022,
            tail_on_pitch: 0.0221,
            main_on_yaw: -0.0227,
            tail_on_yaw: 0.0022,
        },
        quadratic_effectiveness: NO_EFFECTIVENESS,
        rotor_time_constant: PerMotor::both(0.05),
        rotor_reaction: PerMotor::both(0.0),
        coulomb_friction: PerAxis::both(0.0),
        tilting_inertia: 0.0,
        rotor_momentum: 0.0,
        tilting_thrust: 0.0,
    },
    volts_limit: PerMotor::both(24.0),
    supply: SUPPLY,
    nominal_volts: 0.0,
    encoder_counts: PerAxis::new(2880, 4096),
    board: board::F405,
    rest_angle: PerAxis::both(0.0),
    envelope: Envelope { pitch: PITCH_ENVELOPE, rate: RATE_ENVELOPE },
    motor: None,
};

/// [`PAPER`] with the manufacturer's four thrust gains (Quanser Aero set-up file: Kpp .0011, Kpy .0021,
/// Kyp -.0027, Kyy .0022 N m/V).
pub const PAPER_FIXED: Rig =
    Rig { plant: PlantParameters { effectiveness: AERO_EFFECTIVENESS, ..PAPER.plant }, ..PAPER };

const AERO_EFFECTIVENESS: Effectiveness<f64> =
    Effectiveness { main_on_pitch: 0.0011, tail_on_pitch: 0.0021, main_on_yaw: -0.0027, tail_on_yaw: 0.0022 };

/// Quanser Aero (2016) as its manufacturer's set-up file has it: J .0219/.0220, D .0071116/.0220, Ksp .037463
/// and the four thrust gains; encoders 2048/4096; ±24 V; rotor lag as fitted on the Aero 2, which has the
/// same motors (.162-.169 s).
pub const AERO: Rig = Rig {
    plant: PlantParameters {
        mass: 1.075,
        center_of_mass: 0.0,
        gravity: 9.81,
        inertia: PerAxis::new(0.0219, 0.0220),
        damping: PerAxis::new(0.007_111_6, 0.0220),
        stiffness: 0.037_463,
        effectiveness: AERO_EFFECTIVENESS,
        quadratic_effectiveness: NO_EFFECTIVENESS,
        rotor_time_constant: PerMotor::both(0.16),
        rotor_reaction: PerMotor::both(0.0),
        coulomb_friction: PerAxis::both(0.0),
        tilting_inertia: 0.0,
        rotor_momentum: 0.0,
        tilting_thrust: 0.0,
    },
    encoder_counts: PerAxis::new(2048, 4096),
    motor: Some(AERO_MOTOR),
    ..PAPER
};

/// Quanser Aero 2 as identified by its manufacturer (parameter file of the Aero 2): J .0231885/.0238104, D
/// .00199/.00192, Ksp .00744, Kpp .000537, Kpy .000229, Kyp -.000534, Kyy .00102; encoders 2880/4096 and the
/// recommended ±18 V (user manual); rotor lag .162-.169 s as fitted.
pub const AERO2: Rig = Rig {
    plant: PlantParameters {
        mass: 1.07,
        inertia: PerAxis::new(0.023_188_5, 0.023_810_4),
        damping: PerAxis::new(0.00199, 0.00192),
        stiffness: 0.00744,
        effectiveness: Effectiveness {
            main_on_pitch: 0.000_537,
            tail_on_pitch: 0.000_229,
            main_on_yaw: -0.000_534,
            tail_on_yaw: 0.001_02,
        },
        ..AERO.plant
    },
    volts_limit: PerMotor::both(18.0),
    encoder_counts: PerAxis::new(2880, 4096),
    ..AERO
};

/// Quanser Aero as logs of a real one show it (identified from open-loop runs with tachometers; inertias
/// fixed at the set-up file's .0219/.0220, since angles and volts give only ratios): rotor lag .15 s, thrust
/// a v + b v|v|, reaction torque of the rotors, Coulomb friction, K_sp; no m g L cos θ. ±24 V.
pub const AERO_LAB: Rig = Rig {
    plant: PlantParameters {
        damping: PerAxis::new(0.0012, 0.0015),
        stiffness: 0.0382,
        effectiveness: Effectiveness {
            main_on_pitch: 3.5e-5,
            tail_on_pitch: 9.0e-5,
            main_on_yaw: 0.0,
            tail_on_yaw: 8.2e-5,
        },
        quadratic_effectiveness: Effectiveness {
            main_on_pitch: 9.3e-5,
            tail_on_pitch: 6.5e-5,
            main_on_yaw: -5.3e-5,
            tail_on_yaw: 7.8e-5,
        },
        rotor_time_constant: PerMotor::both(0.15),
        rotor_reaction: PerMotor::new(-7.1e-4, 7.4e-4),
        coulomb_friction: PerAxis::new(0.0013, 0.0053),
        ..AERO.plant
    },
    nominal_volts: 10.0,
    ..AERO
};

/// The classic 2-DOF Helicopter (Quanser manual): m 1.3872 kg, l_cm .186 m in front of the pivot, inertias
/// .0384/.0432 without m l², D .8/.318, K .204/.0068/.0219/.072; ±24 V main, ±15 V tail; 4096/8192 counts;
/// rests nose down at 40.5 degrees. Its manual gives no rotor lag: .1 s is assumed.
#[expect(clippy::approx_constant, reason = "the manual's damping of .318 is not 1/pi")]
pub const HELI: Rig = Rig {
    plant: PlantParameters {
        mass: 1.3872,
        center_of_mass: 0.186,
        gravity: 9.81,
        inertia: PerAxis::new(0.0384, 0.0432),
        damping: PerAxis::new(0.8, 0.318),
        stiffness: 0.0,
        effectiveness: Effectiveness {
            main_on_pitch: 0.204,
            tail_on_pitch: 0.0068,
            main_on_yaw: 0.0219,
            tail_on_yaw: 0.072,
        },
        rotor_time_constant: PerMotor::both(0.1),
        ..AERO.plant
    },
    volts_limit: PerMotor::new(24.0, 15.0),
    encoder_counts: PerAxis::new(4096, 8192),
    rest_angle: PerAxis::new(-40.5 * DEGREE, 0.0),
    envelope: Envelope { pitch: 45.0 * DEGREE, rate: RATE_ENVELOPE },
    motor: None,
    ..AERO
};

/// Every preset with its name.
pub const ALL: [(&str, Rig); 6] = [
    ("paper", PAPER),
    ("paper-fixed", PAPER_FIXED),
    ("aero", AERO),
    ("aero2", AERO2),
    ("aero-lab", AERO_LAB),
    ("heli", HELI),
];

impl Rig {
    /// Every number within the range that rigs have ([`plausible`]), what belongs together
    /// in accord, and thrust gains that can be inverted.
    ///
    /// # Errors
    /// Names the first field that is not.
    pub fn validate(&self) -> Result<(), Invalid> {
        self.plant.validate()?;
        plausible::check(plausible::RIG, self)?;
        self.supply.validate()?;
        let within = self.nominal_volts <= self.volts_limit.main.max(self.volts_limit.tail);
        require("nominal_volts", self.nominal_volts, within, "at most volts_limit of a motor")?;
        let rest = self.rest_angle.pitch;
        require(
            "rest_angle.pitch",
            rest,
            rest.abs() <= self.envelope.pitch,
            "within ±envelope.pitch, in rad",
        )?;
        self.plant.effectiveness_at(self.nominal_volts).validate_inverse()
    }
}

impl Supply {
    fn validate(&self) -> Result<(), Invalid> {
        positive("supply.lowest", self.lowest)?;
        let Self { nominal, lowest, highest } = *self;
        require("supply.nominal", nominal, lowest <= nominal, "at least supply.lowest")?;
        let above = highest.is_finite() && nominal <= highest && lowest < highest;
        require("supply.highest", highest, above, "above supply.lowest and at least supply.nominal")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_valid() {
        for (name, rig) in ALL {
            assert_eq!(rig.validate(), Ok(()), "{name}");
        }
    }

    /// Every rig flies from its nominal supply, whatever its motors may get.
    #[test]
    fn the_range_of_the_supply_holds_the_nominal_one_and_is_checked() {
        for (name, rig) in ALL {
            let Supply { nominal, lowest, highest } = rig.supply;
            assert!(lowest <= nominal && nominal <= highest, "{name}");
            let most = rig.volts_limit.main.max(rig.volts_limit.tail);
            assert!(most <= nominal, "{name}: the supply can give what the motors may get");
        }
        let wrong = |supply| Rig { supply, ..AERO2 }.validate().unwrap_err().field;
        assert_eq!(wrong(Supply { lowest: 0.0, ..SUPPLY }), "supply.lowest");
        assert_eq!(wrong(Supply { nominal: 12.0, ..SUPPLY }), "supply.nominal");
        assert_eq!(wrong(Supply { highest: 20.0, ..SUPPLY }), "supply.highest");
    }

    #[test]
    fn a_rig_with_parallel_rotors_is_refused() {
        let mut rig = PAPER;
        rig.plant.effectiveness = Effectiveness {
            main_on_pitch: 0.001,
            tail_on_pitch: 0.002,
            main_on_yaw: 0.002,
            tail_on_yaw: 0.004,
        };
        assert_eq!(rig.validate().unwrap_err().field, "effectiveness (determinant)");
    }

    /// The hold voltages at 15 degrees that follow from eqs (28)-(29), and the sections of the literature
    /// they come from: .081 and .840 V with Table 3, 5.53 and 6.79 V with the manufacturer's gains.
    #[test]
    fn hold_volts_at_15_degrees() {
        for (rig, main, tail) in [(PAPER, 0.081, 0.840), (PAPER_FIXED, 5.53, 6.79)] {
            let weight = 1.075 * 9.8 * 0.002 * libm::cos(15.0 * DEGREE);
            let k = rig.plant.effectiveness;
            let allocator = crate::allocation::Allocator::new(k, rig.volts_limit);
            let volts = allocator.demand(PerAxis::new(weight, 0.0));
            assert!((volts.main - main).abs() < 0.005 && (volts.tail - tail).abs() < 0.005, "{volts:?}");
        }
    }
}
