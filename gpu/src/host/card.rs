//! Batches as launches: what does not fit the card's memory goes in several, and a card that has failed gives
//! nothing more.

use super::driver::{Argument, Driver, Fault};
use super::written;
use crate::robust::{CHANGE, Common, ended, from_words, usual};
use std::string::{String, ToString};
use std::sync::Mutex;
use std::vec::Vec;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::pipeline::Settings;
use twinrotor::plant::{LaggedRotors, PlantParameters, Thrust as _};
use twinrotor::real::Real as _;
use twinrotor_sim::device::{Batch, Change, Device, Draw};
use twinrotor_sim::judged::{Ended, Flown};

/// Most flights of a launch: a fraction of a second, so that a stop is heard.
const MOST: usize = 1 << 20;
/// Fewest worth a launch; with memory for less the card is no use.
const FEWEST: usize = 32;

/// A card that flies batches.
#[derive(Debug)]
pub struct Card<D> {
    driver: D,
    failure: Mutex<Option<Fault>>,
}

impl<D: Driver> Card<D> {
    /// With nothing on it.
    pub fn new(driver: D) -> Self {
        Self { driver, failure: Mutex::new(None) }
    }

    /// Its driver.
    pub fn driver(&self) -> &D {
        &self.driver
    }

    /// What it is called.
    pub fn name(&self) -> String {
        self.driver.name()
    }

    /// What stopped it, if anything did.
    pub fn failure(&self) -> Option<Fault> {
        self.failure.lock().ok()?.clone()
    }

    /// What `kernel` makes of every flight, unless the card has failed, now or before.
    fn run<const W: usize, T: Copy>(
        &self,
        kernel: &Kernel<W, T>,
        batch: &Batch<'_>,
        stop: &dyn Fn() -> bool,
    ) -> Option<Vec<T>> {
        if self.failure().is_some() {
            return None;
        }
        match self.launches(kernel, batch, stop) {
            Ok(flown) => flown,
            Err(fault) => {
                if let Ok(mut failure) = self.failure.lock() {
                    failure.get_or_insert(fault);
                }
                None
            }
        }
    }

    fn launches<const W: usize, T: Copy>(
        &self,
        kernel: &Kernel<W, T>,
        batch: &Batch<'_>,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Vec<T>>, Fault> {
        let (controllers, plants) = (batch.controllers.len(), batch.plants.len());
        let mut all: Vec<Option<T>> = std::vec![None; controllers * plants];
        let shared = Shared::new(&self.driver, batch)?;
        let mut most = MOST;
        let mut from = 0;
        while from < plants {
            if stop() {
                return Ok(None);
            }
            let free = usize::try_from(self.driver.free()?).unwrap_or(usize::MAX);
            let part = Part::fitting(free, W, most, controllers, plants - from);
            let these = batch.plants.get(from..from + part.plants).unwrap_or_default();
            match self.part(kernel, &shared, batch, these, part.controllers, stop) {
                Ok(Some(sums)) => {
                    for (c, sums) in sums.chunks(these.len()).enumerate() {
                        let place = c * plants + from;
                        for (to, flown) in all.iter_mut().skip(place).zip(sums) {
                            *to = Some(*flown);
                        }
                    }
                    from += part.plants;
                }
                Ok(None) => return Ok(None),
                // What was said to be free is not to be had in one piece: less of it.
                Err(Fault::Memory) if part.plants * part.controllers > FEWEST => {
                    most = (part.plants * part.controllers / 2).max(FEWEST);
                }
                Err(fault) => return Err(fault),
            }
        }
        Ok(all.into_iter().collect())
    }

    /// Every controller on these plants, so many controllers in a launch.
    fn part<const W: usize, T: Copy>(
        &self,
        kernel: &Kernel<W, T>,
        shared: &Shared<D::Memory>,
        batch: &Batch<'_>,
        plants: &[Draw],
        controllers: usize,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Vec<T>>, Fault> {
        let numbers = self.driver.upload(&plant_words(plants))?;
        let mut sums = Vec::with_capacity(batch.controllers.len() * plants.len());
        for group in batch.controllers.chunks(controllers) {
            if stop() {
                return Ok(None);
            }
            let (settings, each) = settings_words(group)?;
            let flights = group.len() * plants.len();
            let settings_length = settings.len();
            let settings = self.driver.upload(&settings)?;
            let out = self.driver.reserve(flights * W)?;
            let usual = group.iter().all(|s| usual(*s).is_some());
            let name = if usual { kernel.usual } else { kernel.any };
            let arguments = [
                Argument::Words(&shared.common),
                number(shared.common_length)?,
                Argument::Words(&settings),
                number(settings_length)?,
                number(each)?,
                Argument::Words(&numbers),
                number(plants.len() * PLANT)?,
                number(plants.len())?,
                Argument::Words(&shared.course),
                number(shared.course_length)?,
                Argument::Words(&out),
                number(flights)?,
            ];
            self.driver.launch(name, &arguments, count(flights)?)?;
            let words = self.driver.download(&out)?;
            let word = |k: usize, w: usize| words.get(w * flights + k).copied().unwrap_or(0);
            sums.extend((0..flights).map(|k| (kernel.read)(std::array::from_fn(|w| word(k, w)))));
        }
        Ok(Some(sums))
    }
}

impl<D: Driver> Device for Card<D> {
    fn fly(&self, batch: &Batch<'_>, stop: &(dyn Fn() -> bool + Sync)) -> Option<Vec<Flown>> {
        self.run(&Kernel { usual: "robust_usual", any: "robust_any", read: from_words }, batch, stop)
    }

