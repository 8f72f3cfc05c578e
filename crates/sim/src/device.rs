//! Something that flies many flights at once beside this processor's lanes, with the same bits: a GPU.

use crate::flight::Fidelity;
use crate::judged::{Course, Flown, Rules};
use crate::metrics::{Criterion, Integral};
use std::fmt::Debug;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::Hardware;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{PlantParameters, State};
use twinrotor::reference::Reference;

/// A plant, and what befalls it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Draw {
    /// Its constants.
    pub plant: PlantParameters<f64>,
    /// \[V\] The constant that is added to the volts in effect from the disturbance time on.
    pub disturbance: PerMotor<f64>,
    /// \[counts\] 0..1: where between two counts the start lies.
    pub encoder_phase: PerAxis<f64>,
}

/// What is otherwise from a tick on than it was before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// From when on.
    pub tick: u32,
    /// What is asked for, where that is something else.
    pub asked: Option<Reference<f32>>,
    /// What pushes, in parts of the plant's disturbance.
    pub push: Option<f32>,
}

/// `course` by its changes up to the tick `end`, in their order; the first is that of tick 0.
pub fn changes(mut course: impl Course, end: u32) -> Vec<Change> {
    let (mut list, mut before) = (Vec::new(), None);
    for tick in 0..end {
        let (asked, push) = (course.asked(tick), course.push(tick));
        if asked.is_some() || before != Some(push) {
            list.push(Change { tick, asked, push });
            before = Some(push);
        }
    }
    list
}

/// Flights that differ in controller and plant alone: every controller on every plant, from rest.
#[derive(Debug, Clone, Copy)]
pub struct Batch<'a> {
    /// What they are judged by.
    pub rules: Rules,
    /// What happens in them.
    pub course: &'a [Change],
    /// Sensors and amplifiers, none of them worn; each plant has its encoder phase.
    pub hardware: Hardware,
    /// The controllers.
    pub controllers: &'a [Settings<f32>],
    /// The plants.
    pub plants: &'a [Draw],
}

/// What happens in a flight from a tick on, until the next of these.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// From when on.
    pub tick: u32,
    /// What is asked for.
    pub asked: Reference<f32>,
    /// \[V\] Added to the volts in effect.
    pub volts: PerMotor<f32>,
}

/// Flights of one plant that differ in the controller alone, and of which the integral of the error counts.
#[derive(Debug, Clone, Copy)]
pub struct Integrals<'a> {
    /// Which.
    pub criterion: Criterion,
    /// What is flown.
    pub rig: &'a Rig,
    /// In which world; nothing of the hardware is worn.
    pub fidelity: Fidelity,
    /// Where from.
    pub start: State<f64>,
    /// \[V\] In effect at the rotors then.
    pub rotors: PerMotor<f64>,
    /// What happens, from tick 0 on.
    pub course: &'a [Instant],
    /// How many ticks.
    pub ticks: u32,
    /// The controllers, and the cost that each must get below.
    pub candidates: &'a [(Settings<f32>, f64)],
}

/// What came of one of them.
#[derive(Debug, Clone, Copy)]
pub struct Integrated {
    /// At the end.
    pub integral: Integral<f32>,
    /// The first tick with a look in which it had lost; `None` for none.
    pub first_lost: Option<u32>,
    /// The last one in which it had not.
    pub last_in_play: Option<u32>,
}

/// What flies batches.
pub trait Device: Debug + Send + Sync {
    /// The sums of every flight, controller by controller, each in the order of the plants. Nothing if `stop`
    /// says so before all are known, or if the device has failed; then it keeps why, and gives nothing more.
    fn fly(&self, batch: &Batch<'_>, stop: &(dyn Fn() -> bool + Sync)) -> Option<Vec<Flown>>;

    /// What came of every candidate, on the same terms.
    fn integrals(&self, work: &Integrals<'_>, stop: &(dyn Fn() -> bool + Sync)) -> Option<Vec<Integrated>>;
}
