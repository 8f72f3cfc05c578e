//! What is to be flown, in [words](crate::words).

use super::card::unsaid;
use super::driver::Fault;
use super::written;
use crate::integral::{self, INSTANT};
use crate::robust::{CHANGE, Common};
use rayon::prelude::*;
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
    pub(super) common: Vec<u32>,
    /// What happens in each flight.
    pub(super) course: Vec<u32>,
    /// Each controller.
    pub(super) controllers: Vec<Vec<u32>>,
    /// The plants.
    pub(super) plants: &'a [Draw],
}

impl<'a> Work<'a> {
    pub(super) fn of_batch(batch: &Batch<'a>) -> Result<Self, Fault> {
        Ok(Self {
            common: written(&Common::new(&batch.rules, &batch.hardware)).map_err(unsaid)?,
            course: batch.course.iter().flat_map(change_words).collect(),
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
            common: written(&common).map_err(unsaid)?,
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

fn change_words(change: &Change) -> [u32; CHANGE] {
    let [a, b, c, d, e, f] = reference_words(&change.asked.unwrap_or_default());
    let flags = u32::from(change.asked.is_some()) | u32::from(change.push.is_some()) << 1;
    [change.tick, flags, a, b, c, d, e, f, change.push.unwrap_or(0.0).to_bits()]
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
