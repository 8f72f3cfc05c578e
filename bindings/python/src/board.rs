//! The board's control loop, a rig to fly, and both as the simulated board has them.

use crate::parts::{named_rig, stable_gains_of, word};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::VecDeque;
use std::time::Duration;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{self, Hardware};
use twinrotor::control_loop::{self, Inputs, OperatorCommand};
use twinrotor::drive::Drive;
use twinrotor::encoder::CounterWidth;
use twinrotor::link::ToBoard;
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{SLOT_SIZE, Store};
use twinrotor::parameters::{self, Parameters};
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{RealPlant, State};
use twinrotor::reference::Reference;
use twinrotor::sequence::{Numbered, Sequence};
use twinrotor::supervisor::{ArmState, Condition, Request};
use twinrotor::telemetry::Frame;
use twinrotor_station::{Client, words};

const REQUESTS: [(&str, Request); 4] = [
    ("arm", Request::Arm),
    ("disarm", Request::Disarm),
    ("check", Request::Check),
    ("clear-fault", Request::ClearFault),
];

fn spelt(condition: Condition) -> String {
    format!("{condition:?}")
}

fn reference(angle: [f32; 2], rate: [f32; 2], accel: [f32; 2]) -> PyResult<Reference<f32>> {
    let axes = |name: &str, [pitch, yaw]: [f32; 2]| {
        if pitch.is_finite() && yaw.is_finite() {
            Ok(PerAxis::new(pitch, yaw))
        } else {
            Err(PyValueError::new_err(format!("{name} is [{pitch}, {yaw}]; allowed: finite numbers")))
        }
    };
    Ok(Reference { angle: axes("angle", angle)?, rate: axes("rate", rate)?, accel: axes("accel", accel)? })
}

fn told<'py>(py: Python<'py>, frame: &Frame) -> PyResult<Bound<'py, PyDict>> {
    let axes = |v: PerAxis<f32>| (v.pitch, v.yaw);
    let motors = |v: PerMotor<f32>| (v.main, v.tail);
    let told = PyDict::new(py);
    told.set_item("tick", frame.tick)?;
    told.set_item("angle", axes(frame.angle))?;
    told.set_item("rate", axes(frame.rate))?;
    told.set_item("disturbance", axes(frame.disturbance))?;
    told.set_item("reference", axes(frame.reference))?;
    told.set_item("demand", motors(frame.demand))?;
    told.set_item("unallocated_torque", axes(frame.unallocated_torque))?;
    told.set_item("volts", motors(frame.volts))?;
    told.set_item("supply", frame.supply)?;
    Ok(told)
}

/// The loop that the firmware runs, with its supervisor: counters in, volts out, once a millisecond.
#[pyclass(module = "twinrotor._native", subclass)]
pub(crate) struct ControlLoop {
    control: control_loop::ControlLoop,
    wanted: VecDeque<Numbered<OperatorCommand>>,
    disarm: bool,
    said: Sequence,
}

impl ControlLoop {
    fn want(&mut self, message: OperatorCommand) {
        self.said = self.said.next();
        self.wanted.push_back(Numbered { sequence: self.said, message });
    }
}

#[pymethods]
impl ControlLoop {
    #[new]
    #[pyo3(signature = (preset, gains, counters, counter_bits, checked))]
    fn new(
        preset: &str,
        gains: Option<&str>,
        counters: (i64, i64),
        counter_bits: u8,
        checked: bool,
    ) -> PyResult<Self> {
        let named = named_rig(preset)?;
        let settings = stable_gains_of(gains, &named)?.settings(&named.rig);
        let width = match counter_bits {
            16 => CounterWidth::Bits16,
            24 => CounterWidth::Bits24,
            other => {
                return Err(PyValueError::new_err(format!("counter_bits is {other}; allowed: 16, 24")));
            }
        };
        let parameters = Parameters { checked, ..Parameters::new(&named.rig, &settings) };
        let drive = Drive::new(named.rig.board.pwm_steps());
        Ok(Self {
            control: control_loop::ControlLoop::new(&parameters, width, shown(counters), drive, None),
            wanted: VecDeque::new(),
            disarm: false,
            said: Sequence::default(),
        })
    }

