//! A helicopter and a controller, tick by tick, in one of two worlds.
//!
//! Both are written over any [`Real`]: `f64` to verify, `f32` as the board computes, lanes of `f32` for
//! thousands of runs. The board's own [`ControlLoop`] flies in [`BoardLoop`]; a test shows that [`RigLoop`]
//! gives its bits.

pub use twinrotor::bench::Hardware;

use crate::fittings::Fittings;
#[cfg(feature = "std")]
use crate::scenario::Now;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{Bench, Encoders, Worn};
use twinrotor::control_loop::{ControlLoop, Inputs, OperatorCommand, Outputs};
use twinrotor::drive::Drive;
use twinrotor::encoder::{CounterWidth, angle_per_count};
use twinrotor::estimator::Estimate;
use twinrotor::first_power::{Push, REST_TICKS};
use twinrotor::monitor::SUPPLY_TICKS;
use twinrotor::parameters::{EncoderScale, Limits, LostLink, Parameters};
use twinrotor::pipeline::{Decision, Pipeline, Settings};
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{IdealPlant, PlantParameters, RealPlant, State};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::rig_port::RigPort;
use twinrotor::sequence::{Numbered, Sequence};
use twinrotor::supervisor::{ArmState, Request};
use twinrotor::trial::Candidate;

/// What happened in one tick.
#[derive(Debug, Clone, Copy)]
pub struct Tick<R: Real> {
    /// Where the helicopter was when the tick began.
    pub state: State<R>,
    /// \[rad\] What was wanted.
    pub setpoint: PerAxis<R>,
    /// What the controller made of it.
    pub decision: Decision<R>,
    /// \[V\] What acted on the rotors from this tick to the next.
    pub applied: PerMotor<R>,
    /// \[counts\] Whole ones that the encoders showed when the tick began; zero in a world without encoders.
    pub counts: PerAxis<R>,
    /// What a logger on the rig would have written.
    pub logged: Logged<R>,
}

/// What is known of a rig without looking into it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Logged<R> {
    /// \[rad\] What the encoders showed when the tick began: whole counts, where the rig has any.
    pub angle: PerAxis<R>,
    /// \[V\] What was sent to the motors for the time from this tick to the next.
    pub volts: PerMotor<R>,
}

impl<R: Real> Tick<R> {
    /// \[rad\] What was wanted minus true angle.
    #[inline(always)]
    pub fn error(&self) -> PerAxis<R> {
        self.setpoint.minus(self.state.angle)
    }
}

/// A closed loop that can be stepped.
pub trait ClosedLoop<R: Real> {
    /// One tick with `disturbance` \[V\] added to the volts in effect.
    fn tick(&mut self, reference: &Reference<R>, disturbance: PerMotor<R>) -> Tick<R>;

    /// What befalls the rig from the next tick on, beside the volts that every tick is told. The paper's
    /// world has neither counts nor a supply.
    #[cfg(feature = "std")]
    fn befall(&mut self, now: &Now);

    /// The plant becomes that of these constants; its pose, its rates and what its rotors do stay.
    fn become_plant(&mut self, parameters: &PlantParameters<R>);

    /// What the supervisor says after the last tick; `None` where none watches.
    fn arm_state(&self) -> Option<ArmState> {
        None
    }
}

/// The paper's world: the state is known, rotors answer at once, volts are held for a tick; nothing is
/// quantised or late.
#[derive(Debug, Clone, Copy)]
pub struct IdealLoop<R> {
    plant: IdealPlant<R>,
    nominal_volts: R,
    pipeline: Pipeline<R>,
}

impl<R: Real> IdealLoop<R> {
    /// `plant` is reduced to what eqs (1)-(2) have, with the thrust slope at `rig`'s nominal volts.
    pub fn new(rig: &Rig, settings: &Settings<R>, start: State<R>, sample_time: f64) -> Self {
        let plant = rig.plant.ideal(rig.nominal_volts);
        Self {
            plant: IdealPlant::new(&plant, start, sample_time),
            nominal_volts: R::from_f64(rig.nominal_volts),
            pipeline: Pipeline::new(&settings.for_ideal_rotors(), start.angle),
        }
    }
}

impl<R: Real> ClosedLoop<R> for IdealLoop<R> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[cfg_attr(debug_assertions, inline(never))]
    fn tick(&mut self, reference: &Reference<R>, disturbance: PerMotor<R>) -> Tick<R> {
        let state = self.plant.state();
        let decision = self.pipeline.act(Estimate::exact(state), reference);
        let applied = decision.allocation.volts;
        self.plant.advance(applied, disturbance);
        let logged = Logged { angle: state.angle, volts: applied };
        let counts = PerAxis::zero();
        Tick { state, setpoint: reference.angle, decision, applied, counts, logged }
    }

    #[cfg(feature = "std")]
    fn befall(&mut self, now: &Now) {
        self.plant.set_load(now.torque.cast());
    }

    fn become_plant(&mut self, parameters: &PlantParameters<R>) {
        self.plant.become_plant(&parameters.ideal(self.nominal_volts));
    }
}

