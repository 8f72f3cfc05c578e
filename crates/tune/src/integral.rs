//! What the tuner minimises: an integral of the tracking error over a flight, for many candidates at once.

use crate::optimise::{Candidate, Reached};
use crate::parallel::{self, Stop};
use crate::search::{Effort, Problem};
use crate::tunable::AtBound;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::Wear;
use twinrotor::controller::ControllerSettings;
use twinrotor::gains::{Gains, NAMES};
use twinrotor::law::LawSettings;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor_sim::closed_loop::{ClosedLoop, Hardware, IdealLoop, RigLoop};
use twinrotor_sim::device::{Device, Instant, Integrals, Integrated};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::integrated::{cost, has_lost, integrate, is_look};
use twinrotor_sim::lanes::{Kernel, LANES, gather, in_lanes};
use twinrotor_sim::metrics::Criterion;
use twinrotor_sim::scenario::{Now, SAMPLE_TIME, Scenario};

/// ISE, IAE or ITAE of the paper's law over one scenario, from rest.
#[derive(Debug)]
pub struct Objective {
    criterion: Criterion,
    rig: Rig,
    fidelity: Fidelity,
    references: Vec<Reference<f32>>,
    scenario: Scenario,
    befalls: Vec<Now>,
    device: Option<Arc<dyn Device>>,
    simulated: AtomicU64,
    skipped: AtomicU64,
    diverged: AtomicU64,
}

/// \[ticks\] From one question whether to stop to the next: milliseconds.
const ASK_EVERY: u32 = 4096;

impl Objective {
    /// For a rig, a scenario and a world; `seed` is of what is random in the scenario. Motors are cold,
    /// whatever the scenario says.
    pub fn new(criterion: Criterion, rig: &Rig, scenario: &Scenario, fidelity: Fidelity, seed: u64) -> Self {
        Self {
            criterion,
            rig: *rig,
            fidelity,
            references: scenario.references(),
            befalls: scenario.befalls(seed).take(scenario.last_tick() as usize + 1).collect(),
            scenario: scenario.clone(),
            device: None,
            simulated: AtomicU64::new(0),
            skipped: AtomicU64::new(0),
            diverged: AtomicU64::new(0),
        }
    }

    /// The controller that a position (the paper's order k1..k4) means.
    pub fn controller(position: &[f64]) -> GainsFile {
        let order: [f64; 4] = position.try_into().expect("four gains");
        GainsFile::backstepping(Gains::from_paper_order(order))
    }

    /// What was reached at `position`, of the paper's gains by their names.
    pub fn at_bounds(reached: &[Reached], position: &[f64]) -> Vec<AtBound> {
        let told = |r: &Reached| {
            let (name, value) = (NAMES.get(r.coordinate)?, position.get(r.coordinate)?);
            Some(AtBound { name: (*name).to_owned(), value: *value, side: r.side, bound: r.bound })
        };
        reached.iter().filter_map(told).collect()
    }

    /// The cost of one controller, all the way.
    pub fn cost(&self, controller: &GainsFile) -> f64 {
        let candidate = Candidate {
            position: controller.gains().expect("the paper's law").to_paper_order().to_vec(),
            bound: f64::INFINITY,
        };
        self.costs(&[candidate])[0]
    }

    fn costs_of_group(&self, candidates: &[Candidate], stop: Stop<'_>) -> Option<Vec<f64>> {
        let settings: Vec<Settings<f32>> = candidates
            .iter()
            .map(|c| Self::controller(&c.position).settings(&self.rig).map(f32::from_f64))
            .collect();
        let bounds: Vec<f64> = candidates.iter().map(|c| c.bound).collect();
        let flights = Flights { objective: self, settings: &settings, bounds: &bounds, stop };
        let (costs, ticks) = in_lanes(flights)?;
        Some(self.noted(costs, ticks))
    }

