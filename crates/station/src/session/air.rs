//! The steps of a session with the motors on.

use super::{Begin, Course, Ending, Event, Leg, Phase, Session};
use crate::words;
use std::time::Duration;
use twinrotor::axes::PerAxis;
use twinrotor::control_loop::OperatorCommand;
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::supervisor::ArmState;
use twinrotor::telemetry::{Frame, Kept, TrialPhase};

/// \[rad\], \[rad/s\] What counts as level and at rest.
const LEVEL: (f32, f32) = (0.02, 0.05);
/// \[ticks\] For how long it must be.
const STEADY: u32 = 1_000;
/// \[ticks\] After which a leg begins although it is not.
const LONGEST_RISE: u32 = 20_000;

/// Why a leg begins although the rig has not been still at level.
fn swinging((angle, rate): (f32, f32)) -> String {
    format!(
        "in {} s no second within {:.1}° of level and {:.1}°/s, as estimated; last {:.1}° and {:.1}°/s: the \
         loop swings; the flight begins so",
        LONGEST_RISE / 1_000,
        LEVEL.0.to_degrees(),
        LEVEL.1.to_degrees(),
        angle.to_degrees(),
        rate.to_degrees()
    )
}

/// How long a controller may take to come into force: its shadow, and the longest fading.
const CHANGE: Duration = Duration::from_secs(12);

/// On the way to level, before a leg.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leave {
    /// The leg.
    pub(super) leg: usize,
    /// The tick in which it began.
    from: u32,
    /// The last tick in which it was not level, and how far off it was there \[rad\], \[rad/s\].
    unsteady: u32,
    off: (f32, f32),
}

impl Leave {
    const fn new(leg: usize, tick: u32) -> Self {
        Self { leg, from: tick, unsteady: tick, off: (0.0, 0.0) }
    }
}

impl Session {
    /// Looks at a frame: is the board still as it should be, and what does that change?
    pub(super) fn look(&mut self, frame: &Frame) {
        self.look_on_the_ground(frame);
        match &self.phase {
            Phase::Arming { .. } => match frame.state {
                ArmState::Armed => {
                    self.step("armed", "up to level");
                    self.phase = Phase::Rising(Leave::new(0, frame.tick));
                }
                ArmState::Fault(cause) => self.stopped(cause),
                _ => {}
            },
            Phase::Rising(_) | Phase::Flying { .. } | Phase::Changing { .. } | Phase::Descending { .. } => {
                match frame.state {
                    ArmState::Armed => self.look_in_the_air(frame),
                    ArmState::Fault(cause) => self.stopped(cause),
                    _ => self.end(Ending::Stopped("somebody else has disarmed the board".to_owned())),
                }
            }
            _ => {}
        }
    }

    fn stopped(&mut self, cause: twinrotor::supervisor::Condition) {
        self.end(Ending::Stopped(format!("a fault stopped the flight: {}", words::condition(cause))));
    }

    fn look_in_the_air(&mut self, frame: &Frame) {
        match &mut self.phase {
            Phase::Rising(leave) => {
                let size = |x: PerAxis<f32>| x.pitch.abs().max(x.yaw.abs());
                let off = (size(frame.angle), size(frame.rate));
                // Not by what is no number either.
                if !(off.0 < LEVEL.0 && off.1 < LEVEL.1) {
                    (leave.unsteady, leave.off) = (frame.tick, off);
                }
            }
            Phase::Flying { leg, begin, .. } => {
                if let Begin::Said(sequence, _) = *begin
                    && !sequence.is_newer_than(frame.taken.sequence)
                    && frame.taken.ago < u8::MAX
                {
                    let leg = *leg;
                    let tick = frame.tick.wrapping_sub(frame.taken.ago.into());
                    *begin = Begin::In(tick);
                    self.events.push_back(Event::Begins { leg, tick });
                }
                if frame.controller.trial == TrialPhase::FadingOut {
                    self.taken_back();
                }
            }
            Phase::Changing { leg, begun, .. } => {
                let leg = *leg;
                *begun |= frame.controller.trial != TrialPhase::None;
                let (trial, begun) = (frame.controller.trial, *begun);
                match self.plan.legs.get(leg) {
                    Some(Leg::Try(_)) if trial == TrialPhase::Flying => {
                        self.step("tried", "the other controller flies alone");
                        self.phase = Phase::Rising(Leave::new(leg + 1, frame.tick));
                    }
                    Some(Leg::Try(_)) if trial == TrialPhase::FadingOut => {
                        self.taken_back();
                        self.land(frame.tick, PerAxis::zero());
                    }
                    Some(Leg::Accept) if begun && trial == TrialPhase::None => {
                        self.accepted = frame.controller.accepted == Kept::Unsaved;
                        self.step("accepted", "the other controller is in force until the power goes");
                        self.phase = Phase::Rising(Leave::new(leg + 1, frame.tick));
                    }
                    Some(Leg::Revert) if trial == TrialPhase::None => {
                        self.step("reverted", "the accepted controller flies again");
                        self.phase = Phase::Rising(Leave::new(leg + 1, frame.tick));
                    }
                    _ => {}
                }
            }
            _ => {}
        }
    }

