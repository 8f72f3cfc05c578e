//! Logs cut into windows, each simulated from an initial state of its own.
//!
//! Over a whole run a small error in a constant grows into a large one in yaw, which nothing pulls back; over
//! a window it stays in proportion. A window's initial angles and rates are not known, so they are estimated
//! with the rest, and projected out ([`super::problem`]). The volts in effect are known from the volts sent:
//! they follow exactly from the lag.

use super::smooth::{Smoothed, smooth};
use crate::log::Log;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::plant::{LaggedRotors, Plant, PlantParameters, RealPlant, State, Thrust, decay};

/// A log made ready for simulation.
#[derive(Debug, Clone)]
pub struct Run {
    /// As it was read.
    pub log: Log,
    /// \[rad\] By how much residuals of each axis are divided: the angle's standard deviation over the log.
    pub scale: PerAxis<f64>,
    /// Which axes are compared: a locked one is not, and does not turn.
    pub moves: PerAxis<bool>,
    smoothed: PerAxis<Vec<Smoothed>>,
}

/// Rows of one run that are simulated together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Which run.
    pub run: usize,
    /// First row.
    pub first: usize,
    /// Rows, the first included.
    pub rows: usize,
    /// The row where its stretch without gaps begins: from there the rotors are followed.
    stretch: usize,
}

/// \[s\] Reach of the polynomials that initial states are first guessed by.
const GUESS_REACH: f64 = 0.06;
/// \[s\] Longest step of the integrator.
const LONGEST_STEP: f64 = 2.5e-3;
/// \[rad\] Least scale of residuals: an axis that hardly moves must not weigh more than one that does.
const LEAST_SCALE: f64 = 0.03;
/// \[s\] A rotor's lag, as good as is needed to see where rotors are calm.
const USUAL_LAG: f64 = 0.15;
/// \[kg m²\] A locked axis is one that nothing can turn.
const LOCKED: f64 = 1e9;

/// How many rows a window of `length` \[s\] has.
fn rows(length: f64, sample_time: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a positive number of rows")]
    let rows = (length / sample_time).round() as usize;
    rows.max(2)
}

impl Run {
    /// Smooths the angles and finds the scales.
    pub fn new(log: Log) -> Self {
        let smoothed = |of: fn(&PerAxis<f64>) -> f64| -> Vec<Smoothed> {
            let part = |stretch: &std::ops::Range<usize>| {
                let samples: Vec<f64> = log.angle[stretch.clone()].iter().map(of).collect();
                if samples.len() < 8 {
                    return samples.iter().map(|angle| Smoothed { angle: *angle, rate: 0.0 }).collect();
                }
                smooth(&samples, log.sample_time, GUESS_REACH)
            };
            log.stretches.iter().flat_map(part).collect()
        };
        let smoothed = PerAxis { pitch: smoothed(|a| a.pitch), yaw: smoothed(|a| a.yaw) };
        let scale = log.spread().map(|s| s.max(LEAST_SCALE));
        let moves = log.moves();
        Self { log, scale, moves, smoothed }
    }

    /// Windows of `length` \[s\], one after the other; what is left at the end of a stretch counts if it is
    /// at least half as long.
    pub fn windows(&self, run: usize, length: f64) -> Vec<Window> {
        let rows = rows(length, self.log.sample_time);
        let mut windows = Vec::new();
        for stretch in &self.log.stretches {
            let mut first = stretch.start;
            while stretch.end - first >= rows.div_ceil(2).max(2) {
                let rows = rows.min(stretch.end - first);
                windows.push(Window { run, first, rows, stretch: stretch.start });
                first += rows;
            }
        }
        windows
    }

    /// Windows of about `length` \[s\] to fit constants to: all rows of a stretch, cut near every `length`
    /// where the rotors are calmest.
    ///
    /// A window that begins as the volts jump explains the kick of the rotors by its initial rate, which is
    /// free, and so hides the reaction torque from the fit. Cuts move by up to a quarter of a window, so
    /// windows are half to one and a half as long.
    pub fn calm_windows(&self, run: usize, length: f64) -> Vec<Window> {
        let rows = rows(length, self.log.sample_time);
        let reach = rows / 4;
        let unrest = self.unrest();
        let around = |row: usize, stretch: &std::ops::Range<usize>| {
            unrest[(row + reach).min(stretch.end)] - unrest[row.saturating_sub(reach).max(stretch.start)]
        };
        let mut windows = Vec::new();
        for stretch in &self.log.stretches {
            let stretch_rows = stretch.len();
            // Rounded to the nearest: what is left at the end belongs to the last window or is one of its
            // own.
            let parts = ((2 * stretch_rows + rows) / (2 * rows)).max(usize::from(2 * stretch_rows >= rows));
            let mut first = stretch.start;
            for k in 1..=parts {
                let wanted = stretch.start + k * rows;
                let cut = if k == parts {
                    stretch.end
                } else {
                    let nearest = |row: &usize| row.abs_diff(wanted);
                    (wanted - reach..=(wanted + reach).min(stretch.end))
                        .min_by(|a, b| {
                            around(*a, stretch)
                                .total_cmp(&around(*b, stretch))
                                .then(nearest(a).cmp(&nearest(b)))
                        })
                        .unwrap_or(wanted)
                };
                windows.push(Window { run, first, rows: cut - first, stretch: stretch.start });
                first = cut;
            }
        }
        windows
    }

