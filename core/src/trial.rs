//! Another controller, tried in flight: first as a shadow of the accepted one, then with a growing share of
//! the volts, then alone, until it is accepted or the accepted one takes over again.
//!
//! The candidate computes from the same measurements and the volts that really act, so what it believes has
//! settled before it is listened to, and no law's integrators have to be known to change without a bump: the
//! volts of both are within their limits, and so is every mixture. What the two have in common, settings and
//! all, the candidate takes over as it stands; a controller that is its own trial gives the same bits.
//!
//! The trial is over, by the same mixture back, when it is not accepted in time, is taken back, or tracks
//! worse than [`ERROR_FACTOR`] times the accepted one's recent worst; at once when it makes something that is
//! not finite, and when the motors go off for whatever reason.

use crate::axes::{PerAxis, PerMotor};
use crate::control_loop::OperatorCommand;
use crate::controller::ControllerSettings;
use crate::estimator::Belief;
use crate::parameters::Parameters;
use crate::pipeline::{Decision, Pipeline, Settings};
use crate::real::Real;
use crate::reference::Reference;
use crate::sequence::{Numbered, Sequence};
use crate::telemetry::TrialPhase;
use crate::validate::{Invalid, require};
use serde::{Deserialize, Serialize};

/// \[ticks\] For which a candidate is a shadow.
pub const SHADOW_TICKS: u32 = 300;
/// How many times the accepted controller's recent worst error ends a trial.
pub const ERROR_FACTOR: f32 = 2.0;
/// \[rad\] The least error that does: one degree.
pub const LEAST_ERROR: f32 = core::f32::consts::PI / 180.0;
/// \[ticks\] From one look at the accepted controller's error to the next: a rig needs many to move, and a
/// tick's time is dear.
pub(crate) const NOTE_EVERY: u32 = 4;
/// What is kept of the recent worst error from one look to the next: it fades with a time constant of 32.8 s.
const KEEP: f32 = 1.0 - 1.0 / 8_192.0;

/// \[ms\] From none of the volts to all of them, unless the operator says otherwise.
pub const FADE_MS: u32 = 100;
/// \[ms\] That a candidate flies alone without being accepted, unless the operator says otherwise.
pub const REVERT_MS: u32 = 30_000;

/// What an operator wants tried: a controller on the rig of the parameters in force, whose model, limits and
/// encoders stay.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Attempt {
    /// Law, gains, filter, estimator and allocation.
    pub controller: ControllerSettings<f32>,
    /// \[ms\] From none of the volts to all of them, 1 to 10,000.
    pub fade_ms: u32,
    /// \[ms\] That it flies alone without being accepted, 1 to 600,000.
    pub revert_ms: u32,
}

impl Attempt {
    /// With the usual times.
    #[must_use]
    pub const fn new(controller: ControllerSettings<f32>) -> Self {
        Self { controller, fade_ms: FADE_MS, revert_ms: REVERT_MS }
    }

    /// Every value in its range.
    ///
    /// # Errors
    /// Names the first value that is not.
    pub fn validate(&self) -> Result<(), Invalid<f32>> {
        #[expect(clippy::cast_precision_loss, reason = "exact where it is allowed")]
        let time = |field, time: u32, most, allowed| {
            require(field, time as f32, (1..=most).contains(&time), allowed)
        };
        time("trial.fade_ms", self.fade_ms, 10_000, "1 to 10000 ms")?;
        time("trial.revert_ms", self.revert_ms, 600_000, "1 to 600000 ms")?;
        // Zero, or a NaN.
        let mut sum = 0.0;
        let _ = self.controller.map(|number| sum += 0.0 * number);
        require("trial.controller", sum, sum.is_finite(), "finite numbers")?;
        self.controller.validate()
    }
}

/// A controller to be tried, made ready outside the tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    sequence: Sequence,
    controller: ControllerSettings<f32>,
    pipeline: Pipeline<f32>,
    /// \[ticks\] From none of the volts to all of them.
    fade: u32,
    /// \[ticks\] That it flies alone without being accepted.
    revert: u32,
}

impl Candidate {
    /// What is to be tried, on the rig of `parameters`; `sequence` is the number of the message that asks for
    /// it.
    ///
    /// # Errors
    /// Names the first value out of its range.
    pub fn new(parameters: &Parameters, attempt: &Attempt, sequence: Sequence) -> Result<Self, Invalid<f32>> {
        attempt.validate()?;
        // A tick is a millisecond.
        let Attempt { controller, fade_ms: fade, revert_ms: revert } = *attempt;
        let settings = Settings { controller, ..parameters.settings };
        let pipeline = Pipeline::new(&settings, PerAxis::zero());
        Ok(Self { sequence, controller, pipeline, fade, revert })
    }

    /// Number of the message that asked for it.
    #[must_use]
    pub const fn sequence(&self) -> Sequence {
        self.sequence
    }

    /// Whether `command` is to try it.
    #[must_use]
    pub fn is_asked_for_by(&self, command: &Numbered<OperatorCommand>) -> bool {
        command.message == OperatorCommand::Try && command.sequence == self.sequence
    }
}

/// A controller, and what is known of it. In this order: see
/// [`ControlLoop`](crate::control_loop::ControlLoop).
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub(crate) struct Accepted {
    /// \[rad\] Its largest error of late.
    pub(crate) worst: PerAxis<f32>,
    pub(crate) pipeline: Pipeline<f32>,
    pub(crate) controller: ControllerSettings<f32>,
}

impl Accepted {
    /// Takes the error of a tick.
    #[inline(always)]
    pub(crate) fn note(&mut self, decision: &Decision<f32>) {
        self.worst = error(decision).zip(self.worst, |now, worst| Real::max(now, KEEP * worst));
    }
}

