//! The plant near a pose that it holds, as a linear system.

use serde::Serialize;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::plant::{PlantParameters, RigidBody, State};
use twinrotor::static_reach::hold_volts;

/// A matrix's rows.
pub type Rows = Vec<Vec<f64>>;

/// What a row or a column of the matrices stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Signal {
    /// Its name, as the columns of `simulate --csv` are called where it is one of them.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
}

const fn signal(name: &'static str, unit: &'static str) -> Signal {
    Signal { name, unit }
}

/// θ, ψ, θ̇, ψ̇.
const BODY: [Signal; 4] =
    [signal("theta", "rad"), signal("psi", "rad"), signal("theta_dot", "rad/s"), signal("psi_dot", "rad/s")];
/// The volts in effect of each motor.
const ROTORS: [Signal; 2] = [signal("rotor_main", "V"), signal("rotor_tail", "V")];
/// The volts applied.
const INPUTS: [Signal; 2] = [signal("v_main", "V"), signal("v_tail", "V")];

/// dx/dt = A x + B u, y = C x + D u, of differences from the pose and from the volts that hold it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Linear {
    /// \[rad\] The pitch of the pose; the system is the same at any yaw.
    pub pitch: f64,
    /// \[V\] What holds it.
    pub volts: PerMotor<f64>,
    /// x: θ, ψ, their rates, and the volts in effect of each motor that lags.
    pub states: Vec<Signal>,
    /// u: the volts applied.
    pub inputs: [Signal; 2],
    /// y: θ, ψ.
    pub outputs: [Signal; 2],
    /// States by states.
    #[serde(rename = "A")]
    pub a: Rows,
    /// States by inputs.
    #[serde(rename = "B")]
    pub b: Rows,
    /// Outputs by states.
    #[serde(rename = "C")]
    pub c: Rows,
    /// Outputs by inputs.
    #[serde(rename = "D")]
    pub d: Rows,
}

/// x(k+1) = A x(k) + B u(k), of a [`Linear`] whose volts are held from tick to tick; C and D are the same.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sampled {
    /// \[s\] Of a tick.
    pub sample_time: f64,
    /// States by states.
    #[serde(rename = "A")]
    pub a: Rows,
    /// States by inputs.
    #[serde(rename = "B")]
    pub b: Rows,
}

/// One motor's numbers in what follows: in volts of that motor.
struct Column {
    /// \[N m/V\] On pitch and yaw, of the volts in effect.
    thrust: [f64; 2],
    /// \[N m s/V\] On pitch and yaw, of how fast they change.
    reaction: [f64; 2],
    /// \[s\]
    lag: f64,
}

/// At a pitch where yaw feels `tilt` of what the motors do to it on a level body.
fn columns(plant: &PlantParameters<f64>, volts: PerMotor<f64>, tilt: f64) -> [Column; 2] {
    // d/dv (a v + b v|v|) = a + 2 b |v|.
    let slope = |v: f64| plant.effectiveness.zip(plant.quadratic_effectiveness, |a, b| a + 2.0 * b * v.abs());
    let (main, tail) = (slope(volts.main), slope(volts.tail));
    let (lag, reaction) = (plant.rotor_time_constant, plant.rotor_reaction);
    [
        Column {
            thrust: [main.main_on_pitch, tilt * main.main_on_yaw],
            reaction: [0.0, tilt * reaction.main],
            lag: lag.main,
        },
        Column {
            thrust: [tail.tail_on_pitch, tilt * tail.tail_on_yaw],
            reaction: [reaction.tail, 0.0],
            lag: lag.tail,
        },
    ]
}

fn zeros(rows: usize, columns: usize) -> Rows {
    vec![vec![0.0; columns]; rows]
}

impl Linear {
    /// Eqs (1)-(2) with lag, reaction and gyroscopic torque of the rotors, near rest at `pitch` \[rad\],
    /// within ±π/2. Coulomb friction, which has no slope, is left out.
    pub fn of(plant: &PlantParameters<f64>, pitch: f64) -> Self {
        let volts = hold_volts(plant, pitch);
        let moment = plant.mass * plant.center_of_mass;
        let inertia = RigidBody::new(plant).at(&State::at_rest(PerAxis::new(pitch, 0.0))).inertia;
        let inertia = [inertia.pitch, inertia.yaw];
        let damping = [plant.damping.pitch, plant.damping.yaw];
        let motors = columns(plant, volts, 1.0 + plant.tilting_thrust * (pitch.cos() - 1.0));
        let lagging = motors.iter().zip(ROTORS).filter(|(motor, _)| motor.lag > 0.0);
        let states: Vec<Signal> = BODY.into_iter().chain(lagging.map(|(_, rotor)| rotor)).collect();
        let (mut a, mut b) = (zeros(states.len(), states.len()), zeros(states.len(), 2));
        // At rest, with the torque in balance, yaw feels nothing of pitch.
        a[2][0] = (moment * plant.gravity * pitch.sin() - plant.stiffness * pitch.cos()) / inertia[0];
        for axis in 0..2 {
            a[axis][2 + axis] = 1.0;
            a[2 + axis][2 + axis] = -damping[axis] / inertia[axis];
        }
        let gyroscopic = plant.rotor_momentum * volts.main * pitch.sin();
        a[2][3] -= gyroscopic / inertia[0];
        a[3][2] += gyroscopic / inertia[1];
        let mut state = BODY.len();
        for (input, motor) in motors.iter().enumerate() {
            let lags = motor.lag > 0.0;
            for axis in 0..2 {
                let thrust = motor.thrust[axis] / inertia[axis];
                if lags {
                    let reaction = motor.reaction[axis] / motor.lag / inertia[axis];
                    a[2 + axis][state] = thrust - reaction;
                    b[2 + axis][input] = reaction;
                } else {
                    b[2 + axis][input] = thrust;
                }
            }
            if lags {
                a[state][state] = -1.0 / motor.lag;
                b[state][input] = 1.0 / motor.lag;
                state += 1;
            }
        }
        let mut c = zeros(2, states.len());
        (c[0][0], c[1][1]) = (1.0, 1.0);
        let outputs = [BODY[0], BODY[1]];
        Self { pitch, volts, states, inputs: INPUTS, outputs, a, b, c, d: zeros(2, 2) }
    }

