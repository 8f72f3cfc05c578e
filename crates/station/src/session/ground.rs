//! The steps of a session with the motors off.

use super::{Ending, Event, Phase, Session, Wish, Write};
use crate::client::Question;
use crate::differences::differences;
use crate::words;
use std::time::Duration;
use twinrotor::axes::PerAxis;
use twinrotor::bench::Injection;
use twinrotor::board::Board;
use twinrotor::control_loop::OperatorCommand;
use twinrotor::first_power::{REST_TICKS, SETTLE_TICKS, Verdict};
use twinrotor::link::{self, Identity, Refusal, ToBoard};
use twinrotor::parameters::{Parameters, Provenance};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::rig_port::RigPort;
use twinrotor::supervisor::{ArmState, Condition, Conditions, Request};
use twinrotor::telemetry::Frame;

/// How long a command may take to come to bear.
const PROMPT: Duration = Duration::from_secs(3);
/// From one `Zero` or `ClearFault` to the next: not taken while the rig moves, or the cause is just passing.
const AGAIN: Duration = Duration::from_millis(500);
/// How long the rig may take to come to rest.
const REST: Duration = Duration::from_millis(SETTLE_TICKS as u64);
/// What does not keep a board from being prepared: it is dealt with step by step.
const DEALT_WITH: Conditions =
    Conditions::of(&[Condition::NotZeroed, Condition::NotChecked, Condition::ParametersMissing]);

impl Session {
    /// Why nobody was heard, where that is known better than by the time that has passed.
    pub(super) fn unheard(&self) -> Option<String> {
        if self.identity.is_some() {
            return None;
        }
        if self.echo.is_one() {
            return Some(
                "the port hands back what is sent to it: no board is there, or its receiving and \
                         sending lines are joined"
                    .to_owned(),
            );
        }
        if self.frame.is_some() {
            let why = "the board speaks and does not answer: is the line on which it listens connected?";
            return Some(why.to_owned());
        }
        (self.bytes > 0).then(|| {
            format!(
                "the port gave {} bytes that are no messages, and no answer: is this its port, does the \
                 board run this firmware, at {} baud?",
                self.bytes,
                link::BAUD
            )
        })
    }

    pub(super) fn found(&mut self, identity: Identity) {
        if !matches!(self.phase, Phase::Finding) {
            return;
        }
        self.step(
            "found",
            format!(
                "{} with firmware {}, link version {}{}",
                identity.chip,
                identity.firmware,
                link::VERSION,
                if identity.port == RigPort::Simulated { "; it simulates its rig" } else { "" }
            ),
        );
        if let Some(report) = &identity.reset {
            self.step("reset", words::reset(report));
        }
        let provenance = match identity.provenance {
            Provenance::Stored => None,
            Provenance::Missing => Some("no parameters are stored: those built in are in force".to_owned()),
            Provenance::OtherVersion { found } => {
                Some(format!("the stored parameters are of version {found}: those built in are in force"))
            }
            Provenance::Damaged => {
                Some("the stored parameters are damaged: those built in are in force".to_owned())
            }
        };
        if let Some(told) = provenance {
            self.step("flash", told);
        }
        let expected = self.plan.board;
        if let Some(board) = Board::with_chip(&identity.chip)
            && board.pwm_steps() != expected.pwm_steps()
        {
            return self.trouble(format!(
                "the board is a {}, and a {} is expected: {} and {} steps of the PWM",
                board.name,
                expected.name,
                board.pwm_steps(),
                expected.pwm_steps()
            ));
        }
        // What the wiring's check found at another kind of rig counts for nothing here.
        self.plan.parameters = self.plan.parameters.at_port(identity.port);
        let simulates = identity.port == RigPort::Simulated;
        self.identity = Some(identity);
        self.heard = self.clock.now();
        if !simulates && !self.plan.injections.is_empty() {
            return self.trouble(words::refusal(&Refusal::NotSimulated));
        }
        self.client.send(&ToBoard::Telemetry { every: self.plan.frame_every });
        self.phase = Phase::Looking;
    }