    /// The board has ended a trial by itself. Told once.
    fn taken_back(&mut self) {
        if self.flaw.is_none() {
            let why = "the board has taken the trial back: its errors were beyond twice those before";
            self.step("taken back", why);
            self.flaw = Some(why.to_owned());
        }
    }

    /// What is due in the air by the last frame.
    pub(super) fn go_on_in_the_air(&mut self, now: Duration) {
        let Some(Frame { tick, .. }) = self.frame else { return };
        match &mut self.phase {
            Phase::Rising(leave) => {
                let leave = *leave;
                let level = tick.wrapping_sub(leave.unsteady) >= STEADY;
                if level || tick.wrapping_sub(leave.from) >= LONGEST_RISE {
                    if !level {
                        self.step("unsteady", swinging(leave.off));
                    }
                    self.begin(leave.leg, tick, now);
                }
            }
            Phase::Flying { course, begin, leg } => {
                let leg = *leg;
                let (Begin::Said(_, from) | Begin::In(from)) = *begin;
                // What is said now is taken in the next tick at the earliest.
                let due = course.due(tick.wrapping_add(1).wrapping_sub(from));
                let begun = matches!(begin, Begin::In(_));
                let over = begun && tick.wrapping_sub(from) >= course.ticks();
                if let Some(setpoint) = due {
                    self.command(OperatorCommand::Setpoint(setpoint));
                }
                if begun {
                    self.let_befall(tick.wrapping_sub(from));
                }
                if over {
                    self.land_or_go_on(leg, tick);
                }
            }
            Phase::Changing { until, .. } if now >= *until => {
                self.flaw = Some("the board does not change its controller".to_owned());
                self.land(tick, PerAxis::zero());
            }
            Phase::Descending { course, from } => {
                let gone = tick.wrapping_sub(*from);
                let (due, over) = (course.due(gone), gone >= course.ticks());
                if let Some(setpoint) = due {
                    self.command(OperatorCommand::Setpoint(setpoint));
                }
                if over {
                    self.step("down", "at the rest pose");
                    self.end(self.flaw.clone().map_or(Ending::Flown, Ending::Trouble));
                }
            }
            _ => {}
        }
    }

    /// What is to befall the rig by that tick of the flight.
    fn let_befall(&mut self, tick: u32) {
        while let Some((at, injection)) = self.plan.injections.first().copied()
            && at <= tick
        {
            self.plan.injections.remove(0);
            self.step("injected", words::injection(&injection));
            self.command(OperatorCommand::Inject(injection));
        }
    }

    fn begin(&mut self, leg: usize, tick: u32, now: Duration) {
        let changing = Phase::Changing { leg, begun: false, until: now + CHANGE };
        match self.plan.legs.get(leg) {
            Some(Leg::Try(attempt)) => {
                let attempt = **attempt;
                self.step("trying", "the other controller computes beside, then its volts fade in");
                self.attempt(attempt);
                self.phase = changing;
            }
            Some(Leg::Accept | Leg::Revert) if self.flaw.is_some() => self.land(tick, PerAxis::zero()),
            Some(Leg::Accept) => {
                self.command(OperatorCommand::Accept);
                // A trial is under way: that it ends is what is waited for.
                self.phase = Phase::Changing { leg, begun: true, until: now + CHANGE };
            }
            Some(Leg::Revert) => {
                self.command(OperatorCommand::Revert);
                self.phase = changing;
            }
            Some(Leg::Fly(references)) => {
                let mut course = Course::new(references.clone());
                let first = course.due(0).unwrap_or_else(|| Reference::at_rest(PerAxis::zero()));
                let seconds = f64::from(course.ticks()) * twinrotor::SAMPLE_TIME;
                self.step("flying", format!("{seconds:.1} s"));
                let sequence = self.command(OperatorCommand::Setpoint(first));
                let begin = Begin::Said(sequence, tick.wrapping_add(1));
                self.phase = Phase::Flying { leg, course, begin };
            }
            None => self.land(tick, PerAxis::zero()),
        }
    }

    fn land_or_go_on(&mut self, leg: usize, tick: u32) {
        let Phase::Flying { course, .. } = &self.phase else { return };
        let end = course.end();
        if leg + 1 < self.plan.legs.len() {
            self.command(OperatorCommand::Setpoint(Reference::at_rest(PerAxis::zero())));
            self.phase = Phase::Rising(Leave::new(leg + 1, tick));
        } else {
            self.land(tick, end);
        }
    }

    /// Down to the rest pose from `from` \[rad\], at the rate at which a board approaches a setpoint.
    fn land(&mut self, tick: u32, from: PerAxis<f32>) {
        self.step("landing", "down to the rest pose");
        let parameters = &self.plan.parameters;
        let pitch = parameters.encoders.pitch;
        let rest = PerAxis { pitch: f32::from_i32(pitch.rest_counts) * pitch.angle_per_count, ..from };
        let settings = &parameters.settings;
        let course = Course::ramp(from, rest, parameters.limits.approach_rate, settings.sample_time);
        self.phase = Phase::Descending { course, from: tick };
    }
}
