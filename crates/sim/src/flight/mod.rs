//! One flight, recorded: a rig, a controller, a scenario and a world to fly them in.

mod extent;
mod warm;

pub use extent::Extent;

use crate::closed_loop::{BoardLoop, ClosedLoop, Hardware, IdealLoop, Logged, RigLoop, Tick};
use crate::error::{Error, Outcome};
use crate::metrics::{Metrics, Report};
use crate::scenario::{Now, SAMPLE_TIME, Scenario};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor::supervisor::{ArmState, Condition};

/// Which world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fidelity {
    /// The paper's: true state, no lag, no quantisation, no delay, 1 kHz hold.
    Ideal,
    /// The rig's: encoder counts, estimated rates, rotor lag, one tick of delay, PWM steps.
    Rig,
}

/// Which arithmetic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scalar {
    /// As the board computes.
    F32,
    /// To verify.
    F64,
}

/// What to fly.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    /// The machine as the controller knows it.
    pub rig: &'a Rig,
    /// The machine that is flown: plant, encoders, supply, limits, envelope. `rig`, unless truth and belief
    /// are two.
    pub truth: &'a Rig,
    /// The controller.
    pub settings: &'a Settings<f64>,
    /// What to follow.
    pub scenario: &'a Scenario,
    /// \[rad\] Where to start; at what rates and with what rotors is the scenario's.
    pub initial: PerAxis<f64>,
    /// Which world.
    pub fidelity: Fidelity,
    /// Of the disturbance, the encoders' phase and their noise.
    pub seed: u64,
}

/// One tick of a recording, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// \[s\] tick x sample time.
    pub time: f64,
    /// True angles and rates.
    pub state: State<f64>,
    /// \[rad\] What was wanted.
    pub reference: PerAxis<f64>,
    /// \[V\] What acted on the rotors.
    pub volts: PerMotor<f64>,
    /// \[V\] What disturbed them.
    pub disturbance: PerMotor<f64>,
    /// \[N m\] What turned the body from outside.
    pub load: PerAxis<f64>,
    /// What a logger on the rig would have written.
    pub logged: Logged<f64>,
}

/// What is read off a row.
pub type Reading = fn(&Row) -> f64;

/// A flight as columns, SI units: those of `simulate --csv`.
pub const COLUMNS: [(&str, Reading); 11] = [
    ("t", |r| (r.time * 1e6).round() / 1e6),
    ("theta", |r| r.state.angle.pitch),
    ("theta_dot", |r| r.state.rate.pitch),
    ("psi", |r| r.state.angle.yaw),
    ("psi_dot", |r| r.state.rate.yaw),
    ("theta_ref", |r| r.reference.pitch),
    ("psi_ref", |r| r.reference.yaw),
    ("v_main", |r| r.volts.main),
    ("v_tail", |r| r.volts.tail),
    ("dist_main", |r| r.disturbance.main),
    ("dist_tail", |r| r.disturbance.tail),
];

/// A flight as a logger on the rig would have written it, SI units: the columns that identification and
/// replay read.
pub const LOG_COLUMNS: [(&str, Reading); 7] = [
    ("t", |r| (r.time * 1e6).round() / 1e6),
    ("pitch", |r| r.logged.angle.pitch),
    ("yaw", |r| r.logged.angle.yaw),
    ("v0", |r| r.logged.volts.main),
    ("v1", |r| r.logged.volts.tail),
    ("ref_pitch", |r| r.reference.pitch),
    ("ref_yaw", |r| r.reference.yaw),
];

/// A flight.
#[derive(Debug, Clone)]
pub struct Flight {
    /// Every tick.
    pub rows: Vec<Row>,
    /// In numbers.
    pub report: Report,
    /// What the board's supervisor made of it, where the board's loop flew.
    pub board: Option<BoardState>,
    /// The first moment outside the rig's envelope.
    pub left_envelope: Option<Moment>,
}

/// A tick of a flight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Moment {
    /// Counted from 0.
    pub tick: u32,
    /// \[s\]
    pub time: f64,
}

impl Moment {
    /// Of a tick, counted from 0.
    pub fn of(tick: u32) -> Self {
        Self { tick, time: f64::from(tick) * SAMPLE_TIME }
    }
}

/// The supervisor's state at the end of a flight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BoardState {
    /// `armed` or `fault`.
    pub state: &'static str,
    /// What the motors were cut for.
    pub condition: Option<Condition>,
    /// When they were.
    #[serde(flatten)]
    pub since: Option<Moment>,
}

impl BoardState {
    const ARMED: Self = Self { state: "armed", condition: None, since: None };

    fn cut(condition: Condition, tick: u32) -> Self {
        Self { state: "fault", condition: Some(condition), since: Some(Moment::of(tick)) }
    }
}

impl Flight {
    /// Why this flight was none, in one line.
    pub fn stopped(&self) -> Option<String> {
        if let Some(BoardState { condition: Some(condition), since: Some(since), .. }) = self.board {
            return Some(format!("the board cut the motors after {:.3} s: {condition:?}", since.time));
        }
        let left = self.left_envelope?;
        Some(format!("the rig left its envelope after {:.3} s", left.time))
    }
}