    /// Looks at a frame on the ground.
    pub(super) fn look_on_the_ground(&mut self, frame: &Frame) {
        match &mut self.phase {
            Phase::Looking => self.is_it_free(frame),
            Phase::Clearing { .. } if !matches!(frame.state, ArmState::Fault(_)) => {
                self.step("cleared", "the fault is cleared");
                self.read();
            }
            Phase::Checking { begun, over } => match frame.state {
                ArmState::Checking => *begun = true,
                ArmState::Fault(cause) if *begun => {
                    self.end(Ending::Stopped(format!(
                        "a fault stopped the first-power check: {}",
                        words::condition(cause)
                    )));
                }
                _ if *begun && over.is_none() => *over = Some(self.clock.now() + PROMPT),
                _ => {}
            },
            Phase::Zeroing { first, .. } => {
                // Any of them: when word of one comes late, the next is on its way already.
                let taken = !first.is_newer_than(frame.taken.sequence);
                if taken && !frame.conditions.contains(Condition::NotZeroed) && self.lies_at_rest(frame) {
                    self.step("zeroed", "where the rig lies is its rest pose");
                    self.phase = Phase::Waiting { until: self.clock.now() + PROMPT };
                }
            }
            Phase::Waiting { .. } if frame.state == ArmState::Ready => {
                if self.plan.ask && !self.asked_to_arm {
                    self.ask(Wish::Arm);
                } else {
                    self.arm();
                }
            }
            _ => {}
        }
    }

    fn is_it_free(&mut self, frame: &Frame) {
        match frame.state {
            ArmState::Armed | ArmState::Checking => {
                self.trouble("another program is flying this board: end that first");
            }
            ArmState::Fault(cause) => {
                self.step("fault", words::condition(cause));
                self.lay_down();
                self.command(OperatorCommand::Request(Request::ClearFault));
                let now = self.clock.now();
                self.phase = Phase::Clearing { again: now + AGAIN, until: now + PROMPT };
            }
            ArmState::Disarmed | ArmState::Ready => {
                self.lay_down();
                self.read();
            }
        }
    }

    /// A rig that the board simulates is laid down in its rest pose, sound: from there its flight can be
    /// computed once more.
    fn lay_down(&mut self) {
        if self.identity.as_ref().is_some_and(|identity| identity.port == RigPort::Simulated) {
            self.command(OperatorCommand::Inject(Injection::Rest));
        }
    }

    fn read(&mut self) {
        self.client.ask(Question::Read, self.clock.now());
        self.phase = Phase::Reading;
    }

    /// The parameters that are in force, whether they were read or written.
    pub(super) fn has(&mut self, kept: &Parameters) {
        let now = self.clock.now();
        self.heard = now;
        match self.phase {
            Phase::Reading => {
                let built_in = |identity: &Identity| identity.provenance != Provenance::Stored;
                let different = differences(&self.plan.parameters, kept);
                let not_stored = self.identity.as_ref().is_some_and(built_in);
                // What the board knows of its wiring stays so.
                self.plan.parameters.checked = kept.checked && !not_stored;
                if different.is_empty() && !not_stored {
                    self.step("compared", "the board has what is asked for");
                    self.phase = Phase::Settling { until: now + PROMPT };
                    return;
                }
                self.events.push_back(Event::Differs(different));
                match self.plan.write {
                    Write::Always => self.write(),
                    Write::Ask => self.ask(Wish::Write),
                    Write::Never => {
                        self.trouble("the board does not have the parameters that are asked for");
                    }
                }
            }
            Phase::Writing => {
                self.step("written", "the parameters read back the same, bit for bit");
                self.phase = Phase::Settling { until: now + PROMPT };
            }
            Phase::Saving => {
                let wanted = self.tried.map(|(_, attempt)| attempt.controller);
                let saved = wanted == Some(kept.settings.controller);
                let ending = if saved {
                    self.step("saved", "the board boots with the accepted controller from now on");
                    Ending::Flown
                } else {
                    Ending::Trouble("the board saved another controller than was accepted".to_owned())
                };
                self.end(ending);
            }
            _ => {}
        }
    }

    fn write(&mut self) {
        self.may_write = true;
        self.client.ask(Question::Write(Box::new(self.plan.parameters)), self.clock.now());
        self.phase = Phase::Writing;
    }

    fn ask(&mut self, wish: Wish) {
        self.events.push_back(Event::Asks(wish.clone()));
        self.phase = Phase::Asking(wish);
    }

    pub(super) fn granted(&mut self, wish: &Wish) {
        match wish {
            Wish::Write => self.write(),
            Wish::Check => self.check(),
            Wish::Rest => self.zero(),
            Wish::Arm => {
                self.asked_to_arm = true;
                self.phase = Phase::Waiting { until: self.clock.now() + PROMPT };
            }
        }
    }

