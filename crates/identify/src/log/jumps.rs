//! Angles that jump as no rig does: wrapped ones are unwrapped, single wild rows are taken from their
//! neighbours, and anything else is refused.

use std::f64::consts::{PI, TAU};

/// \[rad/s\] Faster than any of these rigs turns, and \[rad\] what a jump must exceed besides.
const FASTEST: [f64; 2] = [30.0, 0.3];
/// Longest run of rows that is taken for a slip of the sensor.
const MOST_WILD: usize = 3;
/// Rows of which one may be wild, so many at least.
const RARE: usize = 200;

/// Mends the angles \[rad\] of one axis, with times \[s\]; `counts` a turn where the file counts. Tells what
/// was done.
pub(super) fn mend(
    axis: &str,
    angle: &mut [f64],
    time: &[f64],
    counts: Option<f64>,
) -> Result<Vec<String>, String> {
    // A counter of sixteen bits starts again after 65536 counts; an angle from an arc tangent after half a
    // turn.
    let periods: Vec<f64> = [TAU, PI].into_iter().chain(counts.map(|n| TAU * 65_536.0 / n)).collect();
    let mut notes = Vec::new();
    let mut jumps = jumps(angle, time);
    if jumps.is_empty() {
        return Ok(notes);
    }
    if !fit_a_period(angle, time, &jumps, &periods) {
        let wild = wild_rows(angle, time, &jumps);
        if wild.len() * RARE > angle.len() + RARE {
            return Err(format!(
                "{axis} jumps {} times by more than a rig can move, first by {:.3} rad at {:.3} s; allowed: \
                 an angle that goes on (is it the right column?)",
                jumps.len(),
                angle[jumps[0] + 1] - angle[jumps[0]],
                time[jumps[0] + 1]
            ));
        }
        if let Some(row) = wild.first() {
            let told = format!(
                "{axis} is {:.3} rad at {:.3} s, far from the rows beside it: {} such rows are taken from \
                 their neighbours",
                angle[*row],
                time[*row],
                wild.len()
            );
            interpolate(angle, time, &wild);
            notes.push(told);
        }
        jumps = self::jumps(angle, time);
    }
    if jumps.is_empty() {
        return Ok(notes);
    }
    let Some(period) = periods.iter().find(|p| fits(angle, time, &jumps, **p)) else {
        let first = jumps[0];
        return Err(format!(
            "{axis} jumps by {:.3} rad within {:.4} s at {:.3} s and stays there; allowed: at most {:.0} \
             rad/s \
             (was it zeroed in the run, or is the log two runs? cut it there)",
            angle[first + 1] - angle[first],
            time[first + 1] - time[first],
            time[first + 1],
            FASTEST[0]
        ));
    };
    unwrap(angle, &jumps, *period);
    notes.push(format!("{axis} wraps at {period:.4} rad in {} places: unwrapped", jumps.len()));
    Ok(notes)
}

/// Rows after which an angle jumps.
fn jumps(angle: &[f64], time: &[f64]) -> Vec<usize> {
    let far = |k: &usize| (angle[k + 1] - angle[*k]).abs() > most(time[k + 1] - time[*k]);
    (0..angle.len().saturating_sub(1)).filter(far).collect()
}

/// \[rad\] Most that an angle changes in `step` \[s\].
fn most(step: f64) -> f64 {
    FASTEST[0] * step + FASTEST[1]
}

fn fits(angle: &[f64], time: &[f64], jumps: &[usize], period: f64) -> bool {
    jumps.iter().all(|k| {
        let (step, jump) = (time[k + 1] - time[*k], (angle[k + 1] - angle[*k]).abs());
        (jump - period).abs() <= most(step).min(0.2 * period)
    })
}

fn fit_a_period(angle: &[f64], time: &[f64], jumps: &[usize], periods: &[f64]) -> bool {
    periods.iter().any(|period| fits(angle, time, jumps, *period))
}

/// Rows between two jumps that lie close together, where the angle before the first and that after the second
/// belong together; and the like at the ends.
fn wild_rows(angle: &[f64], time: &[f64], jumps: &[usize]) -> Vec<usize> {
    let mut wild = Vec::new();
    let (first, last) = (jumps[0], jumps[jumps.len() - 1]);
    if first < MOST_WILD && (jumps.len() == 1 || jumps[1] > first + MOST_WILD) {
        wild.extend(0..=first);
    }
    let mut k = 0;
    while k + 1 < jumps.len() {
        let (from, to) = (jumps[k], jumps[k + 1]);
        let apart = (angle[to + 1] - angle[from]).abs();
        if to - from <= MOST_WILD && apart <= most(time[to + 1] - time[from]) {
            wild.extend(from + 1..=to);
            k += 1;
        }
        k += 1;
    }
    if last + 1 + MOST_WILD >= angle.len() && !wild.contains(&last) {
        wild.extend(last + 1..angle.len());
    }
    wild
}

/// Puts these rows on the line between the good ones beside them.
fn interpolate(angle: &mut [f64], time: &[f64], wild: &[usize]) {
    for row in wild {
        let before = (0..*row).rev().find(|k| !wild.contains(k));
        let after = (*row..angle.len()).find(|k| !wild.contains(k));
        angle[*row] = match (before, after) {
            (Some(a), Some(b)) => {
                let part = (time[*row] - time[a]) / (time[b] - time[a]);
                angle[a] + part * (angle[b] - angle[a])
            }
            (Some(one), None) | (None, Some(one)) => angle[one],
            (None, None) => angle[*row],
        };
    }
}

/// Takes whole periods out, so that no row jumps; the whole lies as near zero as it did.
fn unwrap(angle: &mut [f64], jumps: &[usize], period: f64) {
    let mut sum = 0.0;
    let mut next = jumps.iter().peekable();
    let before: Vec<f64> = angle.to_vec();
    for k in 0..angle.len() {
        angle[k] += sum;
        if next.peek() == Some(&&k) {
            next.next();
            sum -= period * (before[k + 1] - before[k]).signum();
        }
    }
    let turns = (angle[0] / period).round() * period;
    angle.iter_mut().for_each(|a| *a -= turns);
}
