//! When rows were taken: an even clock is kept, an uneven one is brought to even steps, by the time of each
//! row and never by its number.

use super::Rows;
use std::ops::Range;
use twinrotor::axes::PerMotor;

/// \[s\] Sample times outside of this are of no use, or no seconds.
const SAMPLE_TIMES: [f64; 2] = [1e-4, 0.1];
/// \[s\] A usual sample time: which unit a column of times is in is told by what comes nearest.
const USUAL: f64 = 5e-3;
/// In sample times: a step this long is a gap whatever it is in seconds, one longer than the second is a gap
/// unless it is shorter than [`BRIDGED`].
const GAPS: [f64; 2] = [3.5, 1.5];
/// \[s\] Over a step as short as this an angle runs straight to less than a count.
const BRIDGED: f64 = 0.03;
/// More gaps than this part of all steps is a log that is not sampled at all regularly.
const MOST_GAPS: f64 = 0.01;
/// Part of a sample time by which the rows of an even clock may be off their places.
const EVEN: f64 = 0.02;

/// Even steps, and what was done for them.
pub(super) struct Clock {
    /// \[s\] From row to row.
    pub(super) sample_time: f64,
    /// Rows between gaps.
    pub(super) stretches: Vec<Range<usize>>,
    /// What was found.
    pub(super) notes: Vec<String>,
}

/// Brings `rows` to even steps.
pub(super) fn even_out(rows: &mut Rows) -> Result<Clock, String> {
    let steps: Vec<f64> = rows.time.windows(2).map(|t| t[1] - t[0]).collect();
    let median = median(&steps);
    let stretches = stretches(&rows.time, gap(median));
    let gaps = stretches.len() - 1;
    let (least, most) = steps.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), s| (a.min(*s), b.max(*s)));
    if gaps as f64 > MOST_GAPS * steps.len() as f64 {
        return Err(format!(
            "t: rows are {least:.6} to {most:.6} s apart, half of them within {median:.6} s, with {gaps} \
             gaps \
             in {} rows: not sampled evenly; allowed: at most {} % of steps longer than {:.6} s",
            rows.time.len(),
            100.0 * MOST_GAPS,
            gap(median)
        ));
    }
    let mut notes = Vec::new();
    if gaps > 0 {
        let lost: f64 = stretches.windows(2).map(|s| rows.time[s[1].start] - rows.time[s[0].end - 1]).sum();
        let longest = stretches.iter().map(|s| rows.time[s.end - 1] - rows.time[s.start]).fold(0.0, f64::max);
        notes.push(format!(
            "{gaps} gaps, {lost:.3} s in all; no window reaches across one, and the longest stretch without \
             one lasts {longest:.3} s of {:.3} s",
            rows.time.last().copied().unwrap_or(0.0)
        ));
    }
    let inside: f64 = stretches.iter().map(|s| rows.time[s.end - 1] - rows.time[s.start]).sum();
    let count: usize = stretches.iter().map(|s| s.len() - 1).sum();
    let mean = if count > 0 { inside / count as f64 } else { median };
    if stretches.iter().all(|s| is_even(&rows.time[s.clone()], mean)) {
        return Ok(Clock { sample_time: round_if_equal(mean, rows.time.len()), stretches, notes });
    }
    let step = (1e6 * mean).round() / 1e6;
    notes.push(format!(
        "t: rows are {:.3} to {:.3} ms apart, {:.3} ms on average: resampled every {:.3} ms by their own \
         times, volts averaged over each step",
        1e3 * least,
        1e3 * steps.iter().copied().filter(|s| *s <= gap(median)).fold(0.0, f64::max),
        1e3 * mean,
        1e3 * step
    ));
    let stretches = resample(rows, &stretches, step);
    Ok(Clock { sample_time: step, stretches, notes })
}

/// \[s\] A step longer than this is a gap, at this usual step \[s\].
fn gap(median: f64) -> f64 {
    let [long, short] = GAPS.map(|gap| gap * median);
    short.max(long.min(BRIDGED))
}

