//! What a unit holds, and a tick of it.

use crate::design::{Design, What};
use crate::history::{Course, Held, INPUTS, Tuned};
use crate::tuning::{Asked, Tuning};
use crate::variables::{Place, Variable, variables};
use std::sync::Arc;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::Bench;
use twinrotor::parameters::Parameters;
use twinrotor::plant::State;
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::supervisor::ArmState;
use twinrotor::trial::Attempt;
use twinrotor::validate::Invalid;
use twinrotor_sim::closed_loop::{BoardLoop, ClosedLoop, ReadyBoard};
use twinrotor_sim::flight::{self, Fidelity, Plan};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::scenario::Scenario;
use twinrotor_sim::{Error, Outcome};

/// The simulation's own draw of where between two counts the encoders begin: that of `--seed 1`.
const SEED: u64 = 1;

/// What is stepped.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::large_enum_variant, reason = "one a unit")]
enum Machine {
    Plant(Bench<f32>),
    Controller(ReadyBoard),
    Loop(BoardLoop),
}

/// A unit at work. Its copies go on on their own: what a master takes and sets back.
#[derive(Debug, Clone)]
pub struct Model {
    /// Of the design that it was made of, before anybody set a parameter.
    guid: Arc<str>,
    design: Arc<Design>,
    variables: Arc<Vec<Variable>>,
    machine: Machine,
    inputs: [f64; INPUTS],
    /// \[V\] What the amplifiers give, of a board.
    volts: PerMotor<f32>,
    ticks: u64,
    begun: bool,
    /// Copied where a state is taken: a few numbers for each change of the inputs.
    held: Vec<Held>,
    tuned: Vec<Tuned>,
    tuning: Tuning,
    /// Of its board.
    parameters: Arc<Parameters>,
}

impl Model {
    /// At rest in mid-air, as `host-sim simulate` begins.
    ///
    /// # Errors
    ///
    /// If the design's controller is none.
    pub fn new(design: Design) -> Outcome<Self> {
        let all = variables(&design);
        let mut inputs = [0.0; INPUTS];
        for variable in &all {
            if let (Place::Input(k), Some(start)) = (variable.place, variable.start) {
                inputs[k] = start;
            }
        }
        let machine = machine(&design)?;
        let (controller, parameters) = (design.gains.controller, parameters(&design));
        Ok(Self {
            guid: design.guid().into(),
            design: Arc::new(design),
            variables: Arc::new(all),
            machine,
            inputs,
            volts: PerMotor::zero(),
            ticks: 0,
            begun: false,
            held: Vec::new(),
            tuned: Vec::new(),
            tuning: Tuning::new(controller),
            parameters,
        })
    }

    /// What it is of.
    pub fn design(&self) -> &Design {
        &self.design
    }

    /// \[s\] That have been simulated.
    #[expect(clippy::cast_precision_loss, reason = "285,000 years of milliseconds are exact")]
    pub fn time(&self) -> f64 {
        self.ticks as f64 * SAMPLE_TIME
    }

    /// The simulation begins: a parameter that is set from now on is a trial.
    pub fn begin(&mut self) {
        self.begun = true;
    }

    /// A variable's value.
    ///
    /// # Errors
    ///
    /// If there is none of that reference.
    pub fn get(&self, reference: u32) -> Outcome<f64> {
        Ok(match self.variable(reference)?.place {
            Place::Input(k) => self.inputs[k],
            Place::Output(of) => of(self),
            Place::Setting(field) => self.tuning.controller().get(field.name).unwrap_or_default(),
        })
    }

    /// Sets an input or a parameter. One that is set after the simulation has begun is tried in flight: what
    /// was set at one instant together. If the board takes it back, the parameter is again what it was.
    ///
    /// # Errors
    ///
    /// If it is not one of them, or not what it may be; then nothing has changed.
    pub fn set(&mut self, reference: u32, value: f64) -> Outcome<()> {
        let variables = Arc::clone(&self.variables);
        let variable = lookup(&variables, reference)?;
        match variable.place {
            Place::Input(k) => {
                if !value.is_finite() {
                    return Err(Error::invalid(&variable.name, value, "a finite number"));
                }
                self.inputs[k] = value;
                Ok(())
            }
            Place::Output(_) => Err(Error::invalid(&variable.name, value, "reading: it is an output")),
            Place::Setting(field) => {
                let mut controller = *self.tuning.controller();
                controller.set(field.name, value)?;
                controller.validate()?;
                if self.begun {
                    Attempt::new(controller.map(f32::from_f64)).validate().map_err(told)?;
                    self.tuning.want(controller);
                    self.tuned.push(Tuned { tick: self.ticks, reference, value });
                } else {
                    let mut design = (*self.design).clone();
                    design.gains.controller = controller;
                    self.become_design(design)?;
                }
                Ok(())
            }
        }
    }

