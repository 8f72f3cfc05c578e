//! What is to be flown, in [words](crate::words).

use super::card::unsaid;
use super::driver::Fault;
use super::written;
use crate::integral::{self, INSTANT};
use crate::told::{Belief, CHANGE, COMMON, Common, Instruments};
use rayon::prelude::*;
use serde::Serialize;
use std::vec::Vec;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::Hardware;
use twinrotor::plant::{LaggedRotors, PlantParameters, State, Thrust as _};
use twinrotor::real::Real as _;
use twinrotor::reference::Reference;
use twinrotor_sim::device::{Batch, Change, Draw, Instant, Integrals};

/// Every controller on every plant.
pub(super) struct Work<'a> {
    /// What all have in common.
    pub(super) common: [u32; COMMON],
    /// What happens in each flight.
    pub(super) course: Vec<u32>,
    /// Each controller.
    pub(super) controllers: Vec<Vec<u32>>,
    /// The plants.
    pub(super) plants: &'a [Draw],
}

impl<'a> Work<'a> {
    pub(super) fn of_batch(batch: &Batch<'a>) -> Result<Self, Fault> {
        let belief = batch.controllers.first().map(Belief::of);
        let belief = belief.ok_or_else(|| unsaid("there is no controller"))?;
        if batch.controllers.iter().any(|settings| Belief::of(settings) != belief) {
            return Err(unsaid("controllers believe in different rigs"));
        }
        Ok(Self {
            common: filled(&Common {
                bounds: batch.rules.bounds(),
                instruments: Instruments::new(&batch.hardware),
                belief,
            })?,
            course: course_words(batch),
            controllers: batch.controllers.iter().map(written).collect::<Result<_, _>>().map_err(unsaid)?,
            plants: batch.plants,
        })
    }

    pub(super) fn of_integrals(work: &Integrals<'_>, plant: &'a [Draw]) -> Result<Self, Fault> {
        let Hardware { encoder_counts, pwm_steps, supply, .. } = Hardware::of(work.rig, PerAxis::both(0.5));
        let State { angle, rate } = work.start;
        let common = integral::Common {
            criterion: work.criterion,
            ticks: work.ticks,
            plant: work.rig.plant,
            nominal_volts: work.rig.nominal_volts,
            angle,
            rate,
            rotors: work.rotors,
            encoder_counts,
            pwm_steps,
            supply,
        };
        // The bound goes before its controller.
        let controller = |(settings, bound): &(_, f64)| written(&(*bound, settings));
        Ok(Self {
            common: filled(&common)?,
            course: work.course.iter().flat_map(instant_words).collect(),
            controllers: work.candidates.iter().map(controller).collect::<Result<_, _>>().map_err(unsaid)?,
            plants: plant,
        })
    }
}

fn reference_words(asked: &Reference<f32>) -> [u32; 6] {
    let [angle, rate, accel] = [asked.angle, asked.rate, asked.accel].map(|x| x.map(f32::to_bits).to_array());
    [angle[0], angle[1], rate[0], rate[1], accel[0], accel[1]]
}

fn instant_words(instant: &Instant) -> [u32; INSTANT] {
    let [a, b, c, d, e, f] = reference_words(&instant.asked);
    let [main, tail] = instant.volts.map(f32::to_bits).to_array();
    [instant.tick, a, b, c, d, e, f, main, tail]
}

/// The changes of a course, the first in tick 0, each with all that is asked for from then on.
fn course_words(batch: &Batch<'_>) -> Vec<u32> {
    let mut asked = Reference::at_rest(batch.rules.goal.cast());
    let begins = batch.course.first().is_some_and(|change| change.tick == 0);
    let before = (!begins).then_some(Change { tick: 0, asked: None, push: None });
    let words = |change: &Change| {
        asked = change.asked.unwrap_or(asked);
        change_words(change.tick, &asked, change.push)
    };
    before.iter().chain(batch.course).flat_map(words).collect()
}

fn change_words(tick: u32, asked: &Reference<f32>, push: Option<f32>) -> [u32; CHANGE as usize] {
    let [a, b, c, d, e, f] = reference_words(asked);
    [tick, u32::from(push.is_some()), push.unwrap_or(0.0).to_bits(), a, b, c, d, e, f]
}

/// Words that are short of room for what all flights have in common, and zeros.
fn filled(common: &impl Serialize) -> Result<[u32; COMMON], Fault> {
    let words = written(common).map_err(unsaid)?;
    let mut room = [0; COMMON];
    room.get_mut(..words.len())
        .ok_or_else(|| unsaid("what flights share is too long"))?
        .copy_from_slice(&words);
    Ok(room)
}

/// A plant's numbers, in the order in which a thread reads them.
fn plant_numbers(draw: &Draw, mut to: impl FnMut(u32)) {
    let mut push = |x: f32| {
        to(x.to_bits());
        x
    };
    let constants: PlantParameters<f32> = draw.plant.map(f32::from_f64);
    constants.map(&mut push);
    LaggedRotors::<f32>::new(&draw.plant, SAMPLE_TIME).map(&mut push);
    let disturbance: PerMotor<f32> = draw.disturbance.cast();
    let phase: PerAxis<f32> = draw.encoder_phase.cast();
    disturbance.map(&mut push);
    phase.map(&mut push);
}

/// How many words a plant has.
pub(super) fn plant_length(plants: &[Draw]) -> usize {
    let mut words = 0;
    if let Some(draw) = plants.first() {
        plant_numbers(draw, |_| words += 1);
    }
    words
}

/// The plants' numbers, plant by plant.
pub(super) fn plant_words(plants: &[Draw]) -> Vec<u32> {
    let each = plant_length(plants);
    let mut words = std::vec![0; plants.len() * each];
    words.par_chunks_mut(each.max(1)).zip(plants).for_each(|(place, draw)| {
        let mut place = place.iter_mut();
        plant_numbers(draw, |number| {
            if let Some(word) = place.next() {
                *word = number;
            }
        });
    });
    words
}
