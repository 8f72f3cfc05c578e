//! What is measured of a flight, tick by tick, for any [`Real`]: the same sums in the same order for one run,
//! for every lane and for the tuner, so that a cost is the same bits wherever it is computed.

mod report;
mod response;

pub use report::{AxisReport, MotorReport, Report};
pub use response::{Overshoot, Settling, Step};

use crate::closed_loop::Tick;
use response::Response;
use serde::{Deserialize, Serialize};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::compensated::Compensated;
use twinrotor::real::Real;

/// An integral of the tracking error over a flight, each axis on its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Criterion {
    /// ∫ e² dt \[rad² s\]: eq. (30), the paper's ISξ.
    Ise,
    /// ∫ |e| dt \[rad s\].
    Iae,
    /// ∫ t |e| dt \[rad s²\].
    Itae,
}

/// The running sum of one [`Criterion`], by the trapezoid rule over ticks.
#[derive(Debug, Clone, Copy)]
pub struct Integral<R> {
    criterion: Criterion,
    sum: PerAxis<Compensated<R>>,
}

impl Criterion {
    /// What is summed up of an error.
    #[inline(always)]
    fn integrand<R: Real>(self, weight: R, error: R) -> R {
        match self {
            Self::Ise => weight * (error * error),
            Self::Iae | Self::Itae => weight * error.abs(),
        }
    }
}

impl<R: Real> Integral<R> {
    /// Nothing yet.
    pub fn new(criterion: Criterion) -> Self {
        Self { criterion, sum: PerAxis::both(Compensated::new(R::zero())) }
    }

    /// Adds the error \[rad\] at `tick` of `last` + 1. The first and the last count half.
    #[inline(always)]
    pub fn add(&mut self, tick: u32, last: u32, error: PerAxis<R>) {
        let weight = if tick == 0 || tick == last { 0.5 } else { 1.0 };
        let weight = match self.criterion {
            Criterion::Itae => weight * f64::from(tick),
            Criterion::Ise | Criterion::Iae => weight,
        };
        let weight = R::from_f64(weight);
        self.sum.pitch.add(self.criterion.integrand(weight, error.pitch));
        self.sum.yaw.add(self.criterion.integrand(weight, error.yaw));
    }

    /// The sums so far, as they are kept.
    #[inline(always)]
    pub fn sums(&self) -> PerAxis<Compensated<R>> {
        self.sum
    }

    /// One whose sums have come so far.
    pub fn with(self, sum: PerAxis<Compensated<R>>) -> Self {
        Self { sum, ..self }
    }

    /// The integral so far on each axis, in the lane, for ticks of `sample_time` \[s\].
    pub fn value(&self, lane: usize, sample_time: f64) -> PerAxis<f64> {
        let unit = match self.criterion {
            Criterion::Itae => sample_time * sample_time,
            Criterion::Ise | Criterion::Iae => sample_time,
        };
        self.sum.map(|s| {
            let (value, excess) = (s.value().lane(lane), s.excess().lane(lane));
            let (value, excess): (f64, f64) = (value.into(), excess.into());
            (value - excess) * unit
        })
    }
}

/// How hard one motor was worked.
#[derive(Debug, Clone, Copy)]
struct Effort<R> {
    limit: R,
    saturated: R,
    peak_demand: R,
    peak_volts: R,
    volts: R,
    variation: Compensated<R>,
}

impl<R: Real> Effort<R> {
    fn new(limit: R) -> Self {
        let (saturated, peak_demand, peak_volts, volts) = (R::zero(), R::zero(), R::zero(), R::zero());
        Self { limit, saturated, peak_demand, peak_volts, volts, variation: Compensated::new(R::zero()) }
    }

    #[inline(always)]
    fn add(&mut self, tick: u32, demand: R, volts: R) {
        if tick > 0 {
            self.variation.add((volts - self.volts).abs());
        }
        self.volts = volts;
        let over = self.limit.lt(demand.abs());
        self.saturated = self.saturated + R::select(over, R::one(), R::zero());
        self.peak_demand = self.peak_demand.max(demand.abs());
        self.peak_volts = self.peak_volts.max(volts.abs());
    }

    fn report(&self, lane: usize, last: u32, sample_time: f64) -> MotorReport {
        let of = |x: R| -> f64 { x.lane(lane).into() };
        let time = f64::from(last.max(1)) * sample_time;
        MotorReport {
            saturation_time: of(self.saturated) * sample_time,
            saturation_percent: 100.0 * of(self.saturated) / (f64::from(last) + 1.0),
            voltage_variation: (of(self.variation.value()) - of(self.variation.excess())) / time,
            peak_demand: of(self.peak_demand),
            peak_volts: of(self.peak_volts),
        }
    }
}

/// Everything that `simulate` reports of a flight.
#[derive(Debug, Clone, Copy)]
pub struct Metrics<R> {
    last: u32,
    integrals: [Integral<R>; 3],
    response: PerAxis<Response<R>>,
    effort: PerMotor<Effort<R>>,
}

impl<R: Real> Metrics<R> {
    /// Of a flight of `last` + 1 ticks with these steps and voltage limits \[V\].
    pub fn new(last: u32, steps: PerAxis<Option<Step>>, limit: PerMotor<R>) -> Self {
        Self {
            last,
            integrals: [Criterion::Ise, Criterion::Iae, Criterion::Itae].map(Integral::new),
            response: steps.map(Response::new),
            effort: limit.map(Effort::new),
        }
    }

    /// Takes a tick.
    #[inline(always)]
    pub fn add(&mut self, tick: u32, happened: &Tick<R>) {
        let error = happened.error();
        for integral in &mut self.integrals {
            integral.add(tick, self.last, error);
        }
        self.response.pitch.add(tick, error.pitch);
        self.response.yaw.add(tick, error.yaw);
        let demand = happened.decision.allocation.demand;
        self.effort.main.add(tick, demand.main, happened.applied.main);
        self.effort.tail.add(tick, demand.tail, happened.applied.tail);
    }

    /// What it came to in a lane, for ticks of `sample_time` \[s\].
    pub fn report(&self, lane: usize, sample_time: f64) -> Report {
        let [ise, iae, itae] = self.integrals.map(|i| i.value(lane, sample_time));
        let axis = |r: &Response<R>, integrals| r.report(lane, self.last, sample_time, integrals);
        Report {
            pitch: axis(&self.response.pitch, [ise.pitch, iae.pitch, itae.pitch]),
            yaw: axis(&self.response.yaw, [ise.yaw, iae.yaw, itae.yaw]),
            main: self.effort.main.report(lane, self.last, sample_time),
            tail: self.effort.tail.report(lane, self.last, sample_time),
        }
    }
}
