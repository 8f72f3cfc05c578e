//! The tick of the board, as a list of verbs; the arithmetic is in the steps it calls.

use crate::approach::Approach;
use crate::axes::{PerAxis, PerMotor};
use crate::drive::{Drive, Duty};
use crate::encoder::{CounterWidth, Encoder};
use crate::estimator::{Belief, Estimate};
use crate::first_power::{FirstPowerCheck, REST_TICKS, Verdict};
use crate::monitor::{Monitor, Observation};
use crate::parameters::Parameters;
use crate::pipeline::{Decision, Pipeline};
use crate::real::Real;
use crate::reference::Reference;
use crate::sequence::{Numbered, Sequence};
use crate::supervisor::{ArmState, Condition, Conditions, Request, Supervisor};
use crate::telemetry::{Frame, InForce, Kept, Taken, TrialPhase};
use crate::trial::{Accepted, Candidate, Trial};
use serde::{Deserialize, Serialize};

/// Counters in, duties out, once a tick.
#[derive(Debug, Clone, Copy)]
pub struct ControlLoop {
    tick: u32,
    rest_counts: PerAxis<i32>,
    encoders: PerAxis<Encoder>,
    /// \[ticks\] Since an encoder last moved.
    still: u32,
    zeroed: bool,
    checked: bool,
    accepted: Accepted,
    trial: Option<Trial>,
    kept: Kept,
    monitor: Monitor,
    supervisor: Supervisor,
    check: FirstPowerCheck,
    verdict: Option<Verdict>,
    approach: Approach,
    drive: Drive<f32>,
    /// \[V\] What the drive counts on at least.
    supply_low: f32,
    conditions: Conditions,
    decision: Decision<f32>,
    supply: f32,
    /// \[V\] What the last tick's duties give. They are latched at the next tick, so they act one tick late.
    latched: PerMotor<f32>,
    /// The last command, and in which tick it came.
    taken: Option<(Sequence, u32)>,
}

/// What the board has read when a tick begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs<'a> {
    /// What each encoder's counter shows.
    pub counters: PerAxis<u32>,
    /// \[V\] Supply of the amplifiers.
    pub supply: f32,
    /// The amplifier says that it limits the current.
    pub current_limit: bool,
    /// What else is wrong, as only the board can see.
    pub senses: Conditions,
    /// A message came since the last tick.
    pub heard: bool,
    /// The operator wants the motors off. Goes before `command`, which is forgotten.
    pub disarm: bool,
    /// A controller to be tried, while armed and while none is.
    pub trial: Option<&'a Candidate>,
    /// What else the operator wants, if anything new.
    pub command: Option<&'a Numbered<OperatorCommand>>,
}

/// What the operator may want of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum OperatorCommand {
    /// To arm, to disarm, to clear a fault, to check the wiring.
    Request(Request),
    /// To be there, and to move on at that rate and acceleration until the next setpoint.
    Setpoint(Reference<f32>),
    /// To take where the rig lies now, motors off and still, for its rest pose.
    Zero,
    /// To keep the controller that is being tried, once it flies alone.
    Accept,
    /// To go back to the accepted controller.
    Revert,
}

/// What the board is to do when a tick ends.
#[derive(Debug, Clone, Copy)]
pub struct Outputs {
    /// To be latched by the PWM at the next tick.
    pub duty: PerMotor<Duty<f32>>,
    /// The core's yes to turning motors: without it, the amplifiers are switched off.
    pub enable: bool,
    /// What the first-power check found, in the tick it ends.
    pub verdict: Option<Verdict>,
}

impl ControlLoop {
    /// Disarmed, or with the last reset's cause latched; no zero yet. `counters` is what the encoders,
    /// `width` wide, show now.
    pub fn new(
        parameters: &Parameters,
        width: CounterWidth,
        counters: PerAxis<u32>,
        drive: Drive<f32>,
        reset_cause: Option<Condition>,
    ) -> Self {
        let encoders = counters.zip(parameters.encoders, |counter, scale| {
            Encoder::new(width, scale.angle_per_count, counter, scale.rest_counts)
        });
        Self {
            tick: 0,
            rest_counts: parameters.encoders.map(|scale| scale.rest_counts),
            encoders,
            still: 0,
            zeroed: false,
            checked: parameters.checked,
            accepted: Accepted {
                pipeline: Pipeline::new(&parameters.settings, encoders.map(|e| e.angle())),
                controller: parameters.settings.controller,
                worst: PerAxis::zero(),
            },
            trial: None,
            kept: Kept::Stored,
            monitor: Monitor::new(parameters),
            supervisor: Supervisor::new(reset_cause),
            check: FirstPowerCheck::new(parameters.limits.check),
            verdict: None,
            approach: Approach::new(parameters),
            drive,
            supply_low: parameters.limits.supply_low,
            conditions: Conditions::NONE,
            decision: Decision::idle(Estimate::default(), PerAxis::zero()),
            supply: 0.0,
            latched: PerMotor::zero(),
            taken: None,
        }
    }

