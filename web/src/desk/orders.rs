//! What an operator orders: of the board over its link, and of the simulated rig by hand.

use super::bench::Bench;
use super::flying::{Flights, Flying};
use super::tuning::Tuning;
use super::{Desk, controller};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::link::{Nonce, ToBoard};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::supervisor::{ArmState, Condition, Request};
use twinrotor::telemetry::TrialPhase;
use twinrotor::trial::Attempt;
use twinrotor_sim::scenario::{Scenario, Start};
use twinrotor_sim::{Error, Outcome};
use twinrotor_station::client::Question;
use twinrotor_station::words;

/// \[ticks\] From one wish for a zero to the next, and for how long at most: a rig swings for a while.
const ZERO_EVERY: u64 = 1_000;
const LONGEST_REST: u64 = 60_000;
/// \[ticks\] From one word to switch the motors off to the next: a line may lose one.
const CUT_EVERY: u64 = 20;

impl Desk {
    /// The operator wants something of the supervisor.
    pub fn request(&mut self, request: Request) {
        if request == Request::Arm {
            self.client.aim(PerAxis::zero());
        }
        if request == Request::Disarm {
            self.end_flight();
            self.zeroing = None;
            self.cutting = Some(self.ticks + CUT_EVERY);
        }
        self.client.request(request);
    }

    /// May its motors turn, as far as is known?
    #[must_use]
    pub fn motors_may_turn(&self) -> bool {
        self.frame.is_some_and(|frame| frame.state.motors_may_turn())
    }

    /// Motors off, because of `why`, if they may turn and are not being switched off already.
    pub fn cut(&mut self, why: &str) {
        if self.cutting.is_none() && self.motors_may_turn() {
            self.journal.trouble(self.ticks, why);
            self.request(Request::Disarm);
        }
    }

    /// Motors off is said again until it is seen.
    pub(super) fn cut_again(&mut self) {
        match self.cutting {
            Some(_) if !self.motors_may_turn() => self.cutting = None,
            Some(next) if self.ticks >= next => self.request(Request::Disarm),
            _ => {}
        }
    }

    /// To take where the rig lies for its rest pose, as soon as it lies still.
    pub fn zero(&mut self) {
        self.client.send(&ToBoard::Zero);
        self.zeroing = Some((self.ticks, self.ticks + ZERO_EVERY));
    }

    /// A board takes no zero while the rig moves: it is asked again.
    pub(super) fn zero_again(&mut self) {
        let Some((begun, again)) = self.zeroing else { return };
        let wanted = self.frame.is_some_and(|frame| frame.conditions.contains(Condition::NotZeroed));
        match self.ticks - begun {
            waited if wanted && waited >= LONGEST_REST => {
                self.zeroing = None;
                self.journal.trouble(self.ticks, "not zeroed: the rig does not come to rest");
            }
            _ if wanted && self.ticks >= again => {
                self.client.send(&ToBoard::Zero);
                self.zeroing = Some((begun, again + ZERO_EVERY));
            }
            waited if !wanted && waited >= ZERO_EVERY => self.zeroing = None,
            _ => {}
        }
    }

    /// To be there \[rad\]. Ends a scenario.
    pub fn aim(&mut self, angle: PerAxis<f32>) {
        self.end_flight();
        self.client.aim(angle);
    }

    /// To fly a scenario, from level.
    ///
    /// # Errors
    ///
    /// If the board is not armed, or would refuse one of its setpoints.
    pub fn fly(&mut self, scenario: Scenario) -> Outcome<()> {
        let frame = self.frame.filter(|frame| frame.state == ArmState::Armed);
        let frame =
            frame.ok_or_else(|| Error::Unusable("a scenario is flown armed: arm first".to_owned()))?;
        let limits = &self.parameters.limits;
        let outside = |reference: &Reference<f32>| twinrotor::conversation::goal::outside(limits, reference);
        if let Some(refusal) = scenario.references().iter().find_map(outside) {
            return Err(Error::Unusable(words::refusal(&refusal)));
        }
        self.end_flight();
        let mut scenario = scenario;
        if scenario.start != Start::default() {
            self.journal.note(self.ticks, "the scenario's start is left out: the rig is where it is");
            scenario.start = Start::default();
        }
        match &mut self.bench {
            Some(bench) => bench.wear(&scenario),
            None if !scenario.is_undisturbed() || !scenario.inject.is_empty() => {
                let told = "what the scenario lets befall the rig is left out: a real rig has its own";
                self.journal.note(self.ticks, told);
                scenario = scenario.undisturbed();
                scenario.inject.clear();
            }
            None => {}
        }
        self.client.send(&ToBoard::Setpoint(Reference::at_rest(PerAxis::zero())));
        let flies = self.tuning.in_force(frame.controller.trial != TrialPhase::None);
        self.flying = Some(Flying::new(scenario, flies, frame.tick));
        Ok(())
    }

    /// Ends a scenario under way, and what it lets befall the rig.
    pub(super) fn end_flight(&mut self) -> Option<Flying> {
        if let Some(bench) = &mut self.bench {
            bench.calm();
        }
        self.flying.take()
    }

    /// The simulated rig, for a hand at it.
    ///
    /// # Errors
    ///
    /// If the board is at the other end of a line.
    pub fn bench(&mut self) -> Outcome<&mut Bench> {
        let real = || Error::Unusable("only a rig that is simulated here can be disturbed".to_owned());
        self.bench.as_mut().ok_or_else(real)
    }

    /// Wind: steady \[V\] at each motor, and with or without gusts.
    ///
    /// # Errors
    ///
    /// If the rig is not simulated here.
    pub fn disturb(&mut self, steady: PerMotor<f32>, gusts: bool) -> Outcome<()> {
        let bench = self.bench()?;
        bench.wind = steady;
        bench.gusts = if gusts { Scenario::named("3")?.disturbances(1) } else { Vec::new() };
        Ok(())
    }

    /// A fault comes or goes.
    ///
    /// # Errors
    ///
    /// If there is none of that name, or the rig is not simulated here.
    pub fn fault(&mut self, name: &str, present: bool) -> Outcome<()> {
        let words = self.bench()?.fault(name, present)?;
        self.journal.note(self.ticks, if present { words.to_owned() } else { format!("mended: {words}") });
        Ok(())
    }

    /// The draft is tried in flight.
    pub fn try_draft(&mut self) {
        self.tuning.try_draft();
        let attempt = Attempt::new(self.tuning.draft.map(f32::from_f64));
        self.client.send(&ToBoard::Trial(Nonce::default(), attempt));
    }

    /// What is tried is kept, or taken back.
    pub fn judge(&mut self, keep: bool) {
        self.client.send(&if keep { ToBoard::Accept(Nonce::default()) } else { ToBoard::Revert });
    }

    /// The accepted controller to flash.
    pub fn save(&mut self) {
        self.client.ask(Question::Save, self.now());
    }

    /// What was flown.
    #[must_use]
    pub const fn flights(&self) -> &Flights {
        &self.flights
    }

    /// The controllers.
    pub fn tuning(&mut self) -> &mut Tuning {
        &mut self.tuning
    }

    /// The draft becomes the controller of this name.
    ///
    /// # Errors
    ///
    /// If there is none.
    pub fn draw(&mut self, name: &str) -> Outcome<()> {
        let drawn = controller(&self.preset, &self.rig, name)?;
        self.tuning.draw(name, drawn);
        Ok(())
    }
}
