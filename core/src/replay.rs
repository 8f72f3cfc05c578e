//! A recorded flight through the controller: what would it have believed, and asked for?
//!
//! Host and board both do it with this, each with its own build of the same arithmetic, so that a log can be
//! taken to a real board over the link and its answers compared bit for bit. No motor has a part in it, and
//! no tick.

use crate::axes::{PerAxis, PerMotor};
use crate::parameters::{EncoderScale, Parameters};
use crate::pipeline::Pipeline;
use crate::real::Real;
use crate::reference::Reference;
use serde::{Deserialize, Serialize};

/// One tick of a record.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Which tick, counted from the record's first; 0 begins afresh, at rest at its counts.
    pub number: u32,
    /// \[counts\] From the zero of each encoder.
    pub counts: PerAxis<i32>,
    /// \[V\] What the motors get from now to the next tick.
    pub volts: PerMotor<f32>,
    /// Where the rig should be, if that is known: without it, the law is not asked.
    pub wanted: Option<Reference<f32>>,
}

/// What one tick came to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Replayed {
    /// Of which sample.
    pub number: u32,
    /// \[rad\] Estimated angles.
    pub angle: PerAxis<f32>,
    /// \[rad/s\] Estimated rates.
    pub rate: PerAxis<f32>,
    /// \[rad/s²\] Estimated acceleration that the model does not explain.
    pub disturbance: PerAxis<f32>,
    /// \[V\] What the law would have sent, within the limits.
    pub volts: Option<PerMotor<f32>>,
}

impl Replayed {
    /// Whether every number is the same to the bit.
    pub fn same_bits(&self, other: &Self) -> bool {
        let bits = |of: &Self| {
            let axes = [of.angle, of.rate, of.disturbance].map(|a| [a.pitch.to_bits(), a.yaw.to_bits()]);
            (of.number, axes, of.volts.map(|v| [v.main.to_bits(), v.tail.to_bits()]))
        };
        bits(self) == bits(other)
    }
}

/// A replay under way.
#[derive(Debug, Clone, Copy)]
pub struct Replay {
    scale: PerAxis<EncoderScale>,
    pipeline: Pipeline<f32>,
}

impl Replay {
    /// With the controller of `parameters`, at rest where `first` says.
    pub fn new(parameters: &Parameters, first: &Sample) -> Self {
        let scale = parameters.encoders;
        Self { scale, pipeline: Pipeline::new(&parameters.settings, angle(scale, first.counts)) }
    }

    /// One tick.
    pub fn step(&mut self, sample: &Sample) -> Replayed {
        let measured = angle(self.scale, sample.counts);
        let belief = self.pipeline.believe_once(measured, sample.volts);
        let estimate = belief.estimate;
        let volts = sample.wanted.map(|wanted| self.pipeline.decide_once(belief, &wanted).allocation.volts);
        Replayed {
            number: sample.number,
            angle: estimate.state.angle,
            rate: estimate.state.rate,
            disturbance: estimate.disturbance,
            volts,
        }
    }
}

/// \[rad\] As [`crate::encoder::Encoder`] has it.
fn angle(scale: PerAxis<EncoderScale>, counts: PerAxis<i32>) -> PerAxis<f32> {
    counts.zip(scale, |counts, scale| f32::from_i32(counts) * scale.angle_per_count)
}