    /// Other parameters from now on, with the motors off: all starts afresh but the count of ticks.
    pub fn adopt(&mut self, parameters: &Parameters) {
        let width = self.encoders.pitch.width();
        let counters = self.encoders.map(|encoder| encoder.reading());
        let new = Self::new(parameters, width, counters, self.drive, None);
        *self = Self { tick: self.tick, taken: self.taken, ..new };
    }

    /// Whether the motors may turn, since the last tick.
    pub fn state(&self) -> ArmState {
        self.supervisor.state()
    }

    /// What was wrong in the last tick.
    #[inline(always)]
    pub fn conditions(&self) -> Conditions {
        self.conditions
    }

    fn is_armed(&self) -> bool {
        matches!(self.supervisor.state(), ArmState::Armed)
    }

    /// How the last tick came to its duties.
    pub fn decision(&self) -> &Decision<f32> {
        &self.decision
    }

    /// Which tick comes next, counted from boot.
    pub fn next_tick(&self) -> u32 {
        self.tick
    }

    /// The last tick, for telemetry.
    #[inline(always)]
    pub fn frame(&self) -> Frame {
        let decision = &self.decision;
        let tick = self.tick.wrapping_sub(1);
        Frame {
            tick,
            state: self.state(),
            conditions: self.conditions,
            angle: decision.estimate.state.angle,
            rate: decision.estimate.state.rate,
            disturbance: decision.estimate.disturbance,
            reference: decision.reference,
            demand: decision.allocation.demand,
            unallocated_torque: self.unallocated_torque(),
            volts: self.latched,
            supply: self.supply,
            taken: self.taken.map_or(Taken::default(), |(sequence, at)| Taken {
                sequence,
                ago: u8::try_from(tick.wrapping_sub(at)).unwrap_or(u8::MAX),
            }),
            controller: self.in_force(),
        }
    }

    /// Which controller decides, for telemetry.
    fn in_force(&self) -> InForce {
        let (trial, blend) = self.trial.as_ref().map_or((TrialPhase::None, 0), |t| (t.phase(), t.percent()));
        InForce { accepted: self.kept, trial, blend }
    }

    /// A trial's part of the tick.
    #[inline(never)]
    fn go_on_trying(
        &mut self,
        belief: Belief<f32>,
        reference: &Reference<f32>,
        command: Option<&OperatorCommand>,
    ) {
        let Some(trial) = &mut self.trial else { return };
        if command == Some(&OperatorCommand::Revert) {
            trial.take_back();
        }
        let decision = trial.decide(&self.decision, belief, reference);
        let over = decision.is_none() || trial.is_over();
        if let Some(decision) = decision {
            self.decision = decision;
        }
        if over {
            self.trial = None;
        } else if command == Some(&OperatorCommand::Accept)
            && let Some((accepted, _)) = trial.accept()
        {
            self.accepted = accepted;
            self.kept = Kept::Unsaved;
            self.trial = None;
        }
    }

    /// \[N m\] What the limits left over of what the law asked for.
    fn unallocated_torque(&self) -> PerAxis<f32> {
        if self.is_armed() {
            self.accepted.pipeline.unallocated_torque(&self.decision.allocation)
        } else {
            PerAxis::zero()
        }
    }

    /// One tick.
    #[inline(never)]
    pub fn tick(&mut self, inputs: &Inputs<'_>) -> Outputs {
        let command = self.take(inputs);
        let (measured, moved) = self.read_encoders(inputs.counters);
        let mut belief = self.accepted.pipeline.believe(measured, self.latched);
        let tried = self.trial.as_mut().map(|trial| trial.believe(measured, self.latched));
        let flies = self.trial.as_ref().is_some_and(|trial| trial.phase() == TrialPhase::Flying);
        let leading = tried.filter(|_| flies).unwrap_or(belief);
        self.find_conditions(inputs, &leading.estimate, moved);
        if self.supervise(inputs.disarm, command, measured) {
            belief = self.accepted.pipeline.believe_once(measured, self.latched);
        }
        let reference = self.follow(command);
        self.decide(belief, reference, measured);
        if let (Some(belief), true) = (tried, self.is_armed()) {
            self.go_on_trying(belief, &reference, command);
        }
        if let (Some(candidate), None, true) = (inputs.trial, &self.trial, self.is_armed()) {
            self.trial = Some(Trial::begin(candidate, &self.accepted, measured));
        }
        self.supply = inputs.supply;
        // Never below what is allowed: a supply read too low would give the motors more than they should
        // have. In this order, a NaN stays one.
        let supply = Real::max(self.supply_low, inputs.supply);
        let duty = self.drive.duty(self.decision.allocation.volts, supply);
        self.latched = self.drive.volts(duty, supply);
        self.tick = self.tick.wrapping_add(1);
        Outputs { duty, enable: self.state().motors_may_turn(), verdict: self.verdict }
    }

