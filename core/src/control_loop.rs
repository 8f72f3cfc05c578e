//! The tick of the board, as a list of verbs; the arithmetic is in the steps it calls.

use crate::axes::{PerAxis, PerMotor};
use crate::drive::{Drive, Duty};
use crate::encoder::Encoder;
use crate::pipeline::{Command, Pipeline, Settings};
use crate::reference::Reference;

/// Encoders in, duties out, once a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlLoop {
    encoders: PerAxis<Encoder>,
    pipeline: Pipeline<f32>,
    drive: Drive<f32>,
    /// \[V\] What the last tick's duties give. They are latched at the next tick, so they act one tick late.
    latched: PerMotor<f32>,
}

/// What the board has read when a tick begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// What each encoder's counter shows.
    pub counters: PerAxis<u32>,
    /// \[V\] Supply of the amplifiers.
    pub supply: f32,
    /// What is wanted.
    pub reference: Reference<f32>,
}

/// What the board is to do when a tick ends.
#[derive(Debug, Clone, Copy)]
pub struct Outputs {
    /// To be latched by the PWM at the next tick.
    pub duty: PerMotor<Duty<f32>>,
    /// How it came to that.
    pub command: Command<f32>,
}

impl ControlLoop {
    /// Ready to start where the encoders are, at rest, with the motors off.
    pub fn new(settings: &Settings<f32>, encoders: PerAxis<Encoder>, drive: Drive<f32>) -> Self {
        Self {
            encoders,
            pipeline: Pipeline::new(settings, encoders.map(|e| e.angle())),
            drive,
            latched: PerMotor::zero(),
        }
    }

    /// One tick.
    pub fn tick(&mut self, inputs: &Inputs) -> Outputs {
        let measured = self.read_encoders(inputs.counters);
        let applied = self.latched;
        let command = self.pipeline.tick(measured, applied, &inputs.reference);
        let duty = self.drive.duty(command.allocation.volts, inputs.supply);
        self.latched = self.drive.volts(duty, inputs.supply);
        Outputs { duty, command }
    }

    fn read_encoders(&mut self, counters: PerAxis<u32>) -> PerAxis<f32> {
        PerAxis { pitch: self.encoders.pitch.read(counters.pitch), yaw: self.encoders.yaw.read(counters.yaw) }
    }
}