    /// The costs of a group that was flown for so many ticks, once that is counted.
    fn noted(&self, costs: Vec<f64>, ticks: usize) -> Vec<f64> {
        let lanes = costs.len() as u64;
        if ticks == self.references.len() {
            let diverged = costs.iter().filter(|c| c.is_infinite()).count() as u64;
            self.diverged.fetch_add(diverged, Ordering::Relaxed);
        }
        self.simulated.fetch_add(ticks as u64 * lanes, Ordering::Relaxed);
        self.skipped.fetch_add((self.references.len() - ticks) as u64 * lanes, Ordering::Relaxed);
        costs
    }

    /// The same, flown by `device`, as far as it can: what befalls more than volts, and worn hardware, is
    /// flown by this processor alone.
    #[must_use]
    pub fn on(self, device: Option<Arc<dyn Device>>) -> Self {
        let can = !self.scenario.is_more_than_volts()
            && self.befalls.iter().skip(1).all(|now| now.change.is_none())
            && self.scenario.hardware.wear() == Wear::default();
        Self { device: device.filter(|_| can), ..self }
    }

    /// All costs in one piece, and what of it each group of lanes would have been spared.
    fn costs_on(&self, device: &dyn Device, candidates: &[Candidate], stop: Stop<'_>) -> Option<Vec<f64>> {
        let settings =
            |c: &Candidate| (Self::controller(&c.position).settings(&self.rig).map(f32::from_f64), c.bound);
        let flying: Vec<_> = candidates.iter().map(settings).collect();
        let begin = &self.scenario.start;
        let work = Integrals {
            criterion: self.criterion,
            rig: &self.rig,
            fidelity: self.fidelity,
            start: State { angle: begin.angle(), rate: begin.rate() },
            rotors: begin.rotors(),
            course: &self.instants(),
            ticks: u32::try_from(self.references.len()).expect("an hour of ticks at most"),
            candidates: &flying,
        };
        let flown = device.integrals(&work, stop)?;
        let groups = candidates.chunks(LANES).zip(flown.chunks(LANES));
        let costs: Option<Vec<Vec<f64>>> = groups
            .map(|(candidates, flown)| match broken_off(flown) {
                Some(Some(tick)) => Some(self.noted(vec![f64::INFINITY; flown.len()], tick as usize + 1)),
                Some(None) => {
                    let costs = flown.iter().map(|one| finite(cost(&one.integral, 0)));
                    Some(self.noted(costs.collect(), self.references.len()))
                }
                None => self.costs_of_group(candidates, stop),
            })
            .collect();
        Some(costs?.into_iter().flatten().collect())
    }

    /// What happens, by its changes.
    fn instants(&self) -> Vec<Instant> {
        let mut list: Vec<Instant> = Vec::new();
        for (tick, (reference, now)) in (0..).zip(self.references.iter().zip(&self.befalls)) {
            let instant = Instant { tick, asked: *reference, volts: now.volts.cast() };
            // To the bit: a zero may change its sign.
            let same = |last: &Instant| bits(last) == bits(&instant);
            if !list.last().is_some_and(same) {
                list.push(instant);
            }
        }
        list
    }
}

/// In which tick a group of lanes with these flights would have been broken off, if in any: at the first look
/// in which all had lost. `None` where one came back into play after it had lost, by its sums' rounding.
fn broken_off(flown: &[Integrated]) -> Option<Option<u32>> {
    let mut latest = Some(0);
    for one in flown {
        let for_good = one.first_lost.filter(|first| one.last_in_play.is_none_or(|last| last < *first));
        if one.first_lost.is_some() && for_good.is_none() {
            return None;
        }
        latest = latest.zip(for_good).map(|(latest, tick)| tick.max(latest));
    }
    Some(latest)
}

impl Problem for Objective {
    /// Infinity for one that diverges or provably does not get below its bound.
    fn costs_until(&self, candidates: &[Candidate], stop: Stop<'_>) -> Option<Vec<f64>> {
        if let Some(device) = &self.device {
            return self.costs_on(&**device, candidates, stop);
        }
        parallel::by_group(candidates, LANES, |group| self.costs_of_group(group, stop))
    }

    fn effort(&self) -> Effort {
        Effort {
            simulated: self.simulated.load(Ordering::Relaxed),
            skipped: self.skipped.load(Ordering::Relaxed),
            diverged: self.diverged.load(Ordering::Relaxed),
        }
    }
}