    /// The command that counts in this tick: none where the operator disarms.
    #[inline(always)]
    fn take<'a>(&mut self, inputs: &Inputs<'a>) -> Option<&'a OperatorCommand> {
        let Numbered { sequence, message } = inputs.command.filter(|_| !inputs.disarm)?;
        self.taken = Some((*sequence, self.tick));
        Some(message)
    }

    fn read_encoders(&mut self, counters: PerAxis<u32>) -> (PerAxis<f32>, PerAxis<i32>) {
        let before = self.encoders.map(|e| e.position());
        let measured = PerAxis {
            pitch: self.encoders.pitch.read(counters.pitch),
            yaw: self.encoders.yaw.read(counters.yaw),
        };
        let moved = self.encoders.zip(before, |e, before| e.position().wrapping_sub(before));
        let lies = moved == PerAxis::both(0);
        self.still = if lies { self.still.saturating_add(1) } else { 0 };
        (measured, moved)
    }

    fn find_conditions(&mut self, inputs: &Inputs<'_>, estimate: &Estimate<f32>, moved: PerAxis<i32>) {
        let found = self.monitor.check(&Observation {
            moved,
            estimate,
            wanted: self.decision.reference,
            applied: self.latched,
            supply: inputs.supply,
            supply_before: self.supply,
            current_limit: inputs.current_limit,
            demand: self.decision.allocation.demand,
            zeroed: self.zeroed,
            armed: self.is_armed(),
            motors_may_turn: self.state().motors_may_turn(),
            landed: self.approach.has_landed(),
            heard: inputs.heard,
        });
        // A jump means lost counts: where zero was is no longer known.
        self.zeroed &= !(found.contains(Condition::PitchJump) || found.contains(Condition::YawJump));
        self.conditions = found
            .union(inputs.senses)
            .with(Condition::NotZeroed, !self.zeroed)
            .with(Condition::NotChecked, !self.checked);
    }

    /// Moves the supervisor. At a change of state the estimator starts afresh, which this tells; at arming so
    /// do reference and monitor.
    fn supervise(&mut self, disarm: bool, command: Option<&OperatorCommand>, measured: PerAxis<f32>) -> bool {
        let before = self.supervisor.state();
        let request = match (self.verdict.take(), command) {
            (Some(_), _) => Some(Request::Disarm),
            _ if disarm => Some(Request::Disarm),
            (None, Some(OperatorCommand::Request(request))) => Some(*request),
            _ => None,
        };
        if !self.supervisor.step(self.conditions, request) {
            return false;
        }
        self.accepted.pipeline.restart(measured);
        self.accepted.worst = PerAxis::zero();
        self.trial = None;
        match self.supervisor.state() {
            ArmState::Armed => {
                self.monitor.restart();
                self.approach.begin(measured);
            }
            ArmState::Checking => {
                self.monitor.restart();
                self.check.restart();
            }
            _ if before == ArmState::Armed => self.approach.level(),
            _ => {}
        }
        true
    }

    fn follow(&mut self, command: Option<&OperatorCommand>) -> Reference<f32> {
        match command {
            Some(OperatorCommand::Setpoint(setpoint)) => self.approach.aim(*setpoint),
            Some(OperatorCommand::Zero)
                if self.still >= REST_TICKS && !self.supervisor.state().motors_may_turn() =>
            {
                self.zero();
            }
            _ => {}
        }
        if !self.is_armed() {
            return self.approach.idle();
        }
        if self.monitor.has_just_lost_link() {
            self.approach.lose_link();
            if let Some(trial) = &mut self.trial {
                trial.take_back();
            }
        }
        self.approach.step()
    }

    /// Takes where the rig lies for its rest pose.
    fn zero(&mut self) {
        self.encoders.pitch.set_position(self.rest_counts.pitch);
        self.encoders.yaw.set_position(self.rest_counts.yaw);
        self.accepted.pipeline.restart(self.encoders.map(|e| e.angle()));
        self.zeroed = true;
    }

    /// What the motors are to do: what the law says when armed, what the check says when checking, else
    /// nothing.
    fn decide(&mut self, belief: Belief<f32>, reference: Reference<f32>, measured: PerAxis<f32>) {
        if self.is_armed() {
            self.decision = self.accepted.pipeline.decide(belief, &reference);
            // During a trial, errors are not its own alone.
            if self.trial.is_none() {
                self.accepted.note(&self.decision);
            }
            return;
        }
        self.decision = Decision::idle(belief.estimate, reference.angle);
        if self.supervisor.state() == ArmState::Checking {
            let (volts, verdict) = self.check.step(measured, self.still);
            self.decision.allocation.volts = volts;
            self.checked |= verdict == Some(Verdict::Passed);
            self.verdict = verdict;
        }
    }
}

#[cfg(test)]
mod tests;