/// Flies a plan.
///
/// # Errors
///
/// If the loop diverges.
pub fn fly(plan: &Plan<'_>, scalar: Scalar) -> Outcome<Flight> {
    match scalar {
        Scalar::F32 => match plan.fidelity {
            Fidelity::Ideal => record(plan, ideal_loop::<f32>(plan)),
            Fidelity::Rig => record(plan, board_loop(plan)),
        },
        Scalar::F64 => match plan.fidelity {
            Fidelity::Ideal => record(plan, ideal_loop::<f64>(plan)),
            Fidelity::Rig => record(plan, rig_loop::<f64>(plan)),
        },
    }
}

fn start<R: Real>(plan: &Plan<'_>) -> State<R> {
    State { angle: plan.initial.cast(), rate: plan.scenario.start.rate().cast() }
}

fn ideal_loop<R: Real>(plan: &Plan<'_>) -> IdealLoop<R> {
    IdealLoop::new(plan.truth, &plan.settings.map(R::from_f64), start(plan), SAMPLE_TIME)
}

fn real_parts<R: Real>(plan: &Plan<'_>) -> (RealPlant<R>, Hardware, Settings<R>) {
    let mut plant = RealPlant::new(&plan.truth.plant, start(plan), SAMPLE_TIME);
    plant.set_rotors(plan.scenario.start.rotors().cast());
    let phase = plan.scenario.start.encoder_phase;
    let phase = phase.map_or_else(|| encoder_phase(plan.seed), |[pitch, yaw]| PerAxis::new(pitch, yaw));
    let sound = Hardware::of(plan.truth, phase);
    let worn = Hardware { wear: plan.scenario.hardware.wear(), ..sound };
    (plant, worn.taken_for(plan.rig, plan.truth), plan.settings.map(R::from_f64))
}

/// The loop as the board runs it.
pub fn board_loop(plan: &Plan<'_>) -> BoardLoop {
    let (plant, hardware, settings) = real_parts(plan);
    BoardLoop::new(plant, &hardware, &settings)
}

/// The loop as lanes run it.
pub fn rig_loop<R: Real>(plan: &Plan<'_>) -> RigLoop<R> {
    let (plant, hardware, settings) = real_parts(plan);
    RigLoop::new(plant, &hardware, &settings)
}

/// Where between two counts the encoders stand at the start, uniform.
fn encoder_phase(seed: u64) -> PerAxis<f64> {
    // Another stream than the disturbance of the same seed.
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1);
    PerAxis::new(rng.random(), rng.random())
}

fn record<R, L>(plan: &Plan<'_>, mut closed_loop: L) -> Outcome<Flight>
where
    R: Real<Scalar = R> + Into<f64>,
    L: ClosedLoop<R>,
{
    let references = plan.scenario.references::<R>();
    let more_than_volts = plan.scenario.is_more_than_volts();
    let steps = plan.scenario.steps(plan.initial);
    let limit = plan.settings.volts_limit.cast();
    let mut metrics = Metrics::new(plan.scenario.last_tick(), steps, limit);
    let mut rows = Vec::with_capacity(references.len());
    let mut board = closed_loop.arm_state().map(|_| BoardState::ARMED);
    let mut left_envelope = None;
    if plan.scenario.start.hot {
        warm::warm_up(plan, &mut closed_loop)?;
    }
    for (tick, (reference, now)) in (0_u32..).zip(references.iter().zip(plan.scenario.befalls(plan.seed))) {
        if more_than_volts {
            closed_loop.befall(&now);
        }
        if let Some(change) = &now.change {
            closed_loop.become_plant(&change.of(&plan.truth.plant).map(R::from_f64));
        }
        let happened = closed_loop.tick(reference, now.volts.cast());
        let row = row(tick, &happened, &now);
        let PerAxis { pitch, yaw } = row.state.angle;
        if !(pitch.abs() < DIVERGED && yaw.abs() < DIVERGED) {
            return Err(Error::Failed(format!("the loop diverged {:.3} s after the start", row.time)));
        }
        if let (Some(ArmState::Fault(cause)), Some(BoardState { condition: None, .. })) =
            (closed_loop.arm_state(), board)
        {
            board = Some(BoardState::cut(cause, tick));
        }
        if left_envelope.is_none() && !plan.truth.envelope.holds(&row.state) {
            left_envelope = Some(Moment::of(tick));
        }
        metrics.add(tick, &happened);
        rows.push(row);
    }
    Ok(Flight { rows, report: metrics.report(0, SAMPLE_TIME), board, left_envelope })
}

/// \[rad\] An angle beyond which there is nothing left to control: a hundred turns.
const DIVERGED: f64 = 628.0;

fn row<R: Real + Into<f64>>(tick: u32, happened: &Tick<R>, now: &Now) -> Row {
    let axis = |v: PerAxis<R>| v.map(Into::into);
    let motor = |v: PerMotor<R>| v.map(Into::into);
    Row {
        time: f64::from(tick) * SAMPLE_TIME,
        state: State { angle: axis(happened.state.angle), rate: axis(happened.state.rate) },
        reference: axis(happened.setpoint),
        volts: motor(happened.applied),
        disturbance: motor(now.volts.cast::<R>()),
        load: now.torque,
        logged: Logged { angle: axis(happened.logged.angle), volts: motor(happened.logged.volts) },
    }
}

#[cfg(test)]
mod tests;
