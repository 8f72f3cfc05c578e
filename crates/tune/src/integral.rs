//! What the tuner minimises: an integral of the tracking error over a flight, for many candidates at once.

use crate::optimise::Candidate;
use crate::parallel::{self, Stop};
use crate::search::{Effort, Problem};
use std::sync::atomic::{AtomicU64, Ordering};
use twinrotor::axes::PerAxis;
use twinrotor::controller::ControllerSettings;
use twinrotor::gains::Gains;
use twinrotor::law::LawSettings;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor_sim::closed_loop::{ClosedLoop, Hardware, IdealLoop, RigLoop};
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::lanes::{Kernel, LANES, gather, in_lanes};
use twinrotor_sim::metrics::{Criterion, Integral};
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
    simulated: AtomicU64,
    skipped: AtomicU64,
    diverged: AtomicU64,
}

/// A cost must exceed its bound by this part before a flight is broken off. A compensated sum of terms that
/// are not negative can sink by a few units in its last place, 1e-7 of it, and not more.
const SURELY: f64 = 1.0 + 1e-6;
/// \[ticks\] From one look at the sums to the next.
const LOOK_EVERY: u32 = 64;
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
        let lanes = candidates.len() as u64;
        if ticks == self.references.len() {
            let diverged = costs.iter().filter(|c| c.is_infinite()).count() as u64;
            self.diverged.fetch_add(diverged, Ordering::Relaxed);
        }
        self.simulated.fetch_add(ticks as u64 * lanes, Ordering::Relaxed);
        self.skipped.fetch_add((self.references.len() - ticks) as u64 * lanes, Ordering::Relaxed);
        Some(costs)
    }
}

impl Problem for Objective {
    /// Infinity for one that diverges or provably does not get below its bound.
    fn costs_until(&self, candidates: &[Candidate], stop: Stop<'_>) -> Option<Vec<f64>> {
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
    fn integrate<R: Real<Scalar = f32>>(
        &self,
        mut closed_loop: impl ClosedLoop<R>,
    ) -> Option<(Vec<f64>, usize)> {
        let Self { objective, bounds, stop, .. } = *self;
        let Objective { references, befalls, criterion, scenario, .. } = objective;
        let more_than_volts = scenario.is_more_than_volts();
        let last = u32::try_from(references.len() - 1).expect("an hour of ticks at most");
        let mut integral = Integral::<R>::new(*criterion);
        let cost = |integral: &Integral<R>, lane| {
            let PerAxis { pitch, yaw } = integral.value(lane, SAMPLE_TIME);
            pitch + yaw
        };
        for (tick, (reference, now)) in (0..).zip(references.iter().zip(befalls)) {
            if more_than_volts {
                closed_loop.befall(now);
            }
            if let Some(change) = &now.change {
                closed_loop.become_plant(&change.of(&objective.rig.plant).map(R::from_f64));
            }
            let happened = closed_loop.tick(&Reference::splat(reference), now.volts.cast());
            integral.add(tick, last, happened.error());
            if tick % ASK_EVERY == 0 && stop() {
                return None;
            }
            if tick % LOOK_EVERY == LOOK_EVERY - 1
                && bounds.iter().enumerate().all(|(lane, bound)| cost(&integral, lane) > bound * SURELY)
            {
                return Some((vec![f64::INFINITY; bounds.len()], tick as usize + 1));
            }
        }
        let costs = (0..bounds.len()).map(|lane| cost(&integral, lane));
        let finite = costs.map(|c| if c.is_nan() { f64::INFINITY } else { c });
        Some((finite.collect(), references.len()))
    }
}
