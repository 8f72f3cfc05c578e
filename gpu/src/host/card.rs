//! Batches as launches: what does not fit the card's memory goes in several, and a card that has failed gives
//! nothing more.

use super::driver::{Argument, Driver, Fault};
use super::work::{Work, plant_length, plant_words};
use crate::integral;
use crate::robust::{self, usual};
use rayon::prelude::*;
use std::string::{String, ToString};
use std::sync::Mutex;
use std::time::{Duration, Instant};
use std::vec::Vec;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::law::LawSettings;
use twinrotor::pipeline::Settings;
use twinrotor_sim::device::{Batch, Device, Draw, Integrals, Integrated};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::judged::Flown;

/// Most flights of a launch: a fraction of a second, so that a stop is heard.
const MOST: usize = 1 << 20;
/// Fewest worth a launch; with memory for less the card is no use.
const FEWEST: usize = 32;

/// A card that flies batches.
#[derive(Debug)]
pub struct Card<D> {
    driver: D,
    failure: Mutex<Option<Fault>>,
    busy: Mutex<Duration>,
}

impl<D: Driver> Card<D> {
    /// With nothing on it.
    pub fn new(driver: D) -> Self {
        Self { driver, failure: Mutex::new(None), busy: Mutex::default() }
    }

    /// Its driver.
    pub fn driver(&self) -> &D {
        &self.driver
    }

    /// A hash of each flight's ticks, for comparing one device with another, on the terms of
    /// [`Device::fly`].
    pub fn traces(&self, batch: &Batch<'_>) -> Option<Vec<u64>> {
        let read = |[low, high]: [u32; 2]| u64::from(high) << 32 | u64::from(low);
        self.run(&Kernel { name: "robust_trace", read }, Work::of_batch(batch), &|| false)
    }