    /// Something of the supervisor: 'arm', 'disarm', 'check', 'clear-fault'. Motors off goes before all else
    /// that waits.
    fn request(&mut self, what: &str) -> PyResult<()> {
        match word("request", what, &REQUESTS)? {
            Request::Disarm => {
                self.disarm = true;
                self.wanted.clear();
            }
            request => self.want(OperatorCommand::Request(request)),
        }
        Ok(())
    }

    /// Where the rig lies is its rest pose.
    fn zero(&mut self) {
        self.want(OperatorCommand::Zero);
    }

    /// Angles \[rad\], rates \[rad/s\] and accelerations \[rad/s²\] that are wanted.
    fn aim(&mut self, angle: [f32; 2], rate: [f32; 2], accel: [f32; 2]) -> PyResult<()> {
        self.want(OperatorCommand::Setpoint(reference(angle, rate, accel)?));
        Ok(())
    }

    /// A millisecond: the volts that are to act from the next one on, zero while the motors must not turn.
    fn tick(&mut self, pitch: i64, yaw: i64, supply: f32) -> (f32, f32) {
        let disarm = std::mem::take(&mut self.disarm);
        let command = self.wanted.pop_front();
        let outputs = self.control.tick(&Inputs {
            disarm,
            command: command.as_ref(),
            ..Inputs::sound(shown((pitch, yaw)), supply)
        });
        let volts = if outputs.enable { self.control.frame().volts } else { PerMotor::zero() };
        (volts.main, volts.tail)
    }

    /// 'disarmed', 'ready', 'checking', 'armed' or 'fault'.
    #[getter]
    fn state(&self) -> &'static str {
        words::state(self.control.state())
    }

    /// What the fault was, if there is one.
    #[getter]
    fn fault(&self) -> Option<String> {
        match self.control.state() {
            ArmState::Fault(cause) => Some(spelt(cause)),
            _ => None,
        }
    }

    /// What is wrong now, by name.
    #[getter]
    fn conditions(&self) -> Vec<String> {
        self.control.conditions().iter().map(spelt).collect()
    }

    /// May the amplifiers be enabled?
    #[getter]
    fn motors_may_turn(&self) -> bool {
        self.control.state().motors_may_turn()
    }

    /// The last tick as telemetry has it, SI units.
    fn frame<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        told(py, &self.control.frame())
    }
}

/// What counters of 32 bits or less show.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counters wrap")]
fn shown((pitch, yaw): (i64, i64)) -> PerAxis<u32> {
    PerAxis::new(pitch as u32, yaw as u32)
}

/// A simulated rig in its rest pose: the plant of the preset with rotors that lag, encoders, PWM steps,
/// supply, a stop to rest on, and wires that may be wrong.
#[pyclass(module = "twinrotor._native", subclass)]
pub(crate) struct Bench {
    bench: bench::Bench<f32>,
    drive: Drive<f32>,
    rig: Rig,
}

#[pymethods]
impl Bench {
    #[new]
    fn new(preset: &str) -> PyResult<Self> {
        let rig = named_rig(preset)?.rig;
        let mut bench = bench::Bench::at_rest(&rig, SAMPLE_TIME);
        bench.set_table(true);
        Ok(Self { bench, drive: Drive::new(rig.board.pwm_steps()), rig })
    }

    /// Milliseconds pass; `volts` act from the second one on, and amplifiers that are not enabled give
    /// nothing at once.
    #[pyo3(signature = (volts, enabled=true, ticks=1))]
    fn tick(&mut self, volts: (f32, f32), enabled: bool, ticks: u32) {
        let (main, tail) = volts;
        let duty = self.drive.duty(PerMotor::new(main, tail), self.bench.supply);
        for _ in 0..ticks {
            self.bench.tick(duty, enabled);
        }
    }

    /// Puts it at these angles \[rad\], at rest, its rotors too, on nothing.
    fn place(&mut self, pitch: f32, yaw: f32) {
        let state = State::at_rest(PerAxis::new(pitch, yaw));
        let plant = RealPlant::new(&self.rig.plant, state, SAMPLE_TIME);
        self.bench = bench::Bench::new(plant, &Hardware::of(&self.rig, PerAxis::both(0.5)));
    }