/// The rig's world: encoder counts, estimated rates, rotor lag and whatever else the plant has, PWM steps,
/// and volts that act one tick after they were computed.
#[derive(Debug, Clone, Copy)]
pub struct RigLoop<R> {
    plant: RealPlant<R>,
    encoders: Encoders<R>,
    angle_per_count: PerAxis<R>,
    pipeline: Pipeline<R>,
    drive: Drive<R>,
    /// \[V\] As it should be, and as it is.
    #[cfg_attr(not(feature = "std"), expect(dead_code, reason = "nothing befalls it there"))]
    sound_supply: R,
    supply: R,
    worn: Worn<R>,
    latched: PerMotor<R>,
}

impl<R: Real> RigLoop<R> {
    /// `plant` may differ from what `settings` believe.
    pub fn new(plant: RealPlant<R>, hardware: &Hardware, settings: &Settings<R>) -> Self {
        Self::assemble(plant, hardware, hardware.encoder_phase.cast(), settings)
    }

    /// As [`RigLoop::new`], with an encoder phase [counts, 0..1] that may differ from lane to lane.
    pub fn assemble(
        mut plant: RealPlant<R>,
        hardware: &impl Fittings<R>,
        encoder_phase: PerAxis<R>,
        settings: &Settings<R>,
    ) -> Self {
        let wear = hardware.wear();
        plant.set_cable(&wear.cable);
        let encoders = Encoders::scaled(hardware.counts_per_angle(), encoder_phase);
        let angle_per_count = hardware.angle_per_count();
        let counts = encoders.counts(plant.state().angle);
        let start = counts.zip(angle_per_count, |c, a| c * a);
        let supply = hardware.supply();
        Self {
            worn: Worn::new(&wear, plant.state().angle),
            plant,
            encoders,
            angle_per_count,
            pipeline: Pipeline::new(settings, start),
            drive: Drive::new(hardware.pwm_steps()),
            sound_supply: supply,
            supply,
            latched: PerMotor::zero(),
        }
    }
}

impl<R: Real> RigLoop<R> {
    /// See [`Pipeline::warm`].
    pub fn warm(&mut self, share: R) {
        self.pipeline.warm(share);
    }
}

impl<R: Real> ClosedLoop<R> for RigLoop<R> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[cfg_attr(debug_assertions, inline(never))]
    fn tick(&mut self, reference: &Reference<R>, disturbance: PerMotor<R>) -> Tick<R> {
        let state = self.plant.state();
        let seen = self.worn.seen(state.angle);
        let counts = self.worn.shown(self.encoders.counts(seen));
        let measured = counts.zip(self.angle_per_count, |c, a| c * a);
        let applied = self.latched;
        let decision = self.pipeline.tick(measured, applied, reference);
        let duty = self.drive.duty(decision.allocation.volts, self.supply);
        self.latched = self.drive.volts(duty, self.supply);
        let driven = self.worn.driven(applied);
        self.plant.advance(driven, disturbance);
        let logged = Logged { angle: measured, volts: applied };
        Tick { state, setpoint: reference.angle, decision, applied: driven, counts, logged }
    }

    #[cfg(feature = "std")]
    fn befall(&mut self, now: &Now) {
        self.plant.set_load(now.torque.cast());
        self.worn.set_noise(now.noise.cast());
        self.worn.set_jitter(now.jitter);
        self.supply = now.supply(self.sound_supply);
    }

    fn become_plant(&mut self, parameters: &PlantParameters<R>) {
        self.plant.become_plant(parameters);
    }
}

/// What a board that is zeroed where `bench` is takes its counts for.
fn encoder_scale(hardware: &Hardware, bench: &Bench<f32>) -> PerAxis<EncoderScale> {
    hardware.believed_counts.zip(bench.position(), |counts_per_turn, rest_counts| EncoderScale {
        angle_per_count: angle_per_count(counts_per_turn),
        rest_counts,
    })
}

/// \[ticks\] That a [`ReadyBoard`] lies still before its operator asks for anything.
const STILL: u32 = if REST_TICKS > SUPPLY_TICKS { REST_TICKS } else { SUPPLY_TICKS };
/// Which tick of a [`ReadyBoard`], counted from its boot, arms it: one takes the zero, one finds that nothing
/// prevents arming, one takes the setpoint.
pub(crate) const ARMS: u32 = STILL + 3;

/// What a [`ReadyBoard`] allows of a flight: an envelope as wide as it goes, any silence of the line, and a
/// reference that jumps to its setpoint.
pub(crate) fn limits(supply: f32) -> Limits {
    Limits {
        pitch: core::f32::consts::FRAC_PI_2,
        rate: PerAxis::both(1e3),
        supply_low: 0.5 * supply,
        supply_high: 2.0 * supply,
        command_timeout: 60_000,
        lost_link: LostLink::Off,
        approach_rate: 1e9,
        check: PerMotor::both(Push::default()),
    }
}

/// The control loop that the firmware runs, ready to be armed where the rig is.
#[derive(Debug, Clone, Copy)]
pub struct ReadyBoard(ControlLoop);