/// \[rad\] Of both axes, as the law sees it.
#[inline(always)]
fn error(decision: &Decision<f32>) -> PerAxis<f32> {
    decision.reference.minus(decision.estimate.state.angle).map(f32::abs)
}

/// A trial under way. The phase comes first: by it every tick knows whether there is one.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub(crate) struct Trial {
    phase: TrialPhase,
    /// \[ticks\] In this phase.
    ticks: u32,
    /// \[ticks\] Of `candidate.fade`: its share in the volts.
    share: u32,
    /// \[rad\] The error that ends it.
    bound: PerAxis<f32>,
    candidate: Candidate,
}

impl Trial {
    /// Begins at `place` beside `accepted`, at the end of a tick, where the rig is at `angle` \[rad\].
    pub(crate) fn begin(
        place: &mut Option<Self>,
        candidate: &Candidate,
        accepted: &Accepted,
        angle: PerAxis<f32>,
    ) {
        let bound = accepted.worst.map(|worst| Real::max(LEAST_ERROR, ERROR_FACTOR * worst));
        // Made where it stays: it is large, and a tick's time is dear.
        *place = Some(Self { candidate: *candidate, phase: TrialPhase::Shadow, ticks: 0, share: 0, bound });
        if let Some(Self { candidate, .. }) = place {
            candidate.pipeline.restart(angle);
            candidate.pipeline.inherit(&accepted.pipeline, &candidate.controller, &accepted.controller);
        }
    }

    pub(crate) const fn phase(&self) -> TrialPhase {
        self.phase
    }

    /// \[%\] The candidate's share in the volts.
    pub(crate) fn percent(&self) -> u8 {
        let percent = self.share.saturating_mul(100).checked_div(self.candidate.fade);
        percent.and_then(|percent| u8::try_from(percent).ok()).unwrap_or(100)
    }

    /// What the candidate believes.
    #[inline(never)]
    pub(crate) fn believe(&mut self, measured: PerAxis<f32>, applied: PerMotor<f32>) -> Belief<f32> {
        self.candidate.pipeline.believe_once(measured, applied)
    }

    /// What the motors are to do, of what the accepted controller says (`own`) and what the candidate says
    /// from its `belief`. None ends the trial at once: what the candidate says is not finite.
    #[inline(never)]
    pub(crate) fn decide(
        &mut self,
        own: &Decision<f32>,
        belief: Belief<f32>,
        setpoint: &Reference<f32>,
    ) -> Option<Decision<f32>> {
        let new = self.candidate.pipeline.decide_once(belief, setpoint);
        let found = error(&new);
        if new.allocation.fault() || !(found.pitch + found.yaw).is_finite() {
            return None;
        }
        self.advance(found);
        Some(match self.phase {
            TrialPhase::None | TrialPhase::Shadow => *own,
            TrialPhase::Flying => new,
            TrialPhase::FadingIn | TrialPhase::FadingOut => {
                #[expect(clippy::cast_precision_loss, reason = "at most 10,000")]
                let share = self.share as f32 / self.candidate.fade as f32;
                let mix = |old: PerMotor<f32>, new| old.zip(new, |old, new| mixture(old, new, share));
                let mut mixed = *own;
                mixed.allocation.volts = mix(own.allocation.volts, new.allocation.volts);
                mixed.allocation.demand = mix(own.allocation.demand, new.allocation.demand);
                mixed
            }
        })
    }

    /// A tick further.
    fn advance(&mut self, found: PerAxis<f32>) {
        self.ticks = self.ticks.saturating_add(1);
        match self.phase {
            TrialPhase::None => {}
            TrialPhase::Shadow => {
                if self.ticks == SHADOW_TICKS {
                    self.enter(TrialPhase::FadingIn);
                }
            }
            TrialPhase::FadingIn | TrialPhase::Flying
                if found.pitch > self.bound.pitch || found.yaw > self.bound.yaw =>
            {
                self.enter(TrialPhase::FadingOut);
            }
            TrialPhase::FadingIn => {
                self.share = self.share.saturating_add(1);
                if self.share == self.candidate.fade {
                    self.enter(TrialPhase::Flying);
                }
            }
            TrialPhase::Flying if self.ticks == self.candidate.revert => self.enter(TrialPhase::FadingOut),
            TrialPhase::Flying => {}
            TrialPhase::FadingOut => self.share = self.share.saturating_sub(1),
        }
    }

    fn enter(&mut self, phase: TrialPhase) {
        self.phase = phase;
        self.ticks = 0;
    }

    /// Back to the accepted controller.
    pub(crate) fn take_back(&mut self) {
        if self.phase != TrialPhase::FadingOut {
            self.enter(TrialPhase::FadingOut);
        }
    }

    /// Nothing of the candidate is left in the volts, and nothing will be.
    pub(crate) fn is_over(&self) -> bool {
        self.phase == TrialPhase::FadingOut && self.share == 0
    }

    /// Makes the candidate the `accepted` one, if it flies alone; gives the number of the message that asked
    /// for it.
    pub(crate) fn accept(&self, accepted: &mut Accepted) -> Option<Sequence> {
        if self.phase != TrialPhase::Flying {
            return None;
        }
        accepted.pipeline = self.candidate.pipeline;
        accepted.controller = self.candidate.controller;
        accepted.worst = self.bound.scaled(1.0 / ERROR_FACTOR);
        Some(self.candidate.sequence)
    }
}

/// `share` of the way from `old` to `new`; where they are the same, exactly that.
fn mixture(old: f32, new: f32, share: f32) -> f32 {
    if old.to_bits() == new.to_bits() { old } else { old + share * (new - old) }
}