    /// What the encoders' counters of 16 bits show.
    #[getter]
    fn counters(&self) -> (u32, u32) {
        let PerAxis { pitch, yaw } = self.bench.counters();
        (pitch, yaw)
    }

    /// What the encoders have counted since they were switched on, which no counter wraps.
    #[getter]
    fn counts(&self) -> (i32, i32) {
        let PerAxis { pitch, yaw } = self.bench.counted();
        (pitch, yaw)
    }

    /// True angles \[rad\] and rates \[rad/s\].
    #[getter]
    fn state(&self) -> ((f32, f32), (f32, f32)) {
        let state = self.bench.state();
        ((state.angle.pitch, state.angle.yaw), (state.rate.pitch, state.rate.yaw))
    }

    /// \[V\] Supply of the amplifiers.
    #[getter]
    fn supply(&self) -> f32 {
        self.bench.supply
    }

    #[setter]
    fn set_supply(&mut self, volts: f32) {
        self.bench.supply = volts;
    }

    /// \[V\] Added to the volts in effect.
    #[setter]
    fn set_disturbance(&mut self, volts: (f32, f32)) {
        self.bench.disturbance = PerMotor::new(volts.0, volts.1);
    }

    /// Does something under the rig bear its weight in its rest pose?
    #[setter]
    fn set_table(&mut self, table: bool) {
        self.bench.set_table(table);
    }

    /// Encoders that are not connected.
    #[setter]
    fn set_encoder_stuck(&mut self, stuck: (bool, bool)) {
        self.bench.faults.encoder_stuck = PerAxis::new(stuck.0, stuck.1);
    }

    /// Encoders that count backwards.
    #[setter]
    fn set_encoder_reversed(&mut self, reversed: (bool, bool)) {
        self.bench.faults.encoder_reversed = PerAxis::new(reversed.0, reversed.1);
    }
}

/// A whole simulated board with its rig, at the other end of its line: the same conversation as the
/// firmware's.
#[pyclass(module = "twinrotor._native", subclass, unsendable)]
pub(crate) struct SimulatedBoard {
    board: twinrotor_station::SimulatedBoard,
    client: Client,
    ticks: u64,
}

impl SimulatedBoard {
    fn pass(&mut self) {
        let now = Duration::from_millis(self.ticks);
        self.client.poll(now);
        self.board.push(&self.client.take_outgoing());
        self.board.tick();
        self.client.push(&self.board.take_outgoing(), now);
        self.ticks += 1;
    }
}

#[pymethods]
impl SimulatedBoard {
    #[new]
    fn new(preset: &str, gains: Option<&str>, checked: bool) -> PyResult<Self> {
        let named = named_rig(preset)?;
        let settings = stable_gains_of(gains, &named)?.settings(&named.rig);
        let parameters = Parameters { checked, ..Parameters::new(&named.rig, &settings) };
        let mut store = Store::new(RamFlash::default(), 0);
        parameters::save(&mut store, &parameters, &mut [0; SLOT_SIZE])
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        let board = twinrotor_station::SimulatedBoard::new(&named.rig, parameters, store.into_flash());
        let mut new = Self { board, client: Client::new(), ticks: 0 };
        // Until it has said who it is.
        (0..10).for_each(|_| new.pass());
        Ok(new)
    }

    /// See `ControlLoop.request`.
    fn request(&mut self, what: &str) -> PyResult<()> {
        self.client.request(word("request", what, &REQUESTS)?);
        Ok(())
    }

    /// See `ControlLoop.zero`.
    fn zero(&mut self) {
        self.client.send(&ToBoard::Zero);
    }

    /// See `ControlLoop.aim`.
    fn aim(&mut self, angle: [f32; 2], rate: [f32; 2], accel: [f32; 2]) -> PyResult<()> {
        self.client.send(&ToBoard::Setpoint(reference(angle, rate, accel)?));
        Ok(())
    }

    /// A millisecond passes.
    fn tick(&mut self) {
        self.pass();
    }

    /// See `ControlLoop.state`.
    #[getter]
    fn state(&self) -> &'static str {
        words::state(self.board.frame().state)
    }

    /// The last tick as telemetry has it, SI units.
    fn frame<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        told(py, &self.board.frame())
    }
}