/// Up to [`LANES`] candidates, each with the cost that it must get below.
#[derive(Clone, Copy)]
struct Flights<'a> {
    objective: &'a Objective,
    settings: &'a [Settings<f32>],
    bounds: &'a [f64],
    stop: Stop<'a>,
}

impl Kernel for Flights<'_> {
    /// The costs, and the ticks that were flown.
    type Output = Option<(Vec<f64>, usize)>;
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) -> Self::Output {
        let settings = paper_settings(gather::<R>(self.settings));
        let Objective { rig, scenario, .. } = self.objective;
        let begin = &scenario.start;
        let start = State { angle: begin.angle().cast(), rate: begin.rate().cast() };
        match self.objective.fidelity {
            Fidelity::Ideal => self.integrate(IdealLoop::new(rig, &settings, start, SAMPLE_TIME)),
            Fidelity::Rig => {
                let mut plant = RealPlant::new(&rig.plant, start, SAMPLE_TIME);
                plant.set_rotors(begin.rotors().cast());
                let sound = Hardware::of(rig, PerAxis::both(0.5));
                let hardware = Hardware { wear: scenario.hardware.wear(), ..sound };
                self.integrate(RigLoop::new(plant, &hardware, &settings))
            }
        }
    }
}

/// The same with nothing but the paper's law, as far as the compiler knows: it leaves out what else there
/// could be.
#[inline(always)]
fn paper_settings<R: Real>(settings: Settings<R>) -> Settings<R> {
    let LawSettings::Backstepping(gains) = settings.controller.law else {
        unreachable!("candidates are gains of the paper's law")
    };
    Settings { controller: ControllerSettings::paper(gains), ..settings }
}

impl Flights<'_> {
    /// Flies to the end, or until every candidate has lost or nobody waits for it.
    #[inline(always)]
    fn integrate<R: Real<Scalar = f32>, L: ClosedLoop<R>>(
        &self,
        closed_loop: L,
    ) -> Option<(Vec<f64>, usize)> {
        let Self { objective, bounds, stop, .. } = *self;
        let Objective { references, befalls, criterion, scenario, .. } = objective;
        let more_than_volts = scenario.is_more_than_volts();
        let ticks = u32::try_from(references.len()).expect("an hour of ticks at most");
        let (mut nobody_waits, mut all_lost) = (false, false);
        // The closures' attributes count: one that is not inlined is compiled for the plainest processor.
        let (integral, flown) = integrate(
            closed_loop,
            *criterion,
            ticks,
            #[inline(always)]
            |tick, closed_loop: &mut L| {
                let (reference, now) = (&references[tick as usize], &befalls[tick as usize]);
                if more_than_volts {
                    closed_loop.befall(now);
                }
                if let Some(change) = &now.change {
                    closed_loop.become_plant(&change.of(&objective.rig.plant).map(R::from_f64));
                }
                (*reference, now.volts.cast())
            },
            #[inline(always)]
            |tick, integral| {
                nobody_waits = tick % ASK_EVERY == 0 && stop();
                all_lost = is_look(tick)
                    && bounds.iter().enumerate().all(|(lane, bound)| has_lost(integral, lane, *bound));
                !(nobody_waits || all_lost)
            },
        );
        if nobody_waits {
            return None;
        }
        if all_lost {
            return Some((vec![f64::INFINITY; bounds.len()], flown as usize));
        }
        Some(((0..bounds.len()).map(|lane| finite(cost(&integral, lane))).collect(), references.len()))
    }
}

fn bits(instant: &Instant) -> ([PerAxis<u32>; 3], PerMotor<u32>) {
    let Reference { angle, rate, accel } = instant.asked;
    ([angle, rate, accel].map(|x| x.map(f32::to_bits)), instant.volts.map(f32::to_bits))
}

/// A flight that diverges costs infinity.
fn finite(cost: f64) -> f64 {
    if cost.is_nan() { f64::INFINITY } else { cost }
}
