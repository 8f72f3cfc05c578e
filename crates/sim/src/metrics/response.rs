//! How an axis answers a step: settling and overshoot.

use super::AxisReport;
use twinrotor::real::Real;

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
        Self::towards(R::from_f64(step.signum()))
    }

    /// Of a step upwards for a `direction` of 1, downwards for -1.
    pub fn towards(direction: R) -> Self {
        Self { direction, most: R::zero() }
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
pub(super) struct Response<R> {
    step: Option<Step>,
    settling: [Settling<R>; 2],
    overshoot: Overshoot<R>,
    final_error: R,
}

impl<R: Real> Response<R> {
    pub(super) fn new(step: Option<Step>) -> Self {
        let size = step.map_or(0.0, |s| (s.to - s.from).abs());
        Self {
            step,
            settling: BANDS.map(|band| Settling::new(R::from_f64(band * size))),
            overshoot: Overshoot::new(step.map_or(0.0, |s| s.to - s.from)),
            final_error: R::zero(),
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, tick: u32, error: R) {
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

    pub(super) fn report(&self, lane: usize, last: u32, sample_time: f64, integrals: [f64; 3]) -> AxisReport {
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
