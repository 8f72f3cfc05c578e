//! What is measured of a flight, tick by tick, for any [`Real`]: the same sums in the same order for one run,
//! for every lane and for the tuner, so that a cost is the same bits wherever it is computed.

use crate::closed_loop::Tick;
use serde::{Deserialize, Serialize};
#[cfg(feature = "std")]
use std::fmt;
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

/// The step in an axis' reference that its response is judged by: the last one of the flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The first tick with the new reference.
    pub tick: u32,
    /// \[rad\] Before.
    pub from: f64,
    /// \[rad\] After; other than `from`.
    pub to: f64,
}

/// Settling bands, as parts of the step.
const BANDS: [f64; 2] = [0.02, 0.05];

/// How far an axis went beyond its goal.
#[derive(Debug, Clone, Copy)]
pub struct Overshoot<R> {
    /// 1 for a step upwards, -1 for one downwards.
    direction: R,
    /// \[rad\]
    pub most: R,
}

impl<R: Real> Overshoot<R> {
    /// Of a step whose sign is that of `step`.
    pub fn new(step: f64) -> Self {
        Self { direction: R::from_f64(step.signum()), most: R::zero() }
    }

    /// Takes an error \[rad\]: beyond a goal that lies upwards it is negative.
    #[inline(always)]
    pub fn add(&mut self, error: R) {
        self.most = self.most.max(-error * self.direction);
    }
}

/// When an error was last outside a band, to a part of a tick: between the last tick outside and the next one
/// the error is taken to be straight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settling<R> {
    /// From 0 to this, the unit of the error.
    band: R,
    /// \[ticks\] The last one outside; -1 for none.
    last: R,
    /// The size of the error then, and a tick later.
    error: [R; 2],
    was_outside: R,
}

impl<R: Real> Settling<R> {
    /// Of a band from 0 to `band`; never outside yet.
    pub fn new(band: R) -> Self {
        Self { band, last: R::from_f64(-1.0), error: [R::zero(); 2], was_outside: R::zero() }
    }

    /// Takes the size of the error at a tick, counted from 0.
    #[inline(always)]
    pub fn add(&mut self, tick: R, size: R) {
        let outside = self.band.lt(size);
        let entering = !outside & R::zero().lt(self.was_outside);
        self.last = R::select(outside, tick, self.last);
        self.error[0] = R::select(outside, size, self.error[0]);
        self.error[1] = R::select(entering, size, self.error[1]);
        self.was_outside = R::select(outside, R::one(), R::zero());
    }

    /// \[ticks\] When the error of a lane came in for good, 0 if it never was outside; `None` if it was still
    /// outside at the last of all ticks, `last`.
    pub fn time(&self, lane: usize, last: u32) -> Option<f64> {
        let of = |x: R| -> f64 { x.lane(lane).into() };
        let outside = of(self.last);
        if outside < 0.0 {
            return Some(0.0);
        }
        let [before, after] = self.error.map(of);
        (outside < f64::from(last)).then(|| outside + (before - of(self.band)) / (before - after))
    }
}

impl<R: Real<Scalar = f32>> Settling<R> {
    /// That of one lane.
    pub fn lane(&self, lane: usize) -> Settling<f32> {
        let of = |x: R| x.lane(lane);
        let Self { band, last, error, was_outside } = *self;
        Settling { band: of(band), last: of(last), error: error.map(of), was_outside: of(was_outside) }
    }
}

impl Settling<f32> {
    /// All that it is, to be carried elsewhere.
    pub const fn numbers(&self) -> [f32; 5] {
        let Self { band, last, error: [before, after], was_outside } = *self;
        [band, last, before, after, was_outside]
    }

    /// The other way round.
    pub const fn of_numbers([band, last, before, after, was_outside]: [f32; 5]) -> Self {
        Self { band, last, error: [before, after], was_outside }
    }
}

/// Settling and overshoot of one axis.
#[derive(Debug, Clone, Copy)]
struct Response<R> {
    step: Option<Step>,
    settling: [Settling<R>; 2],
    overshoot: Overshoot<R>,
    final_error: R,
}

impl<R: Real> Response<R> {
    fn new(step: Option<Step>) -> Self {
        let size = step.map_or(0.0, |s| (s.to - s.from).abs());
        Self {
            step,
            settling: BANDS.map(|band| Settling::new(R::from_f64(band * size))),
            overshoot: Overshoot::new(step.map_or(0.0, |s| s.to - s.from)),
            final_error: R::zero(),
        }
    }

    #[inline(always)]
    fn add(&mut self, tick: u32, error: R) {
        self.final_error = error;
        let Some(step) = self.step else { return };
        if tick < step.tick {
            return;
        }
        let now = R::from_f64(f64::from(tick - step.tick));
        let magnitude = error.abs();
        for settling in &mut self.settling {
            settling.add(now, magnitude);
        }
        self.overshoot.add(error);
    }