/// Refuses `time` \[s\] that is in no seconds, with the likely unit.
pub(super) fn check_unit(time: &[f64]) -> Result<(), String> {
    let steps: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).collect();
    let median = median(&steps);
    let [least, most] = SAMPLE_TIMES;
    if (least..=most).contains(&median) {
        return Ok(());
    }
    let units = [("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
    let far = |factor: f64| (median * factor / USUAL).ln().abs();
    let likely = units
        .iter()
        .filter(|(_, factor)| (least..=most).contains(&(median * factor)))
        .min_by(|a, b| far(a.1).total_cmp(&far(b.1)));
    let hint = likely.map_or_else(
        || "no unit of time makes it so: is this the column of times?".to_owned(),
        |(unit, _)| format!("other units? say so: columns t=NAME:{unit}"),
    );
    Err(format!("rows are {median} s apart; allowed: {least} to {most} s ({hint})"))
}

fn stretches(time: &[f64], gap: f64) -> Vec<Range<usize>> {
    let starts = time.windows(2).enumerate().filter(|(_, t)| t[1] - t[0] > gap).map(|(k, _)| k + 1);
    let starts: Vec<usize> = std::iter::once(0).chain(starts).collect();
    let ends = starts.iter().skip(1).copied().chain([time.len()]);
    starts.iter().copied().zip(ends).map(|(from, to)| from..to).collect()
}

/// Is every row where a clock with this step has it?
fn is_even(time: &[f64], step: f64) -> bool {
    let off = time.iter().enumerate().map(|(k, t)| t - time[0] - k as f64 * step);
    let (least, most) = off.fold((0.0_f64, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
    0.5 * (most - least) <= EVEN * step
}

/// Differences of decimal times have noise in the last digits: whole microseconds or nanoseconds where that
/// moves no row by more than a hundredth of a step.
fn round_if_equal(step: f64, rows: usize) -> f64 {
    let rounded = [1e6, 1e9].map(|parts: f64| (parts * step).round() / parts);
    let moves = |other: f64| (other - step).abs() * rows as f64;
    rounded.into_iter().find(|other| moves(*other) < 0.01 * step).unwrap_or(step)
}

/// Every `step` \[s\] of each stretch: angles and speeds on the line between rows; volts, which are held from
/// row to row, averaged over the step, so that what they give the rotors stays the same.
fn resample(rows: &mut Rows, stretches: &[Range<usize>], step: f64) -> Vec<Range<usize>> {
    let mut even = Rows::default();
    let mut found = Vec::with_capacity(stretches.len());
    for stretch in stretches {
        let first = even.time.len();
        let begin = rows.time[stretch.start];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of rows")]
        let steps = ((rows.time[stretch.end - 1] - begin) / step + 1e-6) as usize;
        let mut row = stretch.start;
        for k in 0..=steps {
            let at = begin + k as f64 * step;
            while row + 1 < stretch.end && rows.time[row + 1] <= at {
                row += 1;
            }
            even.time.push(at);
            even.volts.push(mean_volts(rows, stretch.end, row, [at, at + step]));
            let next = (row + 1).min(stretch.end - 1);
            let span = rows.time[next] - rows.time[row];
            let part = if span > 0.0 { ((at - rows.time[row]) / span).clamp(0.0, 1.0) } else { 0.0 };
            let between = |a: f64, b: f64| a + part * (b - a);
            even.angle.push(rows.angle[row].zip(rows.angle[next], between));
            if !rows.rotor_speed.is_empty() {
                even.rotor_speed.push(rows.rotor_speed[row].zip(rows.rotor_speed[next], between));
            }
            even.reference.extend(rows.reference.get(row).copied());
        }
        found.push(first..even.time.len());
    }
    *rows = even;
    found
}

fn mean_volts(rows: &Rows, end: usize, from: usize, [begin, until]: [f64; 2]) -> PerMotor<f64> {
    let mut sum = PerMotor::zero();
    let (mut row, mut at) = (from, begin);
    while at < until {
        let next = if row + 1 < end { rows.time[row + 1].min(until) } else { until };
        sum = sum.plus(rows.volts[row].scaled((next - at).max(0.0)));
        (row, at) = (row + 1, next.max(at));
        if row >= end {
            break;
        }
    }
    sum.scaled(1.0 / (until - begin))
}

/// Of what has at least one value.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}