    fn cuts(&self, batch: &Batch<'_>, stop: &(dyn Fn() -> bool + Sync)) -> Option<Vec<Option<Ended>>> {
        self.run(&Kernel { usual: "robust_cut", any: "robust_cut", read: ended }, batch, stop)
    }
}

/// A kernel that writes `W` words for each flight, and what they say.
struct Kernel<const W: usize, T> {
    /// Its name where every controller is of the [usual] kinds.
    usual: &'static str,
    /// The same for all.
    any: &'static str,
    read: fn([u32; W]) -> T,
}

/// How much goes in a launch.
struct Part {
    plants: usize,
    controllers: usize,
}

impl Part {
    /// Into `free` bytes, of which a tenth is left alone, with so many words for each flight, at most `most`
    /// flights.
    fn fitting(free: usize, flight: usize, most: usize, controllers: usize, plants: usize) -> Self {
        let words = free / 10 * 9 / size_of::<u32>();
        let fewest = FEWEST.min(plants);
        let here = plants.min(most).min((words / (PLANT + flight)).max(fewest));
        let left = words.saturating_sub(here * PLANT) / (here * flight);
        Self { plants: here, controllers: controllers.min(left.min(most / here)).max(1) }
    }
}

/// What every launch of a batch reads.
struct Shared<M> {
    common: M,
    common_length: usize,
    course: M,
    course_length: usize,
}

impl<M> Shared<M> {
    fn new<D: Driver<Memory = M>>(driver: &D, batch: &Batch<'_>) -> Result<Self, Fault> {
        let common = written(&Common::new(&batch.rules, &batch.hardware)).map_err(unsaid)?;
        let course: Vec<u32> = batch.course.iter().flat_map(change_words).collect();
        Ok(Self {
            common_length: common.len(),
            common: driver.upload(&common)?,
            course_length: course.len(),
            course: driver.upload(&course)?,
        })
    }
}

fn unsaid(why: impl ToString) -> Fault {
    Fault::Lost(why.to_string())
}

fn count(number: usize) -> Result<u32, Fault> {
    u32::try_from(number).map_err(unsaid)
}

fn number<'a, M>(of: usize) -> Result<Argument<'a, M>, Fault> {
    count(of).map(Argument::Number)
}

/// Every controller in as many words as the longest needs, and how many that is.
fn settings_words(controllers: &[Settings<f32>]) -> Result<(Vec<u32>, usize), Fault> {
    let words: Vec<Vec<u32>> = controllers.iter().map(written).collect::<Result<_, _>>().map_err(unsaid)?;
    let each = words.iter().map(Vec::len).max().unwrap_or(0);
    let filled = |words: Vec<u32>| words.into_iter().chain(std::iter::repeat(0)).take(each);
    Ok((words.into_iter().flat_map(filled).collect(), each))
}

fn change_words(change: &Change) -> [u32; CHANGE] {
    let asked = change.asked.unwrap_or_default();
    let [angle, rate, accel] = [asked.angle, asked.rate, asked.accel].map(|x| x.map(f32::to_bits).to_array());
    let flags = u32::from(change.asked.is_some()) | u32::from(change.push.is_some()) << 1;
    let push = change.push.unwrap_or(0.0).to_bits();
    [change.tick, flags, angle[0], angle[1], rate[0], rate[1], accel[0], accel[1], push]
}

/// Words of a plant.
const PLANT: usize = PLANT_CONSTANTS + ROTORS + 4;
const PLANT_CONSTANTS: usize = 22;
const ROTORS: usize = 14;

/// The plants' numbers, each in the order in which a thread reads them, neighbours side by side.
fn plant_words(plants: &[Draw]) -> Vec<u32> {
    let mut words = std::vec![0; plants.len() * PLANT];
    for (p, draw) in plants.iter().enumerate() {
        let mut next = words.iter_mut().skip(p).step_by(plants.len());
        let mut push = |x: f32| {
            if let Some(word) = next.next() {
                *word = x.to_bits();
            }
        };
        let constants: PlantParameters<f32> = draw.plant.map(f32::from_f64);
        constants.map(&mut push);
        LaggedRotors::<f32>::new(&draw.plant, SAMPLE_TIME).map(&mut push);
        let disturbance: PerMotor<f32> = draw.disturbance.cast();
        let phase: PerAxis<f32> = draw.encoder_phase.cast();
        disturbance.map(&mut push);
        phase.map(&mut push);
    }
    words
}