    fn report(&self, lane: usize, last: u32, sample_time: f64, integrals: [f64; 3]) -> AxisReport {
        // A flight may have been ended before its last step.
        let step = self.step.filter(|step| step.tick <= last);
        let settled = |band: usize| {
            let ticks = self.settling[band].time(lane, last - step?.tick)?;
            Some(ticks * sample_time)
        };
        let overshoot: f64 = self.overshoot.most.lane(lane).into();
        let final_error: f64 = self.final_error.lane(lane).into();
        AxisReport {
            settling_time_2: settled(0),
            settling_time_5: settled(1),
            // Adding zero makes a negative zero positive.
            overshoot_percent: step.map(|s| 100.0 * overshoot / (s.to - s.from).abs() + 0.0),
            final_error_deg: final_error.to_degrees(),
            ise: integrals[0],
            iae: integrals[1],
            itae: integrals[2],
        }
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

/// A flight in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Report {
    /// Pitch.
    pub pitch: AxisReport,
    /// Yaw.
    pub yaw: AxisReport,
    /// Main motor.
    pub main: MotorReport,
    /// Tail motor.
    pub tail: MotorReport,
}

impl Report {
    /// The paper's objective, both axes together.
    pub fn ise(&self) -> f64 {
        self.integral(Criterion::Ise)
    }

    /// Any of the three, both axes together.
    pub fn integral(&self, criterion: Criterion) -> f64 {
        self.pitch.integral(criterion) + self.yaw.integral(criterion)
    }
}

/// One axis in numbers. What needs a step in the reference is `None` without one, or when it never settles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AxisReport {
    /// \[s\] From the last step to when the error came within 2 % of it for good.
    pub settling_time_2: Option<f64>,
    /// \[s\] The same at 5 %.
    pub settling_time_5: Option<f64>,
    /// \[%\] Of the step, beyond the goal.
    pub overshoot_percent: Option<f64>,
    /// \[deg\] Reference minus angle at the end.
    pub final_error_deg: f64,
    /// \[rad² s\] ∫ e² dt.
    pub ise: f64,
    /// \[rad s\] ∫ |e| dt.
    pub iae: f64,
    /// \[rad s²\] ∫ t |e| dt.
    pub itae: f64,
}

impl AxisReport {
    const fn integral(&self, criterion: Criterion) -> f64 {
        match criterion {
            Criterion::Ise => self.ise,
            Criterion::Iae => self.iae,
            Criterion::Itae => self.itae,
        }
    }
}

/// One motor in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MotorReport {
    /// \[s\] For how long more was asked of it than its limit.
    pub saturation_time: f64,
    /// \[%\] The same, of the flight.
    pub saturation_percent: f64,
    /// \[V/s\] Σ|ΔV| a second of what was applied, over the whole flight: how much it chatters.
    pub voltage_variation: f64,
    /// \[V\] Most that was asked.
    pub peak_demand: f64,
    /// \[V\] Most that was applied.
    pub peak_volts: f64,
}

/// Two tables in plain text: the axes, and the motors.
#[cfg(feature = "std")]
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut row =
            |name: &str, [first, second]: [String; 2]| writeln!(f, "{name:<30} {first:>12} {second:>12}");
        let seconds = |time: Option<f64>| time.map_or_else(|| "never".to_owned(), |t| format!("{t:.3}"));
        // Without a step there is nothing to settle on and nothing to shoot over.
        let of_step = |axis: &AxisReport, text: String| match axis.overshoot_percent {
            Some(_) => text,
            None => "–".to_owned(),
        };
        let axes = [&self.pitch, &self.yaw];
        row("", ["pitch", "yaw"].map(str::to_owned))?;
        row("settling 2 % [s]", axes.map(|a| of_step(a, seconds(a.settling_time_2))))?;
        row("settling 5 % [s]", axes.map(|a| of_step(a, seconds(a.settling_time_5))))?;
        row("overshoot [%]", axes.map(|a| of_step(a, format!("{:.2}", a.overshoot_percent.unwrap_or(0.0)))))?;
        // Adding zero makes a negative zero positive.
        row("final error [°]", axes.map(|a| format!("{:.5}", a.final_error_deg + 0.0)))?;
        row("ISE [rad² s]", axes.map(|a| format!("{:.6}", a.ise)))?;
        row("IAE [rad s]", axes.map(|a| format!("{:.6}", a.iae)))?;
        row("ITAE [rad s²]", axes.map(|a| format!("{:.6}", a.itae)))?;
        let motors = [&self.main, &self.tail];
        row("", ["main motor", "tail motor"].map(str::to_owned))?;
        row("asked beyond its limit [ms]", motors.map(|m| format!("{:.0}", 1e3 * m.saturation_time)))?;
        row("the same, of the flight [%]", motors.map(|m| format!("{:.1}", m.saturation_percent)))?;
        row("voltage variation [V/s]", motors.map(|m| format!("{:.1}", m.voltage_variation)))?;
        row("peak demand [V]", motors.map(|m| format!("{:.2}", m.peak_demand)))?;
        row("peak volts [V]", motors.map(|m| format!("{:.2}", m.peak_volts)))
    }
}