    fn check(&mut self) {
        self.step("checking", "first-power check: each motor in turn pushes the rig a little");
        self.command(OperatorCommand::Request(Request::Check));
        self.phase = Phase::Checking { begun: false, over: None };
    }

    pub(super) fn checked(&mut self, verdict: Verdict) {
        if !matches!(self.phase, Phase::Checking { .. }) {
            return;
        }
        if verdict != Verdict::Passed {
            return self.trouble(format!("first-power check: {}", words::verdict(&verdict)));
        }
        self.step("checked", words::verdict(&verdict));
        // Kept, so that it need not be done at each boot, once the motors are off.
        self.passed = self.may_write;
        self.phase = Phase::Settling { until: self.clock.now() + PROMPT };
    }

    fn zero(&mut self) {
        let now = self.clock.now();
        self.lay_down();
        let first = self.command(OperatorCommand::Zero);
        self.phase = Phase::Zeroing { first, again: now + AGAIN, until: now + REST };
    }

    /// Its encoders show the rest pose, to a count.
    fn lies_at_rest(&self, frame: &Frame) -> bool {
        let rest = self.plan.parameters.encoders.map(|e| (e.angle_per_count, f32::from_i32(e.rest_counts)));
        let off = frame.angle.zip(rest, |angle, (count, counts)| (angle - count * counts).abs() / count);
        off.pitch < 1.5 && off.yaw < 1.5
    }

    fn arm(&mut self) {
        self.step("arming", "the motors turn from now on");
        self.command(OperatorCommand::Setpoint(Reference::at_rest(PerAxis::zero())));
        self.command(OperatorCommand::Request(Request::Arm));
        self.phase = Phase::Arming { until: self.clock.now() + PROMPT };
    }

    /// What the time that has passed has to say on the ground.
    pub(super) fn go_on_on_the_ground(&mut self, now: Duration) {
        let Some(frame) = self.frame else { return };
        let wrong = || words::conditions(frame.conditions);
        match &mut self.phase {
            Phase::Clearing { until, .. } if now >= *until => {
                let cause = words::conditions(frame.conditions.intersection(Conditions::HAZARDS));
                self.trouble(format!("the fault cannot be cleared while {cause}"));
            }
            Phase::Clearing { again, .. } if now >= *again => {
                *again += AGAIN;
                self.command(OperatorCommand::Request(Request::ClearFault));
            }
            Phase::Settling { until } => {
                let until = *until;
                self.prepare(&frame, now >= until);
            }
            Phase::Zeroing { until, .. } if now >= *until => {
                self.trouble(format!("the rig did not come to rest within {} s", REST.as_secs()));
            }
            Phase::Zeroing { again, .. } if now >= *again => {
                *again += AGAIN;
                self.command(OperatorCommand::Zero);
            }
            // It is over, and its verdict was lost on the line.
            Phase::Checking { over: Some(until), .. } if now >= *until => {
                if frame.conditions.contains(Condition::NotChecked) {
                    self.trouble("the board did not say what its first-power check found");
                } else {
                    self.checked(Verdict::Passed);
                }
            }
            Phase::Waiting { until } | Phase::Arming { until } if now >= *until => {
                self.trouble(format!("the board cannot be armed: {}", wrong()));
            }
            Phase::Checking { begun: false, .. } if frame.conditions.contains(Condition::EmergencyStop) => {
                self.trouble(format!("the first-power check does not begin: {}", wrong()));
            }
            _ => {}
        }
    }

    /// What is next once the parameters are as they should be. What is wrong may pass by itself within a
    /// moment of booting or writing, until `late`.
    fn prepare(&mut self, frame: &Frame, late: bool) {
        let stands = frame.conditions.iter().filter(|condition| !DEALT_WITH.contains(*condition));
        let stands = stands.fold(Conditions::NONE, |all, condition| all.with(condition, true));
        if !stands.is_empty() {
            if late {
                self.trouble(format!("the board cannot be armed: {}", words::conditions(stands)));
            }
            return;
        }
        if frame.conditions.contains(Condition::ParametersMissing) && !late || frame.state.motors_may_turn() {
            return;
        }
        if std::mem::take(&mut self.passed) {
            self.plan.parameters.checked = true;
            return self.write();
        }
        if frame.conditions.contains(Condition::NotChecked) {
            if self.plan.ask { self.ask(Wish::Check) } else { self.check() }
        } else if self.plan.ask {
            self.ask(Wish::Rest);
        } else {
            self.step("resting", format!("zero is where the rig lies still for {} ms", REST_TICKS));
            self.zero();
        }
    }
}
