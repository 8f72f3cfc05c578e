//! The tick of the board, as a list of verbs; the arithmetic is in the steps it calls.

mod commands;
mod exchange;
mod status;
mod trying;

pub use exchange::{Inputs, OperatorCommand, Outputs};
pub use status::Status;

use crate::approach::Approach;
use crate::axes::{PerAxis, PerMotor};
use crate::drive::Drive;
use crate::encoder::{CounterWidth, Encoder};
use crate::estimator::{Belief, Estimate};
use crate::first_power::{FirstPowerCheck, Verdict};
use crate::monitor::{Monitor, Observation, Seen};
use crate::parameters::Parameters;
use crate::pipeline::{Decision, Pipeline};
use crate::plant::State;
use crate::real::Real;
use crate::reference::Reference;
use crate::sequence::Sequence;
use crate::supervisor::{ArmState, Condition, Conditions, Request, Supervisor};
use crate::telemetry::{Frame, Kept, Taken, TrialPhase};
use crate::trial::{Accepted, NOTE_EVERY, Trial};
use core::hint::cold_path;

/// Counters in, duties out, once a tick.
///
/// In this order: what the tick always looks at lies within the 1,020 bytes that a floating-point load of a
/// Cortex-M4 reaches from one register; what the monitor looks at every fourth tick, and the trial, which is
/// seldom there, behind it.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct ControlLoop {
    tick: u32,
    encoders: PerAxis<Encoder>,
    /// \[ticks\] Since an encoder last moved.
    still: u32,
    supervisor: Supervisor,
    decision: Decision<f32>,
    supply: f32,
    /// \[V\] What the last tick's duties give. They are latched at the next tick, so they act one tick late.
    latched: PerMotor<f32>,
    taken: Taken,
    kept: Kept,
    zeroed: bool,
    checked: bool,
    verdict: Option<Verdict>,
    drive: Drive<f32>,
    /// \[V\] What the drive counts on at least.
    supply_low: f32,
    approach: Approach,
    accepted: Accepted,
    monitor: Monitor,
    rest_counts: PerAxis<i32>,
    check: FirstPowerCheck,
    /// Number of the message that asked for the accepted controller, unless it is the record's.
    accepted_by: Option<Sequence>,
    trial: Option<Trial>,
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
            accepted_by: None,
            monitor: Monitor::new(parameters),
            supervisor: Supervisor::new(reset_cause),
            check: FirstPowerCheck::new(parameters.limits.check),
            verdict: None,
            approach: Approach::new(parameters),
            drive,
            supply_low: parameters.limits.supply_low,
            decision: Decision::idle(Estimate::default(), PerAxis::zero()),
            supply: 0.0,
            latched: PerMotor::zero(),
            taken: Taken::default(),
        }
    }

    /// Other parameters from now on, with the motors off: all starts afresh but the count of ticks.
    pub fn adopt(&mut self, parameters: &Parameters) {
        let width = self.encoders.pitch.width();
        let counters = self.encoders.map(|encoder| encoder.reading());
        let new = Self::new(parameters, width, counters, self.drive, None);
        *self = Self { tick: self.tick, taken: self.taken, ..new };
    }

    /// In a simulation that begins with warm motors: see [`Pipeline::warm`].
    pub fn warm(&mut self, share: f32) {
        self.accepted.pipeline.warm(share);
    }

    /// Whether the motors may turn, since the last tick.
    pub fn state(&self) -> ArmState {
        self.supervisor.state()
    }

    /// What was wrong in the last tick.
    #[inline(always)]
    pub fn conditions(&self) -> Conditions {
        self.supervisor.present()
    }

    /// Whether state or conditions are others than before the last tick.
    #[inline(always)]
    pub fn has_changed(&self) -> bool {
        self.supervisor.has_changed()
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
        Frame {
            tick: self.tick.wrapping_sub(1),
            state: self.state(),
            conditions: self.conditions(),
            angle: decision.estimate.state.angle,
            rate: decision.estimate.state.rate,
            disturbance: decision.estimate.disturbance,
            reference: decision.reference,
            demand: decision.allocation.demand,
            unallocated_torque: self.unallocated_torque(),
            volts: self.latched,
            supply: self.supply,
            taken: self.taken,
            controller: self.in_force(),
        }
    }

    /// \[N m\] What the limits left over of what the law asked for.
    fn unallocated_torque(&self) -> PerAxis<f32> {
        let allocation = &self.decision.allocation;
        if self.is_armed() && allocation.volts != allocation.demand {
            self.accepted.pipeline.unallocated_torque(allocation)
        } else {
            PerAxis::zero()
        }
    }

    /// One tick.
    #[inline]
    pub fn tick(&mut self, inputs: &Inputs<'_>) -> Outputs {
        let command = self.take(inputs);
        let (measured, moved) = self.read_encoders(inputs.counters);
        let belief = self.accepted.pipeline.believe(measured, self.latched);
        let State { mut angle, mut rate } = belief.estimate.state;
        let mut tried = None;
        if let Some(trial) = &mut self.trial {
            cold_path();
            let belief = trial.believe(measured, self.latched);
            if trial.phase() == TrialPhase::Flying {
                State { angle, rate } = belief.estimate.state;
            }
            tried = Some(belief);
        }
        let found = self.find_conditions(inputs, angle, rate, moved);
        let changes = self.supervise(found, inputs.disarm, command, measured);
        let reference = self.follow(command);
        if changes {
            cold_path();
            self.decide_afresh(reference, measured);
        } else {
            self.decide(belief, reference, measured, Pipeline::decide);
        }
        if let (Some(belief), true) = (tried, self.is_armed()) {
            cold_path();
            let Reference { angle, rate, accel } = reference;
            self.go_on_trying(belief, &Reference { angle, rate, accel }, command);
        }
        if let Some(candidate) = inputs.trial {
            cold_path();
            self.begin_trying(candidate, inputs.command, measured);
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

    fn find_conditions(
        &mut self,
        inputs: &Inputs<'_>,
        angle: PerAxis<f32>,
        rate: PerAxis<f32>,
        moved: PerAxis<i32>,
    ) -> Conditions {
        let observed = Observation {
            seen: Seen {
                tick: self.tick,
                armed: self.is_armed(),
                moved,
                angle,
                rate,
                wanted: self.decision.reference,
                applied: self.latched,
                demand: self.decision.allocation.demand,
            },
            supply: inputs.supply,
            supply_before: self.supply,
            current_limit: inputs.current_limit,
            zeroed: self.zeroed,
            motors_may_turn: self.state().motors_may_turn(),
            heard: inputs.heard,
        };
        let found = self.monitor.check(&observed, || self.approach.has_landed());
        // A jump means lost counts: where zero was is no longer known.
        if found.contains(Condition::PitchJump) || found.contains(Condition::YawJump) {
            cold_path();
            self.zeroed = false;
        }
        found
            .union(inputs.senses)
            .with(Condition::NotZeroed, !self.zeroed)
            .with(Condition::NotChecked, !self.checked)
    }

    /// Moves the supervisor with what was `found`, if that or the operator may move it. At a change of state
    /// the estimator starts afresh, which this tells; at arming so do reference and monitor.
    #[inline(always)]
    fn supervise(
        &mut self,
        found: Conditions,
        disarm: bool,
        command: Option<&OperatorCommand>,
        measured: PerAxis<f32>,
    ) -> bool {
        let request = match command {
            _ if self.verdict.is_some() || disarm => Some(Request::Disarm),
            Some(OperatorCommand::Request(request)) => Some(*request),
            _ => None,
        };
        if request.is_none() && self.supervisor.is_settled(found) {
            return false;
        }
        cold_path();
        self.change_state(found, request, measured)
    }

    #[inline(never)]
    fn change_state(&mut self, found: Conditions, request: Option<Request>, measured: PerAxis<f32>) -> bool {
        let before = self.supervisor.state();
        self.verdict = None;
        if !self.supervisor.step(found, request) {
            return false;
        }
        self.accepted.pipeline.restart(measured);
        self.accepted.worst = PerAxis::zero();
        self.trial = None;
        match self.supervisor.state() {
            ArmState::Armed => {
                self.monitor.restart(measured.pitch);
                self.approach.begin(measured);
            }
            ArmState::Checking => {
                self.monitor.restart(measured.pitch);
                self.check.restart();
            }
            _ if before == ArmState::Armed => {
                self.monitor.end_flight();
                self.approach.level();
            }
            _ => {}
        }
        true
    }

    #[inline(always)]
    fn follow(&mut self, command: Option<&OperatorCommand>) -> Reference<f32> {
        if let Some(command) = command {
            cold_path();
            self.follow_command(command);
        }
        if self.is_armed() {
            if self.monitor.has_just_lost_link() {
                cold_path();
                self.approach.lose_link();
                if let Some(trial) = &mut self.trial {
                    trial.take_back();
                }
            }
            if !self.approach.rests() {
                cold_path();
                // In parts: a whole one would have its place in memory, and every tick would go by it.
                let Reference { angle, rate, accel } = self.approach.step();
                return Reference { angle, rate, accel };
            }
        }
        self.approach.idle()
    }

    /// What the motors are to do after a change of state, with which the estimator has started afresh.
    #[inline(never)]
    fn decide_afresh(&mut self, reference: Reference<f32>, measured: PerAxis<f32>) {
        let belief = self.accepted.pipeline.believe_once(measured, self.latched);
        self.decide(belief, reference, measured, Pipeline::decide_once);
    }

    /// What the motors are to do: what the `law` says when armed, what the check says when checking, else
    /// nothing.
    #[inline(always)]
    fn decide(
        &mut self,
        belief: Belief<f32>,
        reference: Reference<f32>,
        measured: PerAxis<f32>,
        law: impl FnOnce(&mut Pipeline<f32>, Belief<f32>, &Reference<f32>) -> Decision<f32>,
    ) {
        if self.is_armed() {
            self.decision = law(&mut self.accepted.pipeline, belief, &reference);
            // During a trial, errors are not its own alone.
            if self.tick.is_multiple_of(NOTE_EVERY) && self.trial.is_none() {
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