    /// The same from tick to tick of `sample_time` \[s\], above zero, the volts held in between: exactly,
    /// by exp of the matrix with A and B above zeros.
    pub fn sampled(&self, sample_time: f64) -> Sampled {
        let (states, all) = (self.states.len(), self.states.len() + self.inputs.len());
        let mut whole = zeros(all, all);
        for (row, (a, b)) in whole.iter_mut().zip(self.a.iter().zip(&self.b)) {
            let cells = a.iter().chain(b).map(|x| x * sample_time);
            row.iter_mut().zip(cells).for_each(|(cell, x)| *cell = x);
        }
        let held = exponential(&whole);
        let a = held.iter().take(states).map(|row| row[..states].to_vec()).collect();
        let b = held.iter().take(states).map(|row| row[states..].to_vec()).collect();
        Sampled { sample_time, a, b }
    }
}

fn product(left: &Rows, right: &Rows) -> Rows {
    let cell = |row: &[f64], k: usize| row.iter().zip(right).map(|(x, r)| x * r[k]).sum();
    left.iter().map(|row| (0..right[0].len()).map(|k| cell(row, k)).collect()).collect()
}

/// exp of a square matrix: its series, of what is halved until it is small, squared as often.
fn exponential(matrix: &Rows) -> Rows {
    /// Terms after which a matrix of norm 1/2 adds nothing to a double.
    const TERMS: u32 = 18;
    let norm = matrix.iter().map(|row| row.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max);
    let mut halvings = 0;
    while norm * 0.5_f64.powi(halvings) > 0.5 && halvings < 1000 {
        halvings += 1;
    }
    let small: Rows =
        matrix.iter().map(|row| row.iter().map(|x| x * 0.5_f64.powi(halvings)).collect()).collect();
    let mut term = zeros(matrix.len(), matrix.len());
    (0..matrix.len()).for_each(|k| term[k][k] = 1.0);
    let mut sum = term.clone();
    for k in 1..=TERMS {
        term = product(&term, &small);
        for (sum, term) in sum.iter_mut().flatten().zip(term.iter_mut().flatten()) {
            *term /= f64::from(k);
            *sum += *term;
        }
    }
    (0..halvings).fold(sum, |power, _| product(&power, &power))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::SAMPLE_TIME;
    use twinrotor::plant::RealPlant;
    use twinrotor::plant::presets::{AERO2, PAPER};

    /// What a small push changes of a flight of the plant itself is what the matrices say.
    #[test]
    fn the_sampled_matrices_fly_as_the_plant_does() {
        for rig in [PAPER, AERO2] {
            let plant = PlantParameters { coulomb_friction: PerAxis::zero(), ..rig.plant };
            let linear = Linear::of(&plant, 0.0);
            let sampled = linear.sampled(SAMPLE_TIME);
            let push = PerMotor::new(0.02, -0.01);
            let start = || RealPlant::<f64>::new(&plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
            let (mut held, mut pushed) = (start(), start());
            let mut x = vec![0.0; linear.states.len()];
            for _ in 0..500 {
                held.advance(linear.volts, PerMotor::zero());
                pushed.advance(linear.volts.plus(push), PerMotor::zero());
                let row = |a: &[f64], b: &[f64]| {
                    a.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>() + b[0] * push.main + b[1] * push.tail
                };
                x = sampled.a.iter().zip(&sampled.b).map(|(a, b)| row(a, b)).collect();
            }
            let (held, pushed) = (held.state(), pushed.state());
            let (angle, rate) = (pushed.angle.minus(held.angle), pushed.rate.minus(held.rate));
            for ((x, there), signal) in
                x.iter().zip([angle.pitch, angle.yaw, rate.pitch, rate.yaw]).zip(&linear.states)
            {
                assert!((x - there).abs() < 0.01 * there.abs(), "{signal:?}: {x} {there}");
            }
        }
    }

    /// Against the closed form: a lag of τ decays by exp(-T/τ) in T and takes up the rest, whatever T is.
    #[test]
    fn a_lag_sampled_is_its_exponential() {
        let linear = Linear::of(&PAPER.plant, 0.0);
        let lag = PAPER.plant.rotor_time_constant.main;
        for time in [0.001, 0.05, 2.0] {
            let sampled = linear.sampled(time);
            let decay = (-time / lag).exp();
            assert!(
                (sampled.a[4][4] - decay).abs() < 1e-12 && (sampled.b[4][0] - (1.0 - decay)).abs() < 1e-12
            );
        }
    }
}