    /// How long the kernels have run.
    pub fn busy(&self) -> Duration {
        self.busy.lock().map(|busy| *busy).unwrap_or_default()
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
    fn run<const W: usize, T: Copy + Send>(
        &self,
        kernel: &Kernel<W, T>,
        work: Result<Work<'_>, Fault>,
        stop: &dyn Fn() -> bool,
    ) -> Option<Vec<T>> {
        if self.failure().is_some() {
            return None;
        }
        match work.and_then(|work| self.launches(kernel, &work, stop)) {
            Ok(flown) => flown,
            Err(fault) => {
                if let Ok(mut failure) = self.failure.lock() {
                    failure.get_or_insert(fault);
                }
                None
            }
        }
    }

    fn launches<const W: usize, T: Copy + Send>(
        &self,
        kernel: &Kernel<W, T>,
        work: &Work<'_>,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Vec<T>>, Fault> {
        let (controllers, plants) = (work.controllers.len(), work.plants.len());
        let mut parts: Vec<(usize, Vec<T>)> = Vec::new();
        let course = self.driver.upload(&work.course)?;
        let plant = plant_length(work.plants);
        let mut most = MOST;
        let mut from = 0;
        while from < plants {
            if stop() {
                return Ok(None);
            }
            let free = usize::try_from(self.driver.free()?).unwrap_or(usize::MAX);
            let part = Part::fitting(free, [plant, W], most, controllers, plants - from);
            let these = work.plants.get(from..from + part.plants).unwrap_or_default();
            match self.part(kernel, &course, work, these, part.controllers, stop) {
                Ok(Some(sums)) => {
                    parts.push((part.plants, sums));
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
        if let [(_, all)] = &mut parts[..] {
            return Ok(Some(std::mem::take(all)));
        }
        let of = |c: usize| parts.iter().filter_map(move |(n, sums)| sums.get(c * n..(c + 1) * n));
        Ok(Some((0..controllers).flat_map(of).flatten().copied().collect()))
    }

    /// Every controller on these plants, so many controllers in a launch.
    fn part<const W: usize, T: Copy + Send>(
        &self,
        kernel: &Kernel<W, T>,
        course: &D::Memory,
        work: &Work<'_>,
        plants: &[Draw],
        controllers: usize,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Vec<T>>, Fault> {
        let numbers = plant_words(plants);
        let numbers_length = numbers.len();
        let numbers = self.driver.upload(&numbers)?;
        let mut sums = Vec::with_capacity(work.controllers.len() * plants.len());
        for group in work.controllers.chunks(controllers) {
            if stop() {
                return Ok(None);
            }
            let (settings, each) = padded(group);
            let flights = group.len() * plants.len();
            let settings_length = settings.len();
            let settings = self.driver.upload(&settings)?;
            let out = self.driver.reserve(flights * W)?;
            let arguments = [
                Argument::Copied(&work.common),
                Argument::Words(&settings),
                number(settings_length)?,
                number(each)?,
                Argument::Words(&numbers),
                number(numbers_length)?,
                number(plants.len())?,
                Argument::Words(course),
                number(work.course.len())?,
                Argument::Words(&out),
                number(flights)?,
            ];
            let begun = Instant::now();
            self.driver.launch(kernel.name, &arguments, count(flights)?)?;
            if let Ok(mut busy) = self.busy.lock() {
                *busy += begun.elapsed();
            }
            let words = self.driver.download(&out)?;
            let (words, _) = words.as_chunks::<W>();
            if words.len() != flights {
                return Err(unsaid("it gave back fewer words than there are flights"));
            }
            sums.par_extend(words.par_iter().map(|words| (kernel.read)(*words)));
        }
        Ok(Some(sums))
    }
}

impl<D: Driver> Device for Card<D> {
    fn fly(&self, batch: &Batch<'_>, stop: &(dyn Fn() -> bool + Sync)) -> Option<Vec<Flown>> {
        if batch.controllers.is_empty() {
            return Some(Vec::new());
        }
        let flies = |settings: &Settings<f32>| !matches!(settings.controller.law, LawSettings::StateSpace(_));
        let work = if batch.controllers.iter().all(flies) {
            Work::of_batch(batch)
        } else {
            Err(unsaid("its kernels fly no state-space law"))
        };
        let usual = batch.controllers.iter().all(|controller| usual(*controller).is_some());
        let name = if usual { "robust_usual" } else { "robust_any" };
        self.run(&Kernel { name, read: robust::from_words }, work, stop)
    }

    fn integrals(&self, work: &Integrals<'_>, stop: &(dyn Fn() -> bool + Sync)) -> Option<Vec<Integrated>> {
        let name = match work.fidelity {
            Fidelity::Ideal => "integral_ideal",
            Fidelity::Rig => "integral_rig",
        };
        let plant = [Draw {
            plant: work.rig.plant,
            disturbance: PerMotor::zero(),
            encoder_phase: PerAxis::both(0.5),
        }];
        let words =
            self.run(&Kernel { name, read: |words| words }, Work::of_integrals(work, &plant), stop)?;
        let integrated = |words| {
            let (integral, first_lost, last_in_play) = integral::from_words(work.criterion, words);
            Integrated { integral, first_lost, last_in_play }
        };
        Some(words.into_iter().map(integrated).collect())
    }
}

/// A kernel that writes `W` words for each flight, and what they say.
struct Kernel<const W: usize, T> {
    name: &'static str,
    read: fn([u32; W]) -> T,
}

/// How much goes in a launch.
struct Part {
    plants: usize,
    controllers: usize,
}

impl Part {
    /// Into `free` bytes, of which a tenth is left alone, with so many words for each plant and each flight,
    /// at most `most` flights.
    fn fitting(
        free: usize,
        [plant, flight]: [usize; 2],
        most: usize,
        controllers: usize,
        plants: usize,
    ) -> Self {
        let words = free / 10 * 9 / size_of::<u32>();
        let fewest = FEWEST.min(plants);
        let here = plants.min(most).min((words / (plant + flight)).max(fewest));
        let left = words.saturating_sub(here * plant) / (here * flight);
        Self { plants: here, controllers: controllers.min(left.min(most / here)).max(1) }
    }
}

pub(super) fn unsaid(why: impl ToString) -> Fault {
    Fault::Lost(why.to_string())
}

fn count(number: usize) -> Result<u32, Fault> {
    u32::try_from(number).map_err(unsaid)
}

fn number<'a, M>(of: usize) -> Result<Argument<'a, M>, Fault> {
    count(of).map(Argument::Number)
}

/// Every controller in as many words as the longest needs, and how many that is.
fn padded(controllers: &[Vec<u32>]) -> (Vec<u32>, usize) {
    let each = controllers.iter().map(Vec::len).max().unwrap_or(0);
    let filled =
        |words: &Vec<u32>| words.iter().copied().chain(std::iter::repeat(0)).take(each).collect::<Vec<_>>();
    (controllers.iter().flat_map(filled).collect(), each)
}