impl ReadyBoard {
    /// For encoders that show `counters` \[counts\] and a supply \[V\]: zeroed there, and to be armed by the
    /// first tick. Its envelope is as wide as it goes, and its reference jumps to the first setpoint instead
    /// of approaching it.
    pub fn new(hardware: &Hardware, settings: &Settings<f32>, bench: &Bench<f32>) -> Self {
        let parameters = Parameters {
            settings: *settings,
            encoders: encoder_scale(hardware, bench),
            limits: limits(bench.supply),
            checked: true,
            port: RigPort::Pwm,
        };
        let drive = Drive::new(hardware.pwm_steps);
        let (counters, supply) = (bench.counters(), bench.supply);
        let mut board = Self(ControlLoop::new(&parameters, CounterWidth::Bits16, counters, drive, None));
        for _ in 0..STILL {
            board.step(counters, supply, None);
        }
        board.step(counters, supply, Some(OperatorCommand::Zero));
        board.step(counters, supply, None);
        board
    }

    /// The tick that the firmware does; the first one arms.
    pub fn tick(&mut self, counters: PerAxis<u32>, supply: f32, reference: &Reference<f32>) -> Outputs {
        let mut setpoint = Some(OperatorCommand::Setpoint(*reference));
        if self.0.state() == ArmState::Ready {
            self.step(counters, supply, setpoint.take());
            setpoint = Some(OperatorCommand::Request(Request::Arm));
        }
        self.step(counters, supply, setpoint)
    }

    /// A tick in which the operator asks for something else than a setpoint, such as a controller to be
    /// tried.
    pub fn tick_with(
        &mut self,
        counters: PerAxis<u32>,
        supply: f32,
        command: &Numbered<OperatorCommand>,
        trial: Option<&Candidate>,
    ) -> Outputs {
        self.0.tick(&Inputs { command: Some(command), trial, ..Inputs::sound(counters, supply) })
    }

    /// What flies.
    pub fn control(&self) -> &ControlLoop {
        &self.0
    }

    /// (Where everything is inlined it would be there five times.)
    #[cfg_attr(target_arch = "nvptx64", inline(never))]
    fn step(&mut self, counters: PerAxis<u32>, supply: f32, command: Option<OperatorCommand>) -> Outputs {
        self.0.tick(&Inputs {
            command: command.map(|message| Numbered { sequence: Sequence::default(), message }).as_ref(),
            ..Inputs::sound(counters, supply)
        })
    }
}

/// The rig's world with the control loop that the firmware runs, counters that wrap included.
#[derive(Debug, Clone, Copy)]
pub struct BoardLoop {
    /// The rig.
    pub bench: Bench<f32>,
    /// What the board takes the counts for, and where it was switched on.
    scale: PerAxis<EncoderScale>,
    /// \[V\] As it should be.
    #[cfg_attr(not(feature = "std"), expect(dead_code, reason = "nothing befalls it there"))]
    supply: f32,
    /// Its board.
    pub board: ReadyBoard,
}

impl BoardLoop {
    /// As [`RigLoop::new`], with a [`ReadyBoard`].
    pub fn new(plant: RealPlant<f32>, hardware: &Hardware, settings: &Settings<f32>) -> Self {
        let bench = Bench::new(plant, hardware);
        let scale = encoder_scale(hardware, &bench);
        Self { bench, scale, supply: bench.supply, board: ReadyBoard::new(hardware, settings, &bench) }
    }

    /// See [`Pipeline::warm`].
    pub fn warm(&mut self, share: f32) {
        self.board.0.warm(share);
    }

    /// Does the board's supervisor let the law turn the motors? A flight that leaves the envelope ends that
    /// for good.
    pub fn is_armed(&self) -> bool {
        self.board.control().state() == ArmState::Armed
    }
}

impl ClosedLoop<f32> for BoardLoop {
    fn tick(&mut self, reference: &Reference<f32>, disturbance: PerMotor<f32>) -> Tick<f32> {
        let state = self.bench.state();
        let shown = self.bench.shown();
        let counts = self.scale.zip(shown, |at, count| f32::from_i32(at.rest_counts + count));
        let angle = self.scale.zip(counts, |at, count| at.angle_per_count * count);
        let outputs = self.board.tick(self.bench.counters(), self.bench.supply, reference);
        let volts = if outputs.enable { self.bench.latched() } else { PerMotor::zero() };
        self.bench.disturbance = disturbance;
        let applied = self.bench.tick(outputs.duty, outputs.enable);
        let decision = *self.board.control().decision();
        let logged = Logged { angle, volts };
        Tick { state, setpoint: reference.angle, decision, applied, counts, logged }
    }

    #[cfg(feature = "std")]
    fn befall(&mut self, now: &Now) {
        self.bench.set_load(now.torque.cast());
        self.bench.worn.set_noise(now.noise.cast());
        self.bench.worn.set_jitter(now.jitter);
        self.bench.supply = now.supply(self.supply);
    }

    fn become_plant(&mut self, parameters: &PlantParameters<f32>) {
        self.bench.become_plant(parameters);
    }

    fn arm_state(&self) -> Option<ArmState> {
        Some(self.board.control().state())
    }
}