    fn become_design(&mut self, design: Design) -> Outcome<()> {
        self.machine = machine(&design)?;
        self.tuning = Tuning::new(design.gains.controller);
        self.parameters = parameters(&design);
        self.design = Arc::new(design);
        Ok(())
    }

    fn variable(&self, reference: u32) -> Outcome<&Variable> {
        lookup(&self.variables, reference)
    }

    /// Steps from `from` for `size` \[s\], inputs held.
    ///
    /// # Errors
    ///
    /// If it does not stand there, or the size is no multiple of a tick.
    pub fn step(&mut self, from: f64, size: f64) -> Outcome<()> {
        // A master's sum of steps is off by its rounding.
        let off = (from - self.time()).abs();
        if off.is_nan() || off > 1e-6 * SAMPLE_TIME.max(from.abs()) {
            return Err(Error::invalid("communication point", from, format!("{} s", self.time())));
        }
        let ticks = (size / SAMPLE_TIME).round();
        let is_multiple = (size - ticks * SAMPLE_TIME).abs() <= 1e-6 * SAMPLE_TIME;
        if !(is_multiple && (1.0..=1e9).contains(&ticks)) {
            return Err(Error::invalid("communication step size", size, "a multiple of 0.001 s"));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 1 to 1e9")]
        self.advance(ticks as u64);
        Ok(())
    }

    /// So many ticks with the inputs as they are.
    fn advance(&mut self, ticks: u64) {
        let bits = |inputs: [f64; INPUTS]| inputs.map(f64::to_bits);
        if self.held.last().is_none_or(|last| bits(last.inputs) != bits(self.inputs)) {
            self.held.push(Held { tick: self.ticks, inputs: self.inputs });
        }
        for _ in 0..ticks {
            self.tick();
        }
    }

    /// All that it takes to be here again: what it was told, which grows by 48 bytes with each change of an
    /// input.
    pub fn to_bytes(&self) -> Vec<u8> {
        let gains = GainsFile { controller: self.design.gains.controller, provenance: None };
        Course {
            guid: self.guid.to_string(),
            gains: gains.to_toml(),
            begun: self.begun,
            ticks: self.ticks,
            inputs: self.inputs,
            held: self.held.clone(),
            tuned: self.tuned.clone(),
        }
        .to_bytes()
    }

    /// The unit where [`Model::to_bytes`] was asked, from this one as it was made: flown there once more,
    /// which takes some .3 us a tick.
    ///
    /// # Errors
    ///
    /// If the bytes are no state of this unit.
    pub fn from_bytes(&self, bytes: &[u8]) -> Outcome<Self> {
        let course = Course::from_bytes(bytes)?;
        if course.guid != *self.guid {
            return Err(Error::invalid(
                "serialized state",
                course.guid,
                format!("{}, this unit's", self.guid),
            ));
        }
        let mut design = (*self.design).clone();
        let controller = GainsFile::parse("the state's gains", &course.gains)?.controller;
        if controller != design.gains.controller {
            design.gains = GainsFile { controller, provenance: None };
        }
        let fresh = Self { ticks: 0, held: Vec::new(), tuned: Vec::new(), ..self.clone() };
        let mut there = Self { volts: PerMotor::zero(), begun: course.begun, ..fresh };
        there.become_design(design)?;
        let mut tuned = course.tuned.iter().peekable();
        let ends = course.held.iter().skip(1).map(|next| next.tick).chain([course.ticks]);
        for (held, end) in course.held.iter().zip(ends) {
            there.inputs = held.inputs;
            while let Some(next) = tuned.next_if(|tuned| tuned.tick < end) {
                there.advance(next.tick.saturating_sub(there.ticks));
                there.set(next.reference, next.value)?;
            }
            there.advance(end - there.ticks);
        }
        for last in tuned {
            there.set(last.reference, last.value)?;
        }
        there.inputs = course.inputs;
        Ok(there)
    }

    fn tick(&mut self) {
        #[expect(clippy::cast_possible_truncation, reason = "finite, and f32 is what flies")]
        let [a, b, c, d, e] = self.inputs.map(|x| x as f32);
        let asked = self.asked();
        match &mut self.machine {
            Machine::Plant(bench) => {
                bench.disturbance = PerMotor::new(c, d);
                bench.advance(PerMotor::new(a, b), true);
            }
            Machine::Controller(board) => {
                let counters = PerAxis::new(self.inputs[2], self.inputs[3]).map(counter);
                let outputs = match &asked {
                    Some((command, trial)) => board.tick_with(counters, e, command, trial.as_ref()),
                    None => board.tick(counters, e, &Reference::at_rest(PerAxis::new(a, b))),
                };
                let given = board.control().frame().volts;
                self.volts = if outputs.enable { given } else { PerMotor::zero() };
            }
            Machine::Loop(both) => {
                let disturbance = PerMotor::new(c, d);
                self.volts = match &asked {
                    Some((command, trial)) => {
                        let (counters, supply) = (both.bench.counters(), both.bench.supply);
                        let outputs = both.board.tick_with(counters, supply, command, trial.as_ref());
                        both.bench.disturbance = disturbance;
                        both.bench.tick(outputs.duty, outputs.enable)
                    }
                    None => both.tick(&Reference::at_rest(PerAxis::new(a, b)), disturbance).applied,
                };
            }
        }
        self.ticks += 1;
    }

    /// What the operator of its board asks for in the tick that comes, beside flying on.
    fn asked(&mut self) -> Option<Asked> {
        let control = match &self.machine {
            Machine::Plant(_) => return None,
            Machine::Controller(board) => board.control(),
            Machine::Loop(both) => both.board.control(),
        };
        self.tuning.ask(control, &self.parameters)
    }

    fn bench(&self) -> Option<&Bench<f32>> {
        match &self.machine {
            Machine::Plant(bench) => Some(bench),
            Machine::Loop(both) => Some(&both.bench),
            Machine::Controller(_) => None,
        }
    }

    pub(crate) fn state(&self) -> State<f32> {
        self.bench().map_or_else(|| State::at_rest(PerAxis::zero()), Bench::state)
    }

    pub(crate) fn counts(&self) -> PerAxis<i32> {
        self.bench().map_or_else(|| PerAxis::both(0), Bench::counted)
    }

    pub(crate) fn supply(&self) -> f64 {
        self.bench().map_or(0.0, |bench| bench.supply.into())
    }

    pub(crate) fn volts(&self) -> PerMotor<f32> {
        self.volts
    }

    pub(crate) fn is_armed(&self) -> bool {
        match &self.machine {
            Machine::Plant(_) => false,
            Machine::Controller(board) => board.control().state() == ArmState::Armed,
            Machine::Loop(both) => both.is_armed(),
        }
    }
}

fn lookup(variables: &[Variable], reference: u32) -> Outcome<&Variable> {
    let found = usize::try_from(reference).ok().and_then(|k| variables.get(k));
    found.ok_or_else(|| {
        Error::invalid("value reference", reference, format!("0 to {}", variables.len().saturating_sub(1)))
    })
}

/// What a counter of 16 bits shows of a count.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counters wrap")]
fn counter(count: f64) -> u32 {
    count.rem_euclid(65_536.0) as u32
}

/// What a board of it is made with, as far as a trial asks.
fn parameters(design: &Design) -> Arc<Parameters> {
    let rig = &design.named.rig;
    Arc::new(Parameters::new(rig, &design.gains.settings(rig)))
}

/// What the core says of a value, as everywhere here.
fn told(invalid: Invalid<f32>) -> Error {
    Error::from(invalid)
}

fn machine(design: &Design) -> Outcome<Machine> {
    let rig = &design.named.rig;
    let settings = design.gains.settings(rig);
    let scenario = Scenario::named("step")?;
    let both = flight::board_loop(&Plan {
        rig,
        truth: rig,
        settings: &settings,
        scenario: &scenario,
        initial: PerAxis::zero(),
        fidelity: Fidelity::Rig,
        seed: SEED,
    });
    Ok(match design.what {
        What::Plant => Machine::Plant(both.bench),
        What::Controller => Machine::Controller(both.board),
        What::Loop => Machine::Loop(both),
    })
}