    /// \[V\] Summed over all rows before each: how far the volts sent are from those in effect, at a lag as
    /// these rigs have it.
    fn unrest(&self) -> Vec<f64> {
        let keep = decay(self.log.sample_time, USUAL_LAG);
        let mut sum = 0.0;
        let mut all = Vec::with_capacity(self.log.volts.len() + 1);
        all.push(sum);
        for stretch in &self.log.stretches {
            let mut acting = self.log.volts[stretch.start];
            for volts in &self.log.volts[stretch.clone()] {
                let missing = volts.minus(acting);
                sum += missing.main.abs() + missing.tail.abs();
                all.push(sum);
                acting = volts.minus(missing.scaled(keep));
            }
        }
        all
    }

    /// Does anything happen in a window? Where the rig lies still with its motors off there is nothing to
    /// learn.
    pub fn is_alive(&self, window: &Window) -> bool {
        let rows = window.first..window.first + window.rows;
        let begin = self.log.angle[window.first];
        self.log.volts[rows.clone()].iter().any(|v| v.main != 0.0 || v.tail != 0.0)
            || self.log.angle[rows].iter().any(|a| *a != begin)
    }

    /// A first guess of the state at a row.
    pub fn guess(&self, row: usize) -> State<f64> {
        let at = |s: &Vec<Smoothed>| s[row];
        let (pitch, yaw) = (at(&self.smoothed.pitch), at(&self.smoothed.yaw));
        State { angle: PerAxis::new(pitch.angle, yaw.angle), rate: PerAxis::new(pitch.rate, yaw.rate) }
    }

    /// \[V\] In effect where each window of this run begins. Where a stretch begins, the rotors are taken to
    /// have settled.
    pub fn rotor_volts(&self, windows: &[Window], lag: PerMotor<f64>) -> Vec<PerMotor<f64>> {
        let keep = lag.map(|tau| decay(self.log.sample_time, tau));
        let volts = &self.log.volts;
        let mut found = Vec::with_capacity(windows.len());
        let mut at = (usize::MAX, 0, PerMotor::zero());
        for window in windows {
            if at.0 != window.stretch {
                at = (window.stretch, window.stretch, volts[window.stretch]);
            }
            let (_, mut row, mut acting) = at;
            while row < window.first {
                acting = volts[row].plus(acting.minus(volts[row]).zip(keep, |m, k| m * k));
                row += 1;
            }
            at = (window.stretch, row, acting);
            found.push(acting);
        }
        found
    }

    /// Simulates a window from `start` (true angles) with these volts in effect, and shows every `stride`-th
    /// row's true angles.
    pub fn simulate(
        &self,
        window: &Window,
        plant: &PlantParameters<f64>,
        start: State<f64>,
        rotor_volts: PerMotor<f64>,
        stride: usize,
        mut seen: impl FnMut(usize, PerAxis<f64>),
    ) {
        let log = &self.log;
        let parts = (log.sample_time / LONGEST_STEP).ceil().max(1.0);
        let step = log.sample_time / parts;
        let mut plant = *plant;
        if !self.moves.pitch {
            plant.inertia.pitch = LOCKED;
        }
        if !self.moves.yaw {
            plant.inertia.yaw = LOCKED;
        }
        let mut rotors = LaggedRotors::new(&plant, step);
        rotors.volts = rotor_volts;
        let mut body: RealPlant<f64> = Plant::assemble(plant, rotors, start, step);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small positive number"
        )]
        let parts = parts as usize;
        for k in 0..window.rows {
            if k % stride == 0 {
                seen(window.first + k, body.state().angle);
            }
            for _ in 0..parts {
                body.advance(log.volts[window.first + k], PerMotor::zero());
            }
        }
    }
}
